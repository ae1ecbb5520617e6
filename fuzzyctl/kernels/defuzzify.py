"""Defuzzifiers: from the activations of the rules to one number, written as assignments of a program."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import groupby, pairwise

from fuzzyctl.expr import ZERO, Binary, Compare, Expr, Name, Number, Where, replace_names
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, Vertex
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


Hull = tuple[float | Expr, float | Expr]


def defuzzify(
    builder: Builder,
    output: OutputPlan,
    active: Sequence[Activation],
    inputs: Mapping[str, Expr],
    previous: Expr | None,
) -> tuple[Expr, Expr]:
    """Write the assignments for one output.

    Args:
        builder: The program to write into.
        output: The output.
        active: The rules that name it, without those of activation 0.
        inputs: The clamped inputs by name, for consequents that are functions of them.
        previous: The previous value of an output that holds it where no rule fires, else None.

    Returns:
        Its value as an atom, and the condition that some rule fires.
    """
    otherwise = previous or _otherwise(output)
    offset = 0.0
    hull: Hull
    if output.over_rules:
        numerator, denominator, hull = _over_rules(builder, output, active, inputs)
        if output.kind == "weighted_sum":
            fires = Compare(">", denominator, ZERO)
            return builder.let(Where(fires, numerator, otherwise)), fires
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
    # Quotients of rounded (or denormal) sums may leave the hull of what is averaged; proved bounds are bounds of the
    # numbers returned, so the value is held within the hull. NaN stays NaN.
    value = builder.let(clip(builder.let(Where(fires, quotient, otherwise)), *hull))
    if not _passes(hull, otherwise):
        value = builder.let(Where(fires, value, otherwise))
    return value, fires


def _otherwise(output: OutputPlan) -> Number:
    return Number(output.otherwise) if isinstance(output.otherwise, float) else NAN


def _passes(hull: Hull, otherwise: Expr) -> bool:
    """Return whether a value is what it was once it is held within the hull."""
    if not isinstance(otherwise, Number):
        return False
    low, high = hull
    inside = isinstance(low, float) and isinstance(high, float) and low <= otherwise.value <= high
    return inside or math.isnan(otherwise.value)


def middle(output: OutputPlan) -> float:
    """Return the point that moments are taken about: the middle of the range, so that errors scale with the range."""
    return 0.5 * output.lower + 0.5 * output.upper


def consequent_hull(output: OutputPlan, terms: Sequence[int]) -> tuple[float, float]:
    """Return the least and the largest value that an average over these terms, fixed or adaptive, can have."""
    if output.rate is not None:
        return output.lower, output.upper
    ends = [end for t in terms for end in _values(output, output.terms[t])] or [0.0]
    return min(ends), max(ends)


def _values(output: OutputPlan, term: SetPlan) -> tuple[float, float]:
    """Return the ends of what a rule with this consequent can contribute; a function of the inputs is bounded later."""
    if term.expression is not None:
        return term.reach or (-math.inf, math.inf)
    if output.kind != "tsukamoto":
        return term.peak, term.peak
    value = scalar_function(term.inverse(Name("w")))
    ends = sorted(min(max(value(w), output.lower), output.upper) for w in (0.0, 1.0))
    return ends[0], ends[1]


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
    ends: list[float] = []
    for (x0, y0), (x1, y1) in pairwise(_whole(term.vertices)):
        left, right = max(x0, output.lower), min(x1, output.upper)
        if left < right and max(y0, y1) > 0.0:
            ends += [left, right]
    return (min(ends), max(ends)) if ends else ()


def _whole(vertices: tuple[Vertex, ...]) -> tuple[Vertex, ...]:
    """Return corners with the stretches beyond the outer ones."""
    return ((-math.inf, vertices[0][1]), *vertices, (math.inf, vertices[-1][1]))


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


def _over_rules(
    builder: Builder, output: OutputPlan, active: Sequence[Activation], inputs: Mapping[str, Expr]
) -> tuple[Expr, Expr, Hull]:
    """Sum activation · consequent, and activation, over rules; rules of equal consequents are summed first."""
    if output.rate is not None:
        numerator = builder.total(times(a.strength, Item(STATE, a.state or 0)) for a in active)
        return numerator, builder.total(a.strength for a in active), consequent_hull(output, ())
    by_value: dict[Expr, list[Expr]] = {}
    for a in active:
        value = _consequent(builder, output, output.terms[a.term], a.strength, inputs)
        by_value.setdefault(value, []).append(a.strength)
    sums = {value: builder.total(parts) for value, parts in by_value.items()}
    if all(output.terms[a.term].expression is None or output.terms[a.term].reach for a in active):
        numerator = builder.total(times(s, value) for value, s in sums.items() if value != ZERO)
        return numerator, builder.total(sums.values()), consequent_hull(output, [a.term for a in active])
    numerator = builder.total(_part(builder, s, value) for value, s in sums.items() if value != ZERO)
    denominator = builder.total(sums.values())
    least = builder.smallest(_if_firing(builder, s, value, math.inf) for value, s in sums.items())
    most = builder.largest(_if_firing(builder, s, value, -math.inf) for value, s in sums.items())
    return numerator, denominator, (least, most)


def _consequent(
    builder: Builder, output: OutputPlan, term: SetPlan, strength: Expr, inputs: Mapping[str, Expr]
) -> Expr:
    """Return the value of a rule's consequent as an atom."""
    if term.expression is not None:
        return builder.let(replace_names(term.expression, inputs))
    if output.kind == "tsukamoto":
        place = builder.let(term.inverse(builder.let(term.share(strength))))
        return builder.let(clip(place, output.lower, output.upper))
    return Number(term.peak)


