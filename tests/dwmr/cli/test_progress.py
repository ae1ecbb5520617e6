"""Stages of a run, and how far each is."""

import runpy
from contextlib import contextmanager

import pytest

from dwmr.core import jit


def test_the_stages_of_a_run_come_in_order(dwmr, monkeypatch):
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
