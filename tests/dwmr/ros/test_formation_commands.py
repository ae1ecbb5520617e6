"""Commands of real robots are those of the loop for the same measurements."""

import numpy as np
import pytest

from dwmr.core.geometry import ahead, clamp, wrap
from dwmr.ros.main import PARAMETERS, prepare
from dwmr.ros.node import FormationCommands, Odometry, StoppedError
from dwmr.simulation.simulate import run
from tests.dwmr.ros.stub import FILTER


def prepared(scenario, **parameters):
    return prepare({**PARAMETERS, "scenario": str(scenario), **parameters})


@pytest.fixture
def short(tmp_path):
    """A scenario without disturbances for a second, with more lines."""

    def write(*lines):
        path = tmp_path / "short.toml"
        text = 'extends = "undisturbed"\nname = "short"\n[run]\nhorizon = 1.0\n'
        path.write_text(text + "\n".join(lines), encoding="utf-8")
        return path

    return write


def measured(trajectory, scenario, k):
    """The odometry of all robots at a sample, orientations wrapped."""
    for i, robot in enumerate(scenario.robots.values()):
        x, y, theta, v, omega = trajectory.values[k, i, :5]
        sideways = trajectory["v_y"][k, i] if "v_y" in {one.name for one in trajectory.law_signals} else 0.0
        yield Odometry(*ahead(x, y, theta, -robot.d), wrap(theta), v, omega, sideways)


MECANUM = ("[robot.vehicle]", 'kind = "omnidirectional"', "half_base = 0.25")


@pytest.mark.parametrize(
    ("law", "more", "wanted"),
    [
        ("aifqsmc", (), ("v_c", "", "omega_c")),
        ("smc", (), ("v_c", "", "omega_c")),
        ("aifqsmc", ("[safety]", *FILTER), ("safe_v", "", "safe_omega")),
        ("omnidirectional", MECANUM, ("v_c", "v_y_c", "omega_c")),
    ],
)
def test_the_measurements_of_a_run_give_its_commands(short, law, more, wanted):
    simulation = prepared(short(*more), controller=law)
    trajectory, commands = run(simulation), FormationCommands(simulation)
    limits = [(r.actuator.v_limit, r.actuator.omega_limit) for r in simulation.scenario.robots.values()]
    for k in range(len(trajectory.t)):
        assert not commands.has_ended
        found = commands.decide(list(measured(trajectory, simulation.scenario, k)))
        asked = zip(*(trajectory[name][k] if name else [0.0] * 3 for name in wanted), limits, strict=True)
        assert found == pytest.approx(
            np.array([[clamp(v, m), clamp(left, m), clamp(omega, n)] for v, left, omega, (m, n) in asked]), abs=1e-9
        )
    assert commands.has_ended


def test_no_command_is_beyond_the_limits_of_robots_and_node(short):
    more = ("[robots.follower1.actuator]", "v_limit = 0.25")
    simulation = prepared(short(*more), v_limit=0.5, omega_limit=0.75)
    start = [Odometry(r.x_0, r.y_0, r.theta_0, 0.0, 0.0) for r in simulation.scenario.robots.values()]
    far = [one._replace(x=one.x - 9.0, y=one.y + 5.0) for one in start]
    found = FormationCommands(simulation).decide([start[0], *far[1:]])
    assert np.abs(found[1:]).tolist() == [[0.25, 0.0, 0.75], [0.5, 0.0, 0.75]]


def test_the_safety_filter_counts_on_the_limits_of_the_node(short):
    simulation = prepared(short("[safety]", *FILTER), v_limit=0.5, omega_limit=0.75)
    assert {(r.actuator.v_limit, r.actuator.omega_limit) for r in simulation.scenario.robots.values()} == {(0.5, 0.75)}
    start = [Odometry(r.x_0, r.y_0, r.theta_0, 0.0, 0.0) for r in simulation.scenario.robots.values()]
    commands = FormationCommands(simulation)
    for _ in range(100):
        found = commands.decide([one._replace(x=one.x - 9.0) for one in start])
    assert commands._periods.guard[1].commands == pytest.approx(found[:, ::2])
    assert np.abs(found).max(axis=0)[:2] == pytest.approx([0.5, 0.0], abs=1e-9)
    assert 0.1 < np.abs(found[:, 2]).max() <= 0.75


def test_the_sensors_of_the_scenario_have_no_part(short):
    found = []
    for more in ((), ("[robot.sensors]", 'pose = "odometry"', "encoder_steps = 2000")):
        simulation = prepared(short(*more))
        commands = FormationCommands(simulation)
        start = [Odometry(r.x_0, r.y_0, r.theta_0, 0.1, 0.0) for r in simulation.scenario.robots.values()]
        found.append([commands.decide([one._replace(x=one.x + k) for one in start]).tolist() for k in range(3)])
    assert found[0] == found[1]


def test_a_follower_begins_in_the_direction_of_its_leader_as_measured(short):
    simulation = prepared(short())
    robots = simulation.scenario.robots.values()
    turned = [Odometry(r.x_0, r.y_0, 0.7, 0.0, 0.0) for r in robots]
    commands = FormationCommands(simulation)
    commands.decide(turned)
    row = commands._periods.record[0]
    assert list(row[1:, 9]) == [0.7, 0.7]


def test_orientations_beyond_a_half_turn_make_no_jump(short):
    simulation = prepared(short())
    commands = FormationCommands(simulation)
    seen = []
    for theta in (3.1, -3.1, -3.0):
        commands.decide([Odometry(r.x_0, r.y_0, theta, 0.0, 0.0) for r in simulation.scenario.robots.values()])
        seen.append(commands._periods.record[min(len(seen), 1), 0, 2])
    assert seen == pytest.approx([3.1, 2 * np.pi - 3.1, 2 * np.pi - 3.0])


def test_a_robot_beyond_all_bounds_ends_the_run(short):
    simulation = prepared(short())
    far = [Odometry(1e11, 0.0, 0.0, 0.0, 0.0) for _ in simulation.scenario.robots]
    with pytest.raises(StoppedError, match=r"robot leader at t = 0\.000 s: x is beyond 1e"):
        FormationCommands(simulation).decide(far)
