"""Membership functions that are one trapezoid: triangle, trapezoid, rectangle and ramp."""

from __future__ import annotations

import math
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Compare, Expr, Number, Where, plus, times
from fuzzyctl.formulas.formula import (
    EDGE,
    FEET,
    TRAPEZOID,
    Cut,
    MembershipFormula,
    Parameters,
    Vertex,
    different,
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
