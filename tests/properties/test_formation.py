"""Properties of whole runs and of the errors they are made of: scenes turned and moved, wrapped angles, convergence."""

import dataclasses
import functools
import json
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from dwmr import find, read, simulate
from dwmr.control.formation import follower_error, follower_position, trajectory_error
from dwmr.core.geometry import wrap_array
from tests import explanation
from tests.dwmr.scenarios import KNOWN
from tests.sizes import examples

angles = st.floats(-3.1, 3.1)
places = st.floats(-20.0, 20.0)
SEPARATION, BEARING = 1.25, 0.75 * math.pi

CIRCLE = """
extends = "paper-with-limits"
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


@functools.cache
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
    scene = {"robots": robots, "obstacles": (type(PAPER.scenario.obstacles[0])(x=beside[0], y=beside[1], radius=0.5),)}
    file = dataclasses.replace(file, scenario=file.scenario.model_copy(update=scene))
    return simulate(file, law, known=KNOWN)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder for the scenarios of all runs, so that the usual one is made once for each law."""
    return tmp_path_factory.mktemp("circles")


class TestSceneTurnedAndMoved:
    @pytest.mark.parametrize(
        ("by", "move"),
        [
            pytest.param(0.0, (30.0, -12.0), marks=pytest.mark.long),
            pytest.param(2.5, (0.0, 0.0), marks=pytest.mark.long),
            (-1.2, (-7.0, 4.0)),
        ],
    )
    @pytest.mark.parametrize("law", ["aifqsmc", "fcafsmc"])
    def test_the_formation_does_the_same(self, folder, law, by, move):
        """Within the avoidance, which begins at 11.5 s, last bits grow about tenfold a second: 1e-9 m by 17 s."""
        usual, other = circle_run(folder, law, 0.0, (0.0, 0.0)), circle_run(folder, law, by, move)
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


PAPER = read(find("paper-with-limits"))


def run(file, law="aifqsmc", **changes):
    """Run a scenario with some of its sections replaced."""
    changed = dataclasses.replace(file, scenario=file.scenario.model_copy(update=changes))
    return simulate(changed, law, known=KNOWN)


REFERENCES = {
    "eight": {"kind": "eight", "amplitude_x": 15.0, "amplitude_y": 15.0, "period": 200.0},
    "circle": {"kind": "circle", "centre_x": 0.0, "centre_y": 0.0, "radius": 8.0, "period": 60.0,
               "direction": "counter-clockwise"},
    "line": {"kind": "line", "start_x": 1.0, "start_y": 2.0, "angle": 2.0, "speed": 0.8},
    "waypoints": {"kind": "waypoints", "points": [[0.0, 0.0], [12.0, 2.0], [14.0, 12.0], [2.0, 10.0]], "closed": True,
                  "speed": 0.6},
    "csv": {"kind": "csv", "file": "csv-path.csv", "closed": True},
}  # fmt: skip


@functools.cache
def undisturbed(kind):
    """Return a scenario file with nothing but friction to disturb it."""
    reference = ", ".join(f"{key} = {json.dumps(value)}" for key, value in REFERENCES[kind].items())
    return read(find("csv-path"), [f"reference={{{reference}}}", "obstacles=[]", "disturbances=[]",
                                   "load.mass_factor=1.0", "load.inertia_factor=1.0", "run.horizon=90.0"])  # fmt: skip


def from_near(file, law, off):
    """Run the formation from where it should be, all robots moved and turned by `off` [m, m, rad]."""
    at = file.shape.at(0.0)
    robots = {}
    for name, robot in file.scenario.robots.items():
        x, y = at.x, at.y
        if robot.formation is not None:
            d_i = file.scenario.robots[robot.formation.leader].d
            x, y = follower_position(x, y, at.theta, d_i, robot.formation.separation, robot.formation.bearing)
        start = {"x_0": x + off[0], "y_0": y + off[1], "theta_0": at.theta + off[2]}
        robots[name] = robot.model_copy(update=start)
    return run(file, law, robots=robots)


def bands(file, trajectory, late, name):
    """Return within which |x_e| [m] and |λ2 y_e + λ3 θ*_e| [rad] of AIFQSMC must stay at last.

    The inner loop, without an integral, lags behind by e_v = (|dv/dt| + friction / m + |c| ω²) / k_p, with c the offset
    of the centre of mass; in turning likewise. With v = v_c − e_v, Eqs. (4), (12), (13), (20) give inside the layer

        dx_e/dt = −λ1² (P + G/β) x_e + e_v + y_e (ω − ω_eq),     |ω − ω_eq| <= |e_ω| + (P + G/β) |σ*_ω|,

    where G >= G_min and β <= 0.05 m, so that |x_e| comes below (e_v + ...) / (λ1² (P + G_min/0.05)). In the same way
    |σ*_ω| comes below e_ω / (P + G_min/0.05), and λ2 y_e + λ3 θ*_e = (λ1 y_e σ_v − σ*_ω) / D.
    """
    robot, dt, i = file.scenario.robots[name], file.scenario.run.dt, trajectory.robots.index(name)
    gains = robot.controllers["aifqsmc"]
    v, omega = (np.abs(trajectory[one][late, i]).max() for one in ("v", "omega"))
    a, alpha = (np.abs(np.diff(trajectory[one][late, i])).max() / dt for one in ("v", "omega"))
    x_e, y_e = (np.abs(trajectory[one][late, i]).max() for one in ("x_e", "y_e"))
    friction, offset = robot.friction, abs(robot.com_offset)
    force = friction.coulomb_force + friction.viscous_force * v
    torque = friction.coulomb_torque + friction.viscous_torque * omega
    e_v = (a + force / robot.mass + offset * omega**2) / robot.inner_loop.k_p_v
    e_omega = (alpha + (torque + robot.mass * offset * v * omega) / robot.inertia) / robot.inner_loop.k_p_omega
    least = gains["p_v"] + file.scenario.rules["ais_reaction"].params["G_min"] / 0.05
    x_band = (e_v + 2.0 * y_e * e_omega) / (gains["lambda_1"] ** 2 * least)
    least_d = gains["lambda_2"] * (robot.d - x_e) + gains["lambda_3"]
    return x_band, (e_omega / least + gains["lambda_1"] ** 2 * y_e * x_e) / least_d


