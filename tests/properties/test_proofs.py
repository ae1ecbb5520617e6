"""What is proved holds for what kernels return: generated systems of every kind, at random points and at all corners.

More of them: FUZZYCTL_PROOFS=1000 python -m pytest tests/properties/test_proofs.py
"""

import math
import os
from fractions import Fraction

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, note

from fuzzyctl import FuzzyctlError, NoRuleFiresError, Proved, Refuted, loads, prove
from fuzzyctl import compile as compile_system
from fuzzyctl.analysis.branch_and_bound.boxed_system import System
from fuzzyctl.analysis.branch_and_bound.queue import start_of
from fuzzyctl.analysis.multilinear.surface import surface_of
from fuzzyctl.kernels.plan.build import plan
from tests.properties.around import points_around
from tests.properties.drawn_systems import KINDS
from tests.properties.drawn_tables import systems as drawn_tables
from tests.properties.running import quick
from tests.properties.test_active import systems as active_tables
from tests.sizes import examples

#: Generated systems of each test.
COUNT = int(os.environ.get("FUZZYCTL_PROOFS", examples(40)))
DRAWN = quick(COUNT, COUNT)


def kernels_of(system):
    """All kernels that may differ in rounding."""
    found = []
    for backend in ("python", "numpy"):
        for algorithm in ("rules", "interpolation", "active"):
            try:
                found.append(compile_system(system, backend, algorithm=algorithm))
            except FuzzyctlError:
                assert algorithm != "rules"
    return found


def values_at(kernel, points, state):
    """Values of shape (points, outputs); NaN where no rule fires."""
    rows = []
    for point in points:
        try:
            given = () if state is None else (state,)
            row = np.atleast_1d(kernel.batch(np.array([point]), *(g[None] for g in given))[0])
        except NoRuleFiresError:
            row = np.full(len(kernel.output_names), math.nan)
        rows.append(row)
    return np.array(rows)


def random_boxes(lo, hi, rng, count):
    """Boxes within cells, and points in each: ends, their neighbours, and some between."""
    finite = [
        (np.where(np.isfinite(lo), lo, np.minimum(hi, 0) - 10.0)),
        (np.where(np.isfinite(hi), hi, np.maximum(lo, 0) + 10.0)),
    ]
    chosen = rng.integers(0, lo.shape[1], count)
    a, b = finite[0][:, chosen], finite[1][:, chosen]
    shares = np.sort(rng.uniform(size=(2, *a.shape)) * (rng.uniform(size=a.shape) < 0.7), axis=0)
    low = np.clip(a + shares[0] * (b - a), a, b)
    high = np.where(rng.uniform(size=a.shape) < 0.5, b, np.clip(a + np.maximum(shares[1], shares[0]) * (b - a), low, b))
    # In points enclosures are so narrow that rounding shows.
    high = np.where(rng.uniform(size=count) < 0.3, low, high)
    inside = [low, high, np.minimum(np.nextafter(low, np.inf), high), np.maximum(np.nextafter(high, -np.inf), low)]
    inside += [np.clip(low + rng.uniform(size=low.shape) * (high - low), low, high) for _ in range(4)]
    return low, high, inside


def check_enclosures(system, seed, *, count=12, straight=True):
    """Every kernel's numbers lie in the enclosures, and in those of first order."""
    boxed = System(system, plan(system))
    cells = boxed.cells([])
    if cells is None:
        return
    kernels = kernels_of(system)
    state = kernels[0].start() if kernels[0].n_states else None
    low, high, inside = random_boxes(*cells, np.random.default_rng(seed), count)
    wanted = list(range(len(system.outputs)))
    with np.errstate(all="ignore"):
        found, _ = boxed.evaluate(list(boxed.inputs_of(low, high, sloped=True).values()), wanted)
        alone = [boxed.evaluate(list(boxed.inputs_of(low, high, sloped=False).values()), [k])[1] for k in wanted]
    for points in inside:
        for kernel in kernels:
            values = values_at(kernel, points.T, state)
            for k, e in zip(wanted, found, strict=True):
                own = values[:, k]
                fine = np.isnan(own) | ((np.broadcast_to(e.lo, count) <= own) & (own <= np.broadcast_to(e.hi, count)))
                note(f"{kernel} {points.T[~fine]} {own[~fine]} {low.T[~fine]} {high.T[~fine]}")
                assert fine.all()
                assert not (alone[k] & ~np.isnan(own)).any()
                if e.slopes is None or not straight:
                    continue
                down, up = (np.broadcast_to(s, low.shape) for s in e.slopes)
                start, slack = start_of(low, high, down, up)
                with np.errstate(all="ignore"):
                    (there,), _ = boxed.evaluate(list(boxed.inputs_of(start, start, sloped=False).values()), [k])
                    least = there.lo - slack * (1 + 1e-12) - e.error
                fine = np.isnan(own) | ~(own < least)
                note(f"first order: {points.T[~fine]} {own[~fine]} {least[~fine] if least.ndim else least}")
                assert fine.all()


