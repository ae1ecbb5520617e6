"""Knots and values of multilinear systems, whose outputs interpolate between the corners of terms.

With straight-sided terms, the product as conjunction and an average of constants, firing strengths are multilinear
between the corners of the terms. So are the two sums of the average, Σ w_r c_r and Σ w_r, whatever the number of rules:
their values at the knots say all. Where the second sum is 1 everywhere, as on partitions of unity, so is the output.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from itertools import pairwise, product
from operator import mul
from typing import Final

from fuzzyctl.expr import Binary, Expr, Name, Number
from fuzzyctl.kernels.plan.build import InputPlan, OutputPlan, Plan, SetPlan, degree_name, step_name
from fuzzyctl.records import record

#: Most knots of all inputs together: a table of 1 MiB for each sum.
MOST_KNOTS: Final = 1 << 17
#: Sums of activations that differ from 1 by less are 1 but for rounding.
_UNITY: Final = 8 * 2.0**-52
#: Where the sum of activations falls below this part of its largest value, the quotient is left to the rules.
_LEAST_SHARE: Final = 1e-3
#: Corners closer to each other than this part of the range differ by rounding only, and count as one.
_SAME: Final = 1e-14
#: A cell narrower than this part of the range is steeper than its coefficients are exact.
_NARROWEST: Final = 1e-7
#: Degrees that differ by less are the same but for rounding.
ROUNDING: Final = 1e-13
#: Slopes, and products of one slope of each input, must be that far from the largest and the smallest number.
STEEPEST: Final = 1e250

#: A function of the knots of some inputs: positions of these inputs, and values that are not 0 by position of knots.
Tensor = tuple[tuple[int, ...], dict[tuple[int, ...], float]]


@record(frozen=True)
class Table:
    """An output at all knots.

    Args:
        value: Values of the output if the activations sum to 1, else of Σ w_r c_r; the last input varies fastest.
        weight: Values of Σ w_r, empty if they sum to 1.
        low, high: Bounds of the output.
    """

    value: tuple[float, ...]
    weight: tuple[float, ...]
    low: float
    high: float


@record(frozen=True)
class Grid:
    """All outputs at the knots of the inputs that rules read.

    Args:
        inputs: Positions of these inputs.
        knots: Of each of them, rising; beyond the outer ones nothing changes.
        outputs: One for each output.
    """

    inputs: tuple[int, ...]
    knots: tuple[tuple[float, ...], ...]
    outputs: tuple[Table, ...]

    @property
    def size(self) -> int:
        """Number of knots of all inputs together."""
        return math.prod(len(k) for k in self.knots)


def grid_of(plan: Plan) -> Grid | str:
    """Return the values of all outputs at the knots, or why the system does not interpolate."""
    reason = _unsuited(plan)
    if reason:
        return reason
    inputs = tuple(sorted({d.variable for d in plan.degrees}))
    knots = tuple(knots_of(plan.inputs[i], [d.set for d in plan.degrees if d.variable == i]) for i in inputs)
    for k, i in zip(knots, inputs, strict=True):
        if too_close(k, [d.set for d in plan.degrees if d.variable == i]):
            return f"corners of '{plan.inputs[i].name}' lie too close to each other"
    if not all(1.0 / STEEPEST < math.prod(s) < STEEPEST for s in zip(*map(_slopes, knots), strict=True)):
        return "the ranges of its inputs are too small or too large"
    if math.prod(map(len, knots)) > MOST_KNOTS:
        return f"its inputs have {math.prod(map(len, knots)):,} knots together, more than {MOST_KNOTS:,}"
    strengths = _Strengths(plan, inputs, knots)
    fired = [strengths.tensor(s) for s in plan.strengths]
    if any(f is None for f in fired):
        return "firing strengths are not products of straight lines"
    tables = [_table(plan, output, [f for f in fired if f is not None], inputs, knots) for output in plan.outputs]
    outputs = tuple(t for t in tables if t is not None)
    if len(outputs) < len(tables):
        return "activations come close to 0"
    return Grid(inputs, knots, outputs)


def _unsuited(plan: Plan) -> str:
    """Return a reason that the plan itself gives."""
    if plan.states or plan.held:
        return "it has a state"
    if not plan.all_act:
        return f"activation '{next(a.kind for a in plan.activations if a.kind != 'general')}' compares rules"
    if plan.has_formulas:
        return "lets, or outputs that are formulas, are not looked up"
    if any(o.reads for o in plan.outputs) or plan.chains:
        return "rules read outputs"
    if plan.least not in (None, 0.0):
        return f"rules act only above {plan.least:g}"
    if any(o.merge != "rules" or o.total != "activations" for o in plan.outputs):
        return "averages run over something else than rules"
    if any(e.change is not None or e.factor != 1.0 for o in plan.outputs for e in o.implied):
        return "hedges or weights change what consequents feel"
    if any(o.clamped for o in plan.outputs):
        return "outputs are clamped"
    if not all(o.averages for o in plan.outputs):
        return "not all defuzzifiers are averages over rules"
    if any(o.terms[e.term].expression is not None for o in plan.outputs for e in o.implied):
        return "consequents are functions of the inputs"
    if not plan.degrees:
        return "no rule reads an input"
    curved = next((d for d in plan.degrees if not is_continuous(d.set)), None)
    if curved is not None:
        return f"term '{curved.term}' of '{plan.variable(curved.variable).name}' has no straight sides or jumps"
    return ""


def is_continuous(term: SetPlan) -> bool:
    """Return whether a set has straight sides and no jumps."""
    return bool(term.vertices) and all(a[0] < b[0] for a, b in pairwise(term.vertices))


def knots_of(variable: InputPlan, sets: Sequence[SetPlan]) -> tuple[float, ...]:
    """Return the corners of some terms, and the ends of the range that cut a side."""
    corners = sorted({x for term in sets for x, _ in term.vertices})
    if not variable.extrapolate:
        inside = [x for x in corners if variable.lower < x < variable.upper]
        first = [variable.lower] if corners[0] <= variable.lower else []
        corners = [*first, *inside, *([variable.upper] if corners[-1] >= variable.upper else [])]
    least = _SAME * (corners[-1] - corners[0])
    return tuple(x for k, x in enumerate(corners) if k == 0 or x - corners[k - 1] > least)


def _slopes(knots: Sequence[float]) -> tuple[float, float]:
    """Return the largest and the smallest slope of a side between knots."""
    widths = [b - a for a, b in pairwise(knots)] or [1.0]
    return 1.0 / min(widths), 1.0 / sum(widths)


def too_close(knots: Sequence[float], sets: Sequence[SetPlan]) -> bool:
    """Return whether corners of sets lie so close to each other that lines between knots are not the degrees."""
    least = max(_NARROWEST * (knots[-1] - knots[0]), 1.0 / STEEPEST)
    if any(b - a < least for a, b in pairwise(knots)):
        return True
    moved = [(term, knots[bisect_right(knots, x) - 1], y) for term, x, y in rounded(knots, sets)]
    return any(abs(degree_at(term, knot) - y) > ROUNDING for term, knot, y in moved)


def rounded(knots: Sequence[float], sets: Sequence[SetPlan]) -> list[tuple[SetPlan, float, float]]:
    """Return the corners, each with its set and degree, that count as a knot from which they differ by rounding."""
    places = set(knots)
    return [(s, x, y) for s in sets for x, y in s.vertices if knots[0] <= x <= knots[-1] and x not in places]


def degree_at(term: SetPlan, x: float) -> float:
    """Return the degree of a straight-sided term, counted from the lower end of a side, which avoids cancellation."""
    vertices = term.vertices
    if x <= vertices[0][0]:
        return vertices[0][1]
    for (x0, y0), (x1, y1) in pairwise(vertices):
        if x <= x1:
            if x == x1:
                return y1
            return y0 + (y1 - y0) * ((x - x0) / (x1 - x0)) if y0 <= y1 else y1 + (y0 - y1) * ((x1 - x) / (x1 - x0))
    return vertices[-1][1]


class _Strengths:
    """Firing strengths at the knots."""

    def __init__(self, plan: Plan, inputs: Sequence[int], knots: Sequence[Sequence[float]]) -> None:
        self.lengths = [len(k) for k in knots]
        self.known: dict[str, Tensor | None] = {}
        for i, d in enumerate(plan.degrees):
            own = inputs.index(d.variable)
            values = {(k,): degree_at(d.set, x) for k, x in enumerate(knots[own])}
            self.known[degree_name(i)] = ((own,), {k: v for k, v in values.items() if v != 0.0})
        for i, step in enumerate(plan.steps):
            self.known[step_name(i)] = self.tensor(step)

    def tensor(self, strength: Expr) -> Tensor | None:
        """Return a firing strength at the knots, None for one that is not multilinear between them."""
        match strength:
            case Name(name=name):
                return self.known[name]
            case Number(value=value):
                return (), {(): value}
            case Binary(op="*", left=left, right=right):
                a, b = self.tensor(left), self.tensor(right)
                return _product(a, b) if a is not None and b is not None else None
            case Binary(op="+" | "-" as op, left=left, right=right):
                a, b = self.tensor(left), self.tensor(right)
                return self._sum(a, b, 1.0 if op == "+" else -1.0) if a is not None and b is not None else None
        return None

    def _sum(self, a: Tensor, b: Tensor, sign: float) -> Tensor:
        over = tuple(sorted({*a[0], *b[0]}))
        total = dict(self._spread(a, over))
        for position, value in self._spread(b, over).items():
            total[position] = total.get(position, 0.0) + sign * value
        return over, total

    def _spread(self, tensor: Tensor, over: tuple[int, ...]) -> Mapping[tuple[int, ...], float]:
        """Return a tensor as one over more inputs."""
        inputs, values = tensor
        if inputs == over:
            return values
        ranges = [range(self.lengths[i]) for i in over]
        where = [over.index(i) for i in inputs]
        return {p: values[q] for p in product(*ranges) if (q := tuple(p[w] for w in where)) in values}


def _product(a: Tensor, b: Tensor) -> Tensor | None:
    """Return a product; of two factors that change with the same input it is not a straight line."""
    if set(a[0]) & set(b[0]):
        return None
    over = (*a[0], *b[0])
    if not a[0] or not b[0] or a[0][-1] < b[0][0]:  # in order already
        return over, {(*p, *q): u * v for p, u in a[1].items() for q, v in b[1].items()}
    order = sorted(range(len(over)), key=lambda k: over[k])
    values = {tuple((*p, *q)[k] for k in order): u * v for p, u in a[1].items() for q, v in b[1].items()}
    return tuple(over[k] for k in order), values


def _table(
    plan: Plan, output: OutputPlan, fired: Sequence[Tensor], inputs: Sequence[int], knots: Sequence[Sequence[float]]
) -> Table | None:
    """Return one output at the knots, None where too little fires."""
    size = math.prod(map(len, knots))
    strides = [math.prod(len(k) for k in knots[i + 1 :]) for i in range(len(knots))]
    above, below = [0.0] * size, [0.0] * size
    peaks = []
    #: By the inputs of a firing strength, the strides of these, and the steps along all others.
    ways: dict[tuple[int, ...], tuple[list[int], list[int]]] = {}
    peaks_of = {k: output.terms[k].peak for k in {entry.term for entry in output.implied}}
    for entry in output.implied:
        rule = plan.rules[entry.rule]
        if rule.weight == 0.0:
            continue
        peak = peaks_of[entry.term]
        over, values = fired[rule.strength]
        if any(values.values()):
            peaks.append(peak)
        if over not in ways:
            free = [i for i in range(len(knots)) if i not in over]
            shifts = [sum(s) for s in product(*([strides[i] * k for k in range(len(knots[i]))] for i in free))]
            ways[over] = [strides[i] for i in over], shifts
        own, shifts = ways[over]
        for position, value in values.items():
            start = sum(map(mul, own, position))
            for shift in shifts:
                above[start + shift] += rule.weight * value * peak
                below[start + shift] += rule.weight * value
    if not peaks or min(below) <= _LEAST_SHARE * max(below):
        return None
    # An average lies between its operands, also with rounding; in a cell it lies between its corners.
    low, high = min(peaks), max(peaks)
    at_knots = tuple(min(max(a / w, low), high) for a, w in zip(above, below, strict=True))
    ends = min(at_knots), max(at_knots)
    if all(abs(w - 1.0) <= _UNITY for w in below):
        return Table(at_knots, (), *ends)
    return Table(tuple(above), tuple(below), *ends)
