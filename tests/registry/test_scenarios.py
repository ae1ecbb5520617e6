"""Every shipped scenario is clean, finite, deterministic, and keeps its leader clear of the obstacles."""

from functools import cache

import numpy as np
import pytest

from dwmr import find, measure, read, simulate
from tests.dwmr.paper import TABLE_13
from tests.dwmr.process import here
from tests.dwmr.scenarios import KNOWN
from tests.physics import needs_mujoco, shipped, shipped_names, shipped_of_equations

CLOSE = ("aifqsmc", "fcafsmc")
#: Table 13 of the paper: the leader of AIFQSMC in Gazebo, with nothing added.
LEADER = TABLE_13["aifqsmc"]["leader"]


def run(name, law, *overrides):
    file = read(find(name), overrides)
    trajectory = simulate(file, law, known=KNOWN)
    return trajectory, measure(trajectory, file.scenario)


@cache
def whole(name, law):
    return run(name, law)


def test_the_promised_ones_are_there():
    promised = {"paper", "paper-without-obstacles", "undisturbed", "five-robots", "csv-path", "paper-as-printed"}
    promised |= {"experiment", "moving-obstacles", "own-references", "virtual-structure", "consensus"}
    promised |= {"paper-with-limits", "paper-constant-gain", "paper-ideal-loop", "paper-lost-turn"}
    assert promised <= set(shipped_names())


@pytest.mark.parametrize("name", shipped())
def test_is_clean(name):
    assert read(find(name)).scenario.name == name
    done = here("check", name)
    assert "warning" not in done.stdout + done.stderr


@pytest.mark.parametrize("law", ["aifqsmc", "smc"])
@pytest.mark.parametrize("name", shipped())
def test_is_finite_and_deterministic(name, law):
    first, second = (run(name, law, "run.horizon=1")[0] for _ in range(2))
    assert first.stop is None
    assert np.isfinite(first.values).all()
    assert np.array_equal(first.values, second.values)
    assert np.array_equal(first.law_values, second.law_values)


def with_laws(names):
    """Each scenario with the laws that it is made for: the paper's, of another vehicle its own."""
    for name in names:
        own = read(find(name)).scenario.run.controller
        yield from ((name, law) for law in (CLOSE if own in CLOSE else [own]))


@pytest.mark.parametrize(("name", "law"), [*with_laws(shipped_of_equations())])
def test_reaches_its_end_without_a_collision(name, law):
    trajectory, result = whole(name, law)
    assert trajectory.stop is None
    assert np.isfinite(trajectory.values).all()
    assert result["obstacles_hit"] == []
    assert result["centre_distance"]["leader"] is None or result["centre_distance"]["leader"] >= 1.06


@pytest.mark.parametrize("name", ["x_e", "y_e", "theta_e"])
def test_undisturbed_is_within_a_tenth_of_table_13(name):
    _, result = whole("undisturbed", "aifqsmc")
    assert result["rmse"]["leader"][name] == pytest.approx(LEADER[name], rel=0.10)


@needs_mujoco
@pytest.mark.long
def test_the_experiment_has_the_leader_of_table_13_within_15_percent_at_any_step():
    _, result = whole("experiment", "aifqsmc")
    half = run("experiment", "aifqsmc", "run.substeps=8")[1]["rmse"]
    for name, printed in LEADER.items():
        assert result["rmse"]["leader"][name] == pytest.approx(printed, rel=0.15)
        for robot, errors in result["rmse"].items():
            assert half[robot][name] == pytest.approx(errors[name], rel=0.02)
    assert (result["obstacles_hit"], result["robots_hit"]) == ([], [])


def test_the_path_as_printed_passes_far_from_two_obstacles():
    trajectory, result = whole("paper-as-printed", "aifqsmc")
    gaps = [
        np.hypot(trajectory["x_r"][:, 0] - x, trajectory["y_r"][:, 0] - y).min()
        for x, y in ((0.0, 15.5), (8.0, -4.25), (-14.5, -11.25))
    ]
    assert gaps == pytest.approx([7.5, 5.2, 0.8], abs=0.05)
    assert result["avoidance_s"]["leader"] < 0.5 * whole("paper", "aifqsmc")[1]["avoidance_s"]["leader"]


@pytest.mark.parametrize("law", CLOSE)
def test_the_fifth_robot_follows_through_a_chain(law):
    trajectory, result = whole("five-robots", law)
    assert trajectory.robots == ("leader", "follower1", "follower2", "follower3", "follower4")
    assert max(result["rmse"][name]["x_e"] for name in ("follower3", "follower4")) < 0.4