@pytest.mark.parametrize("kind", KINDS)
@DRAWN
@given(st.data())
def test_enclosures_hold_what_kernels_return(kind, data):
    check_enclosures(data.draw(KINDS[kind]), data.draw(st.integers(0, 1000)))


@quick(COUNT // 3, COUNT // 3)
@given(st.data())
def test_enclosures_hold_rules_that_act_alone(data):
    text, _ = data.draw(active_tables())
    check_enclosures(loads(text), data.draw(st.integers(0, 1000)))


@DRAWN
@given(st.data())
def test_kernels_are_as_near_to_rational_arithmetic_as_is_said(data):
    text, knots = data.draw(drawn_tables())
    system = loads(text)
    surface = surface_of(plan(system))
    if surface is None:
        return
    points = points_around(knots, data.draw(st.integers(0, 1000)))
    for kernel in kernels_of(system):
        for point, value in zip(points, values_at(kernel, points, None)[:, 0], strict=True):
            held = [
                x if v.extrapolate else min(max(x, v.lower.value), v.upper.value)
                for x, v in zip(point, system.inputs, strict=True)
            ]
            above, below = surface.sums(0, [Fraction(max(min(x, 1e300), -1e300)) for x in held])
            note(f"{text} {kernel} {point} {value} {float(above / below)} {float(surface.errors[0])}")
            assert abs(Fraction(float(value)) - above / below) <= surface.errors[0]


@DRAWN
@given(st.data())
def test_what_is_proved_to_rise_rises_and_what_is_refuted_does_not(data):
    text, knots = data.draw(drawn_tables())
    system = loads(text + "\nrequire increasing(u, x0)\nrequire decreasing(u, x0)\n")
    rising, falling = prove(system, timeout=0.2)
    rng = np.random.default_rng(data.draw(st.integers(0, 1000)))
    ends = [(v.lower.value, v.upper.value) for v in system.inputs]
    kernel = compile_system(system, "numpy", algorithm="rules")
    for _ in range(8):
        others = [rng.uniform(*e) if rng.uniform() < 0.5 else rng.choice(e) for e in ends[1:]]
        row = sorted({*rng.uniform(*ends[0], 20), *ends[0], *(k for k in knots[0] if ends[0][0] <= k <= ends[0][1])})
        steps = np.diff(values_at(kernel, [[x, *others] for x in row], None)[:, 0])
        note(f"{text} {others} {row} {steps} {rising} {falling}")
        assert not (isinstance(rising, Proved) and (steps < -1e-9).any())
        assert not (isinstance(falling, Proved) and (steps > 1e-9).any())
    for verdict, sign in ((rising, 1), (falling, -1)):
        if isinstance(verdict, Refuted):
            first, second = (system(**p) for p in (verdict.witness.point, verdict.witness.other))
            assert sign * (second - first) < 0


@DRAWN
@given(st.data())
def test_what_is_proved_of_an_interpolating_system_holds_and_what_is_refuted_does_not(data):
    text, knots = data.draw(drawn_tables())
    bound = data.draw(st.integers(-9, 9))
    claims = [
        f"u <= {bound}",
        f"u >= {bound}",
        f"u <= {bound} when x0 >= 1",
        f"u(-x0{', x1, x2'[: 4 * (len(knots) - 1)]}) <= u + 1",
    ]
    system = loads(text + "\n" + "\n".join(f"require {c}" for c in claims) + "\n")
    verdicts = prove(system, timeout=0.3)
    points = points_around(knots, data.draw(st.integers(0, 1000)))
    for kernel in kernels_of(system):
        inside = [
            [min(max(x, v.lower.value), v.upper.value) for x, v in zip(p, system.inputs, strict=True)] for p in points
        ]
        values = values_at(kernel, inside, None)[:, 0]
        mirrored = values_at(kernel, [[-p[0], *p[1:]] for p in inside], None)[:, 0]
        broken = [
            values > bound,
            values < bound,
            (values > bound) & (np.array([p[0] for p in inside]) >= 1),
            mirrored > values + 1 + 1e-9,
        ]
        for verdict, where in zip(verdicts, broken, strict=True):
            note(f"{text} {verdict} {np.array(inside)[where]}")
            assert not (isinstance(verdict, Proved) and where.any())
    for verdict, claim in zip(verdicts, claims, strict=True):
        if isinstance(verdict, Refuted) and "when" not in claim and "(" not in claim:
            value = system(**verdict.witness.point)
            assert value > bound if "<=" in claim else value < bound
