"""docs/explanation/experiment.md prints numbers: they must be those of its result file, and that of the runs."""

import pytest

from tests import explanation
from tests.dwmr.scenarios import measured
from tests.physics import needs_mujoco

PAGE = explanation.text("experiment.md")
RESULTS = explanation.results("experiment/readings.json")
SCRIPT = explanation.script("experiment/readings.py")


def test_the_tables_of_the_page_are_those_of_the_results():
    for row in (*SCRIPT.rows(RESULTS), *SCRIPT.grid_rows(RESULTS)):
        assert row in PAGE


def test_all_readings_have_results():
    assert list(RESULTS) == list(SCRIPT.READINGS)


def test_the_leader_is_within_15_percent_and_half_the_step_changes_less_than_2():
    table = SCRIPT.TABLE_13["aifqsmc"]
    shipped, half = (RESULTS[name]["errors"] for name in ("as shipped", "half the step"))
    for name in SCRIPT.NAMES:
        assert shipped["leader"][name] == pytest.approx(table["leader"][name], rel=0.15)
        for robot, row in shipped.items():
            assert half[robot][name] == pytest.approx(row[name], rel=0.02)


def test_the_equations_give_what_the_results_say():
    assert SCRIPT.run(SCRIPT.READINGS["the equations"]) == close(RESULTS["the equations"])


def test_slow_drives_give_table_13_as_nearly_as_the_page_says():
    for name in ("drives of 1.05 rad/s, 1.74 rad/s²", "the equations, 1.05 rad/s, 1.74 rad/s²"):
        errors = RESULTS[name]["errors"]
        near, spread = SCRIPT.nearness(errors)
        assert near >= 8
        assert spread <= 0.22
        for key in SCRIPT.NAMES:
            assert errors["leader"][key] == pytest.approx(SCRIPT.TABLE_13["aifqsmc"]["leader"][key], rel=0.1)
    assert min(SCRIPT.nearness(RESULTS[name]["errors"])[1] for name in ("as shipped", "the equations")) > 0.6


def test_a_slow_drive_winds_up_the_gain_of_follower1_only():
    overrides = SCRIPT.READINGS["the equations, 1.05 rad/s, 1.74 rad/s²"]
    drift = measured("experiment", "aifqsmc", *overrides)["drift"]
    largest = {robot: row["k_h_omega"]["largest"] for robot, row in drift.items()}
    assert largest == pytest.approx({"leader": 0.32, "follower1": 2.78, "follower2": 0.32}, rel=0.1)
    found = SCRIPT.run(overrides)["errors"]["follower1"]["theta_e"]
    assert found == pytest.approx(
        RESULTS["the equations, 1.05 rad/s, 1.74 rad/s²"]["errors"]["follower1"]["theta_e"], rel=0.1
    )


@needs_mujoco
@pytest.mark.long
@pytest.mark.parametrize(
    "name",
    ["as shipped", "odometry", "noise of 1 cm, 0.01 rad, 0.01 m/s, 0.01 rad/s"],
)
def test_bodies_give_what_the_results_say(name):
    found, kept = SCRIPT.run(SCRIPT.READINGS[name]), RESULTS[name]
    assert (found["stopped"], found["robots_hit"]) == (kept["stopped"], kept["robots_hit"])
    for robot, row in kept["errors"].items():
        for name in SCRIPT.NAMES:
            assert found["errors"][robot][name] == pytest.approx(row[name], rel=0.05)


def close(result):
    errors = {
        robot: {name: pytest.approx(value, rel=0.02, abs=1e-3) for name, value in row.items()}
        for robot, row in result["errors"].items()
    }
    return {**result, "errors": errors}
