"""Properties of whole runs and of the errors they are made of: scenes turned and moved, wrapped angles, convergence."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from dwmr import simulate
from dwmr.formation import follower_error, trajectory_error
from dwmr.fuzzy_gains import Rules
from dwmr.metrics import distances
from dwmr.scenario import Obstacle
from dwmr.scenario_file import find, read

angles = st.floats(-3.1, 3.1)
places = st.floats(-20.0, 20.0)
SEPARATION, BEARING = 1.25, 0.75 * math.pi
#: The leader's reference point may come to the sum of obstacle and robot radius: 0.5 m + 0.56 m.
CLOSEST = 1.06
#: Obstacles nearer than this to the start are in its way before it has found the path.
FROM_START = 6.0

CIRCLE = """
extends = "paper"
[run]
horizon = 25.0
[reference]
kind = "circle"
centre_x = {x!r}
centre_y = {y!r}
radius = 8.0
start_angle = {angle!r}
period = 80.0
direction = "counter-clockwise"
"""


def turned(x, y, by, move):
    """Return a place in the scene after it has been turned and moved."""
    c, s = math.cos(by), math.sin(by)
    return c * x - s * y + move[0], s * x + c * y + move[1]


def circle_run(folder, law, by, move):
    """Run the formation on a circle with an obstacle beside it, the whole scene turned and moved."""
    x, y = turned(0.0, 0.0, by, move)
    path = folder / "circle.toml"
    path.write_text(CIRCLE.format(x=x, y=y, angle=0.3 + by), encoding="utf-8")
    file = read(path)
    robots = {}
    for name, (x_0, y_0) in {"leader": (7.0, 2.0), "follower1": (8.0, 0.0), "follower2": (6.0, 0.5)}.items():
        place = turned(x_0, y_0, by, move)
        start = {"x_0": place[0], "y_0": place[1], "theta_0": file.scenario.robots[name].theta_0 + 1.7 + by}
        robots[name] = file.scenario.robots[name].model_copy(update=start)
    beside = turned(0.2, 8.3, by, move)
    scene = {"robots": robots, "obstacles": (Obstacle(x=beside[0], y=beside[1], radius=0.5),)}
    file = dataclasses.replace(file, scenario=file.scenario.model_copy(update=scene))
    return simulate.run(simulate.prepare(file, law, Rules(file.scenario.rules, (), file.places)))


class TestSceneTurnedAndMoved:
    @pytest.mark.parametrize(("by", "move"), [(0.0, (30.0, -12.0)), (2.5, (0.0, 0.0)), (-1.2, (-7.0, 4.0))])
    @pytest.mark.parametrize("law", ["aifqsmc", "fcafsmc"])
    def test_the_formation_does_the_same(self, tmp_path, law, by, move):
        """Within the avoidance, which begins at 11.5 s, last bits grow about tenfold a second: 1e-9 m by 17 s."""
        usual, other = circle_run(tmp_path, law, 0.0, (0.0, 0.0)), circle_run(tmp_path, law, by, move)
        seen = usual.t <= 17.0
        assert (usual["obstacle"][seen] >= 0).sum() > 500
        for name in ("x_e", "y_e"):
            assert np.abs(usual[name] - other[name])[seen].max() < 1e-8, name
        x, y = turned(usual["x"], usual["y"], by, move)
        assert np.abs(np.hypot(x - other["x"], y - other["y"]))[seen].max() < 1e-8

    @given(places, places, angles, places, places, angles, angles, places, places)
    def test_the_errors_are_the_same(self, x, y, theta, x_r, y_r, theta_r, by, a, b):
        (x_2, y_2), (x_r2, y_r2) = turned(x, y, by, (a, b)), turned(x_r, y_r, by, (a, b))
        one = trajectory_error(x, y, theta, x_r, y_r, theta_r, theta_r, 0.5, 0.1)
        two = trajectory_error(x_2, y_2, theta + by, x_r2, y_r2, theta_r + by, theta_r + by, 0.5, 0.1)
        assert two[:2] == pytest.approx(one[:2], abs=1e-9)
        assert two[3:] == pytest.approx(one[3:], abs=1e-9)
        assert math.cos(two.theta_e_star - one.theta_e_star) == pytest.approx(1.0)


class TestWrapping:
    @given(places, places, angles, places, places, angles, st.sampled_from([-4, -1, 1, 3]))
    def test_a_full_turn_changes_no_error(self, x, y, theta, x_j, y_j, theta_j, turns):
        assume(abs(abs(theta - theta_j) - math.pi) > 1e-6)
        by = 2.0 * math.pi * turns

        def errors(robot, leader):
            own = trajectory_error(x, y, robot, x_j, y_j, leader, leader, 0.5, 0.1)
            follower = follower_error(x, y, leader, 0.5, 0.1, 0.1, x_j, y_j, robot, leader, 0.4, SEPARATION, BEARING)
            return (*own, *follower)

        assert errors(theta_j + by, theta) == pytest.approx(errors(theta_j, theta), abs=1e-9)
        assert errors(theta_j, theta + by) == pytest.approx(errors(theta_j, theta), abs=1e-9)

    @given(places, places, st.sampled_from([math.pi, -math.pi, 3.0 * math.pi]), angles, st.floats(-2.9, 2.9))
    def test_no_error_jumps_where_an_angle_passes_half_a_turn(self, x, y, across, theta, off):
        """All angles pass it together, `off` apart: the wrapped error is away from its own half turn."""
        h = 1e-9

        def errors(angle):
            star = angle + off
            own = trajectory_error(0.0, 0.0, angle, x, y, star, star, 0.5, 0.1)
            follower = follower_error(x, y, star, 0.5, 0.1, 0.1, 0.0, 0.0, angle, star, 0.4, SEPARATION, BEARING)
            return np.array((*own, *follower))

        assert np.abs(errors(across + h) - errors(across - h)).max() < 1e-6


PAPER = read(find("paper"))
RULES = Rules(PAPER.scenario.rules, (), PAPER.places)
PREPARED = simulate.prepare(PAPER, "aifqsmc", RULES)


def run(**changes):
    """Run the paper's scenario under AIFQSMC with some of its sections replaced."""
    scenario = PAPER.scenario.model_copy(update=changes)
    return scenario, simulate.run(dataclasses.replace(PREPARED, scenario=scenario))


