"""Gaps between bodies against another way to compute them: polygons, their sides, and the hull of all differences."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from dwmr.plant import bodies
from dwmr.plant.bodies import Outline, contact, gap_between, gap_to_point
from dwmr.results.metrics import measure
from dwmr.scenario.file import find, read
from tests.dwmr.results.test_metrics import SCENARIO, trajectory

SIZES = st.floats(0.05, 2.0)
PLACES = st.floats(-3.0, 3.0)
POSES = st.tuples(PLACES, PLACES, st.floats(-7.0, 7.0))
BOXES = st.builds(Outline, st.just(0.0), SIZES, SIZES, st.just(0.0))


def corners(pose, box):
    x, y, theta = pose
    turn = np.array([[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]])
    signs = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
    return (signs * (box.half_length, box.half_width)) @ turn.T + (x, y)


def to_segment(point, start, end):
    share = np.clip(np.dot(point - start, end - start) / np.dot(end - start, end - start), 0.0, 1.0)
    return float(np.hypot(*(start + share * (end - start) - point)))


def signed_distance(first, second):
    """Distance of the origin from the hull of all differences of corners, negative inside."""
    hull = ConvexHull([a - b for a in first for b in second])
    if (hull.equations[:, 2] <= 0.0).all():
        return float(hull.equations[:, 2].max())
    return min(to_segment(np.zeros(2), *hull.points[side]) for side in hull.simplices)


def column(pose):
    return np.array(pose)[:, None]


class TestGapBetween:
    @settings(max_examples=300)
    @given(POSES, BOXES, POSES, BOXES)
    def test_is_the_distance_of_the_polygons_and_the_depth_of_their_overlap(self, p, a, q, b):
        expected = signed_distance(corners(p, a), corners(q, b))
        assert gap_between(column(p), a, column(q), b)[0] == pytest.approx(expected, abs=1e-9)

    @given(POSES, BOXES, POSES, BOXES)
    def test_is_the_same_from_both_sides(self, p, a, q, b):
        there, back = gap_between(column(p), a, column(q), b), gap_between(column(q), b, column(p), a)
        assert there == pytest.approx(back, abs=1e-12)

    @given(POSES, POSES, SIZES, SIZES)
    def test_of_discs_is_that_of_their_middles_without_the_radii(self, p, q, r, s):
        gap = gap_between(column(p), Outline(0.0, 0.0, 0.0, r), column(q), Outline(0.0, 0.0, 0.0, s))
        assert gap == pytest.approx(math.hypot(p[0] - q[0], p[1] - q[1]) - r - s, abs=1e-12)

    def test_by_hand(self):
        box = Outline(0.0, 1.0, 0.5, 0.0)
        others = np.array([[3.0, 0.0, 0.0], [3.0, 0.0, math.pi / 2], [4.0, 5.0, 0.0], [1.5, 0.0, 0.0]]).T
        gaps = gap_between(np.zeros((3, 4)), box, others, box)
        assert gaps == pytest.approx([1.0, 1.5, math.hypot(2.0, 4.0), -0.5])


class TestGapToPoint:
    @given(POSES, BOXES, PLACES, PLACES)
    def test_is_the_distance_from_the_sides(self, pose, box, x, y):
        outline = corners(pose, box)
        away = min(to_segment(np.array([x, y]), outline[k], outline[k - 1]) for k in range(4))
        gap = gap_to_point(column(pose), box, x, y)[0]
        assert abs(gap) == pytest.approx(away, abs=1e-9)
        if away > 1e-6:  # inside is to the left of every side, as they go round counter-clockwise
            (e_x, e_y), (d_x, d_y) = (outline - np.roll(outline, 1, axis=0)).T, (np.array([x, y]) - outline).T
            assert (gap < 0.0) == bool((e_x * d_y - e_y * d_x > 0.0).all())


class TestOutline:
    def test_is_the_body_about_the_axle(self):
        leader = SCENARIO.robots["leader"]
        found = bodies.outline(leader)
        assert (found.half_length, found.half_width, found.margin) == pytest.approx((0.4555, 0.34, 0.0))
        assert found.middle + leader.d == pytest.approx(-0.0865)

    def test_of_a_robot_without_a_body_is_the_circle_that_encloses_it(self):
        found = bodies.outline(SCENARIO.robots["leader"].model_copy(update={"body": None}))
        assert found == (-0.1, 0.0, 0.0, 0.56)


def moved(**columns):
    """Three samples of the robots far from each other, but for the columns given."""
    return trajectory(**{"x": [0.0, 50.0, 100.0], "y": 0.0, **columns})


class TestMeasures:
    def test_the_gap_counts_from_the_bodies(self):
        result = measure(moved(x=[8.0, 50.0, 100.0], y=-6.0), SCENARIO)
        # the body reaches 0.34 m to its side, the obstacle 0.5 m from (8, -4.25); its reference point is 0.1 m ahead
        assert result["centre_distance"]["leader"] == pytest.approx(1.75)
        assert result["obstacle_gap"]["leader"] == pytest.approx(1.75 - 0.34 - 0.5)
        assert result["obstacles_hit"] == []
        assert result["robots_hit"] == []

    def test_an_obstacle_is_hit_before_the_reference_point_gets_there(self):
        y = np.array([[-6.0], [-5.0], [-6.0]]) * [1, 0, 0]
        result = measure(moved(x=[8.0, 50.0, 100.0], y=y), SCENARIO)
        assert result["centre_distance"]["leader"] == pytest.approx(0.75)
        (hit,) = result["obstacles_hit"]
        assert hit == pytest.approx({"robot": "leader", "obstacle": 1, "t": 0.005, "lasted": 0.005, "depth": 0.09})

    def test_robots_that_overlap_hit_each_other(self):
        x = np.array([[0.0, 50.0, 100.0], [0.0, 0.7, 100.0], [0.0, 0.6, 100.0]])
        result = measure(moved(x=x), SCENARIO)
        (hit,) = result["robots_hit"]
        assert hit["robots"] == ["leader", "follower1"]
        # the axles are 0.3 m nearer than the reference points, which are 0.1 and 0.4 m ahead of them
        assert hit["depth"] == pytest.approx(0.911 - 0.3)
        assert (hit["t"], hit["lasted"]) == pytest.approx((0.005, 0.01))
        assert result["robot_gap"]["leader"] == result["robot_gap"]["follower1"] == -hit["depth"]
        assert result["robot_gap"]["follower2"] > 40.0

    def test_a_robot_alone_has_no_gap(self):
        alone = read(find("paper"), ["obstacles=[]"]).scenario
        run = moved()
        one = measure(type(run)("smc", ("leader",), run.t, run.values[:, :1], run.law_values[:, :1], (), 0.1), alone)
        assert one["robot_gap"] == one["obstacle_gap"] == one["centre_distance"] == {"leader": None}

    def test_of_a_run_hold_at_every_sample(self, run_paper):
        """The search looks only at samples at which circles about the bodies are near: all others must be farther."""
        file, run = run_paper("fcafsmc", "run.horizon=70")
        least = measure(run, file.scenario)["robot_gap"]
        for a, b in itertools.combinations(run.robots, 2):
            first, second = (bodies.poses(run, file.scenario, name) for name in (a, b))
            shapes = [bodies.outline(file.scenario.robots[name]) for name in (a, b)]
            gaps = gap_between(first, shapes[0], second, shapes[1])
            assert gaps.min() >= max(least[a], least[b])
        assert least["leader"] == least["follower2"] == pytest.approx(-0.25, abs=0.01)

    def test_meetings_are_where_bodies_first_touch(self):
        x = np.array([[0.0, 50.0, 100.0], [0.0, 0.7, 100.0], [0.0, 0.5, 100.0]])
        assert bodies.meetings(moved(), SCENARIO).shape == (0, 2)
        assert bodies.meetings(moved(x=x), SCENARIO) == pytest.approx(np.array([[-0.1865, 0.0]]))
        y = np.array([[-6.0], [-5.0], [-6.0]]) * [1, 0, 0]
        assert bodies.meetings(moved(x=[8.0, 50.0, 100.0], y=y), SCENARIO) == pytest.approx(np.array([[7.8135, -5.0]]))

    def test_have_no_contact_where_the_gap_stays_open(self):
        assert contact(np.array([0.0, 1.0]), 1.0, np.array([0.1, 0.2])) is None
