"""Output surfaces of multilinear systems in rational arithmetic, with the rounding error of kernels.

Between the corners of the terms the sums Σ w_r c_r and Σ w_r are multilinear: their values at the corners say all. They
are computed here from the terms themselves, not from the rounded tables of the kernels.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import field
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import pairwise, product
from typing import Final

from fuzzyctl.analysis.degrees import without_idle
from fuzzyctl.expr import Binary, Expr, Name, Number, names_in
from fuzzyctl.formulas import MEMBERSHIP, is_straight
from fuzzyctl.kernels.algorithms.grid import Grid, Table, grid_of
from fuzzyctl.kernels.inference.defuzzify.defuzzify import consequent_hull
from fuzzyctl.kernels.plan.build import Plan, SetPlan, degree_name, step_name
from fuzzyctl.records import record

#: Most products of corners and rules: about a second.
MOST: Final = 200_000
#: Sums of activations this close to 1 are taken for 1, which the error accounts for.
_UNITY: Final = Fraction(1, 1 << 40)
#: Half the distance from 1 to the next float.
_U: Final = 2.0**-53

Point = tuple[Fraction, ...]


@record(frozen=True)
class Surface:
    """All outputs of a system that interpolates.

    Args:
        plan: The system.
        grid: The values that its kernels interpolate.
        inputs: Positions of the inputs that rules read.
        corners: Of each of them, rising.
    """

    plan: Plan
    grid: Grid
    inputs: tuple[int, ...]
    corners: tuple[tuple[Fraction, ...], ...]
    _fired: dict[tuple[int, ...], tuple[Fraction, ...]] = field(default_factory=dict, compare=False, repr=False)
    _values: dict[tuple[int, tuple[int, ...]], tuple[Fraction, Fraction]] = field(
        default_factory=dict, compare=False, repr=False
    )
    _raw: dict[tuple[int, tuple[int, ...]], tuple[Fraction, Fraction]] = field(
        default_factory=dict, compare=False, repr=False
    )

    def sums_at(self, output: int, corner: tuple[int, ...]) -> tuple[Fraction, Fraction]:
        """Return Σ w_r c_r and Σ w_r at a corner; where all sums are 1 the first one is the value of the output."""
        key = (output, corner)
        if key not in self._values:
            above, below = self._raw_sums(output, corner)
            self._values[key] = (above / below, Fraction(1)) if self.is_unity[output] else (above, below)
        return self._values[key]

    def sums(self, output: int, point: Sequence[Fraction]) -> tuple[Fraction, Fraction]:
        """Return the same at a point, one value for each input of the system."""
        weights = [_weights(self.corners[k], point[i]) for k, i in enumerate(self.inputs)]
        if all(len(row) == 1 for row in weights):
            return self.sums_at(output, tuple(row[0][0] for row in weights))
        above = below = Fraction(0)
        for choice in product(*weights):
            weight = math.prod((c[1] for c in choice), start=Fraction(1))
            if weight:
                a, b = self.sums_at(output, tuple(c[0] for c in choice))
                above, below = above + weight * a, below + weight * b
        return above, below

    def _raw_sums(self, output: int, corner: tuple[int, ...]) -> tuple[Fraction, Fraction]:
        key = (output, corner)
        if key not in self._raw:
            self._raw[key] = self._summed(output, corner)
        return self._raw[key]

    def _summed(self, output: int, corner: tuple[int, ...]) -> tuple[Fraction, Fraction]:
        fired = self._strengths(corner)
        above = below = Fraction(0)
        planned = self.plan.outputs[output]
        for entry in planned.implied:
            rule = self.plan.rules[entry.rule]
            if fired[rule.strength] and rule.weight:
                activation = fired[rule.strength] * Fraction(rule.weight)
                above, below = above + activation * Fraction(planned.terms[entry.term].peak), below + activation
        return above, below

    def _strengths(self, corner: tuple[int, ...]) -> tuple[Fraction, ...]:
        if corner not in self._fired:
            values: dict[str, Fraction] = {}
            for i, d in enumerate(self.plan.degrees):
                k = self.inputs.index(d.variable)
                values[degree_name(i)] = self._degrees[i][corner[k]]
            for i, step in enumerate(self.plan.steps):
                values[step_name(i)] = _rational(step, values)
            self._fired[corner] = tuple(_rational(s, values) for s in self.plan.strengths)
        return self._fired[corner]

    @cached_property
    def _degrees(self) -> list[list[Fraction]]:
        """Degrees at the corners of their inputs."""
        return [[_degree(d.set, x) for x in self.corners[self.inputs.index(d.variable)]] for d in self.plan.degrees]

    @cached_property
    def indices(self) -> list[tuple[int, ...]]:
        """All corners, as positions."""
        return list(product(*(range(len(c)) for c in self.corners)))

    @cached_property
    def is_unity(self) -> tuple[bool, ...]:
        """Whether the activations of each output sum to 1, but for what rounding did to the corners of terms."""
        return tuple(
            all(abs(self._raw_sums(o, c)[1] - 1) <= _UNITY for c in self.indices) for o in range(len(self.plan.outputs))
        )

    def hull(self, output: int) -> tuple[float, float]:
        """Return the ends that kernels hold an output within."""
        planned = self.plan.outputs[output]
        terms = [e.term for e in planned.implied if self.plan.rules[e.rule].weight > 0.0]
        return consequent_hull(planned, terms)

    @cached_property
    def errors(self) -> tuple[Fraction, ...]:
        """How far the numbers that kernels return may be from each output."""
        return tuple(Fraction(_Error(self, o).most()) for o in range(len(self.plan.outputs)))


@lru_cache(maxsize=8)
def surface_of(plan: Plan, *, most: int = MOST) -> Surface | None:
    """Return the outputs of a system that interpolates, None for any other, or one with too many corners.

    Args:
        plan: The system.
        most: Most products of corners and rules.
    """
    plan = without_idle(plan) if plan.lets else plan
    grid = grid_of(plan)
    if not isinstance(grid, Grid) or grid.size * len(plan.rules) > most:
        return None
    corners = tuple(_corners(plan, i) for i in grid.inputs)
    surface = Surface(plan, grid, grid.inputs, corners)
    if len(surface.indices) * len(plan.rules) > most or not all(map(math.isfinite, map(float, surface.errors))):
        return None
    return surface


def _corners(plan: Plan, position: int) -> tuple[Fraction, ...]:
    """Return the breakpoints of the terms of an input within its range."""
    variable = plan.inputs[position]
    results = {Fraction(x) for d in plan.degrees if d.variable == position for x, _ in d.set.vertices}
    if variable.extrapolate:
        return tuple(sorted(results))
    lower, upper = Fraction(variable.lower), Fraction(variable.upper)
    return tuple(sorted({lower, upper} | {x for x in results if lower <= x <= upper}))


def _degree(term: SetPlan, x: Fraction) -> Fraction:
    vertices = [(Fraction(u), Fraction(v)) for u, v in MEMBERSHIP[term.kind].vertices(term.parameters)]
    height = Fraction(term.height)
    if x <= vertices[0][0]:
        return height * vertices[0][1]
    for (x0, y0), (x1, y1) in pairwise(vertices):
        if x <= x1:
            return height * (y0 + (y1 - y0) * (x - x0) / (x1 - x0))
    return height * vertices[-1][1]


def _rational(strength: Expr, known: Mapping[str, Fraction]) -> Fraction:
    match strength:
        case Name(name=name):
            return known[name]
        case Number(value=value):
            return Fraction(value)
        case Binary(op="*", left=left, right=right):
            a = _rational(left, known)
            return a * _rational(right, known) if a else a
        case Binary(op="+" | "-" as op, left=left, right=right):
            a, b = _rational(left, known), _rational(right, known)
            return a + b if op == "+" else a - b
    raise TypeError(f"{type(strength).__name__} is not multilinear")


@record(frozen=True)
class _Error:
    """The error of one output: of evaluating the rules, and of interpolating rounded values.

    All bounds are generous; they are of first order with twice the constant that a careful count would give.
    """

    surface: Surface
    output: int

    def most(self) -> float:
        surface, table = self.surface, self.surface.grid.outputs[self.output]
        weights = [surface._raw_sums(self.output, c)[1] for c in surface.indices]
        least = float(min(weights))
        if least < 1e-9:
            return math.inf
        unity = float(max(abs(w - 1) for w in weights)) if surface.is_unity[self.output] else 0.0
        largest = max(map(abs, surface.hull(self.output)))
        return max(self._of_rules(least), self._of_table(table, least)) + 4.0 * unity * largest

    def _of_rules(self, least: float) -> float:
        """Bound the error of Σ w c / Σ w, in which degrees, products and sums are rounded."""
        plan = self.surface.plan
        planned = plan.outputs[self.output]
        largest = max(map(abs, self.surface.hull(self.output)))
        operations = 9 * len(plan.inputs) + len(planned.implied) + 8
        relative = self._relative
        if all(relative[plan.rules[e.rule].strength] for e in planned.implied):
            # Everything is positive, so that errors are relative, whatever the sum of the activations.
            return 4.0 * operations * _U * largest
        depth = 2 + max(_operations(e) for e in (*plan.steps, *plan.strengths)) * (1 + len(plan.steps))
        # The others may be off by as much where they are small.
        absolute = sum(plan.rules[e.rule].weight for e in planned.implied if not relative[plan.rules[e.rule].strength])
        whole = absolute + float(max(self.surface._raw_sums(self.output, c)[1] for c in self.surface.indices))
        return 4.0 * (operations + 9 * depth) * _U * largest * max(whole, 1.0) / least

    @cached_property
    def _relative(self) -> list[bool]:
        """Whether the error of each firing strength is relative: it is a product of degrees with relative errors."""
        plan = self.surface.plan
        sound = {degree_name(i) for i, d in enumerate(plan.degrees) if _is_plain(d.set)}
        for i, step in enumerate(plan.steps):
            if _is_product(step) and {n.name for n in names_in(step)} <= sound:
                sound.add(step_name(i))
        return [_is_product(e) and {n.name for n in names_in(e)} <= sound for e in plan.strengths]

    def _of_table(self, table: Table, least: float) -> float:
        """Bound the error of interpolating: that of the values at the knots, and that of the program."""
        largest = max(map(abs, (table.low, table.high)))
        value = self._off(table.value, 0) + self._rounding(table.value)
        if not table.weight:
            # The kernels take sums of activations for 1 that here are a quotient.
            return value + (0.0 if self.surface.is_unity[self.output] else 32.0 * _U * largest)
        weight = self._off(table.weight, 1) + self._rounding(table.weight)
        return 2.0 * (value + largest * weight) / least + 4.0 * _U * largest

    def _off(self, values: Sequence[float], which: int) -> float:
        """Return the largest distance of the interpolated values from the sums, which is at one of the corners."""
        surface, knots = self.surface, self.surface.grid.knots
        raw = not surface.is_unity[self.output] and bool(surface.grid.outputs[self.output].weight)
        rational = [[Fraction(x) for x in axis] for axis in knots]
        most = Fraction(0)
        for corner in surface.indices:
            point = [surface.corners[k][c] for k, c in enumerate(corner)]
            sums = surface._raw_sums(self.output, corner)
            wanted = sums[which] if raw or which else sums[0] / sums[1]
            most = max(most, abs(_interpolated(rational, values, point) - wanted))
        return float(most) * (1.0 + 1e-15)

    def _rounding(self, values: Sequence[float]) -> float:
        knots = self.surface.grid.knots
        n, lengths = len(knots), [len(k) for k in knots]
        return 4.0 * (6 * n + 4) * _U * _largest_polynomial(values, lengths)


def _weights(knots: Sequence[Fraction], x: Fraction) -> list[tuple[int, Fraction]]:
    """Return the indices of the knots beside a value, each with its weight in a linear interpolation."""
    if x <= knots[0]:
        return [(0, Fraction(1))]
    i = bisect_right(knots, x) - 1
    if i == len(knots) - 1 or x == knots[i]:
        return [(i, Fraction(1))]
    weight = (x - knots[i]) / (knots[i + 1] - knots[i])
    return [(i, 1 - weight), (i + 1, weight)]


def _interpolated(knots: Sequence[Sequence[Fraction]], values: Sequence[float], point: Sequence[Fraction]) -> Fraction:
    weights = [_weights(axis, x) for axis, x in zip(knots, point, strict=True)]
    total = Fraction(0)
    for choice in product(*weights):
        index = 0
        for (i, _), axis in zip(choice, knots, strict=True):
            index = index * len(axis) + i
        total += math.prod((s for _, s in choice), start=Fraction(1)) * Fraction(values[index])
    return total


def _largest_polynomial(values: Sequence[float], lengths: Sequence[int]) -> float:
    """Return the largest sum of the magnitudes of the terms of a cell's polynomial, and of those that cancel in them.

    A term is a mixed difference of the values at the corners; each subtraction on the way to it is rounded relative to
    its own result, which is larger than the term where much cancels.
    """
    results = [[(v, 0.0)] for v in values]
    for d, length in enumerate(lengths):
        stride = math.prod(lengths[d + 1 :])
        wider = []
        for k, terms in enumerate(results):
            beside = results[k + stride] if k // stride % length + 1 < length else terms
            steps = [(b - a, u + v + abs(b - a)) for (a, u), (b, v) in zip(terms, beside, strict=True)]
            wider.append([*terms, *steps])
        results = wider
    return max(sum(abs(term) + cancelled for term, cancelled in terms) for terms in results)


def _is_product(expr: Expr) -> bool:
    match expr:
        case Name() | Number():
            return True
        case Binary(op="*", left=left, right=right):
            return _is_product(left) and _is_product(right)
    return False


def _is_plain(term: SetPlan) -> bool:
    return is_straight(term.kind) and not MEMBERSHIP[term.kind].variadic


def _operations(expr: Expr) -> int:
    return 1 + _operations(expr.left) + _operations(expr.right) if isinstance(expr, Binary) else 0