class TestConvergence:
    @settings(max_examples=8, deadline=None)
    @given(st.floats(-2.0, 1.0), st.floats(-1.0, 2.0), st.floats(-1.0, 1.0))
    def test_errors_vanish_without_disturbance_and_obstacles(self, x_0, y_0, theta_0):
        """60 s from any start near the path; friction stays, which the inner loop does not know of."""
        leader = PAPER.scenario.robots["leader"].model_copy(update={"x_0": x_0, "y_0": y_0, "theta_0": theta_0})
        _, trajectory = run(
            run=PAPER.scenario.run.model_copy(update={"horizon": 60.0}),
            robots={**PAPER.scenario.robots, "leader": leader},
            obstacles=(),
            disturbances=(),
        )
        late = trajectory.t > 55.0
        for name in ("x_e", "y_e"):
            assert np.abs(trajectory[name][late]).max() < 0.05, name


class TestAvoidance:
    @settings(max_examples=10, deadline=None, derandomize=True)
    @given(st.floats(20.0, 190.0), st.floats(-1.0, 1.0))
    def test_the_leader_keeps_clear_of_an_obstacle_beside_the_path(self, t, aside):
        """One obstacle up to 1 m from the path, and 6 m from the start.

        No distance between several obstacles makes this a property: the method promises nothing, and of 40 scenes with
        three obstacles 12 m apart or more, up to 2 m from the path, 3 came closer.
        """
        w = 2.0 * math.pi / 200.0
        ahead = np.array([2.0 * math.cos(2.0 * w * t), math.cos(w * t)])
        ahead /= np.linalg.norm(ahead)
        place = np.array([15.0 * math.sin(2.0 * w * t), 15.0 * math.sin(w * t)]) + aside * np.array(
            [-ahead[1], ahead[0]]
        )
        assume(np.linalg.norm(place - [-1.0, 1.0]) > FROM_START)
        scenario, trajectory = run(obstacles=(Obstacle(x=float(place[0]), y=float(place[1]), radius=0.5),))
        assert (trajectory["obstacle"][:, 0] >= 0).any()
        assert distances(trajectory, scenario, "leader").min() >= CLOSEST
