"""A bar that says how far long work is, on terminals only."""

import io
import sys

from dwmr.cli.common import progress


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
    assert "left:" in found


def test_a_remark_stands_until_the_first_move(monkeypatch):
    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setenv("TERM", "xterm")
    with progress(" (compiling at the first run)") as start:
        start("smc", 8)
    assert "smc (compiling at the first run)" in sys.stderr.getvalue()
