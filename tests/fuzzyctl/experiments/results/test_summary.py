"""summary.json."""

import json
import math

import numpy as np

from fuzzyctl.experiments.results.folder import results
from fuzzyctl.experiments.results.summary import finite, versions, write_summary


def test_numbers_that_are_not_finite_become_null(tmp_path):
    with results(tmp_path, ("summary.json",)) as files:
        write_summary(files, {"measures": {"overshoot": math.nan, "rise": 1.5, "peaks": (np.float64("inf"), 2)}})
        files.publish()
    found = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert found == {"measures": {"overshoot": None, "rise": 1.5, "peaks": [None, 2]}}


def test_what_is_no_number_stays():
    assert finite({"name": "nan", "on": True, "none": None}) == {"name": "nan", "on": True, "none": None}


def test_versions_name_what_computes():
    assert list(versions()) == ["python", "fuzzyctl", "numpy", "numba"]
