"""A line or a bar that says how far long work is, on terminals only."""

import io
import re
import sys

import pytest

from fuzzyctl.cli import progress as module
from fuzzyctl.cli.main import main
from fuzzyctl.cli.progress import progress, stages, status_line


class Terminal(io.StringIO):
    def isatty(self):
        return True


def shown_on(stream, monkeypatch):
    """Make a stream standard error; pytest replaces it between fixtures and tests."""
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    return stream


def test_a_pipe_gets_nothing(monkeypatch):
    pipe = shown_on(io.StringIO(), monkeypatch)
    with status_line() as report:
        assert report is None
    with progress() as start:
        start("smc", 8)(2)
    with stages() as begin:
        begin("reading", 0)
        begin("compiling", 100)(50)
    assert pipe.getvalue() == ""


@pytest.mark.parametrize(("patience", "is_shown"), [(0.0, True), (1000.0, False)])
def test_a_terminal_gets_a_line_once_work_takes_long(monkeypatch, patience, is_shown):
    terminal = shown_on(Terminal(), monkeypatch)
    monkeypatch.setattr(module, "PATIENCE", patience)
    with status_line() as report:
        report("comparing: 10 %")
        report("comparing: 20 %")
    assert ("comparing: 20 %" in terminal.getvalue()) == is_shown
    assert bool(terminal.getvalue()) == is_shown


def test_a_bar_has_a_remark_until_it_moves(monkeypatch):
    terminal = shown_on(Terminal(), monkeypatch)
    with progress(" (compiling at the first run)", left=True) as start:
        move = start("smc", 8)
    assert "smc (compiling at the first run)" in terminal.getvalue()
    with progress(left=True) as start:
        move = start("smc", 8)
        move(2)
    assert re.search("smc.*25 %.*left", terminal.getvalue())


def test_stages_take_each_others_place(monkeypatch):
    terminal = shown_on(Terminal(), monkeypatch)
    with stages() as begin:
        begin("reading", 0)
        begin("compiling", 100)(25.5)
    # The lines of the terminal one after the other, without colours.
    lines = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", terminal.getvalue()).replace("\r", "\n").splitlines()
    assert any("compiling" in line and "26 %" in line for line in lines)
    assert not any("reading" in line and "compiling" in line for line in lines)


def test_proofs_tell_of_their_boxes(monkeypatch, tmp_path):
    terminal = shown_on(Terminal(), monkeypatch)
    path = tmp_path / "s.fz"
    path.write_text(
        "system s\ndefuzzifier weighted_average\ninput x in [0, 1]\n  a = gaussian(0, 0.4)\n  b = gaussian(1, 0.4)\n"
        "output y in [0, 1]\n  p = constant(0)\n  q = constant(1)\nif x is a then y is p\nif x is b then y is q\n"
        "require y <= x + 0.2\n",
        encoding="utf-8",
    )
    monkeypatch.setattr(module, "PATIENCE", 0.0)
    with pytest.raises(SystemExit) as stop:
        main(["prove", str(path)])
    assert stop.value.code == 0
    assert re.search(r"y <= x \+ 0\.2: \d+ boxes settled, \d+ open", terminal.getvalue())
