"""Exact centroid of piecewise-linear sets: area and moment in closed form.

The range is cut at all corners of the terms, and, where sets are clipped, at the crossings of their lines. Inside a
piece every term is a line, and integrals over the piece are polynomials of the activations.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import combinations, pairwise
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Number, Where, minus, plus, times
from fuzzyctl.formulas import Vertex
from fuzzyctl.kernels.plan.build import OutputPlan
from fuzzyctl.kernels.plan.traced import exact, is_free, rounded
from fuzzyctl.kernels.program.builder import Builder
from fuzzyctl.records import record

#: (term, its activation as an atom, the largest value the activation can have)
Height = tuple[int, Expr, float]
Moments = tuple[Expr, Expr]

#: Ranges as wide have squares of all digits.
_SMALL: Final = 1e-100
_LARGE: Final = 1e100


@record(frozen=True)
class Line:
    """A term inside a piece: its degrees at the two ends, and who it is."""

    height: Expr
    most: float
    left: Fraction
    right: Fraction

    @property
    def rise(self) -> Fraction:
        """How much higher it is at the right end."""
        return self.right - self.left


@record(frozen=True)
class Piece:
    """A part of the range where all terms are lines; ends are counted from the middle of the range."""

    start: Fraction
    end: Fraction
    lines: tuple[Line, ...]


def exact_centroid(builder: Builder, output: OutputPlan, heights: Sequence[Height]) -> tuple[Expr, Expr]:
    """Write the centroid of the aggregated set, counted from the middle of the range, and its area, as an atom."""
    unit = unit_of(output)
    area, moment = exact_moments(builder, output, heights, unit)
    return times(Number(unit), moment / area), area


def unit_of(output: OutputPlan) -> float:
    """Return the unit of lengths: 1, or a power of two of the size of a range whose square is not a number."""
    width = output.upper - output.lower
    return 1.0 if _SMALL < width < _LARGE else math.ldexp(1.0, math.frexp(width)[1] - 1)


def in_units(length: Expr, unit: float) -> Expr:
    """Return a length in some unit."""
    return length if unit == 1.0 else length / unit


def exact_moments(builder: Builder, output: OutputPlan, heights: Sequence[Height], unit: float = 1.0) -> Moments:
    """Write the area and the first moment, about the middle of the range, of the aggregated set.

    Args:
        builder: The program to write into.
        output: Piecewise-linear terms, implication `min` or `product`, aggregation `max` or `sum`.
        heights: Activations, merged by term as far as the aggregation allows.
        unit: The unit of lengths.

    Returns:
        Area and moment as atoms.
    """
    clipped = output.implication == "min"
    parts: list[Moments] = []
    for stretch in pieces(output, heights):
        piece = replace(stretch, start=stretch.start / exact(unit), end=stretch.end / exact(unit))
        if output.aggregation == "sum":
            cut = _clipped if clipped else _scaled
            parts.extend(_about_middle(builder, piece, line, cut(builder, line, line.height)) for line in piece.lines)
        elif clipped and is_handover(piece):
            parts.append(_handover(builder, piece))
        elif clipped:
            parts.extend(m for part in uncrossed(piece) for m in _clipped_union(builder, part))
        else:
            parts.extend(_scaled_union(builder, piece))
    return builder.total(p[0] for p in parts), builder.total(p[1] for p in parts)


def has_many_pieces(output: OutputPlan, heights: Sequence[Height], most_pairs: int | None) -> bool:
    """Return whether the exact moments would take too many statements, counted without writing any.

    Each corner of a term cuts all terms that are there, and lines that meet in a piece are compared pair by pair. A sum
    compares none.
    """
    if most_pairs is None:
        return False
    shapes = [output.terms[term].vertices for term, _, _ in heights]
    corners = sorted({x for shape in shapes for x, _ in shape if output.lower < x < output.upper})
    lines = 0
    for shape in shapes:
        start = -math.inf if shape[0][1] > 0.0 else shape[0][0]
        end = math.inf if shape[-1][1] > 0.0 else shape[-1][0]
        lines += 1 + bisect_left(corners, end) - bisect_right(corners, start)
    return lines * (1 if output.aggregation == "sum" else lines / (len(corners) + 1)) > most_pairs


def pieces(output: OutputPlan, heights: Sequence[Height]) -> list[Piece]:
    """Cut the output range at the corners of the terms; a polygon has corners at those of terms without a rule, too."""
    middle = exact(0.5 * output.lower + 0.5 * output.upper)
    lower, upper = exact(output.lower), exact(output.upper)
    shapes = [output.terms[term].vertices for term, _, _ in heights]
    others = [term.vertices for term in output.terms] if output.rule == "polygon" else []
    corners = {lower, upper} | {exact(x) for shape in (*shapes, *others) for x, _ in shape}
    cuts = sorted(c for c in corners if lower <= c <= upper)
    result: list[Piece] = []
    for a, b in pairwise(cuts):
        ends = [line_ends(shape, a, b) for shape in shapes]
        lines = [_line(h, most, *e) for (_, h, most), e in zip(heights, ends, strict=True) if any(e)]
        if lines:
            result.append(Piece(a - middle, b - middle, tuple(lines)))
    return result


def uncrossed(piece: Piece) -> list[Piece]:
    """Cut a piece where two of its lines cross."""
    length = piece.end - piece.start
    shares = {Fraction(0), Fraction(1)}
    for a, b in combinations(piece.lines, 2):
        before, after = a.left - b.left, a.right - b.right
        if before * after < 0:
            shares.add(before / (before - after))
    parts: list[Piece] = []
    for s, t in pairwise(sorted(shares)):
        lines = tuple(
            _line(line.height, line.most, line.left + s * line.rise, line.left + t * line.rise) for line in piece.lines
        )
        parts.append(Piece(piece.start + s * length, piece.start + t * length, lines))
    return parts


def _line(height: Expr, most: float, left: Fraction, right: Fraction) -> Line:
    """Return a line; one that rises by less than the smallest number is level, since programs divide by the rise."""
    return Line(height, most, left, right if rounded(right - left) != 0.0 else left)


def line_ends(vertices: tuple[Vertex, ...], a: Fraction, b: Fraction) -> tuple[Fraction, Fraction]:
    """Return the limits at both ends of a piece (a, b) that holds no corner of the set inside."""
    if b <= vertices[0][0]:
        return exact(vertices[0][1]), exact(vertices[0][1])
    for (x0, y0), (x1, y1) in pairwise(vertices):
        if x0 <= a and b <= x1:
            slope = (exact(y1) - exact(y0)) / (exact(x1) - exact(x0))
            left, right = (exact(y0) + slope * (x - exact(x0)) for x in (a, b))
            # Of free corners these are not the same number in floating point.
            return exact(y0) if a == x0 else left, exact(y1) if b == x1 else right
    return exact(vertices[-1][1]), exact(vertices[-1][1])


def is_handover(piece: Piece) -> bool:
    """Return whether one term falls from 1 to 0 while another rises from 0 to 1, as neighbours of a partition do."""
    ends = {(rounded(line.left), rounded(line.right)) for line in piece.lines}
    return len(piece.lines) == 2 and ends == {(1.0, 0.0), (0.0, 1.0)}


def handover(builder: Builder, a: Expr, b: Expr) -> Moments:
    """Integrate max(min(a, 1 - t), min(b, t)) over [0, 1], in closed form.

    Both sets reach up to m = min(a, b, 1/2) together. The parts above m on either side do not overlap, so with
    ∫ min(s, t) dt = s - s²/2 the area is a + b - m - (a² + b²)/2 + m², and the moment about the left end
    (a + b - m - a² + m²)/2 + (a³ - b³)/6: the cubes of m cancel.
    """
    m = builder.let(Call("min", (a, b, Number(0.5))))
    a2, b2, m2 = (builder.let(times(h, h)) for h in (a, b, m))
    reach = builder.let(minus(plus(a, b), m))
    area = builder.let(plus(minus(reach, times(Number(0.5), builder.let(plus(a2, b2)))), m2))
    cubes = builder.let(minus(builder.let(times(a, a2)), builder.let(times(b, b2))))
    halves = builder.let(plus(minus(reach, a2), m2))
    moment = builder.let(plus(times(Number(0.5), halves), times(Number(1 / 6), cubes)))
    return area, moment


def _handover(builder: Builder, piece: Piece) -> Moments:
    """Integrate the union of two neighbours over a piece, about the middle of the range."""
    falling = next(line for line in piece.lines if line.left == 1)
    rising = next(line for line in piece.lines if line.left == 0)
    a, b = (
        builder.let(Call("min", (line.height, ONE))) if line.most > 1.0 else line.height for line in (falling, rising)
    )
    area, moment = handover(builder, a, b)
    length = piece.end - piece.start
    moved = plus(
        _constant_times(rounded(piece.start * length), area), _constant_times(rounded(length * length), moment)
    )
    return builder.let(_constant_times(rounded(length), area)), builder.let(moved)


def _clipped_union(builder: Builder, piece: Piece) -> list[Moments]:
    """Integrate max_k min(h_k, l_k) over a piece where no two lines cross.

    With the lines in rising order, h_k may be replaced by H_k = max(h_k, ..., h_m): a clipped upper line covers the
    lower one clipped as high. At level t the set is then cut by the line k with H_{k+1} < t <= H_k, so the integral is
    the sum over k of I_k(H_k) - I_k(H_{k+1}) with I_k(s) the integral of min(s, l_k).
    """
    lines = sorted(piece.lines, key=lambda line: line.left + line.right)
    parts: list[Moments] = []
    above: Expr = ZERO
    for line in reversed(lines):
        reached = builder.largest([above, line.height]) if above != ZERO else line.height
        area, moment = _about_middle(builder, piece, line, _clipped(builder, line, reached))
        if above != ZERO:
            lost_area, lost_moment = _about_middle(builder, piece, line, _clipped(builder, line, above))
            area, moment = builder.let(minus(area, lost_area)), builder.let(minus(moment, lost_moment))
        parts.append((area, moment))
        above = reached
    return parts


def _clipped(builder: Builder, line: Line, level: Expr) -> Moments:
    """Integrate min(s, l) over a piece of length 1, the moment taken about the end where the line is high.

    With r = min(s, high), q = max(0, r - low) and z = q / (high - low), the part at level t has the length
    (high - t) / (high - low), so that area = r - q z / 2 and moment = (r - q z (1 - z / 3)) / 2.
    """
    low, high = min(line.left, line.right), max(line.left, line.right)
    reach = level if rounded(high) >= line.most else builder.let(Call("min", (level, Number(rounded(high)))))
    if low == high:
        return reach, builder.let(times(Number(0.5), reach))
    above = reach
    if low > 0:
        above = builder.let(Call("max", (ZERO, builder.let(minus(reach, Number(rounded(low)))))))
    span = high - low
    z = above if span == 1 else builder.let(_share(above, rounded(span)))
    qz = builder.let(times(above, z))
    area = builder.let(minus(reach, times(Number(0.5), qz)))
    thirds = minus(ONE, times(z, Number(1 / 3)))
    moment = builder.let(times(Number(0.5), minus(reach, times(qz, thirds))))
    return area, moment


def _share(above: Expr, span: float) -> Expr:
    """Return a part of a span; of a piece between free corners that may meet 0 where it is empty."""
    share = above / span
    return Where(Compare(">", Number(span), ZERO), share, ZERO) if is_free(span) else share


def _scaled(builder: Builder, line: Line, level: Expr) -> Moments:
    """Integrate s · l over a piece of length 1, the moment taken about the end where the line is high."""
    low, high = min(line.left, line.right), max(line.left, line.right)
    area = builder.let(times(level, Number(rounded((low + high) / 2))))
    return area, builder.let(times(level, Number(rounded((high + 2 * low) / 6))))


def _about_middle(builder: Builder, piece: Piece, line: Line, local: Moments) -> Moments:
    """Scale the moments of a unit piece to its length and move them from the line's high end to the middle."""
    length = piece.end - piece.start
    to_right = line.right >= line.left
    high_end = piece.end if to_right else piece.start
    area, moment = local
    inward = Number(rounded(-length * length if to_right else length * length))
    moved = plus(_constant_times(rounded(high_end * length), area), times(inward, moment))
    return builder.let(_constant_times(rounded(length), area)), builder.let(moved)


