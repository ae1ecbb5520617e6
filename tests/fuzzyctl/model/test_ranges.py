"""Ranges of params that follow from others: in files, under settings, under free numbers, in blocks inside blocks."""

import pytest

import fuzzyctl
from fuzzyctl import DiagnosticError, ValueOutOfBoundsError
from fuzzyctl.testing import check_text

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


def messages(text):
    return [d.message for d in check_text(text)[1] if d.severity == "error"]


@pytest.fixture
def loop():
    return fuzzyctl.loads(TEXT.replace("= g\nnext", "= 1\nnext"), block=fuzzyctl.Loop)


@pytest.mark.parametrize(
    ("written", "message"),
    [
        ("kk = 9", "param 'k' of 'law' is 9, outside of (0, 5)"),
        ("kk = 1.6", "param 'z' of 'law' is 3.2, outside of [0, 3]"),
    ],
)
def test_of_a_block_of_a_loop(written, message):
    assert messages(TEXT) == []
    assert messages(TEXT.replace("kk = 1", written)) == [message]


def test_of_a_block_in_a_controller():
    """The end of a range is that under what the block is given; starts of states follow, too."""
    assert messages(TEXT.replace("g=k)", "top=5, low=4)")) == []
    found = messages(TEXT.replace("g=k)", "top=5, low=6)"))
    assert found == ["param 'low' of 'inner' is 6, outside of [0, top]"]
    found = messages(TEXT.replace("in (0, 2]", "in (0, 9]").replace("g=k)", "g=3)"))
    assert found == ["the start of state 's' of 'inner' is 3, outside of [0, 2]"]


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
        fuzzyctl.simulate(loop, **{name: value})
    assert [d.message for d in error.value.diagnostics] == [message]
    experiment = fuzzyctl.Experiment(loop, "python", free=[name])
    assert experiment.run([1.4]).stopped is None
    with pytest.raises(ValueOutOfBoundsError, match=r"'law\.[kz]'"):
        experiment.run([value])


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
