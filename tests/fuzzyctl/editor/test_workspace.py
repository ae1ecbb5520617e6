import pytest

from fuzzyctl.editor import session
from fuzzyctl.editor.session import Workspace, matches, rule_files
from tests.fuzzyctl.editor.marked import LOOP, SYSTEM, marked


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "sub").mkdir()
    for hidden in (".git", "node_modules"):
        (tmp_path / hidden).mkdir()
        (tmp_path / hidden / "c.fz").write_text("system hidden\n")
    (tmp_path / "a.fz").write_text(SYSTEM)
    (tmp_path / "sub" / "b.fz").write_text(LOOP)
    (tmp_path / "bytes.fz").write_bytes(b"\xff\xfe\0")
    (tmp_path / "other.txt").write_text("system other\n")
    return tmp_path


@pytest.mark.parametrize(
    ("query", "found"),
    [
        ("service", ["service"]),
        ("SERV", ["service"]),
        ("srvc", ["service"]),
        ("tip", ["tip", "tip"]),
        ("gain", ["gain"]),
        ("closed", ["closed"]),
        ("hardly", ["hardly"]),
        ("poor", ["poor"]),
        ("most", ["most"]),
        ("small", ["small"]),
        ("surface", ["surface"]),
        ("level", ["level"]),
        ("law", ["law", "law"]),
        ("iae", ["iae"]),
        ("food", ["food"]),
        ("good", ["good"]),
        ("hidden", []),
        ("other", []),
        ("zzz", []),
    ],
)
def test_names_of_all_files(folder, query, found):
    assert [s.name for s in Workspace().symbols([folder], query, {})] == found


def test_all_names(folder):
    names = {s.name for s in Workspace().symbols([folder], "", {})}
    assert {"tip", "service", "law", "closed", "N"} <= names


def test_texts_that_are_open_count_instead_of_files(folder):
    opened = {str(folder / "a.fz"): marked("system unsaved\n§")[0]}
    files = Workspace()
    assert [s.name for s in files.symbols([folder], "unsaved", opened)] == ["unsaved"]
    assert files.symbols([folder], "service", opened) == []


def test_files_change_and_vanish(folder):
    files = Workspace()
    assert files.symbols([folder], "other", {}) == []
    (folder / "a.fz").write_text("system another_one\n")
    assert [s.name for s in files.symbols([folder], "other", {})] == ["another_one"]
    (folder / "a.fz").unlink()
    assert files.symbols([folder], "other", {}) == []
    assert files.symbols([folder / "absent"], "", {}) == []


def test_not_more_files_than_allowed(folder, monkeypatch):
    assert [p.name for p in rule_files([folder])] == ["a.fz", "bytes.fz", "b.fz"]
    monkeypatch.setattr(session, "MAX_FILES", 1)
    assert [p.name for p in rule_files([folder])] == ["a.fz"]


@pytest.mark.parametrize(("query", "name", "is_match"), [("", "a", True), ("ac", "abc", True), ("ca", "abc", False)])
def test_letters_in_order(query, name, is_match):
    assert matches(query, name) is is_match
