"""A bar that says how far long work is, on terminals only."""

import io
import re
import runpy
import sys
from contextlib import contextmanager

import pytest

from dwmr.control.fuzzy_gains import Rules
from dwmr.core import jit
from dwmr.scenario.file import find, read
from dwmr.simulation import simulate
from fuzzyctl.cli.bars import progress, stages


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

    def test_of_a_run_come_in_order(self, dwmr, monkeypatch):
        seen = []

        @contextmanager
        def recorded():
            yield lambda name, total: seen.append(name) or (lambda done: None)

        monkeypatch.setattr("dwmr.cli.run.stages", recorded)
        assert dwmr("run", "paper", "--controller", "smc", "--set", "run.horizon=1")[0] == 0
        seen = [name for name in seen if name != "compiling"]  # which there is only without a cache
        assert seen == [
            "reading", "proving", "loading the compiler", "simulating smc", "measuring", "drawing", "writing"
        ]  # fmt: skip


@pytest.mark.skipif(not jit.COMPILED, reason="numba is missing")
def test_compiling_is_reported_as_a_share_of_all_functions(tmp_path):
    source = tmp_path / "own.py"  # a file of its own, so that it is in no cache of an earlier run
    source.write_text("def successor(x):\n    return x + 1.0\n", encoding="utf-8")
    shares = []
    with jit.watched(shares.append):
        jit.compiled(runpy.run_path(str(source))["successor"])(1.0)
    assert 0.0 < shares[-1] <= 100.0


def test_a_run_reports_first_that_all_is_compiled():
    file = read(find("paper"), ["run.horizon=1"])
    seen = []
    simulate.run(simulate.prepare(file, "smc", Rules(file.scenario.rules, (), file.places)), seen.append)
    assert (seen[0], seen[-1]) == (0, 201)
