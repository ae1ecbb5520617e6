"""Centroid and bisector of polygons: their corners are samples, and the places where terms meet their activations."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

from fuzzyctl.expr import ONE, ZERO, Compare, Expr, Logic, Name, Number, Where, minus, plus, times
from fuzzyctl.kernels.inference.defuzzify.envelope import sorted_atoms
from fuzzyctl.kernels.inference.defuzzify.sampled_bisector import share_of
from fuzzyctl.kernels.inference.defuzzify.sampling import HALF, Carried, Samples, carry
from fuzzyctl.kernels.program.builder import Builder, clip
from fuzzyctl.kernels.program.program import Item

#: The two ends of a side: their places, or their degrees.
Ends = tuple[Expr, Expr]
Side = tuple[Ends, Ends]
#: From a builder for the loop, the sides of a cell and what is carried: what is carried on.
Step = Callable[[Builder, Sequence[Side], Mapping[str, Expr]], Carried]


def moments_of(builder: Builder, places: Ends, degrees: Ends) -> Ends:
    """Write the area below a side, and its moment."""
    (a, b), (y, z) = places, degrees
    area = builder.let(times(HALF, times(minus(b, a), plus(y, z))))
    weighted = plus(times(a, plus(plus(y, y), z)), times(b, plus(y, plus(z, z))))
    return area, builder.let(times(Number(1 / 6), times(minus(b, a), weighted)))


def sampled_polygon(samples: Samples, middle: float) -> Ends:
    """Write the centroid or the bisector, counted from the middle of the range, and the area, as an atom."""
    sums = _along(samples, middle, {"area": ZERO, "moment": ZERO}, _sum)
    if samples.output.kind == "centroid":
        return sums["moment"] / sums["area"], sums["area"]
    half = samples.builder.let(times(HALF, sums["area"]))
    start = {"sum": ZERO, "place": Number(samples.points[0] - middle)}
    return _along(samples, middle, start, partial(_halved, half))["place"], sums["area"]


def _along(samples: Samples, middle: float, carried: Carried, step: Step) -> Carried:
    """Carry values along the sides."""
    for inner, counter, count, sides in _cells(samples, middle):
        names = {what: Name(samples.builder.fresh()) for what in carried}
        carried = carry(samples.builder, inner, count, counter, carried, names, step(inner, sides, names))
    return carried


def _sum(builder: Builder, sides: Sequence[Side], carried: Mapping[str, Expr]) -> Carried:
    """Return area and moment so far."""
    parts = [moments_of(builder, *side) for side in sides]
    area, moment = (builder.total(own) for own in zip(*parts, strict=True))
    return {"area": plus(carried["area"], area), "moment": plus(carried["moment"], moment)}


def _halved(half: Expr, builder: Builder, sides: Sequence[Side], carried: Mapping[str, Expr]) -> Carried:
    """Return the area so far, and where it is half of all."""
    area, place = carried["sum"], carried["place"]
    for (a, b), (y, z) in sides:
        width = builder.let(minus(b, a))
        before, area = area, builder.let(plus(area, moments_of(builder, (a, b), (y, z))[0]))
        left = builder.let(Where(Compare(">", width, ZERO), minus(half, before) / width, ZERO))
        own = plus(a, times(width, builder.let(share_of(builder, y, z, left))))
        hit = Logic("and", (Compare("<", before, half), Compare(">=", area, half)))
        place = builder.let(Where(hit, own, place))
    return {"sum": area, "place": place}


def _cells(samples: Samples, middle: float) -> Iterator[tuple[Builder, str, int, tuple[Side, ...]]]:
    """Yield loops over cells between samples: what to write into, counter, number and sides of a cell.

    In the cells of a loop the same sets are, or may be, above 0.
    """
    known = samples.degrees
    first = replace(samples, points=samples.points[:-1], degrees=tuple(d and d[:-1] for d in known))
    last = replace(samples, points=samples.points[1:], degrees=tuple(d and d[1:] for d in known))
    either = tuple(d and tuple(map(max, d, d[1:])) for d in known)
    for own, begin, end in replace(first, degrees=either).stretches():
        if own:
            counter, inner = samples.builder.fresh(), samples.builder.inner()
            loop = inner, begin, end, counter
            ends = {k: (first.degree(k, *loop), last.degree(k, *loop)) for k in own}
            tables = ([p - middle for p in side.points[begin:end]] for side in (first, last))
            places = [inner.let(Item(samples.builder.table(t), counter)) for t in tables]
            yield inner, counter, end - begin, tuple(_sides(samples, inner, ends, places))


def _sides(samples: Samples, inner: Builder, ends: Mapping[int, Ends], places: Sequence[Expr]) -> Iterator[Side]:
    """Yield the sides of a cell, from left to right; a term that is clipped bends where it has its activation."""
    terms = [(samples.heights[k][1], samples.output.terms[samples.heights[k][0]], pair) for k, pair in ends.items()]
    cuts = [_reach(inner, h, pair) for h, term, pair in terms if samples.output.implication_of(term) == "min"]
    knots: list[Ends] = []
    for t in (ZERO, *sorted_atoms(inner, cuts), ONE):
        degrees = {k: _between(inner, pair, t) for k, pair in ends.items()}
        knots.append((_between(inner, (places[0], places[1]), t), inner.let(samples.join(inner, degrees))))
    yield from (((a, b), (y, z)) for (a, y), (b, z) in pairwise(knots))


def _reach(inner: Builder, level: Expr, ends: Ends) -> Expr:
    """Return at which part of a cell a line has a level; an end of the cell if it has it nowhere inside."""
    rise = inner.let(minus(ends[1], ends[0]))
    share = Where(Compare("==", rise, ZERO), ZERO, minus(level, ends[0]) / rise)
    return inner.let(clip(inner.let(share), 0.0, 1.0))


def _between(inner: Builder, ends: Ends, t: Expr) -> Expr:
    """Return the value of a line at a part of a cell."""
    if t in (ZERO, ONE):
        return ends[0] if t == ZERO else ends[1]
    return inner.let(plus(times(minus(ONE, t), ends[0]), times(t, ends[1])))
