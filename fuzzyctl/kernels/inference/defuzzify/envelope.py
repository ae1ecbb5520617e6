"""Upper envelope of the aggregated set, for piecewise-linear terms.

The range is cut at the corners of the terms. Inside a piece the set still bends where a term is clipped and where two
terms cross, which depends on the activations: such places are computed, held within the piece, and sorted by a network
of minima and maxima, so that the program has no branches.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import combinations, pairwise
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Logic, Number, Where, minus, plus, times
from fuzzyctl.kernels.inference.defuzzify.centroid import Height, Line, Piece, is_handover, line_ends, pieces, uncrossed
from fuzzyctl.kernels.inference.defuzzify.maxima import Hits, place_of, tolerance
from fuzzyctl.kernels.inference.defuzzify.sampled_bisector import SLACK, moments_of, past_gap, share_of
from fuzzyctl.kernels.plan.build import OutputPlan
from fuzzyctl.kernels.program.builder import Builder, clip, sorted_atoms
from fuzzyctl.records import record


@record(frozen=True)
class Knot:
    """A point of the outline, as atoms: its place, counted from the middle of the range, and the degree there."""

    x: Expr
    y: Expr


def outline(builder: Builder, output: OutputPlan, heights: Sequence[Height]) -> list[list[Knot]]:
    """Write the outline of an aggregated set.

    Args:
        builder: The program to write into.
        output: Piecewise-linear terms, implication `min` or `product`, aggregation `max` or `sum`.
        heights: Activations, merged by term as far as the aggregation allows.

    Returns:
        For each piece of the range where the set is not 0, from left to right, its knots from left to right. The set
        may jump between pieces.
    """
    clipped, bends = output.implication == "min", _bends_at_crossings(output)
    knots: list[list[Knot]] = []
    for piece in pieces(output, heights):
        if clipped and bends and is_handover(piece):
            knots.append(_knots(builder, output, piece, _handover_places(builder, piece)))
            continue
        for part in uncrossed(piece) if clipped and bends else [piece]:
            places = _levels(builder, part, union=bends) if clipped else _crossings(builder, part) if bends else []
            knots.append(_knots(builder, output, part, [ZERO, *_sorted(builder, places), ONE]))
    return knots


def _bends_at_crossings(output: OutputPlan) -> bool:
    """Return whether a set bends where two of its terms cross."""
    return output.aggregation == "max" and output.rule != "polygon"


def size_of(output: OutputPlan, heights: Sequence[Height]) -> int:
    """Return about how many statements an outline takes."""
    clipped, bends = output.implication == "min", _bends_at_crossings(output)
    count = 0
    for piece in pieces(output, heights):
        for part in uncrossed(piece) if clipped and bends else [piece]:
            lines = len(part.lines)
            places = 2 * lines if clipped else lines * (lines - 1) // 2 if bends else 0
            count += (places + 2) * (2 * lines + 8) + places * places // 4
    return count


def joints(builder: Builder, output: OutputPlan, heights: Sequence[Height]) -> list[Knot]:
    """Write the degree at the corners where some term jumps: there the larger degree of each term holds."""
    stretches = pieces(output, heights)
    middle = Fraction(0.5 * output.lower + 0.5 * output.upper)
    shapes = [output.terms[t].vertices for t, _, _ in heights]
    knots: list[Knot] = []
    for place in sorted({p.start for p in stretches} | {p.end for p in stretches}):
        limits = [_limits(shape, stretches, place, middle) for shape in shapes]
        if all(a == b for a, b in limits):
            continue
        parts = [
            (h, Number(float(max(stretches))))
            for (_, h, _), stretches in zip(heights, limits, strict=True)
            if max(stretches) > 0
        ]
        implied = [Call("min", (h, d)) if output.implication == "min" else times(h, d) for h, d in parts]
        knots.append(Knot(Number(float(place)), _joined(builder, output, [builder.let(y) for y in implied])))
    return knots


def _limits(
    shape: tuple[tuple[float, float], ...], stretches: Sequence[Piece], place: Fraction, middle: Fraction
) -> tuple[Fraction, Fraction]:
    """Return the limits of a term from both sides of a corner, 0 beyond the range."""
    zero = Fraction(0)
    left = next((line_ends(shape, p.start + middle, p.end + middle)[1] for p in stretches if p.end == place), zero)
    right = next((line_ends(shape, p.start + middle, p.end + middle)[0] for p in stretches if p.start == place), zero)
    return left, right


def _knots(builder: Builder, output: OutputPlan, piece: Piece, places: Sequence[Expr]) -> list[Knot]:
    length = piece.end - piece.start
    knots = []
    for t in places:
        if t in (ZERO, ONE):
            x: Expr = Number(float(piece.start if t == ZERO else piece.end))
        else:
            x = builder.let(plus(Number(float(piece.start)), times(Number(float(length)), t)))
        cut = _clipped if output.implication == "min" else _times_height
        implied = [cut(builder, line, t) for line in piece.lines]
        knots.append(Knot(x, _joined(builder, output, [y for y in implied if y != ZERO])))
    return knots


def _times_height(builder: Builder, line: Line, t: Expr) -> Expr:
    degree = _degree(builder, line, t)
    return ZERO if degree == ZERO else builder.let(times(line.height, degree))


def _clipped(builder: Builder, line: Line, t: Expr) -> Expr:
    """Return a term clipped at its activation, which it has exactly from where it reaches it on.

    Near its foot the degree of a line has lost its digits; a tiny activation has not.
    """
    low, high = min(line.left, line.right), max(line.left, line.right)
    level = builder.let(Call("min", (line.height, Number(float(high)))))
    if low == high or t == (ONE if line.rise > 0 else ZERO):
        return level
    if t in (ZERO, ONE):
        return ZERO if low == 0 else builder.let(Call("min", (line.height, Number(float(low)))))
    place = _reaching(builder, line, line.height)
    reached = Compare(">=" if line.rise > 0 else "<=", t, place)
    return builder.let(Where(reached, level, _degree(builder, line, t)))


def _degree(builder: Builder, line: Line, t: Expr) -> Expr:
    """Return the degree of a term at a part of a piece."""
    if t in (ZERO, ONE) or line.rise == 0:
        return Number(float(line.right if t == ONE else line.left))
    return builder.let(plus(Number(float(line.left)), times(Number(float(line.rise)), t)))


def _joined(builder: Builder, output: OutputPlan, implied: Sequence[Expr]) -> Expr:
    if output.aggregation == "sum":
        return builder.total(implied)
    return builder.largest(implied)


def _levels(builder: Builder, piece: Piece, *, union: bool) -> list[Expr]:
    """Return where lines reach the levels at which they are clipped; a union also bends where one takes over.

    Lines that do not cross have an order. In a union each counts from the level on that those above it reach up to.
    """
    lines = sorted(piece.lines, key=lambda line: -(line.left + line.right)) if union else list(piece.lines)
    places: list[Expr] = []
    above: Expr = ZERO
    for line in lines:
        level = line.height if above == ZERO else builder.let(Call("max", (above, line.height)))
        for bound in dict.fromkeys((above, level) if union else (line.height,)):
            if bound != ZERO and line.rise != 0:
                places.append(_reaching(builder, line, bound))
        above = level
    return places


def _reaching(builder: Builder, line: Line, level: Expr) -> Expr:
    """Return up to which part of a piece a line has not reached a level, or from which on it has."""
    away = minus(level, Number(float(line.left)))
    return builder.let(clip(builder.let(away / float(line.rise)), 0.0, 1.0))


def _crossings(builder: Builder, piece: Piece) -> list[Expr]:
    """Return where scaled lines cross; the beginning of the piece for those that do not."""
    places: list[Expr] = []
    for a, b in combinations(piece.lines, 2):
        before, after = (
            builder.let(minus(_scaled(a.height, p), _scaled(b.height, q)))
            for p, q in ((a.left, b.left), (a.right, b.right))
        )
        falls = Logic("and", (Compare(">", before, ZERO), Compare("<", after, ZERO)))
        rises = Logic("and", (Compare("<", before, ZERO), Compare(">", after, ZERO)))
        crossing = before / (before - after)
        places.append(builder.let(clip(builder.let(Where(Logic("or", (falls, rises)), crossing, ZERO)), 0.0, 1.0)))
    return places


def _scaled(height: Expr, degree: Fraction) -> Expr:
    return ZERO if degree == 0 else times(height, Number(float(degree)))


def _handover_places(builder: Builder, piece: Piece) -> list[Expr]:
    """Return the knots of max(min(a, 1 - t), min(b, t)), the usual piece of a partition, which need no sorting.

    The first set is flat until it falls, or until the second one rises above it; likewise from the other end.
    """
    falling = next(line for line in piece.lines if line.left == 1)
    rising = next(line for line in piece.lines if line.left == 0)
    a, b = (builder.let(Call("min", (line.height, ONE))) for line in (falling, rising))
    half = Number(0.5)
    a_falls = Logic("or", (Compare(">=", a, b), Compare(">", a, half)))
    b_rises = Logic("or", (Compare(">=", b, a), Compare(">", b, half)))
    first = builder.let(Where(a_falls, 1.0 - a, a))
    last = builder.let(Where(b_rises, b, 1.0 - b))
    return [ZERO, first, builder.let(clip(half, first, last)), last, ONE]


def _sorted(builder: Builder, values: Sequence[Expr]) -> list[Expr]:
    """Return some atoms in rising order."""
    return sorted_atoms(builder, list(dict.fromkeys(values)))


def segments(knots: Sequence[Sequence[Knot]]) -> list[tuple[Knot, Knot]]:
    """Return the straight parts of an outline, from left to right."""
    return [pair for row in knots for pair in pairwise(row)]


def largest_of(builder: Builder, knots: Sequence[Knot]) -> Expr:
    """Write the largest degree."""
    return builder.largest(k.y for k in knots)


_HALF: Final = Number(0.5)
#: Degrees that are the same but for rounding.
_ROUNDING: Final = 1e-12


def straight_centroid(builder: Builder, output: OutputPlan, heights: Sequence[Height]) -> tuple[Expr, Expr]:
    """Write the centroid of an outline, counted from the middle of the range, and its area, as an atom."""
    parts = [moments_of(builder, (a.x, b.x), (a.y, b.y)) for a, b in segments(outline(builder, output, heights))]
    area = builder.total(value for value, _ in parts)
    return builder.total(value for _, value in parts) / area, area


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
    chosen: list[Expr] = [sums[-2] if parts else ZERO, last[0].x, last[1].x, last[0].y, last[1].y]
    after = last[0].x
    for k in reversed(range(len(parts) - 1)):
        a, b = parts[k]
        here = Compare(">=", sums[k + 1], under)
        chosen = [
            builder.let(Where(here, value, other))
            for value, other in zip((sums[k], a.x, b.x, a.y, b.y), chosen, strict=True)
        ]
        after = builder.let(Where(Compare(">", sums[k + 1], over), a.x, after))
    before, start, end, left, right = chosen
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
    rows = outline(builder, output, heights)
    jumps = joints(builder, output, heights)
    knots = _in_order(rows, jumps)
    most = largest_of(builder, knots)
    bound = builder.let(times(Number(1.0 - max(tolerance(output), _ROUNDING)), most))
    hits = {k: builder.let(Where(Compare(">=", k.y, bound), ONE, ZERO)) for k in jumps}
    for part in rows:
        hits |= {k: _is_top(builder, part, i, bound) for i, k in enumerate(part) if k not in hits}
    slack = builder.let(times(Number(_ROUNDING), most))
    intervals = tuple((_is_flat(builder, hits, a, b, slack), a.x, b.x) for a, b in segments(rows))
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


def _in_order(rows: Sequence[Sequence[Knot]], others: Sequence[Knot]) -> list[Knot]:
    """Return the knots of an outline from left to right, among them those where terms jump."""
    left = list(others)
    result: list[Knot] = []
    for part in rows:
        while left and _number(left[0]) <= _number(part[0]):
            result.append(left.pop(0))
        result.extend(part)
    return [*result, *left]


def _number(knot: Knot) -> float:
    """Return the place of a knot at a corner."""
    assert isinstance(knot.x, Number)
    return knot.x.value
