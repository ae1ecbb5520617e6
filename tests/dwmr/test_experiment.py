"""docs/explanation/experiment.md prints numbers: they must be those of its result file, and that of the runs."""

import importlib.util
import json
from pathlib import Path

import pytest

from tests.physics import needs_mujoco

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "explanation" / "experiment"
PAGE = FOLDER.with_suffix(".md").read_text(encoding="utf-8")
RESULTS = json.loads((FOLDER / "readings.json").read_text(encoding="utf-8"))


def script():
    spec = importlib.util.spec_from_file_location("readings", FOLDER / "readings.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_tables_of_the_page_are_those_of_the_results():
    for row in script().rows(RESULTS):
        assert row in PAGE


def test_all_readings_have_results():
    assert list(RESULTS) == list(script().READINGS)


def test_the_leader_is_within_15_percent_and_half_the_step_changes_less_than_2():
    table = script().TABLE_13["aifqsmc"]
    shipped, half = (RESULTS[name]["errors"] for name in ("as shipped", "half the step"))
    for name in script().NAMES:
        assert shipped["leader"][name] == pytest.approx(table["leader"][name], rel=0.15)
        for robot, row in shipped.items():
            assert half[robot][name] == pytest.approx(row[name], rel=0.02)


def test_the_equations_give_what_the_results_say():
    assert script().run(script().READINGS["the equations"]) == close(RESULTS["the equations"])


@needs_mujoco
@pytest.mark.long
def test_bodies_give_what_the_results_say():
    found, kept = script().run(()), RESULTS["as shipped"]
    assert (found["stopped"], found["robots_hit"]) == (kept["stopped"], kept["robots_hit"])
    for robot, row in kept["errors"].items():
        for name in script().NAMES:
            assert found["errors"][robot][name] == pytest.approx(row[name], rel=0.05)


def close(result):
    errors = {
        robot: {name: pytest.approx(value, rel=0.02, abs=1e-3) for name, value in row.items()}
        for robot, row in result["errors"].items()
    }
    return {**result, "errors": errors}
