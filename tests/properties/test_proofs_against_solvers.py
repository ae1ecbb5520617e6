"""Verdicts and bounds set against z3 on piecewise-linear systems, and against Arb's enclosures on curved ones.

What a system means to both is in this file alone. More of them:
FUZZYCTL_PROOFS=1000 python -m pytest tests/properties/test_proofs_against_solvers.py
"""

import os
import random
from fractions import Fraction
from itertools import product

import flint
import pytest
import z3

from fuzzyctl import Proved, Refuted, loads, prove
from fuzzyctl.analysis.extremes import extents
from tests.sizes import examples

#: Generated systems of each kind.
COUNT = int(os.environ.get("FUZZYCTL_PROOFS", examples(24)))
#: Seconds for one end of a bound beside Arb's enclosures.
SECONDS = 0.05 if COUNT < 100 else 0.5


def number(rng, low, high, parts=16):
    return low + (high - low) * rng.randint(0, parts) / parts


class Lines:
    """A system of triangles on one or two inputs, joined by min or max, with a sum of constants: piecewise linear."""

    def __init__(self, seed):
        rng = random.Random(seed)
        self.inputs = ["x", "y"][: rng.randint(1, 2)]
        self.peaks = {n: sorted(rng.sample(range(-8, 9), rng.randint(2, 3))) for n in self.inputs}
        self.values = [rng.randint(-6, 6) for _ in range(4)]
        cells = list(product(*(range(len(p)) for p in self.peaks.values())))
        self.rules = [
            (cell, rng.choice(["and", "and", "or"]), rng.randrange(4), rng.choice([1, 0.5])) for cell in cells
        ]
        self.averages = len(self.inputs) == 1
        self.claims = [rng.choice(["u <= {}", "u >= {}"]).format(number(rng, -8, 8)) for _ in range(3)]

    @property
    def text(self):
        lines = [
            "system s",
            f"defuzzifier {'weighted_average' if self.averages else 'weighted_sum'}",
            "and min",
            "or max",
        ]
        for n, peaks in self.peaks.items():
            lines += [f"input {n} in [-10, 10]", "  terms " + " ".join(f"T{k}@{p}" for k, p in enumerate(peaks))]
        lines += ["output u in [-20, 20] else 0", *(f"  c{k} = constant({v})" for k, v in enumerate(self.values))]
        for cell, word, value, weight in self.rules:
            parts = [f"{n} is T{k}" for n, k in zip(self.inputs, cell, strict=True)]
            lines.append(f"if {f' {word} '.join(parts)} then u is c{value} weight {weight}")
        return "\n".join([*lines, *(f"require {c} within 1e-9" for c in self.claims)]) + "\n"

    def term(self, name, k, x):
        peaks = self.peaks[name]
        sides = []
        if k:
            sides.append((x - peaks[k - 1]) / (peaks[k] - peaks[k - 1]))
        if k + 1 < len(peaks):
            sides.append((peaks[k + 1] - x) / (peaks[k + 1] - peaks[k]))
        degree = sides[0] if len(sides) == 1 else z3.If(sides[0] < sides[1], sides[0], sides[1])
        return z3.If(degree < 0, z3.RealVal(0), z3.If(degree > 1, z3.RealVal(1), degree))

    def output(self, variables):
        """Σ w c, and Σ w, as z3 has them."""
        above = below = z3.RealVal(0)
        for cell, word, value, weight in self.rules:
            degrees = [self.term(n, k, variables[n]) for n, k in zip(self.inputs, cell, strict=True)]
            fired = degrees[0]
            for d in degrees[1:]:
                fired = z3.If((fired < d) if word == "and" else (fired > d), fired, d)
            share = fired * z3.Q(Fraction(weight).numerator, Fraction(weight).denominator)
            above, below = above + share * self.values[value], below + share
        return above, below

    def is_broken_somewhere(self, claim, slack):
        """Whether z3 finds a point that breaks a claim by more than a slack."""
        solver = z3.Solver()
        variables = {n: z3.Real(n) for n in self.inputs}
        for x in variables.values():
            solver.add(x >= -10, x <= 10)
        above, below = self.output(variables)
        word, op, bound = claim.split()
        assert word == "u"
        limit = Fraction(bound) + (slack if op == "<=" else -slack)
        level = z3.Q(limit.numerator, limit.denominator)
        # An average is compared after multiplication with the sum of the activations, which is positive.
        level = level * below if self.averages else level
        solver.add(above > level if op == "<=" else above < level)
        return solver.check() == z3.sat


@pytest.mark.parametrize("seed", range(COUNT))
def test_z3_agrees_about_piecewise_linear_systems(seed):
    case = Lines(seed)
    system = loads(case.text)
    for claim, verdict in zip(case.claims, prove(system, timeout=2), strict=True):
        if isinstance(verdict, Proved):
            assert not case.is_broken_somewhere(claim, Fraction(2, 10**9)), (case.text, verdict)
        elif isinstance(verdict, Refuted):
            assert case.is_broken_somewhere(claim, Fraction(0)), (case.text, verdict)
        else:
            # Only what comes very near to its bound may be left open, such as a ridge of kinks as high as the bound.
            assert case.is_broken_somewhere(claim, Fraction(-1, 10**6)), (case.text, verdict)


