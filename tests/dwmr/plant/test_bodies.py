"""Gaps between bodies against another way to compute them: polygons, their sides, and the hull of all differences."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from dwmr.scenario.outlines import Outline, gap_between, gap_to_point, outline_pose

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


class TestOutlinePose:
    def test_turns_the_middle_with_the_robot(self):
        turns = np.array([0.0, math.pi / 2, math.pi])
        found = outline_pose(Outline(0.5, 1.0, 0.5, 0.0), np.full(3, 2.0), np.full(3, 3.0), turns)
        assert found == pytest.approx(np.array([[2.5, 2.0, 1.5], [3.0, 3.5, 3.0], turns]))