def _constant_times(factor: float, value: Expr) -> Expr:
    return ZERO if factor == 0.0 else times(Number(factor), value)


def _scaled_union(builder: Builder, piece: Piece) -> list[Moments]:
    """Integrate max_k h_k l_k over a piece: each line over the stretch where it is the highest.

    Where a line is beaten depends on the activations. An upper envelope of lines is convex, so a line is highest on one
    stretch [t0, t1], between the crossings with all others. Of lines that are the same, the first counts.
    """
    ends = [
        (
            builder.let(_constant_times(rounded(line.left), line.height)),
            builder.let(_constant_times(rounded(line.right), line.height)),
        )
        for line in piece.lines
    ]
    return [_stretch(builder, piece, ends, k) for k in range(len(ends))]


def _stretch(builder: Builder, piece: Piece, ends: Sequence[Moments], k: int) -> Moments:
    p0, p1 = ends[k]
    starts: list[Expr] = []
    stops: list[Expr] = []
    for j, (o0, o1) in enumerate(ends):
        if j != k:
            d0, d1 = builder.let(minus(p0, o0)), builder.let(minus(p1, o1))
            crossing = d0 / (d0 - d1)
            behind = Compare("<=" if j < k else "<", d0, ZERO)
            starts.append(builder.let(Where(behind, Where(Compare(">", d1, ZERO), crossing, ONE), ZERO)))
            stops.append(builder.let(Where(Compare("<", d1, ZERO), Where(Compare(">", d0, ZERO), crossing, ZERO), ONE)))
    t0: Expr = builder.largest(starts) if starts else ZERO
    stop = builder.let(Call("min", tuple(stops))) if stops else ONE
    t1 = builder.let(Call("max", (t0, stop))) if starts else stop
    slope = builder.let(minus(p1, p0))
    y0, y1 = builder.let(plus(p0, times(slope, t0))), builder.let(plus(p0, times(slope, t1)))
    width = builder.let(minus(t1, t0))
    length = piece.end - piece.start
    local_area = builder.let(times(times(Number(0.5), width), plus(y0, y1)))
    weighted = plus(times(y0, plus(plus(t0, t0), t1)), times(y1, plus(t0, plus(t1, t1))))
    local_moment = builder.let(times(times(Number(1 / 6), width), weighted))
    area = builder.let(times(Number(rounded(length)), local_area))
    start = _constant_times(rounded(piece.start * length), local_area)
    return area, builder.let(plus(start, times(Number(rounded(length * length)), local_moment)))
