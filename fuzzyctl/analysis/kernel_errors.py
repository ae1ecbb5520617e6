"""Proved differences between kernels and rules, for algorithms that look up the rules that can act.

The surface of interpolation knows its error (`exact`). Here are the two methods that use rules which act alone.
Both count corners as one that differ by rounding, and round other operations than those of all rules.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Final

from fuzzyctl.formulas import Vertex
from fuzzyctl.kernels.algorithms import rule_cells
from fuzzyctl.kernels.algorithms.rule_cells import Active, active_of, linear_parts
from fuzzyctl.kernels.plan.build import OutputPlan, Plan

#: Twice the rounding error of one operation, which covers products of such errors.
_ULP: Final = Fraction(1, 1 << 52)


def kernel_errors(plan: Plan) -> list[float]:
    """Bound for each output how far kernels that look at the rules that act alone are from all rules."""
    table = active_of(plan, least_gain=0.0)
    if isinstance(table, Active):
        return [_upward(_of_average(plan, table, output)) for output in plan.outputs]
    return [0.0 for _ in plan.outputs]


def _upward(error: Fraction) -> float:
    return math.nextafter(float(error), math.inf) if error else 0.0


def _of_average(plan: Plan, own: Active, output: OutputPlan) -> Fraction:
    """Bound the error of an average over the rules that act.

    Let an activation a_r be off by e_r. The average changes by Σ e_r (c_r - y) / Σ a_r, that is by twice the largest
    |c| times Σ |e_r| / Σ a_r at most. Degrees are counted from where they are smallest, so that rounding is a part of
    each a_r: at most 40 operations for each input, with those of the numbers of a line.
    """
    largest = max((_magnitude(plan, output, e.term) for e in output.implied), default=Fraction(0))
    operations = 40 * len(own.axes) + (1 << len(own.axes)) + len(plan.rules) + len(plan.inputs) + 8
    return largest * (operations * _ULP + 4 * _moved_share(plan, own, output))


def _moved_share(plan: Plan, own: Active, output: OutputPlan) -> Fraction:
    """Return Σ |e_r| / Σ a_r where corners that count as one move degrees by more than a part of them.

    There the table is full, so that some rule acts by the highest degree of each input. In a product only the degree
    that is moved matters, in a minimum the smallest of these.
    """
    moved = [(_moved(plan, axis), _least_of_the_highest(axis)) for axis in own.axes]
    if not any(off for off, _ in moved):
        return Fraction(0)
    weights = [Fraction(plan.rules[e.rule].weight) for e in output.implied]
    if own.norm == "min":
        parts = max(off for off, _ in moved) / min(highest for _, highest in moved)
    else:
        parts = sum((off / highest for off, highest in moved if off), Fraction(0))
    return sum(weights) / min(w for w in weights if w > 0) * parts


def _magnitude(plan: Plan, output: OutputPlan, term: int) -> Fraction:
    """Return the largest sum of the parts of a consequent."""
    parts = linear_parts(output.terms[term])
    assert parts is not None, "others are no averages of what rules that act say"
    factors, constant = parts
    reach = {i.name: Fraction(max(abs(i.lower), abs(i.upper))) for i in plan.inputs}
    return abs(Fraction(constant)) + sum(abs(Fraction(f)) * reach[name] for name, f in factors.items())


def _moved(plan: Plan, axis: rule_cells.Axis) -> Fraction:
    """Return how far a degree of the table is from that of the term, 0 but where corners count as one.

    Both are straight between the corners of either.
    """
    if not axis.is_rounded:
        return Fraction(0)
    most = Fraction(0)
    for degree in (d for d in plan.degrees if d.variable == axis.position):
        corners = _finite(degree.set.vertices)
        for k, (left, right) in enumerate(pairwise(axis.knots)):
            inside = [x for x, _ in corners if left < x < right]
            for x in (Fraction(left), *inside, Fraction(right)):
                most = max(most, abs(_at(corners, x) - _looked_up(axis, degree.term, k, x)))
    return most


def _looked_up(axis: rule_cells.Axis, term: str, cell: int, x: Fraction) -> Fraction:
    """Return the degree of a term in a cell of a table, 0 for one that it does not name there."""
    return sum(
        (_line(side, cell, x) for side, names in zip(axis.sides, axis.terms, strict=True) if names[cell] == term),
        Fraction(0),
    )


def _line(side: rule_cells.Side, cell: int, x: Fraction) -> Fraction:
    return Fraction(side.slope[cell]) * (x - Fraction(side.foot[cell])) + Fraction(side.base[cell])


def _least_of_the_highest(axis: rule_cells.Axis) -> Fraction:
    """Return what at least one of the two terms of each cell has everywhere: at the ends, or where they cross."""
    least = Fraction(1)
    for k, (left, right) in enumerate(pairwise((*axis.knots, axis.knots[-1]))):
        ends = [[_line(side, k, Fraction(x)) for x in (left, right)] for side in axis.sides]
        (a, b), (c, d) = ends
        least = min(least, max(a, c), max(b, d))
        if (a - c) * (b - d) < 0:
            least = min(least, a + (b - a) * (a - c) / ((a - c) - (b - d)))
    return least


def _finite(vertices: Iterable[Vertex]) -> list[tuple[Fraction, Fraction]]:
    return [(Fraction(x), Fraction(y)) for x, y in vertices if math.isfinite(x)]


def _at(corners: Sequence[tuple[Fraction, Fraction]], x: Fraction) -> Fraction:
    """Return the degree of a term with straight sides and no jumps."""
    if x <= corners[0][0]:
        return corners[0][1]
    for (x0, y0), (x1, y1) in pairwise(corners):
        if x <= x1:
            return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    return corners[-1][1]
