"""Membership functions with straight sides: triangle, trapezoid, rectangle, ramp, piecewise; singleton and constant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, Literal

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Number, Where, plus, times
from fuzzyctl.formulas.formula import (
    EDGE,
    FEET,
    TRAPEZOID,
    Cut,
    MembershipFormula,
    Parameters,
    Vertex,
    between,
    different,
    first,
    ordered,
    rising,
    second,
    tops,
)

_TRIANGLE: Final = ("left", "peak", "right")


def _trapezoid_degree(x: Expr, p: Parameters) -> Expr:
    """Rise from left foot to left top, stay at 1, fall from right top to right foot; an infinite foot is a shoulder."""
    left, left_top, right_top, right = p
    expr: Expr = ONE
    if right < math.inf:
        fall: Expr = ZERO
        if right > right_top:
            slope = (right - x) / (right - right_top)
            fall = Where(Compare("<", x, Number(right)), slope, ZERO)
        expr = Where(Compare("<=", x, Number(right_top)), expr, fall)
    if left > -math.inf:
        rise: Expr = ZERO
        if left < left_top:
            slope = (x - left) / (left_top - left)
            rise = Where(Compare(">", x, Number(left)), slope, ZERO)
        expr = Where(Compare(">=", x, Number(left_top)), expr, rise)
    return expr


def _trapezoid_vertices(p: Parameters) -> tuple[Vertex, ...]:
    left, left_top, right_top, right = p
    corners: list[Vertex] = []
    if left > -math.inf:
        corners.append((left, 0.0))
    corners.append((left_top, 1.0))
    if right_top > left_top:
        corners.append((right_top, 1.0))
    if right < math.inf:
        corners.append((right, 0.0))
    return tuple(corners)


def _trapezoid_inverse(w: Expr, p: Parameters) -> Expr | None:
    left, left_top, right_top, right = p
    if left > -math.inf and right == math.inf:
        return _ramp_inverse(w, (left, left_top))
    if left == -math.inf and right < math.inf:
        return _ramp_inverse(w, (right, right_top))
    return None


def _as_trapezoid(p: Parameters) -> Parameters:
    left, peak, right = p
    return (left, peak, peak, right)


def _as_shoulder(p: Parameters) -> Parameters:
    """Return a ramp as a trapezoid with an infinite foot."""
    start, end = p
    return (start, end, end, math.inf) if start < end else (-math.inf, end, end, start)


def _as_block(p: Parameters) -> tuple[float, float, float, float]:
    """Return a rectangle as a trapezoid; an infinite side stays a foot, and the top ends at the finite one."""
    left, right = p
    return (left, left if left > -math.inf else right, right if right < math.inf else left, right)


def _rectangle_mistake(p: Parameters) -> str | None:
    if p == (-math.inf, math.inf):
        return "left and right are both infinite"
    return rising(("left", "right"))(p)


def _ramp_inverse(w: Expr, p: Parameters) -> Expr:
    start, end = p
    return start + (end - start) * w


def _straight_cut(degree: Expr, corners: tuple[Vertex, ...]) -> Cut:
    tops = [x for x, y in corners if y == 1.0]
    left: Expr = Number(-math.inf)
    right: Expr = Number(math.inf)
    if corners[0][1] == 0.0:
        left = plus(Number(corners[0][0]), times(Number(tops[0] - corners[0][0]), degree))
    if corners[-1][1] == 0.0:
        right = plus(Number(corners[-1][0]), times(Number(tops[-1] - corners[-1][0]), degree))
    return left, right


TRAPEZOIDS: Final[tuple[MembershipFormula, ...]] = (
    MembershipFormula(
        name="triangle",
        parameters=_TRIANGLE,
        summary="0 at the feet, 1 at the peak; an infinite foot makes a shoulder",
        degree=lambda x, p: _trapezoid_degree(x, _as_trapezoid(p)),
        mistake=ordered(_TRIANGLE),
        core=second,
        vertices=lambda p: _trapezoid_vertices(_as_trapezoid(p)),
        inverse=lambda w, p: _trapezoid_inverse(w, _as_trapezoid(p)),
        infinite=FEET,
        straight=True,
        peaked=True,
        cut=lambda degree, p: _straight_cut(degree, _trapezoid_vertices(_as_trapezoid(p))),
    ),
    MembershipFormula(
        name="trapezoid",
        parameters=TRAPEZOID,
        summary="0 at the feet, 1 between the tops; an infinite foot makes a shoulder",
        degree=_trapezoid_degree,
        mistake=ordered(TRAPEZOID),
        core=tops,
        vertices=_trapezoid_vertices,
        inverse=_trapezoid_inverse,
        infinite=FEET,
        straight=True,
        peaked=True,
        cut=lambda degree, p: _straight_cut(degree, _trapezoid_vertices(p)),
    ),
    MembershipFormula(
        name="rectangle",
        parameters=("left", "right"),
        summary="1 from left to right, ends included, 0 elsewhere; with one infinite side a step",
        degree=lambda x, p: _trapezoid_degree(x, _as_block(p)),
        mistake=_rectangle_mistake,
        core=lambda p: _as_block(p)[1:3],
        vertices=lambda p: _trapezoid_vertices(_as_block(p)),
        infinite=FEET,
        straight=True,
        cut=lambda degree, p: _straight_cut(degree, _trapezoid_vertices(_as_block(p))),
    ),
    MembershipFormula(
        name="ramp",
        parameters=EDGE,
        summary="0 at start and before, 1 at end and beyond, straight between; falling where end < start",
        degree=lambda x, p: _trapezoid_degree(x, _as_shoulder(p)),
        mistake=different(EDGE),
        core=second,
        vertices=lambda p: _trapezoid_vertices(_as_shoulder(p)),
        inverse=_ramp_inverse,
        straight=True,
        cut=lambda degree, p: _straight_cut(degree, _trapezoid_vertices(_as_shoulder(p))),
    ),
)


def _piecewise_degree(x: Expr, p: Parameters) -> Expr:
    """Search the stretch of x by halves and go straight between its ends; at a jump the largest degree holds."""
    corners = _corners(p)
    there: dict[float, list[float]] = {}
    for place, degree in corners:
        there.setdefault(place, []).append(degree)
    places = sorted(there)
    degrees = [there[place] for place in places]
    stretches: list[Expr] = [Number(degrees[0][0])]
    for i, place in enumerate(places):
        side: Expr = Number(degrees[i][-1])
        if i + 1 < len(places) and degrees[i][-1] != degrees[i + 1][0]:
            run = (x - place) / (places[i + 1] - place)
            side = side + (degrees[i + 1][0] - degrees[i][-1]) * run
        if max(degrees[i]) > degrees[i][-1]:
            side = Where(Compare("==", x, Number(place)), Number(max(degrees[i])), side)
        stretches.append(side)
    return _search(x, places, stretches)


def _search(x: Expr, places: Sequence[float], stretches: Sequence[Expr], before_it: Literal["<", "<="] = "<") -> Expr:
    """Choose the stretch before, between or after some places."""
    if not places:
        return stretches[0]
    half = len(places) // 2
    before = _search(x, places[:half], stretches[: half + 1], before_it)
    after = _search(x, places[half + 1 :], stretches[half + 1 :], before_it)
    return Where(Compare(before_it, x, Number(places[half])), before, after)


def _corners(p: Parameters) -> tuple[Vertex, ...]:
    return tuple(zip(p[::2], p[1::2], strict=True))


def _piecewise_core(p: Parameters) -> tuple[float, float]:
    corners = _corners(p)
    top = max(y for _, y in corners)
    places = [x for x, y in corners if y == top]
    return min(places), max(places)


def _piecewise_inverse(w: Expr, p: Parameters) -> Expr | None:
    """Search the stretch of w by halves; a degree that is never reached lies at the nearest end, one of a flat stretch
    at the end of it that lower degrees are next to."""
    corners = _corners(p)
    degrees = [y for _, y in corners]
    if degrees[0] == degrees[-1]:
        return None
    if degrees[0] > degrees[-1]:
        corners, degrees = corners[::-1], degrees[::-1]
    if degrees != sorted(degrees):
        return None
    there = {y: x for x, y in reversed(corners)}
    levels, entries = list(there)[::-1], list(there.values())[::-1]
    exits = list({y: x for x, y in corners}.values())
    stretches: list[Expr] = [Number(exits[0])]
    for i in range(len(levels) - 1):
        stretches.append(_between(w, (levels[i], exits[i]), (levels[i + 1], entries[i + 1])))
    stretches.append(Number(entries[-1]))
    return _search(w, levels, stretches, "<=")


def _between(w: Expr, before: Vertex, after: Vertex) -> Expr:
    """Return the place on a straight side, by rounding never beyond its upper end."""
    (low, start), (high, end) = before, after
    if start == end:
        return Number(end)
    run = (w - low) / (high - low)
    place = start + (end - start) * run
    return Call("min" if start < end else "max", (Number(end), place))


def _piecewise_mistake(p: Parameters) -> str | None:
    if len(p) < 4 or len(p) % 2:
        return "it takes pairs x1, y1, x2, y2, ..., two or more of them"
    for (x0, _), (x1, _) in zip(_corners(p), _corners(p)[1:], strict=False):
        if x0 > x1:
            return f"x = {x0:.6g} is greater than the next x = {x1:.6g}"
    for _, y in _corners(p):
        if not 0.0 <= y <= 1.0:
            return f"the degree {y:.6g} lies outside [0, 1]"
    if max(y for _, y in _corners(p)) == 0.0:
        return "its degree is 0 everywhere"
    return None


PIECEWISE: Final = MembershipFormula(
    name="piecewise",
    parameters=("x1", "y1"),
    summary="straight from (x1, y1) to (x2, y2) and so on, constant beyond the ends; an x given twice is a "
    "jump, where the larger degree holds",
    degree=_piecewise_degree,
    mistake=_piecewise_mistake,
    core=_piecewise_core,
    vertices=_corners,
    inverse=_piecewise_inverse,
    variadic=True,
    pieces=lambda p: p[::2],
    straight=True,
    extent=lambda p: between(p[::2]),
)


def _singleton_degree(x: Expr, p: Parameters) -> Expr:
    return Where(Compare("==", x, Number(p[0])), ONE, ZERO)


def _spot(p: Parameters) -> tuple[Vertex, ...]:
    return (p[0], 0.0), (p[0], 1.0), (p[0], 0.0)


SINGLETONS: Final[tuple[MembershipFormula, ...]] = (
    MembershipFormula(
        name="singleton",
        parameters=("value",),
        summary="1 at the value, 0 elsewhere",
        degree=_singleton_degree,
        mistake=lambda p: None,
        core=first,
        vertices=_spot,
        fuzzy=False,
    ),
    MembershipFormula(
        name="constant",
        parameters=("value",),
        summary="a Takagi-Sugeno consequent of order 0; in an average the same as a singleton",
        degree=_singleton_degree,
        mistake=lambda p: None,
        core=first,
        vertices=_spot,
        fuzzy=False,
    ),
)
