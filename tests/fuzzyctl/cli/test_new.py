"""Files that `fuzzyctl new` writes; transcripts/new.txt holds what it prints."""

import pytest

import fuzzyctl
from tests.commands import runner
from tests.shipped import SYSTEMS

run = runner()


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", ["my heater", "a-b", "x" * 201])
def test_a_name_that_cannot_be_one_is_wrong_usage(name, folder):
    assert run("new", "--", name).exit_code == 2
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("name", ["system", "abs", "x", "ö" * 100])
def test_every_other_name_makes_a_clean_file_in_its_canonical_layout(name):
    result = run("new", name)
    assert result.exit_code == 0, result.output
    assert run("check", "--deny", "warnings", f"{name}.fz").exit_code == 0
    assert run("fmt", "--check", f"{name}.fz").exit_code == 0
    assert fuzzyctl.load(f"{name}.fz").name == name


@pytest.mark.parametrize("path", sorted(SYSTEMS[0].parent.rglob("*.fz")), ids=lambda p: p.stem)
def test_a_copy_of_a_shipped_file_is_whole(path, folder):
    assert run("new", "copy", "--from", path.stem).exit_code == 0
    assert {p.name for p in folder.iterdir()} - {"copy.fz"} <= {p.name for p in path.parent.glob("*")}
    result = run("check", "copy.fz")
    assert result.exit_code == 0, result.output
