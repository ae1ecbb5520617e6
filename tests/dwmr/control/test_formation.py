import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dwmr.control.formation import (
    follower_auxiliary_rate,
    follower_error,
    follower_position,
    separation_and_bearing,
    trajectory_auxiliary_rate,
    trajectory_error,
)
from dwmr.core.geometry import to_body

angles = st.floats(-3.0, 3.0)
places = st.floats(-20.0, 20.0)
speeds = st.floats(-1.0, 1.0)
SEPARATION, BEARING = 1.25, 0.75 * math.pi


class TestTrajectoryError:
    def test_sees_a_reference_ahead_and_to_the_left(self):
        e = trajectory_error(1.0, 1.0, math.pi / 2, 0.0, 3.0, math.pi / 2, math.pi / 2, 0.5, 0.1)
        assert (e.x_e, e.y_e) == pytest.approx((2.0, 1.0))
        assert (e.drift_x, e.drift_y) == pytest.approx((0.5, 0.0))

    def test_wraps_the_orientation_error(self):
        e = trajectory_error(0.0, 0.0, -3.1, 0.0, 0.0, 3.1, 3.1, 0.5, 0.1)
        assert e.theta_e_star == pytest.approx(6.2 - 2 * math.pi)


class TestTrajectoryAuxiliaryRate:
    def test_turns_the_auxiliary_orientation_towards_the_reference(self):
        assert trajectory_auxiliary_rate(0.3, 0.2, 0.5, 0.1) == pytest.approx(5.0 * math.sin(0.1))

    def test_rests_when_they_agree(self):
        assert trajectory_auxiliary_rate(0.3, 0.3, 0.5, 0.1) == 0.0


class TestSeparationAndBearing:
    @given(places, places, angles, st.floats(0.2, 5.0), angles)
    def test_undoes_the_placing_of_a_follower(self, x, y, theta, separation, bearing):
        x_j, y_j = follower_position(x, y, theta, 0.1, separation, bearing)
        # Eqs. (44), (45) measure from follower to leader and turn by π, so the bearing comes back
        measured, angle = separation_and_bearing(x, y, theta, 0.1, x_j, y_j)
        assert measured == pytest.approx(separation, abs=1e-9)
        assert math.cos(angle - bearing) == pytest.approx(1.0, abs=1e-9)

    def test_a_follower_behind_on_the_left_has_a_bearing_in_the_second_quadrant(self):
        separation, bearing = separation_and_bearing(0.1, 0.0, 0.0, 0.1, -1.0, 1.0)
        assert separation == pytest.approx(math.sqrt(2.0))
        assert bearing == pytest.approx(0.75 * math.pi)


class TestFollowerError:
    @given(places, places, angles, places, places, angles)
    def test_is_the_missing_way_in_the_followers_frame(self, x_i, y_i, theta_i, x_j, y_j, theta_j):
        e = follower_error(x_i, y_i, theta_i, 0.5, 0.1, 0.1, x_j, y_j, theta_j, theta_j, 0.4, SEPARATION, BEARING)
        x_r, y_r = follower_position(x_i, y_i, theta_i, 0.1, SEPARATION, BEARING)
        assert (e.x_e, e.y_e) == pytest.approx(to_body(x_r - x_j, y_r - y_j, theta_j), abs=1e-9)

    @given(angles, angles, speeds, speeds)
    def test_drift_is_the_velocity_of_the_place_in_the_followers_frame(self, theta_i, theta_j, v_i, omega_i):
        e = follower_error(0.0, 0.0, theta_i, v_i, omega_i, 0.1, 3.0, 1.0, theta_j, theta_j, 0.4, SEPARATION, BEARING)
        h = 1e-6
        # the leader's axle moves along its orientation, the reference point d ahead of it
        axle = (-0.1 * math.cos(theta_i), -0.1 * math.sin(theta_i))
        places_at = []
        for t in (-h, h):
            turn = theta_i + omega_i * t
            x = axle[0] + v_i * t * math.cos(theta_i) + 0.1 * math.cos(turn)
            y = axle[1] + v_i * t * math.sin(theta_i) + 0.1 * math.sin(turn)
            places_at.append(follower_position(x, y, turn, 0.1, SEPARATION, BEARING))
        (x_a, y_a), (x_b, y_b) = places_at
        expected = to_body((x_b - x_a) / (2 * h), (y_b - y_a) / (2 * h), theta_j)
        assert (e.drift_x, e.drift_y) == pytest.approx(expected, abs=1e-6)


class TestFollowerAuxiliaryRate:
    @given(angles, speeds, speeds, angles)
    def test_moves_a_point_ahead_of_the_axle_sideways_as_the_formation_does(self, theta_i, v_i, omega_i, theta_star):
        rate = follower_auxiliary_rate(theta_i, v_i, omega_i, theta_star, 0.4, SEPARATION, BEARING)
        angle = theta_i + BEARING
        x_dot = v_i * math.cos(theta_i) - SEPARATION * omega_i * math.sin(angle)
        y_dot = v_i * math.sin(theta_i) + SEPARATION * omega_i * math.cos(angle)
        assert 0.4 * rate == pytest.approx(to_body(x_dot, y_dot, theta_star)[1], abs=1e-9)
