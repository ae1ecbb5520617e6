"""Proved bounds set against kernels: random points, all corners of terms and the numbers beside them.

A million evaluations of each of many systems, which takes hours:
FUZZYCTL_PROOFS=300 FUZZYCTL_EVALUATIONS=1000000 python -m pytest -n 0 -s tests/properties/test_bounds_hold.py
"""

import itertools
import math
import os

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, note

from fuzzyctl import FuzzyctlError, loads
from fuzzyctl import compile as compile_system
from fuzzyctl.analysis.extremes import extents
from fuzzyctl.analysis.multilinear.surface import surface_of
from fuzzyctl.kernels.plan.build import plan
from tests.properties.around import corners_of
from tests.properties.drawn_systems import KINDS
from tests.properties.drawn_tables import systems as drawn_tables
from tests.properties.running import quick, total
from tests.sizes import examples

#: Generated systems of each kind, random points of each, and seconds for one end of one bound.
COUNT = int(os.environ.get("FUZZYCTL_PROOFS", examples(12)))
DRAWN = quick(COUNT, COUNT)
EVALUATIONS = int(os.environ.get("FUZZYCTL_EVALUATIONS", "2000"))
SECONDS = 0.02 if EVALUATIONS <= 10_000 else 0.3
#: Most points made of corners and their neighbours, and points of one batch.
CORNERS, BATCH = max(2000, EVALUATIONS // 10), 100_000


def beside(variable):
    """Corners of the terms of an input, and the floating-point numbers beside them."""
    found = {x for c in corners_of(variable) for x in (math.nextafter(c, -math.inf), c, math.nextafter(c, math.inf))}
    if variable.extrapolate:
        found |= {-math.inf, math.inf, variable.lower.value - 1e3, variable.upper.value + 1e3}
    # As floats compare, 0.0 and -0.0 are one; a negative odd power tells them apart.
    return sorted(found) + ([-0.0] if min(found) <= 0.0 <= max(found) else [])


def batches(system, rng):
    """Yield points: all corners and neighbours, of very many a part, then random ones."""
    axes = [beside(i) for i in system.inputs]
    if math.prod(map(len, axes)) <= CORNERS:
        yield np.array(list(itertools.product(*axes)))
    else:
        yield np.stack([rng.choice(axis, CORNERS) for axis in axes], axis=1)
    lower, upper = np.array([system.range_of(i) for i in system.inputs]).T
    for start in range(0, EVALUATIONS, BATCH):
        count = min(BATCH, EVALUATIONS - start)
        points = rng.uniform(lower - 0.05 * (upper - lower), upper + 0.05 * (upper - lower), (count, len(lower)))
        # Some inputs stand at corners while others run.
        for i, axis in enumerate(axes):
            at = rng.uniform(size=count) < 0.1
            points[at, i] = rng.choice(axis, int(at.sum()))
        yield points


def states(kernel, flat, count, rng):
    """States for a batch: consequents anywhere in the range of their output, previous values as they are at first."""
    if not kernel.n_states:
        return ()
    given_at_first = np.broadcast_to(kernel.start(), (count, kernel.n_states)).copy()
    for k, (o, _) in enumerate(flat.states):
        own = flat.outputs[o]
        given_at_first[:, k] = rng.uniform(own.lower, own.upper, count)
    return (given_at_first,)


def check_bounds(system, seed):
    """No kernel returns a number outside the proved bounds; those at corners are attained but for rounding."""
    system = total(system)
    flat, rng = plan(system), np.random.default_rng(seed)
    found = extents(system, timeout=SECONDS)
    for algorithm in ("rules", "interpolation"):
        try:
            kernel = compile_system(system, "numpy", algorithm=algorithm)
        except FuzzyctlError:
            assert algorithm == "interpolation"
            continue
        for points in batches(system, rng):
            given_states = states(kernel, flat, len(points), rng)
            values = kernel.batch(points, *given_states) if not flat.held else kernel.batch(points)
            values = values.reshape(len(points), -1)
            for own, extent in zip(values.T, found, strict=True):
                outside = (own < extent.lo) | (own > extent.hi)
                note(f"{algorithm} {extent} {points[outside][:3]} {own[outside][:3]}")
                assert not outside.any()
    surface = surface_of(flat)
    if surface is not None and not flat.initial_state:
        for k, e in enumerate(found):
            # The bound stands off from the lowest corner by what kernels may be off, and the value found there is one
            # of theirs; then both are rounded.
            off = 2.0 * float(surface.errors[k]) + 4.0 * math.ulp(max(abs(e.lo), abs(e.hi)))
            size = max(1.0, *map(abs, surface.hull(k)))
            note(f"{e} {off}")
            # Where activations do not sum to 1, two sums are rounded and divided, and how far that is off depends on
            # how small the lower one is.
            assert off <= 1e-12 * size or not surface.is_unity[k]
            assert abs(e.lo - e.lo_found) <= off
            assert abs(e.hi - e.hi_found) <= off


@pytest.mark.parametrize("kind", KINDS)
@DRAWN
@given(st.data())
def test_bounds_hold_whatever_a_system_is_made_of(kind, data):
    check_bounds(data.draw(KINDS[kind]), data.draw(st.integers(0, 1000)))


@DRAWN
@given(st.data())
def test_bounds_of_interpolating_systems_hold_and_are_attained(data):
    text, _ = data.draw(drawn_tables())
    check_bounds(loads(text), data.draw(st.integers(0, 1000)))
