"""Gaps and contacts of recorded runs, and the measures that count them."""

import dataclasses
import itertools

import numpy as np
import pytest

from dwmr import find, measure, read
from dwmr.scenario.outlines import gap_between, outline, outline_pose
from tests.dwmr.scenarios import by_hand

SCENARIO = read(find("paper-with-limits")).scenario


def moved(**columns):
    """Three samples of the robots far from each other, but for the columns given."""
    return by_hand(**{"x": [0.0, 50.0, 100.0], "y": 0.0, **columns})


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
        alone = read(find("paper-with-limits"), ["obstacles=[]"]).scenario
        run = moved()
        run = dataclasses.replace(run, robots=("leader",), values=run.values[:, :1], law_values=run.law_values[:, :1])
        one = measure(run, alone)
        assert one["robot_gap"] == one["obstacle_gap"] == one["centre_distance"] == {"leader": None}

    def test_of_a_run_hold_at_every_sample(self, run_with_limits):
        """The search looks only at samples at which circles about the bodies are near: all others must be farther."""
        file, run = run_with_limits("fcafsmc", "run.horizon=70")
        least = measure(run, file.scenario)["robot_gap"]
        for a, b in itertools.combinations(run.robots, 2):
            shapes = [outline(file.scenario.robots[name]) for name in (a, b)]
            first, second = (
                outline_pose(shape, *(run[signal][:, run.robots.index(name)] for signal in ("x", "y", "theta")))
                for shape, name in zip(shapes, (a, b), strict=True)
            )
            gaps = gap_between(first, shapes[0], second, shapes[1])
            assert gaps.min() >= max(least[a], least[b])
        assert least["leader"] == least["follower2"] == pytest.approx(-0.25, abs=0.01)
