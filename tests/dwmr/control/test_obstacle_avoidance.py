import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dwmr.control.obstacle_avoidance import (
    Avoidance,
    avoid,
    avoidance_radius,
    constant_radius,
    evasive_direction,
    evasive_side,
)

RADIUS = 0.56
AVOIDANCE = Avoidance(1.7, 5.0, 5.0, 2.0, 1.0, 0.1, 0.0)


class TestAvoidanceRadius:
    @given(st.floats(0.5, 30.0), st.floats(-2.0, 2.0))
    def test_lies_between_the_constant_and_the_largest_radius(self, distance, speed):
        assert 2.76 <= avoidance_radius(distance, speed, 0.5, RADIUS, AVOIDANCE) <= 5.0

    def test_expands_as_printed(self):
        expected = 2.76 + 5.0 * 0.8 / (2.0 * math.exp(2.0))
        assert avoidance_radius(2.0, -0.8, 0.5, RADIUS, AVOIDANCE) == pytest.approx(expected)

    def test_at_rest_counts_obstacle_robot_and_margin(self):
        assert avoidance_radius(3.0, 0.0, 0.5, 0.3, AVOIDANCE) == pytest.approx(0.5 + 0.3 + 1.7)
        assert constant_radius(0.5, 0.3, 1.7) == pytest.approx(2.5)

    def test_grows_with_speed_and_shrinks_with_distance(self):
        assert avoidance_radius(3.0, 1.0, 0.5, RADIUS, AVOIDANCE) > avoidance_radius(3.0, 0.5, 0.5, RADIUS, AVOIDANCE)
        assert avoidance_radius(3.0, 1.0, 0.5, RADIUS, AVOIDANCE) > avoidance_radius(4.0, 1.0, 0.5, RADIUS, AVOIDANCE)


class TestEvasiveSide:
    def test_passes_on_the_side_it_already_looks_to(self):
        assert evasive_side(0.2, 0.0) == 1.0
        assert evasive_side(-0.2, 0.0) == -1.0

    def test_compares_across_the_seam_of_the_circle(self):
        assert evasive_side(-3.1, 3.1) == 1.0
        assert evasive_side(3.1, -3.1) == -1.0


class TestEvasiveDirection:
    def test_runs_along_the_boundary_on_it(self):
        assert evasive_direction(3.0, 0.0, 3.0, 3.0, 1.0) == pytest.approx(math.pi / 2)
        assert evasive_direction(3.0, 0.0, 3.0, 3.0, -1.0) == pytest.approx(-math.pi / 2)

    def test_points_away_inside_and_towards_outside(self):
        assert math.cos(evasive_direction(2.0, 0.0, 2.0, 3.0, 1.0)) < 0.0
        assert math.cos(evasive_direction(4.0, 0.0, 4.0, 3.0, 1.0)) > 0.0


class TestAvoid:
    OBSTACLES = np.array([[0.0, 10.0, 0.5], [4.0, 0.0, 0.5], [2.0, 0.0, 0.5]])

    def test_is_off_where_nothing_is_near(self):
        sides = np.zeros(3)
        assert avoid(50.0, 50.0, 0.0, 1.0, RADIUS, self.OBSTACLES, sides, AVOIDANCE)[0] == -1
        assert not sides.any()

    @pytest.mark.parametrize(("x", "expected"), [(1.3, 2), (4.8, 1)])
    def test_takes_the_nearest_of_two_active_ones(self, x, expected):
        sides = np.zeros(3)
        nearest, _, radius = avoid(x, 0.1, 0.0, 0.5, RADIUS, self.OBSTACLES, sides, AVOIDANCE)
        assert nearest == expected
        assert radius > 2.76
        assert sides[0] == 0.0
        assert sides[1] != 0.0
        assert sides[2] != 0.0

    def test_only_the_speed_towards_the_obstacle_counts(self):
        for theta, closing in ((0.0, 0.8), (math.pi / 3, 0.4), (math.pi / 2, 0.0), (math.pi, 0.8)):
            _, _, radius = avoid(0.0, 0.0, theta, 0.8, RADIUS, self.OBSTACLES[2:], np.zeros(1), AVOIDANCE)
            assert radius == pytest.approx(avoidance_radius(2.0, closing, 0.5, RADIUS, AVOIDANCE))

    def test_keeps_the_side_it_began_with(self):
        sides = np.zeros(3)
        avoid(-0.5, 0.0, 0.3, 0.5, RADIUS, self.OBSTACLES[2:], sides[2:], AVOIDANCE)
        assert sides[2] == 1.0
        avoid(-0.5, 0.0, -0.3, 0.5, RADIUS, self.OBSTACLES[2:], sides[2:], AVOIDANCE)
        assert sides[2] == 1.0

    def test_forgets_the_side_when_it_is_out_again(self):
        sides = np.array([1.0])
        avoid(-20.0, 0.0, -0.3, 0.5, RADIUS, self.OBSTACLES[2:], sides, AVOIDANCE)
        assert sides[0] == 0.0

    def test_is_off_inside_the_obstacle_itself(self):
        sides = np.zeros(1)
        assert avoid(2.0, 0.3, 0.0, 0.5, RADIUS, self.OBSTACLES[2:], sides, AVOIDANCE)[0] == -1

    def test_hysteresis_ends_an_avoidance_beyond_the_radius_and_begins_none(self):
        sides, obstacles = np.zeros(1), self.OBSTACLES[2:]
        with_hysteresis = AVOIDANCE._replace(hysteresis=0.5)
        on = [
            avoid(2.0 - distance, 0.0, 0.0, 0.0, RADIUS, obstacles, sides, with_hysteresis)[0] == 0
            for distance in (3.0, 2.7, 3.0, 3.25, 3.27, 3.0)  # R_d at rest is 2.76 m
        ]
        assert on == [False, True, True, True, False, False]
