"""Bisector and maxima of piecewise-linear sets in closed form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Logic, Number, Where, minus, plus, times
from fuzzyctl.kernels.inference.defuzzify.centroid import Height
from fuzzyctl.kernels.inference.defuzzify.envelope import Knot, joints, largest_of, outline, segments
from fuzzyctl.kernels.inference.defuzzify.maxima import Hits, place_of, tolerance
from fuzzyctl.kernels.inference.defuzzify.sampled_bisector import SLACK, past_gap, share_of
from fuzzyctl.kernels.inference.defuzzify.sampled_polygon import moments_of
from fuzzyctl.kernels.plan.build import OutputPlan
from fuzzyctl.kernels.program.builder import Builder

_HALF: Final = Number(0.5)
#: Degrees that are the same but for rounding.
_ROUNDING: Final = 1e-12


def straight_centroid(builder: Builder, output: OutputPlan, heights: Sequence[Height]) -> tuple[Expr, Expr]:
    """Write the centroid of an outline, counted from the middle of the range, and its area, as an atom."""
    parts = [moments_of(builder, (a.x, b.x), (a.y, b.y)) for a, b in segments(outline(builder, output, heights))]
    area = builder.total(own for own, _ in parts)
    return builder.total(own for _, own in parts) / area, area


def straight_bisector(builder: Builder, output: OutputPlan, heights: Sequence[Height]) -> tuple[Expr, Expr]:
    """Write where the area to the left is half of all; at a gap the middle of the gap.

    Returns:
        Its place, counted from the middle of the range, and the area, as atoms.
    """
    parts = segments(outline(builder, output, heights))
    sums: list[Expr] = [ZERO]
    for a, b in parts:
        width = builder.let(minus(b.x, a.x))
        area = times(times(_HALF, width), plus(a.y, b.y))
        sums.append(builder.let(plus(sums[-1], builder.let(area))))
    whole = sums[-1]
    half = builder.let(times(_HALF, whole))
    under, over = builder.let(times(Number(1.0 - SLACK), half)), builder.let(times(Number(1.0 + SLACK), half))
    last = parts[-1] if parts else (Knot(ZERO, ZERO), Knot(ZERO, ZERO))
    found: list[Expr] = [sums[-2] if parts else ZERO, last[0].x, last[1].x, last[0].y, last[1].y]
    after = last[0].x
    for k in reversed(range(len(parts) - 1)):
        a, b = parts[k]
        here = Compare(">=", sums[k + 1], under)
        found = [
            builder.let(Where(here, own, other))
            for own, other in zip((sums[k], a.x, b.x, a.y, b.y), found, strict=True)
        ]
        after = builder.let(Where(Compare(">", sums[k + 1], over), a.x, after))
    before, start, end, left, right = found
    width = builder.let(minus(end, start))
    area = Where(Compare(">", width, ZERO), minus(half, before) / width, ZERO)
    share = share_of(builder, left, right, builder.let(area))
    place = builder.let(plus(start, times(width, builder.let(share))))
    return builder.let(past_gap(place, end, after)), whole


def straight_maximum(builder: Builder, output: OutputPlan, heights: Sequence[Height]) -> tuple[Expr, Expr]:
    """Write the place of the maximum that the output asks for.

    Returns:
        Its place, counted from the middle of the range, not computed yet; and the largest degree as an atom.
    """
    own = outline(builder, output, heights)
    jumps = joints(builder, output, heights)
    knots = _in_order(own, jumps)
    most = largest_of(builder, knots)
    bound = builder.let(times(Number(1.0 - max(tolerance(output), _ROUNDING)), most))
    hits = {k: builder.let(Where(Compare(">=", k.y, bound), ONE, ZERO)) for k in jumps}
    for part in own:
        hits |= {k: _is_top(builder, part, i, bound) for i, k in enumerate(part) if k not in hits}
    slack = builder.let(times(Number(_ROUNDING), most))
    intervals = tuple((_is_flat(builder, hits, a, b, slack), a.x, b.x) for a, b in segments(own))
    return place_of(builder, output, Hits(intervals, tuple((hits[k], k.x) for k in knots))), most


def _is_top(builder: Builder, part: Sequence[Knot], position: int, bound: Expr) -> Expr:
    """Return 1 for a knot that reaches a bound and does not lie on a slope towards a neighbour, else 0."""
    knot = part[position]
    beside = builder.largest(k.y for k in part[max(position - 1, 0) : position + 2] if k != knot)
    level = builder.let(times(Number(1.0 - _ROUNDING), beside))
    is_top = Logic("and", (Compare(">=", knot.y, bound), Compare(">=", knot.y, level)))
    return builder.let(Where(is_top, ONE, ZERO))


def _is_flat(builder: Builder, hits: Mapping[Knot, Expr], a: Knot, b: Knot, slack: Expr) -> Expr:
    """Return 1 for a stretch that attains the maximum everywhere, else 0."""
    apart = builder.let(Call("abs", (builder.let(minus(a.y, b.y)),)))
    return builder.let(times(builder.let(times(hits[a], hits[b])), Where(Compare("<=", apart, slack), ONE, ZERO)))


def _in_order(own: Sequence[Sequence[Knot]], others: Sequence[Knot]) -> list[Knot]:
    """Return the knots of an outline from left to right, among them those where terms jump."""
    left = list(others)
    found: list[Knot] = []
    for part in own:
        while left and _number(left[0]) <= _number(part[0]):
            found.append(left.pop(0))
        found.extend(part)
    return [*found, *left]


def _number(knot: Knot) -> float:
    """Return the place of a knot at a corner."""
    assert isinstance(knot.x, Number)
    return knot.x.value
