"""A bar that says how far long work is, on terminals only."""

import io
import re
import sys

from fuzzyctl.cli.progress import progress, stages


class Terminal(io.StringIO):
    def isatty(self):
        return True


def shown(monkeypatch, stream, **options):
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    with progress(**options) as start:
        move = start("smc", 8)
        move(2)
    return stream.getvalue()


def test_a_pipe_gets_none(monkeypatch):
    assert shown(monkeypatch, io.StringIO()) == ""


def test_a_terminal_gets_one_that_moves(monkeypatch):
    found = shown(monkeypatch, Terminal(), left=True)
    assert "smc" in found
    assert "25 %" in found
    assert "left" in found


def test_a_remark_stands_until_the_first_move(monkeypatch):
    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setenv("TERM", "xterm")
    with progress(" (compiling at the first run)") as start:
        start("smc", 8)
    assert "smc (compiling at the first run)" in sys.stderr.getvalue()


def lines(stream):
    """What a terminal shows one after the other, without colours."""
    return re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", stream.getvalue()).replace("\r", "\n").splitlines()


class TestStages:
    def test_take_each_others_place(self, monkeypatch):
        monkeypatch.setattr(sys, "stderr", Terminal())
        monkeypatch.setenv("TERM", "xterm")
        with stages() as begin:
            begin("reading", 0)
            begin("compiling", 100)(25.5)
        found = lines(sys.stderr)
        assert any("compiling" in line and "26 %" in line for line in found)
        assert not any("reading" in line and "compiling" in line for line in found)

    def test_say_nothing_in_a_pipe(self, monkeypatch):
        monkeypatch.setattr(sys, "stderr", io.StringIO())
        with stages() as begin:
            begin("reading", 0)
            begin("compiling", 100)(50)
        assert sys.stderr.getvalue() == ""