class Curves:
    """Gaussians or bells on two inputs, with the product and an average of constants or lines."""

    def __init__(self, seed):
        rng = random.Random(1000 + seed)
        self.means = {n: [number(rng, -2, 2) for _ in range(2)] for n in "xy"}
        self.width = {n: rng.choice([0.4, 1.0, 3.0]) for n in "xy"}
        self.kind = rng.choice(["gaussian", "bell"])
        self.values = [number(rng, -3, 3) for _ in range(4)]
        self.slope = rng.choice([0, 0, 0.5])

    @property
    def text(self):
        lines = ["system s", "and product", "defuzzifier weighted_average"]
        more = ", 2" if self.kind == "bell" else ""
        for n, means in self.means.items():
            lines.append(f"input {n} in [-2, 2]")
            lines += [f"  T{k} = {self.kind}({m}, {self.width[n]}{more})" for k, m in enumerate(means)]
        lines.append("output u in [-10, 10]")
        lines += [f"  c{k} = function({v} + {self.slope} * x)" for k, v in enumerate(self.values)]
        lines += [f"if x is T{i} and y is T{j} then u is c{2 * i + j}" for i in range(2) for j in range(2)]
        return "\n".join(lines) + "\n"

    def degree(self, n, k, x):
        z = (x - flint.arb(self.means[n][k])) / flint.arb(self.width[n])
        return (-z * z / 2).exp() if self.kind == "gaussian" else 1 / (1 + z**4)

    def value(self, x, y):
        above = below = flint.arb(0)
        for i, j in product(range(2), repeat=2):
            w = self.degree("x", i, x) * self.degree("y", j, y)
            above += w * (flint.arb(self.values[2 * i + j]) + flint.arb(self.slope) * x)
            below += w
        return above / below


@pytest.mark.parametrize("seed", range(COUNT))
def test_arb_agrees_about_curved_systems(seed):
    case = Curves(seed)
    (extent,) = extents(loads(case.text), timeout=1.0 if COUNT >= 24 else 0.3)
    rng = random.Random(seed)
    corners = [(-2.0, -2.0), (2.0, 2.0), (-2.0, 2.0), (2.0, -2.0)]
    for x, y in [*corners, *((rng.uniform(-2, 2), rng.uniform(-2, 2)) for _ in range(200))]:
        value = case.value(flint.arb(x), flint.arb(y))
        assert not value < flint.arb(extent.lo) - flint.arb(1e-15)
        assert not value > flint.arb(extent.hi) + flint.arb(1e-15)
    for at, found in ((extent.lo_at, extent.lo_found), (extent.hi_at, extent.hi_found)):
        if at is not None:
            assert abs(case.value(flint.arb(at["x"]), flint.arb(at["y"])) - flint.arb(found)) < 1e-12
    for _ in range(100):  # no slope is beyond its bound
        x, y, h = rng.uniform(-2, 1.999), rng.uniform(-2, 2), 0.001
        rise = abs(case.value(flint.arb(x + h), flint.arb(y)) - case.value(flint.arb(x), flint.arb(y)))
        assert not rise > flint.arb(extent.steepness["x"]) * (flint.arb(x + h) - flint.arb(x)) * 1.000001


def enclosure_of(case, cells=24):
    """Arb's enclosure of the values over the box, from balls that cover it cell by cell."""
    radius = 2 / cells
    balls = [flint.arb(-2 + (2 * k + 1) * radius, radius) for k in range(cells)]
    values = [case.value(x, y) for x in balls for y in balls]
    # Far from all means a sum of activations may be 0 for all that Arb knows of a cell.
    known = all(v.is_finite() for v in values)
    return (min(float(v.lower()) for v in values), max(float(v.upper()) for v in values)) if known else (-99.0, 99.0)


@pytest.mark.parametrize("seed", range(COUNT))
def test_arb_encloses_what_is_found_and_contradicts_no_verdict(seed):
    case, rng = Curves(seed), random.Random(2000 + seed)
    (extent,) = extents(loads(case.text), timeout=SECONDS)
    low, high = enclosure_of(case)
    assert low <= extent.lo_found <= extent.hi_found <= high
    # Where Arb knows on which side of a number all values lie, so must we; where a value lies beyond it, likewise.
    spread = extent.hi_found - extent.lo_found + 0.1
    bounds = [
        number(rng, max(low, -9.0), min(high, 9.0), 997),
        extent.hi_found - 0.05 * spread,
        extent.hi_found + 0.05 * spread,
    ]
    claims = "".join(f"require u <= {b!r}\n" for b in bounds)
    for bound, verdict in zip(bounds, prove(loads(case.text + claims), timeout=2 * SECONDS), strict=True):
        if isinstance(verdict, Proved):
            assert extent.hi_found <= bound
        elif isinstance(verdict, Refuted):
            assert bound < high
            at = verdict.witness.point
            assert case.value(flint.arb(at["x"]), flint.arb(at["y"])) > flint.arb(bound) - flint.arb(1e-12)
