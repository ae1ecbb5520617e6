"""docs/explanation/vehicles.md prints numbers: they must be those of its result file, and that of a run."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "explanation" / "vehicles"
RESULTS = json.loads((FOLDER / "runs.json").read_text(encoding="utf-8"))


def script():
    spec = importlib.util.spec_from_file_location("runs", FOLDER / "runs.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_table_of_the_page_is_that_of_the_results():
    page = FOLDER.with_suffix(".md").read_text(encoding="utf-8")
    assert list(RESULTS) == list(script().RUNS)
    for row in script().rows(RESULTS):
        assert row in page


@pytest.mark.parametrize("name", ["car, its own law, obstacles, wide turns", "mecanum wheels, their own law"])
def test_runs_give_what_the_results_say(name):
    found = script().result(*script().RUNS[name])
    np.testing.assert_allclose(found["errors"], RESULTS[name]["errors"], rtol=0.02, atol=1e-3)
    assert list(found["hits"]) == RESULTS[name]["hits"] == [0, 0]
