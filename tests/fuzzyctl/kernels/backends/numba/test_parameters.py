"""Values of systems that differ in numbers only share their machine code."""

import ctypes
import gc
import math
import pickle
import re
import sys
import weakref

import numba
import numpy as np
import pytest

from fuzzyctl import loads
from fuzzyctl.kernels.backends.numba import source as numba_backend
from fuzzyctl.kernels.backends.numba.source import Numbers
from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.plan.build import plan

INTERPOLATED = """
system s
param peak = {peak}
defuzzifier weighted_average
input x in [0, 1]
  lo = triangle(-inf, 0, peak)
  mid = triangle(0, peak, 1)
  hi = triangle(peak, 1, inf)
output u in [-9, 9]
  a = singleton({value})
  b = singleton(3)
  c = singleton(-1)
if x is lo then u is a
if x is mid then u is b
if x is hi then u is c
"""

MAMDANI = """
system s
defuzzifier centroid{samples}
input x in [0, 10]
  lo = gaussian(0, {width})
  hi = gaussian(10, {width})
input y in [0, 10]
  terms lo hi
output u in [0, 30]
  small = triangle(0, 5, {corner})
  large = triangle(10, 25, 30)
output v in [0, 1] defuzzifier weighted_average
  no = singleton(0.125)
  yes = singleton({width} / 10)
if x is lo and y is lo then u is small, v is no
if x is hi or y is hi then u is large, v is yes
"""

ADAPTIVE = """
system s
defuzzifier weighted_average
input x in [-1, 1]
  n = triangle(-inf, -{half}, 0)
  z = triangle(-{half}, 0, {half})
  p = triangle(0, {half}, inf)
output F in [-2, 2] adaptive rate {gamma} * x
  a = singleton(-1)
  b = singleton(0)
  c = singleton(1)
if x is n then F is a
if x is z then F is b
if x is p then F is c
"""


@pytest.fixture
def compiled(monkeypatch, tmp_path):
    """Return the names of kernels that are compiled; the cache is empty at first."""
    monkeypatch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path))
    for name in [n for n in sys.modules if n.startswith("fuzzyctl_kernel_")]:
        monkeypatch.delitem(sys.modules, name)
    return lambda: {n for n in sys.modules if n.startswith("fuzzyctl_kernel_")}


PAIRS = [
    (INTERPOLATED.format(peak=0.25, value=7), INTERPOLATED.format(peak=0.375, value=-6.5), 1),
    (MAMDANI.format(width=3, corner=12, samples=""), MAMDANI.format(width=4.5, corner=11, samples=""), 2),
    # How many samples a set covers is the length of a loop, so the corners stay.
    (
        MAMDANI.format(width=3, corner=12, samples="(resolution=51)"),
        MAMDANI.format(width=4.5, corner=12, samples="(resolution=51)"),
        2,
    ),
]


@numba.njit
def at(f, point):
    return f(point[0]) if len(point) == 1 else f(point[0], point[1])


@pytest.mark.parametrize(("first", "second", "inputs"), PAIRS, ids=["interpolated", "exact", "sampled"])
def test_values_of_further_systems_compile_nothing(compiled, first, second, inputs):
    third = second.replace("4.5", "3.5").replace("0.375", "0.4375")
    points = np.random.default_rng(1).uniform(-2, 12, (40, inputs))
    points[0] = math.nan
    known = set()
    for text in (first, second, third):
        value, plain = compile_system(loads(text), "numba").value, compile_system(loads(text), "python")
        assert len(compiled()) == 1
        assert known <= compiled()
        known = compiled()
        for point in map(tuple, points.tolist()):
            assert at(value, point) == pytest.approx(plain(*point), rel=1e-13, nan_ok=True)


@pytest.mark.parametrize(("half", "gamma"), [(0.3, 2.5), (0.45, 4.0)])
def test_values_of_adaptive_systems_and_their_rates(half, gamma):
    kernel = compile_system(loads(ADAPTIVE.format(half=half, gamma=gamma)), "numba")
    value, rates = kernel.value, kernel.rates_value

    @numba.njit
    def both(f, g, x, state, change):
        g(x, state, change)
        return f(x, state)

    state, change, expected = np.array([-0.5, 0.25, 1.5]), np.empty(3), np.empty(3)
    kernel.jit_rates(0.2, state, expected)
    assert both(value, rates, 0.2, state, change) == kernel(0.2, state) == value(0.2, state)
    assert change.tolist() == expected.tolist() != [0, 0, 0]
    rates(0.2, state, change)
    assert change.tolist() == expected.tolist()


def test_a_value_is_of_its_signature_only():
    """Code that takes kernels as values is compiled once for all of them."""

    @numba.njit
    def slope(f, x):
        return (f(x + 1e-3) - f(x - 1e-3)) / 2e-3

    for peak in (0.25, 0.5, 0.75):
        kernel = compile_system(loads(INTERPOLATED.format(peak=peak, value=7)), "numba")
        assert slope(kernel.value, 0.01) == pytest.approx((kernel(0.011) - kernel(0.009)) / 2e-3, rel=1e-12)
    assert len(slope.signatures) == 1


def test_values_outlive_their_kernels():
    values = [
        compile_system(loads(INTERPOLATED.format(peak=0.5, value=v)), "numba").value for v in np.linspace(1, 5, 9)
    ]

    @numba.njit
    def at_zero(f):
        return f(0.0)

    assert [at_zero(v) for v in values] == np.linspace(1, 5, 9).tolist()


def test_the_code_of_a_value_stays_when_the_value_is_gone():
    """Compiled code keeps the address only, in a list of functions for example."""
    value = compile_system(loads(INTERPOLATED.format(peak=0.5, value=3)), "numba").value
    address, gone = value.__wrapper_address__(), weakref.ref(value)
    del value
    gc.collect()
    assert gone() is None
    assert ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(address)(0.0) == 3.0


def test_values_are_made_anew_in_other_processes():
    kernel = compile_system(loads(ADAPTIVE.format(half=0.3, gamma=2.5)), "numba")
    state, own, other = np.array([-0.5, 0.25, 1.5]), np.empty(3), np.empty(3)
    assert pickle.loads(pickle.dumps(kernel.value))(0.2, state) == kernel.value(0.2, state)
    kernel.rates_value(0.2, state, own)
    pickle.loads(pickle.dumps(kernel.rates_value))(0.2, state, other)
    assert own.tolist() == other.tolist()


def test_without_numba_values_are_plain_functions():
    kernel = compile_system(loads(INTERPOLATED.format(peak=0.5, value=7)), "python")
    assert kernel.value is kernel.jit


def test_no_number_of_the_system_stands_in_the_code():
    program = compile_system(loads(INTERPOLATED.format(peak=0.3125, value=6.75)), "python").algorithm.point
    numbers = Numbers(program)
    source = numba_backend.evaluation_source(program, numbers)
    assert set(re.findall(r"\d+\.\d+", source)) <= {"0.0", "1.0", "0.5", "2.0"}
    assert {0.3125, 6.75} <= set(numbers.values)


def test_sets_that_are_integrated_keep_their_numbers():
    text = MAMDANI.format(width=3, corner=12, samples="").replace("triangle(0, 5, 12)", "gaussian(5, 2)")
    flat = plan(loads(text))
    kernel = compile_system(loads(text), "numba")
    assert not Numbers(kernel.algorithm.point).shares
    assert flat.outputs
    assert kernel(2.0, 3.0) == pytest.approx(compile_system(loads(text), "python")(2.0, 3.0), rel=1e-11)
