"""Bisector of samples by the rule of each tool; centroid and bisector of polygons through samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Logic, Name, Number, Where, minus, plus, times
from fuzzyctl.kernels.inference.defuzzify.sampling import HALF, Carried, Samples, carry, total
from fuzzyctl.kernels.program.builder import Builder, clip, sorted_atoms
from fuzzyctl.kernels.program.program import Assign, Fold, Item

#: Parts of the area that are taken for rounding: where half of it ends up to this, a gap may follow.
SLACK: Final = 1e-13


def sampled_bisector(samples: Samples, middle: float) -> tuple[Expr, Expr]:
    """Write the bisector of samples by the rule of the output.

    Returns:
        Its place, counted from the middle, and a measure that is above 0 if it exists; the place is not computed yet,
        so that it may be left out if the set is empty.
    """
    match samples.output.rule:
        case "first":
            return _first(samples, middle)
        case "nearest":
            return _nearest(samples, middle)
        case "walk":
            return _walk(samples, middle)
        case "two_sided":
            return _two_sided(samples, middle)
        case "between":
            return _between(samples, middle)
    return _interpolated(samples, middle)


def _first(samples: Samples, middle: float) -> tuple[Expr, Expr]:
    """Take the first sample up to which the sum is half or more."""
    whole = total(samples)
    half = samples.builder.let(times(HALF, whole))

    def step(b: Builder, v: Expr, items: Sequence[Expr], c: Mapping[str, Expr]) -> Carried:
        area = b.let(plus(c["sum"], v))
        hit = Logic("and", (Compare("<", c["sum"], half), Compare(">=", area, half)))
        return {"sum": area, "place": Where(hit, items[0], c["place"])}

    points = [p - middle for p in samples.points]
    return samples.scan({"sum": ZERO, "place": ZERO}, step, [points])["place"], whole


def _nearest(samples: Samples, middle: float) -> tuple[Expr, Expr]:
    """Take the mean of all samples up to which the sum is nearest to half, as numbers, however close others come."""
    builder = samples.builder
    whole = total(samples)
    unit = builder.let(Where(Compare(">", whole, ZERO), whole, ONE))

    def step(b: Builder, v: Expr, items: Sequence[Expr], c: Mapping[str, Expr]) -> Carried:
        area = b.let(plus(c["sum"], v))
        away = b.let(Call("abs", (area / unit - HALF,)))
        nearer, same = Compare("<", away, c["away"]), Compare("==", away, c["away"])
        return {
            "sum": area,
            "away": Where(nearer, away, c["away"]),
            "total": Where(nearer, items[0], Where(same, plus(c["total"], items[0]), c["total"])),
            "count": Where(nearer, ONE, Where(same, plus(c["count"], ONE), c["count"])),
        }

    start = {"sum": ZERO, "away": Number(math.inf), "total": ZERO, "count": ZERO}
    points = [p - middle for p in samples.points]
    result = samples.scan(start, step, [points], gaps=True)
    return result["total"] / result["count"], whole


def _walk(samples: Samples, middle: float) -> tuple[Expr, Expr]:
    """Go from the left by trapezoids while the left part is the smaller one; take the nearer end of the last one."""
    builder, points = samples.builder, [p - middle for p in samples.points]
    ends = plus(samples.at(0), samples.at(len(points) - 1))
    whole = builder.let(times(HALF, minus(times(Number(2.0), total(samples)), builder.let(ends))))

    def step(b: Builder, v: Expr, items: Sequence[Expr], c: Mapping[str, Expr]) -> Carried:
        goes_on = Compare("<", c["left"], c["right"])
        area = b.let(times(HALF, plus(c["last"], v)))
        left, right = b.let(plus(c["left"], area)), b.let(minus(c["right"], area))
        place = Where(Compare(">=", area, minus(left, right)), items[1], items[0])
        return {
            "left": Where(goes_on, left, c["left"]),
            "right": Where(goes_on, right, c["right"]),
            "place": Where(goes_on, place, c["place"]),
            "last": v,
        }

    start = {"left": ZERO, "right": whole, "place": Number(points[0]), "last": samples.at(0)}
    before = [points[0], *points[:-1]]
    return samples.scan(start, step, [before, points], first=1, gaps=True)["place"], whole


def _two_sided(samples: Samples, middle: float) -> tuple[Expr, Expr]:
    """Go from both ends, always on the side whose sum is less, until both meet; the outermost samples do not count.

    Which sample is next depends on the sums, so that degrees are computed from its place.
    """
    builder, points = samples.builder, samples.points
    if len(points) == 1:
        return Number(points[0] - middle), samples.at(0)
    inner, counter = builder.inner(), builder.fresh()
    step = (points[-1] - points[0]) / (len(points) - 1)
    low, high, below, above = (builder.fresh() for _ in range(4))
    names = {n: Name(n) for n in (low, high, below, above)}
    from_left = Compare("<=", names[below], names[above])
    lower, upper = inner.let(plus(names[low], ONE)), inner.let(minus(names[high], ONE))
    x = inner.let(plus(Number(points[0]), times(Number(step), inner.let(Where(from_left, lower, upper)))))
    degrees = {k: samples.output.terms[t].degree(x) for k, (t, _, _) in enumerate(samples.heights)}
    value = inner.let(samples.join(inner, degrees))
    new = {
        low: Where(from_left, lower, names[low]),
        high: Where(from_left, names[high], upper),
        below: Where(from_left, plus(names[below], value), names[below]),
        above: Where(from_left, names[above], plus(names[above], value)),
    }
    then = tuple(Assign(n, inner.let(v)) for n, v in new.items())
    first = tuple(Assign(n, Number(v)) for n, v in zip(new, (0.0, len(points) - 1.0, 0.0, 0.0), strict=True))
    body = tuple(s for s in inner.statements if isinstance(s, Assign))
    builder.statements.append(Fold(len(points) - 1, counter, first, body, then))
    return plus(Number(points[0] - middle), times(Number(step), names[low])), names[below]


def _between(samples: Samples, middle: float) -> tuple[Expr, Expr]:
    """Go from both ends, always on the side whose sum is less, until all samples are taken.

    The place is between the last ones taken on both sides, nearer to that of the larger sum of the other side; a side
    without taken samples ends at the end of the range.
    """
    builder, output, points = samples.builder, samples.output, samples.points
    inner, counter = builder.inner(), builder.fresh()
    step = (points[-1] - points[0]) / max(len(points) - 1, 1)
    low, high, below, above, left, right = (builder.fresh() for _ in range(6))
    names = {n: Name(n) for n in (low, high, below, above, left, right)}
    from_left: Expr = Compare("<=", names[below], names[above])
    if output.tolerance:
        from_left = Logic("or", (from_left, Compare("<", minus(names[below], names[above]), Number(output.tolerance))))
    is_left = Compare(">", inner.let(Where(from_left, ONE, ZERO)), ZERO)
    place = inner.let(plus(Number(points[0]), times(Number(step), inner.let(Where(is_left, names[low], names[high])))))
    value = inner.let(
        samples.join(inner, {k: output.terms[t].degree(place) for k, (t, _, _) in enumerate(samples.heights)})
    )
    new = {
        low: Where(is_left, plus(names[low], ONE), names[low]),
        high: Where(is_left, names[high], minus(names[high], ONE)),
        below: Where(is_left, plus(names[below], value), names[below]),
        above: Where(is_left, names[above], plus(names[above], value)),
        left: Where(is_left, place, names[left]),
        right: Where(is_left, names[right], place),
    }
    then = tuple(Assign(n, inner.let(v)) for n, v in new.items())
    starts = (0.0, len(points) - 1.0, 0.0, 0.0, output.lower, output.upper)
    first = tuple(Assign(n, Number(v)) for n, v in zip(new, starts, strict=True))
    body = tuple(s for s in inner.statements if isinstance(s, Assign))
    builder.statements.append(Fold(len(points), counter, first, body, then))
    whole = builder.let(plus(names[below], names[above]))
    ends = [builder.let(minus(names[n], Number(middle))) for n in (right, left)]
    moment = plus(times(names[below], ends[0]), times(names[above], ends[1]))
    return builder.let(moment) / whole, whole


def _interpolated(samples: Samples, middle: float) -> tuple[Expr, Expr]:
    """Take the place inside a cell up to which the area is half; where a gap follows, the middle of the gap.

    Samples at the middles or left ends of cells are the degrees of the cells; between end points the set is straight.
    """
    builder, points = samples.builder, samples.points
    straight = samples.output.grid == "endpoints"
    width = (samples.output.upper - samples.output.lower) / (len(points) - (1 if straight else 0))
    if straight:
        starts = [p - middle for p in (points[0], *points[:-1])]
    else:
        starts = [p - middle - (0.5 * width if samples.output.grid == "midpoint" else 0.0) for p in points]
    whole = total(samples)
    if straight:
        ends = builder.let(plus(samples.at(0), samples.at(len(points) - 1)))
        whole = builder.let(minus(whole, times(HALF, ends)))
    half = builder.let(times(HALF, whole))
    under, over = builder.let(times(Number(1.0 - SLACK), half)), builder.let(times(Number(1.0 + SLACK), half))

    def step(b: Builder, v: Expr, items: Sequence[Expr], c: Mapping[str, Expr]) -> Carried:
        left = c["last"] if straight else v
        area = b.let(plus(c["sum"], times(HALF, plus(left, v)) if straight else v))
        hit = b.let(Where(Logic("and", (Compare("<", c["sum"], under), Compare(">=", area, under))), ONE, ZERO))
        after = Logic("and", (Compare("<=", c["sum"], over), Compare(">", area, over)))
        is_hit = Compare(">", hit, ZERO)
        return {
            "sum": area,
            "before": Where(is_hit, c["sum"], c["before"]),
            "start": Where(is_hit, items[0], c["start"]),
            "left": Where(is_hit, left, c["left"]),
            "right": Where(is_hit, v, c["right"]),
            "after": Where(after, items[0], c["after"]),
            **({"last": v} if straight else {}),
        }

    start: dict[str, Expr] = dict.fromkeys(("sum", "before", "start", "left", "right", "after"), ZERO)
    if straight:
        start["last"] = samples.at(0)
    result = samples.scan(start, step, [starts], first=1 if straight else 0, gaps=straight)
    rest = builder.let(minus(half, result["before"]))
    share = builder.let(share_of(builder, result["left"], result["right"], rest))
    place = builder.let(plus(result["start"], times(Number(width), share)))
    end = builder.let(plus(result["start"], Number(width)))
    # Ends that meet may differ by rounding.
    after = builder.let(Where(Compare(">", result["after"], plus(end, Number(1e-9 * width))), result["after"], end))
    return builder.let(past_gap(place, end, after)), whole


def past_gap(place: Expr, end: Expr, after: Expr) -> Expr:
    """Return the place found in a stretch, or the middle of a gap behind the stretch.

    At the end of a stretch where the set vanishes the place has lost its digits, while the end is known.

    Args:
        place: Up to where the area is half.
        end: Where its stretch ends.
        after: Where the stretch begins in which the area comes to be more than half.
    """
    return Where(Compare(">", after, end), times(HALF, plus(end, after)), place)


def share_of(builder: Builder, left: Expr, right: Expr, area: Expr) -> Expr:
    """Return up to which part of a stretch of length 1 a straight line from one degree to another has some area.

    From left s + (right - left) s² / 2 = a follows s = 2 a / (left + √(left² + 2 (right - left) a)), without
    cancellation.

    Args:
        builder: The program to write into.
        left, right, area: Atoms.
    """
    square = plus(times(left, left), times(times(Number(2.0), minus(right, left)), area))
    root = Call("sqrt", (builder.let(Call("max", (ZERO, builder.let(square)))),))
    below = builder.let(plus(left, root))
    share = Where(Compare(">", below, ZERO), times(Number(2.0), area) / below, ZERO)
    return clip(builder.let(share), 0.0, 1.0)


#: The two ends of a side: their places, or their degrees.
Ends = tuple[Expr, Expr]
Side = tuple[Ends, Ends]
#: From a builder for the loop, the sides of a cell and the old values: the new values.
_SideStep = Callable[[Builder, Sequence[Side], Mapping[str, Expr]], Carried]


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


def _along(samples: Samples, middle: float, carried: Carried, step: _SideStep) -> Carried:
    """Carry values along the sides."""
    for inner, counter, count, sides in _cells(samples, middle):
        names = {what: Name(samples.builder.fresh()) for what in carried}
        carried = carry(samples.builder, inner, count, counter, carried, names, step(inner, sides, names))
    return carried


def _sum(builder: Builder, sides: Sequence[Side], carried: Mapping[str, Expr]) -> Carried:
    """Return area and moment so far."""
    parts = [moments_of(builder, *side) for side in sides]
    area, moment = (builder.total(values) for values in zip(*parts, strict=True))
    return {"area": plus(carried["area"], area), "moment": plus(carried["moment"], moment)}


def _halved(half: Expr, builder: Builder, sides: Sequence[Side], carried: Mapping[str, Expr]) -> Carried:
    """Return the area so far, and where it is half of all."""
    area, place = carried["sum"], carried["place"]
    for (a, b), (y, z) in sides:
        width = builder.let(minus(b, a))
        before, area = area, builder.let(plus(area, moments_of(builder, (a, b), (y, z))[0]))
        left = builder.let(Where(Compare(">", width, ZERO), minus(half, before) / width, ZERO))
        x = plus(a, times(width, builder.let(share_of(builder, y, z, left))))
        hit = Logic("and", (Compare("<", before, half), Compare(">=", area, half)))
        place = builder.let(Where(hit, x, place))
    return {"sum": area, "place": place}


def _cells(samples: Samples, middle: float) -> Iterator[tuple[Builder, str, int, tuple[Side, ...]]]:
    """Yield loops over cells between samples: what to write into, counter, number and sides of a cell.

    In the cells of a loop the same sets are, or may be, above 0.
    """
    degrees = samples.degrees
    first = replace(samples, points=samples.points[:-1], degrees=tuple(d and d[:-1] for d in degrees))
    last = replace(samples, points=samples.points[1:], degrees=tuple(d and d[1:] for d in degrees))
    either = tuple(d and tuple(map(max, d, d[1:])) for d in degrees)
    for sets, begin, end in replace(first, degrees=either).stretches():
        if sets:
            counter, inner = samples.builder.fresh(), samples.builder.inner()
            loop = inner, begin, end, counter
            ends = {k: (first.degree(k, *loop), last.degree(k, *loop)) for k in sets}
            tables = ([p - middle for p in side.points[begin:end]] for side in (first, last))
            places = [inner.let(Item(samples.builder.table(t), counter)) for t in tables]
            yield inner, counter, end - begin, tuple(_sides(samples, inner, ends, places))


def _sides(samples: Samples, inner: Builder, ends: Mapping[int, Ends], places: Sequence[Expr]) -> Iterator[Side]:
    """Yield the sides of a cell, from left to right; a term that is clipped bends where it has its activation."""
    terms = [(samples.heights[k][1], samples.output.terms[samples.heights[k][0]], pair) for k, pair in ends.items()]
    cuts = [_reach(inner, h, pair) for h, term, pair in terms if samples.output.implication_of(term) == "min"]
    knots: list[Ends] = []
    for t in (ZERO, *sorted_atoms(inner, cuts), ONE):
        degrees = {k: _line_at(inner, pair, t) for k, pair in ends.items()}
        knots.append((_line_at(inner, (places[0], places[1]), t), inner.let(samples.join(inner, degrees))))
    yield from (((a, b), (y, z)) for (a, y), (b, z) in pairwise(knots))


def _reach(inner: Builder, level: Expr, ends: Ends) -> Expr:
    """Return at which part of a cell a line has a level; an end of the cell if it has it nowhere inside."""
    rise = inner.let(minus(ends[1], ends[0]))
    share = Where(Compare("==", rise, ZERO), ZERO, minus(level, ends[0]) / rise)
    return inner.let(clip(inner.let(share), 0.0, 1.0))


def _line_at(inner: Builder, ends: Ends, t: Expr) -> Expr:
    """Return the value of a line at a part of a cell."""
    if t in (ZERO, ONE):
        return ends[0] if t == ZERO else ends[1]
    return inner.let(plus(times(minus(ONE, t), ends[0]), times(t, ends[1])))
