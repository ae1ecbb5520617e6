"""A folder of results: filled at once, or not at all."""

import os

import pytest

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.experiments.results.folder import results


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
