"""Drawn loops that `check` passes run through the other commands without a raw exception."""

import pytest

from tests.fuzz.runs_what_check_passes import drawn, failure, failures_of

#: Commands that take no compiler and no long proof; the script has all of them.
COMMANDS = (
    "fmt --check FILE",
    "simulate FILE -o run",
    "eval FILE INPUTS",
    "page FILE -o page.html",
    "codegen FILE --target c --free P -o out --unproved",
)


@pytest.mark.parametrize("seed", range(2))
def test_drawn_loops_that_check_passes_run(seed, tmp_path, monkeypatch):
    files = drawn(seed)
    monkeypatch.chdir(tmp_path)
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert failure(["check", "drawn.fz"]) == (0, "")
    assert list(failures_of(files, COMMANDS)) == []
