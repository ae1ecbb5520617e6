"""Ranges of params that follow from others: in files, under settings, under free numbers, in blocks inside blocks."""

import pytest

import fuzzyctl
from fuzzyctl.diagnostics.diagnostic import DiagnosticError, ValueOutOfBoundsError
from fuzzyctl.model.checks.terms import has_computed_params, outside_ranges
from fuzzyctl.simulation.loop_params import with_settings
from tests.fuzzyctl.resolve.mistakes import errors_in

TEXT = """controller inner
input x
param g in (0, 2] = 1
param top in [0, 9] = 2
param low in [0, top] = 0
state s in [0, 2] = g
next s = s
output y = g * x + low + s

controller law
input x
param k in (0, 5) = 1
param m = 2 * k
param z in [0, 3] = m
block b = inner(x, g=k)
output y = b.y + z
every 10 ms

plant store
input u
state q = 0
der q = u - q
output o = q

loop run_of_law
param kk = 1
block law   = law(1 - store.o, k=kk)
block store = store(law.y)
run 100 ms
"""


@pytest.fixture
def loop(tmp_path):
    (tmp_path / "loop.fz").write_text(TEXT.replace("= g\nnext", "= 1\nnext"), encoding="utf-8")
    return fuzzyctl.load(tmp_path / "loop.fz", block=fuzzyctl.Loop)


@pytest.mark.parametrize(
    ("written", "message"),
    [
        ("kk = 9", "param 'k' of 'law' is 9, outside of (0, 5)"),
        ("kk = 1.6", "param 'z' of 'law' is 3.2, outside of [0, 3]"),
    ],
)
def test_of_a_block_of_a_loop(written, message):
    assert errors_in(TEXT) == []
    assert [m for _, m, _ in errors_in(TEXT.replace("kk = 1", written))] == [message]


def test_of_a_block_in_a_controller():
    """The end of a range is that under what the block is given; starts of states follow, too."""
    assert errors_in(TEXT.replace("g=k)", "top=5, low=4)")) == []
    found = errors_in(TEXT.replace("g=k)", "top=5, low=6)"))
    assert [m for _, m, _ in found] == ["param 'low' of 'inner' is 6, outside of [0, top]"]
    found = errors_in(TEXT.replace("in (0, 2]", "in (0, 9]").replace("g=k)", "g=3)"))
    assert [m for _, m, _ in found] == ["the start of state 's' of 'inner' is 3, outside of [0, 2]"]


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("kk", 0, "param 'law.k' is 0, outside of (0, 5)"),
        ("law.k", 5, "param 'law.k' is 5, outside of (0, 5)"),
        ("kk", 1.6, "param 'law.z' is 3.2, outside of [0, 3]"),
    ],
)
def test_under_settings_and_free_numbers(loop, name, value, message):
    with pytest.raises(DiagnosticError) as error:
        with_settings(loop, {name: value})
    assert [d.message for d in error.value.diagnostics] == [message]
    experiment = fuzzyctl.Experiment(loop, "python", free=[name])
    assert experiment.run([1.4]).stopped is None
    with pytest.raises(ValueOutOfBoundsError, match=r"'law\.[kz]'"):
        experiment.run([value])


def test_inside_a_block_that_is_inside(loop):
    law = loop.controllers[0]
    assert [o.what for o in outside_ranges(law, {"k": 1.4}, "law.")] == []
    assert [o.what for o in outside_ranges(law, {"k": 2.5, "z": 0.0}, "law.")] == ["param 'law.b.g'"]
    assert has_computed_params(law)
    assert not has_computed_params(loop.plants[0])


def test_of_free_numbers_of_a_controller(loop):
    """The end of a range may be free, too."""
    step = fuzzyctl.compile(loop.controllers[0], "python", free=["k"])
    assert step.start(k=1.4)[-1] == 1.4
    with pytest.raises(ValueOutOfBoundsError, match=r"'z' under these free numbers must be in \[0, 3\], got 3.2"):
        step.start(k=1.6)
    inner = fuzzyctl.compile(loop.controllers[0].controllers[0], "python", free=["top", "low"])
    assert inner.start(top=5, low=4)[-1] == 4.0
    with pytest.raises(ValueOutOfBoundsError, match="low"):
        inner.start(top=3, low=4)
