"""Steps whose numbers are states: params, params of instances and calls, and numbers of systems."""

import numpy as np
import pytest

import fuzzyctl
from fuzzyctl import ArgumentError, UnknownNameError, ValueOutOfBoundsError

BACKENDS = ("python", "numpy", "numba")

TEXT = """
system surface
defuzzifier center_average
param width = 1
input e in [-1, 1]
  terms N@(-width) Z@0 P@(width)
output u in [-1, 1]
  terms N=-1 Z=0 P=1
table u = e
    N Z P
  | N Z P

controller lag
input x
param T = 0.5
param U = 2 * T
let y = lowpass(x, U)
output y2 = y

controller law
function gained(x) = k2 * x
input r
param k in (0, 10] = 2 unit "V"
param k2 = k ^ 2
param first = 0.1
param w = 1
let moved = surface(k * r, width=w)
block smooth = lag(moved, T=k / 4)
state s = first
next s = s + dt * gained(r)
output u = smooth.y2 + s + integral(r, start=first)
every 100 ms
"""
FREE = ["k", "first", "w", "surface.u.P.peak"]
VALUES = {"k": 3.0, "first": 0.2, "w": 0.9, "surface.u.P.peak": 0.8}
TYPED = (
    TEXT.replace("= 2 unit", "= 3 unit").replace("= 0.1", "= 0.2").replace("w = 1", "w = 0.9").replace("P=1", "P=0.8")
)
INPUTS = np.sin(np.arange(40) / 5)


def controller(text=TEXT):
    return fuzzyctl.loads(text, block="law")


@pytest.mark.parametrize("backend", BACKENDS)
def test_free_numbers_are_those_that_are_typed(backend):
    step = fuzzyctl.compile(controller(), backend, free=FREE)
    assert step.free_names == tuple(FREE)
    assert step.state_names[-4:] == tuple(FREE)
    expected, last = fuzzyctl.compile(controller(TYPED), "python").run(INPUTS)
    found, state = step.run(INPUTS, step.start(VALUES))
    assert found == pytest.approx(expected, abs=1e-12)
    assert state == pytest.approx([*last, *VALUES.values()], abs=1e-12)
    typed, _ = fuzzyctl.compile(controller(), "python").run(INPUTS)
    assert step.run(INPUTS)[0] == pytest.approx(typed, abs=1e-12)


def test_without_free_numbers_a_start_takes_none():
    step = fuzzyctl.compile(controller(), "python")
    assert step.free_names == ()
    with pytest.raises(UnknownNameError, match="no free number 'k'; there are: none"):
        step.start(k=3)


@pytest.mark.parametrize(
    ("values", "error", "message"),
    [
        ({"k": 11}, ValueOutOfBoundsError, r"free number 'k' must be in \(0, 10\] V, got 11.0"),
        ({"k": 0}, ValueOutOfBoundsError, r"free number 'k' must be in \(0, 10\] V, got 0.0"),
        ({"first": np.inf}, ValueOutOfBoundsError, "free number 'first' must be a finite number, got inf"),
        ({"w": -1}, ValueOutOfBoundsError, "free number 'surface.width' must be one that the system can have"),
        ({"x": 1}, UnknownNameError, "no free number 'x'; there are: k, first, w, surface.u.P.peak"),
        ({"k": "a"}, ArgumentError, "free number 'k' must be an array of real numbers"),
    ],
)
def test_values_are_checked(values, error, message):
    step = fuzzyctl.compile(controller(), "python", free=FREE)
    with pytest.raises(error, match=message):
        step.start(values)


@pytest.mark.parametrize(
    ("names", "error", "message"),
    [
        (["q"], UnknownNameError, "no free number 'q'; there are: k, k2, first, w, smooth.T, smooth.U, surface.NAME"),
        (["surface.q"], UnknownNameError, "there are: surface.width, surface.e, surface.u"),
        (["k", "k"], ArgumentError, "'k' cannot be free: it is given twice"),
        (["surface.width"], ArgumentError, "'surface.width' cannot be free: a call of the system sets it"),
        ("k", ArgumentError, "free must be a list of names, got str"),
        ([1], ArgumentError, "got int in it"),
    ],
)
def test_what_cannot_be_free_is_refused(names, error, message):
    with pytest.raises(error, match=message):
        fuzzyctl.compile(controller(), "python", free=names)


def test_numbers_of_states_cannot_be_free():
    late = controller(TEXT.replace("integral(r, start=first)", "delay(r, k)"))
    with pytest.raises(ArgumentError, match="'k' cannot be free: a constant depends on it at"):
        fuzzyctl.compile(late, "python", free=["k"])


WRITTEN_ONCE = """
param K = 1
param L = 2 * K

system surface
defuzzifier weighted_average
input e in [-1, 1]
  terms N P
output u in [-9, 9] = L * e + K

system other
defuzzifier weighted_average
input x in [-1, 1]
  terms N P
output F in [-2, 2] adaptive rate x
  terms N=0 P=0
table F = x
    N P
  | N P

controller inner
input x
state s = K
next s = 0.5 * s + x
output y = K * s

controller law
input r
block b = inner(r)
output u = surface(r) + b.y + other(r)
every 1 s
"""


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_param_that_is_written_once_for_all_blocks_is_one_number(backend):
    step = fuzzyctl.compile(controller(WRITTEN_ONCE), backend, free=["K"])
    expected, _ = fuzzyctl.compile(controller(WRITTEN_ONCE.replace("K = 1", "K = 3")), "python").run(INPUTS)
    assert step.run(INPUTS, step.start(K=3))[0] == pytest.approx(expected, abs=1e-12)


def test_a_number_that_a_system_with_a_state_reads_cannot_be_free():
    text = WRITTEN_ONCE.replace("rate x", "rate K * x")
    with pytest.raises(ArgumentError, match=r"'other\.K' cannot be free: the system has a state"):
        fuzzyctl.compile(controller(text), "python", free=["K"])


CONDITIONS = """
controller law
input r
param k in [0, 5] = 0.5
let high = k > 1
let both = high and r > 0
let gain = where(high, 2 * k, k)
state s = 0
next s = s + where(both, r, 0)
output u = where(not high, gain * r, s) / (1 + high)
output is_high = high
every 1 s
"""


@pytest.mark.parametrize("backend", BACKENDS)
def test_conditions_on_free_numbers_have_names(backend):
    step = fuzzyctl.compile(controller(CONDITIONS), backend, free=["k"])
    for k in (0.5, 3.0):
        expected, _ = fuzzyctl.compile(controller(CONDITIONS.replace("= 0.5", f"= {k}")), "python").run(INPUTS)
        assert step.run(INPUTS, step.start(k=k))[0] == pytest.approx(expected, abs=1e-12)


def test_a_let_without_a_value_under_free_numbers_is_refused():
    text = CONDITIONS.replace("let gain =", "let inverse = 1 / (k - 2)\nlet gain = inverse *")
    step = fuzzyctl.compile(controller(text), "python", free=["k"])
    with pytest.raises(ArgumentError, match="'inverse' has no value under these free numbers: division by zero"):
        step.start(k=2)
