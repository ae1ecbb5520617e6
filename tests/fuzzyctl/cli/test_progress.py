"""A line that says how far long work is, on terminals only."""

import io
import sys

from fuzzyctl.cli import progress as module
from fuzzyctl.cli.progress import progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


def shown(monkeypatch, patience):
    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setattr(module, "PATIENCE", patience)
    monkeypatch.setenv("TERM", "xterm")
    with progress() as told:
        told("comparing: 10 %")
        told("comparing: 20 %")
    return sys.stderr.getvalue()


def test_a_pipe_gets_none(monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with progress() as told:
        assert told is None


def test_a_terminal_gets_one_once_it_takes_long(monkeypatch):
    assert "comparing: 20 %" in shown(monkeypatch, 0.0)


def test_short_work_is_quiet(monkeypatch):
    assert shown(monkeypatch, 1000.0) == ""
