"""Defuzzifiers: from the activations of the rules to one number, written as assignments of a program."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from fuzzyctl.expr import ZERO, Binary, Call, Compare, Expr, Name, Number, Where
from fuzzyctl.kernels.centroid import exact_moments
from fuzzyctl.kernels.plan import OutputPlan, SetPlan
from fuzzyctl.kernels.program import NAN, STATE, Accumulate, Assign, Builder, Item, clip, times
from fuzzyctl.kernels.python_backend import scalar_function


@dataclass(frozen=True)
class Activation:
    """How far one rule is active in one output.

    Args:
        strength: Its activation as an atom of the program.
        term: Position of its consequent term.
        state: Position of its adaptive consequent, None for a fixed one.
        weight: The largest activation it can have.
    """

    strength: Expr
    term: int
    state: int | None
    weight: float


def defuzzify(builder: Builder, output: OutputPlan, active: Sequence[Activation]) -> tuple[Expr, Expr]:
    """Write the assignments for one output.

    Returns:
        Its value as an atom, and the condition that some rule fires.
    """
    if output.averages:
        numerator, denominator, hull = _average(builder, output, active)
        offset = 0.0
    elif output.resolution is None:
        numerator, denominator = _exact(builder, output, active)
        offset, hull = middle(output), support_hull(output, [a.term for a in active])
    else:
        numerator, denominator = _sampled(builder, output, active)
        offset, hull = middle(output), support_hull(output, [a.term for a in active])
    fires = Compare(">", denominator, ZERO)
    quotient: Expr = Binary("/", numerator, denominator)
    if offset != 0.0:
        quotient = Binary("+", Number(offset), quotient)
    otherwise = NAN if output.otherwise in (None, "error") else Number(float(output.otherwise))
    # Quotients of rounded (or denormal) sums may leave the hull of what is averaged; proved bounds are bounds of the
    # numbers returned, so the value is held within the hull. NaN stays NaN.
    value = builder.let(clip(builder.let(Where(fires, quotient, otherwise)), *hull))
    if not (math.isnan(otherwise.value) or hull[0] <= otherwise.value <= hull[1]):
        value = builder.let(Where(fires, value, otherwise))
    return value, fires


def middle(output: OutputPlan) -> float:
    """Return the point that moments are taken about: the middle of the range, so that errors scale with the range."""
    return 0.5 * output.lower + 0.5 * output.upper


def average_hull(output: OutputPlan, terms: Sequence[int]) -> tuple[float, float]:
    """Return the least and the largest value that an average over these terms can have."""
    if output.rate is not None:
        return output.lower, output.upper
    peaks = [output.terms[t].peak for t in terms] or [0.0]
    return min(peaks), max(peaks)


def support_hull(output: OutputPlan, terms: Sequence[int]) -> tuple[float, float]:
    """Return the ends of the part of the range where the centroid of these terms can lie."""
    if output.resolution is not None:
        points = sample_points(output)
        degrees = [sampled_degrees(output.terms[t], points) for t in set(terms)]
        inside = [x for i, x in enumerate(points) if any(d[i] > 0.0 for d in degrees)]
    else:
        inside = [end for t in terms for end in support(output, output.terms[t])]
    return (min(inside), max(inside)) if inside else (output.lower, output.upper)


def support(output: OutputPlan, term: SetPlan) -> tuple[float, ...]:
    """Return the ends of the support of a piecewise-linear term within the output range, nothing where it has none."""
    vertices = term.vertices
    left = vertices[0][0] if vertices[0][1] == 0.0 else -math.inf
    right = vertices[-1][0] if vertices[-1][1] == 0.0 else math.inf
    ends = (max(left, output.lower), min(right, output.upper))
    return ends if ends[0] < ends[1] else ()


def sample_points(output: OutputPlan) -> tuple[float, ...]:
    """Return the grid of a sampled centroid: middles of equal cells, or equal steps from end to end."""
    count = output.resolution or 0
    width = output.upper - output.lower
    if output.grid == "midpoint":
        return tuple(output.lower + (i + 0.5) * width / count for i in range(count))
    return tuple(output.lower + i * width / (count - 1) for i in range(count)) if count > 1 else (output.lower,)


def sampled_degrees(term: SetPlan, points: Sequence[float]) -> tuple[float, ...]:
    """Return the degrees of a term at some points."""
    degree = scalar_function(term.degree(Name("x")))
    return tuple(degree(x) for x in points)


def _average(
    builder: Builder, output: OutputPlan, active: Sequence[Activation]
) -> tuple[Expr, Expr, tuple[float, float]]:
    """Sum over rules: activation · consequent over activation; rules of equal consequents are summed first."""
    if output.rate is not None:
        numerator = builder.total(times(a.strength, Item(STATE, a.state or 0)) for a in active)
        return numerator, builder.total(a.strength for a in active), average_hull(output, ())
    by_peak: dict[float, list[Expr]] = {}
    for a in active:
        by_peak.setdefault(output.terms[a.term].peak, []).append(a.strength)
    sums = {peak: builder.total(parts) for peak, parts in by_peak.items()}
    numerator = builder.total(times(s, Number(peak)) for peak, s in sums.items() if peak != 0.0)
    return numerator, builder.total(sums.values()), average_hull(output, [a.term for a in active])


def _heights(builder: Builder, output: OutputPlan, active: Sequence[Activation]) -> list[tuple[int, Expr, float]]:
    """Return (term, activation, largest activation) with rules merged where the aggregation allows it.

    Under `max`, and under `sum` of scaled sets, rules of one term act as one rule.
    """
    if output.aggregation == "sum" and output.implication == "min":
        return [(a.term, a.strength, a.weight) for a in active]
    merged: list[tuple[int, Expr, float]] = []
    for term in dict.fromkeys(a.term for a in active):
        own = [a for a in active if a.term == term]
        if output.aggregation == "max":
            merged.append((term, builder.largest(a.strength for a in own), max(a.weight for a in own)))
        else:
            merged.append((term, builder.total(a.strength for a in own), sum(a.weight for a in own)))
    return merged


def _exact(builder: Builder, output: OutputPlan, active: Sequence[Activation]) -> tuple[Expr, Expr]:
    area, moment = exact_moments(builder, output, _heights(builder, output, active))
    return moment, area


def _sampled(builder: Builder, output: OutputPlan, active: Sequence[Activation]) -> tuple[Expr, Expr]:
    """Σ x μ(x) / Σ μ(x) over the grid, x counted from the middle of the range."""
    points = sample_points(output)
    counter = builder.fresh()
    inner = builder.inner()
    parts: list[Expr] = []
    for term, height, _ in _heights(builder, output, active):
        degree = Item(builder.table(sampled_degrees(output.terms[term], points)), counter)
        cut = Call("min", (height, degree)) if output.implication == "min" else times(height, degree)
        parts.append(inner.let(cut))
    joined = inner.largest(parts) if output.aggregation == "max" else inner.total(parts)
    x = Item(builder.table(p - middle(output) for p in points), counter)
    area, moment = inner.fresh(), inner.fresh()
    body = tuple(s for s in inner.statements if isinstance(s, Assign))
    sums = (Assign(area, joined), Assign(moment, times(x, joined)))
    builder.statements.append(Accumulate(len(points), counter, body, sums))
    return Name(moment), Name(area)