class TestConvergence:
    @settings(max_examples=examples(8, 2), deadline=None)
    @given(st.floats(-2.0, 1.0), st.floats(-1.0, 2.0), st.floats(-1.0, 1.0))
    def test_errors_vanish_without_disturbance_and_obstacles(self, x_0, y_0, theta_0):
        """60 s from any start near the path; friction stays, which the inner loop does not know of."""
        leader = PAPER.scenario.robots["leader"].model_copy(update={"x_0": x_0, "y_0": y_0, "theta_0": theta_0})
        trajectory = run(
            PAPER,
            run=PAPER.scenario.run.model_copy(update={"horizon": 60.0}),
            robots={**PAPER.scenario.robots, "leader": leader},
            obstacles=(),
            disturbances=(),
        )
        late = trajectory.t > 55.0
        for name in ("x_e", "y_e"):
            assert np.abs(trajectory[name][late]).max() < 0.05, name

    @pytest.mark.parametrize("kind", REFERENCES)
    @settings(max_examples=examples(4, 2), deadline=None)
    @given(st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5)))
    def test_errors_come_into_a_band_on_every_kind_of_reference(self, kind, off):
        file = undisturbed(kind)
        trajectory = from_near(file, "aifqsmc", off)
        late = trajectory.t > 70.0
        for name in trajectory.robots:
            x_band, surface_band = bands(file, trajectory, late, name)
            i = trajectory.robots.index(name)
            x_e, y_e = (trajectory[one][late, i] for one in ("x_e", "y_e"))
            theta_e = wrap_array((trajectory["theta_r_star"] - trajectory["theta"])[late, i])
            gains = file.scenario.robots[name].controllers["aifqsmc"]
            assert x_band < 0.15
            assert surface_band < 0.12
            assert np.abs(x_e).max() <= x_band
            assert np.abs(gains["lambda_2"] * y_e + gains["lambda_3"] * theta_e).max() <= surface_band
            # measured: the gain is far above its least value
            assert max(np.abs(x_e).max(), np.abs(y_e).max()) <= 0.02

    @pytest.mark.parametrize("kind", REFERENCES)
    def test_errors_vanish_under_fcafsmc(self, kind):
        """Its gain is an integral of σ*, so that no friction keeps the errors from 0 where the reference is steady."""
        trajectory = from_near(undisturbed(kind), "fcafsmc", (0.3, -0.3, 0.2))
        steady = 1e-4 if kind in ("circle", "line") else 0.01
        late = trajectory.t > 80.0
        assert max(np.abs(trajectory[one][late]).max() for one in ("x_e", "y_e")) < steady

    @pytest.mark.parametrize(("lag", "least", "most"), [(0.02, 0.03, 0.2), (0.001, 0.0, 0.005)])
    def test_a_gain_that_grew_too_far_swings_with_the_lag_of_the_drives(self, lag, least, most):
        """From 7 m beside a circle k̂_h grows tenfold and does not fall again inside the layer."""
        file = undisturbed("circle")
        robots = {
            name: robot.model_copy(update={
                "x_0": PAPER.scenario.robots[name].x_0, "y_0": PAPER.scenario.robots[name].y_0, "theta_0": 0.0,
                "actuator": robot.actuator.model_copy(update={"lag": lag}),
            })
            for name, robot in file.scenario.robots.items()
        }  # fmt: skip
        trajectory = run(file, robots=robots)
        late = trajectory.t > 70.0
        assert trajectory["k_h_omega"][-1].min() > 1.0
        assert least <= np.abs(trajectory["x_e"][late, 1]).max() <= most


SCENES = explanation.script("reproduction/scenes.py")


class TestAvoidance:
    """Obstacles at least 14 m apart, 6 m from the start, and near the path: 0.75 m under AIFQSMC, 0.4 m under FCAFSMC.

    Beside the outside of a turn, 0.6 to 1.5 m from the path, there are places that the leader passes on the other side
    than its reference, and the method promises nothing: see docs/explanation/the-paper.md.
    """

    @pytest.mark.parametrize(("law", "aside"), [("aifqsmc", 0.75), ("fcafsmc", 0.4)])
    def test_the_leader_keeps_clear_of_several_obstacles(self, law, aside):
        least_distances = SCENES.leader_alone(law)

        @settings(max_examples=examples(25), deadline=None)
        @given(st.integers(0, 2**32 - 1), st.integers(2, 4))
        def keeps_clear(seed, count):
            places = SCENES.scene(np.random.default_rng(seed), count, 14.0, aside)
            assert min(least_distances(places)) >= SCENES.CLOSEST

        keeps_clear()

    @pytest.mark.parametrize(("t", "aside"), [(129.3, 1.18), (26.7, -1.16)])
    def test_outside_a_turn_it_may_come_closer(self, t, aside):
        """What the property leaves out: the leader goes round the other side of the obstacle than its reference."""
        assert SCENES.leader_alone("aifqsmc")([SCENES.beside_path(t, aside)])[0] < SCENES.CLOSEST