def _part(builder: Builder, strength: Expr, value: Expr) -> Expr:
    """Return activation · consequent; a function without a value, or an infinite one, counts only if its rule fires."""
    product = times(strength, value)
    return product if isinstance(value, Number) else builder.let(Where(Compare(">", strength, ZERO), product, ZERO))


def _if_firing(builder: Builder, strength: Expr, value: Expr, otherwise: float) -> Expr:
    return builder.let(Where(Compare(">", strength, ZERO), value, Number(otherwise)))


def _heights(builder: Builder, output: OutputPlan, active: Sequence[Activation]) -> list[tuple[int, Expr, float]]:
    """Return (term, activation, largest activation) with rules merged where the aggregation allows it.

    Under `max`, and under `sum` of scaled sets, rules of one term act as one rule.
    """
    if output.aggregation != "max" and (output.aggregation, output.implication) != ("sum", "product"):
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
    """Σ x μ(x) / Σ μ(x) over the grid, x counted from the middle of the range.

    The grid is cut into stretches where the same sets are above 0; the others cost nothing there.
    """
    points = sample_points(output)
    sets = [(h, sampled_degrees(output.terms[t], points)) for t, h, _ in _heights(builder, output, active)]
    areas: list[Expr] = []
    moments: list[Expr] = []
    present = [tuple(k for k, (_, degrees) in enumerate(sets) if degrees[i] > 0.0) for i in range(len(points))]
    start = 0
    for own, stretch in groupby(present):
        stop = start + len(list(stretch))
        if own:
            here = [(sets[k][0], sets[k][1][start:stop]) for k in own]
            area, moment = _stretch(builder, output, here, points[start:stop])
            areas.append(area)
            moments.append(moment)
        start = stop
    return builder.total(moments), builder.total(areas)


def _stretch(
    builder: Builder, output: OutputPlan, sets: Sequence[tuple[Expr, tuple[float, ...]]], points: Sequence[float]
) -> tuple[Expr, Expr]:
    """Add up area and moment over some samples."""
    counter = builder.fresh()
    inner = builder.inner()
    parts: list[Expr] = []
    for height, degrees in sets:
        degree = Item(builder.table(degrees), counter)
        parts.append(inner.let(CONJUNCTIONS[output.implication](height, inner.let(degree))))
    join = AGGREGATIONS[output.aggregation]
    joined = reduce(lambda a, b: inner.let(join(a, b)), parts)
    x = Item(builder.table(p - middle(output) for p in points), counter)
    area, moment = inner.fresh(), inner.fresh()
    body = tuple(s for s in inner.statements if isinstance(s, Assign))
    sums = (Assign(area, joined), Assign(moment, times(x, joined)))
    builder.statements.append(Accumulate(len(points), counter, body, sums))
    return Name(area), Name(moment)
