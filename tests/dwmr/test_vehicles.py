"""docs/explanation/vehicles.md prints numbers: they must be those of its result file, and that of a run."""

import numpy as np
import pytest

from tests import explanation

RESULTS = explanation.results("vehicles/runs.json")
SCRIPT = explanation.script("vehicles/runs.py")


def test_the_table_of_the_page_is_that_of_the_results():
    page = explanation.text("vehicles.md")
    assert list(RESULTS) == list(SCRIPT.RUNS)
    for row in SCRIPT.rows(RESULTS):
        assert row in page


@pytest.mark.parametrize("name", ["car, its own law, obstacles, wide turns", "mecanum wheels, their own law"])
def test_runs_give_what_the_results_say(name):
    found = SCRIPT.result(*SCRIPT.RUNS[name])
    np.testing.assert_allclose(found["errors"], RESULTS[name]["errors"], rtol=0.02, atol=1e-3)
    assert list(found["hits"]) == RESULTS[name]["hits"] == [0, 0]
