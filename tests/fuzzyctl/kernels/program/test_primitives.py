"""The table of primitives has no gaps: each target knows each of them, and all compute the same numbers."""

import itertools
import math

import numpy as np
import pytest

from fuzzyctl.expr import FUNCTIONS as LANGUAGE
from fuzzyctl.expr import SOFT
from fuzzyctl.kernels.backends.numpy_backend import FUNCTIONS as ARRAYS
from fuzzyctl.kernels.interval import scalar
from fuzzyctl.kernels.interval.vector import Enclosure, applied
from fuzzyctl.kernels.program.printer import ALIASES, PRIMITIVES
from fuzzyctl.kernels.program.scalar import IEEE_FUNCTIONS

NUMBERS = [-math.inf, -800.0, -2.5, -1.0, -0.0, 0.0, 0.3, 1.0, 2.0, 800.0, math.inf, math.nan]
#: Functions that Structured Text has not.
NOT_STANDARD = {"atan2", "floor", "fmod"}


def arguments(name):
    count = len(PRIMITIVES[name].arguments.split())
    points = itertools.product(NUMBERS, repeat=count)
    return [p for p in points if name != "clip" or p[1] <= p[2]]


@pytest.mark.parametrize("name", PRIMITIVES)
class TestEveryPrimitive:
    def test_has_a_text_for_every_target(self, name):
        own = PRIMITIVES[name]
        assert own.numpy
        assert own.numba
        assert own.c
        assert bool(own.st) == (name not in NOT_STANDARD)

    def test_computes_the_same_for_floats_and_arrays(self, name):
        points = arguments(name)
        with np.errstate(all="ignore"):
            arrays = ARRAYS[name](*np.array(points).T)
        np.testing.assert_allclose([IEEE_FUNCTIONS[name](*p) for p in points], arrays, rtol=1e-15)


@pytest.mark.parametrize("name", sorted(set(PRIMITIVES) - {"clip", "power"}))
def test_intervals_hold_what_it_computes(name):
    """Intervals have powers as an operator, and enclose `clip` only for arrays."""
    for point in arguments(name):
        value = IEEE_FUNCTIONS[name](*point)
        if all(map(math.isfinite, point)) and math.isfinite(value):
            low, high = scalar.applied(name, [(x, x) for x in point])
            assert low <= value <= high
            own = applied(name, [Enclosure(np.array([x]), np.array([x]), None, np.array(0.0)) for x in point])
            assert own.lo <= value <= own.hi


def test_what_rule_files_call_is_a_primitive_or_made_of_primitives():
    assert {ALIASES.get(name, name) for name in set(LANGUAGE) - SOFT} - {"sign"} <= set(PRIMITIVES)
