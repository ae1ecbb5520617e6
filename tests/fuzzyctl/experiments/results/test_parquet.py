"""Parquet tables with metadata under the name of an application."""

import pytest

from fuzzyctl.experiments.results.parquet import read_table, write_table


def test_columns_and_metadata_come_back(tmp_path):
    columns = {"run": [0, 1], "x": [0.1, None], "why": [None, "σ"]}
    write_table(tmp_path / "t.parquet", columns, {"runs": 2}, "tanks")
    assert read_table(tmp_path / "t.parquet", "tanks") == (columns, {"runs": 2})


def test_a_table_of_another_application_is_refused(tmp_path):
    write_table(tmp_path / "t.parquet", {"run": [0]}, {}, "tanks")
    with pytest.raises(ValueError, match="it has no metadata of valves"):
        read_table(tmp_path / "t.parquet", "valves")
