"""Results are published whole or not at all; columns are read back bit for bit."""

import csv
import json
import math
import os

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.experiments.parquet import read_table, write_table
from fuzzyctl.experiments.result_files import columns_of, finite, results, versions, write_csv, write_summary


def test_files_come_all_or_none(tmp_path):
    (tmp_path / "a").write_text("old")
    with results(tmp_path, ("a", "b")) as files:
        files.write("a", lambda path: path.write_text("new"))
        with pytest.raises(DiagnosticError):
            files.write("b", lambda path: (path / "no" / "such").write_text("new"))
    assert (tmp_path / "a").read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a"]


def test_what_an_earlier_run_left_does_not_stay_beside_new_files(tmp_path):
    (tmp_path / "b").write_text("old")
    (tmp_path / "mine").write_text("kept")
    with results(tmp_path, ("a", "b")) as files:
        files.write("a", lambda path: path.write_text("new"))
        files.publish()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a", "mine"]


def test_a_folder_that_stays_empty_goes_again(tmp_path):
    with pytest.raises(KeyboardInterrupt), results(tmp_path / "x" / "y", ("a",)):
        raise KeyboardInterrupt
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_the_place_of_the_folder_is_reported(tmp_path):
    (tmp_path / "x").write_text("")
    with pytest.raises(DiagnosticError, match="x cannot be written: it is not a folder"), results(tmp_path / "x", ()):
        pass


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes")
def test_a_pipe_in_the_way_of_a_file_is_reported(tmp_path):
    os.mkfifo(tmp_path / "a")
    with pytest.raises(DiagnosticError, match="a cannot be written: it is not a reg"), results(tmp_path, ("a",)):
        pass


def test_a_folder_in_the_way_of_a_file_is_reported(tmp_path):
    (tmp_path / "a").mkdir()
    with pytest.raises(DiagnosticError, match="a cannot be written: it is a folder"), results(tmp_path, ("a",)):
        pass


def test_a_column_has_one_type():
    rows = [{"a": 1, "b": None, "c": "x"}, {"a": 2.5, "c": 1.5}, {"a": 3, "b": 0.5, "c": True}]
    found = columns_of(rows)
    assert found["a"] == [1.0, 2.5, 3.0]
    assert {type(value) for value in found["a"]} == {float}
    assert found["b"] == [None, None, 0.5]
    assert found["c"] == ['"x"', "1.5", "true"]


@given(values=st.lists(st.one_of(st.none(), st.floats())))
def test_numbers_read_back_bit_for_bit(tmp_path_factory, values):
    path = tmp_path_factory.mktemp("csv") / "table.csv"
    write_csv(path, {"run": list(range(len(values))), "x": values})
    with path.open(newline="", encoding="utf-8") as file:
        read = [float(row["x"]) if row["x"] else None for row in csv.DictReader(file)]
    for value, found in zip(values, read, strict=True):
        assert found == value or (math.isnan(value) and math.isnan(found))
        assert value is None or math.copysign(1.0, found) == math.copysign(1.0, value) or math.isnan(value)


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


def test_columns_and_metadata_come_back(tmp_path):
    columns = {"run": [0, 1], "x": [0.1, None], "why": [None, "σ"]}
    write_table(tmp_path / "t.parquet", columns, {"runs": 2}, "tanks")
    assert read_table(tmp_path / "t.parquet", "tanks") == (columns, {"runs": 2})


def test_a_table_of_another_application_is_refused(tmp_path):
    write_table(tmp_path / "t.parquet", {"run": [0]}, {}, "tanks")
    with pytest.raises(ValueError, match="it has no metadata of valves"):
        read_table(tmp_path / "t.parquet", "valves")
