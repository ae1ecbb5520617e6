"""A line that says how far long work is, on terminals only."""

import io
import re
import sys

import pytest

from fuzzyctl.cli import progress as module
from fuzzyctl.cli.main import main
from fuzzyctl.cli.progress import status_line


class Terminal(io.StringIO):
    def isatty(self):
        return True


def shown(monkeypatch, patience):
    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setattr(module, "PATIENCE", patience)
    monkeypatch.setenv("TERM", "xterm")
    with status_line() as reported:
        reported("comparing: 10 %")
        reported("comparing: 20 %")
    return sys.stderr.getvalue()


def test_a_pipe_gets_none(monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with status_line() as reported:
        assert reported is None


def test_a_terminal_gets_one_once_it_takes_long(monkeypatch):
    assert "comparing: 20 %" in shown(monkeypatch, 0.0)


def test_short_work_is_quiet(monkeypatch):
    assert shown(monkeypatch, 1000.0) == ""


def test_proofs_tell_of_their_boxes(monkeypatch, tmp_path):
    path = tmp_path / "s.fz"
    path.write_text(
        "system s\ndefuzzifier weighted_average\ninput x in [0, 1]\n  a = gaussian(0, 0.4)\n  b = gaussian(1, 0.4)\n"
        "output y in [0, 1]\n  p = constant(0)\n  q = constant(1)\nif x is a then y is p\nif x is b then y is q\n"
        "require y <= x + 0.2\n",
        encoding="utf-8",
    )
    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setattr(module, "PATIENCE", 0.0)
    monkeypatch.setenv("TERM", "xterm")
    with pytest.raises(SystemExit) as stop:
        main(["prove", str(path)])
    assert stop.value.code == 0
    assert re.search(r"y <= x \+ 0\.2: \d+ boxes settled, \d+ open", sys.stderr.getvalue())
