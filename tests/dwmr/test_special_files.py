"""Pipes in place of files: named by a scenario or found in a folder of results, they are refused and block nothing."""

import os

import pytest

from dwmr.scenario.file import read
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from tests.dwmr.process import dwmr, here

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the platform has no named pipes")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("base.toml", 'extends = "base.toml"\n'),
        ("path.csv", 'extends = "paper"\n[reference]\nkind = "csv"\nfile = "path.csv"\n'),
    ],
)
def test_a_scenario_that_names_a_pipe_is_refused(tmp_path, name, text):
    os.mkfifo(tmp_path / name)
    (tmp_path / "mine.toml").write_text(text)
    with pytest.raises(DiagnosticError, match="not a regular file"):
        read(tmp_path / "mine.toml")


def test_a_rule_file_that_is_a_pipe_is_refused(tmp_path):
    os.mkfifo(tmp_path / "own.fz")
    (tmp_path / "mine.toml").write_text('extends = "paper"\n[rules.ais_reaction]\nfile = "own.fz"\n')
    done = dwmr("check", "mine.toml", status=1, cwd=tmp_path, timeout=120)
    assert "rules.ais_reaction.file" in done.stderr
    assert "is not a regular file" in done.stderr


def test_a_name_of_a_law_that_no_file_can_have_is_wrong_usage():
    done = here("run", "paper", "--controller", "a" * 300, status=2)
    assert "is not one of" in done.stderr
