"""Spline membership functions: s, z and pi shapes."""

from __future__ import annotations

import math
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Call, Compare, CompareOp, Expr, Number, Where
from fuzzyctl.formulas.formula import (
    EDGE,
    FEET,
    TRAPEZOID,
    Cut,
    MembershipFormula,
    Parameters,
    compare,
    first,
    is_infinite,
    one_sided,
    ordered,
    rising,
    scaled,
    second,
    square,
    tops,
)


def _s_degree(x: Expr, p: Parameters) -> Expr:
    """Rise from 0 at the first to 1 at the second parameter along two parabolas; from right to left if it is less."""
    start, end = p
    after: CompareOp = ">=" if start < end else "<="
    before: CompareOp = "<=" if start < end else ">="
    foot = 2.0 * square(scaled(x, start, end - start))
    top = 1.0 - 2.0 * square(scaled(x, end, end - start))
    rise = Where(
        compare(before, x, 0.5 * start + 0.5 * end), Call("min", (Number(0.5), foot)), Call("max", (Number(0.5), top))
    )
    return Where(compare(after, x, end), ONE, Where(compare(before, x, start), ZERO, rise))


def _s_inverse(w: Expr, p: Parameters) -> Expr:
    start, end = p
    half, width = Number(0.5), Number(end - start)
    foot = start + width * Call("sqrt", (half * w,))
    top = end - width * Call("sqrt", (half * (1.0 - w),))
    return Where(Compare("<", w, half), foot, top)


def _swapped(p: Parameters) -> Parameters:
    return (p[1], p[0])


def _pi_degree(x: Expr, p: Parameters) -> Expr:
    left, left_top, right_top, right = p
    rise: Expr = ONE
    if left > -math.inf:
        rise = _edge(x, left, left_top, ">=")
    fall: Expr = ONE
    if right < math.inf:
        fall = _edge(x, right, right_top, "<=")
    return Where(compare("<", x, left_top), rise, fall)


def _edge(x: Expr, foot: float, top: float, reached: CompareOp) -> Expr:
    return _s_degree(x, (foot, top)) if foot != top else Where(compare(reached, x, top), ONE, ZERO)


def _pi_inverse(w: Expr, p: Parameters) -> Expr | None:
    left, left_top, right_top, right = p
    if left > -math.inf and right == math.inf:
        return _s_inverse(w, (left, left_top))
    if left == -math.inf and right < math.inf:
        return _s_inverse(w, (right, right_top))
    return None


def _pi_cut(degree: Expr, p: Parameters) -> Cut:
    return _side(degree, p[0], p[1], -math.inf), _side(degree, p[3], p[2], math.inf)


def _side(degree: Expr, foot: float, top: float, end: float) -> Expr:
    if is_infinite(foot):
        return Number(end)
    return Number(top) if foot == top else _s_inverse(degree, (foot, top))


SPLINES: Final[tuple[MembershipFormula, ...]] = (
    MembershipFormula(
        name="s_shape",
        parameters=EDGE,
        summary="0 up to start, 2 u² and then 1 - 2 (1 - u)² with u = (x - start) / (end - start), 1 from end on",
        degree=_s_degree,
        mistake=rising(EDGE),
        core=second,
        inverse=_s_inverse,
        continuous=True,
        cut=lambda degree, p: one_sided(_s_inverse(degree, p), rises=True),
    ),
    MembershipFormula(
        name="z_shape",
        parameters=EDGE,
        summary="1 - s_shape(start, end): 1 up to start, 0 from end on",
        degree=lambda x, p: _s_degree(x, _swapped(p)),
        mistake=rising(EDGE),
        core=first,
        inverse=lambda w, p: _s_inverse(w, _swapped(p)),
        continuous=True,
        cut=lambda degree, p: one_sided(_s_inverse(degree, _swapped(p)), rises=False),
    ),
    MembershipFormula(
        name="pi_shape",
        parameters=TRAPEZOID,
        summary="s_shape(left, left_top) up to the tops, z_shape(right_top, right) after them; an infinite foot "
        "makes a shoulder",
        degree=_pi_degree,
        mistake=ordered(TRAPEZOID),
        core=tops,
        inverse=_pi_inverse,
        infinite=FEET,
        peaked=True,
        cut=_pi_cut,
    ),
)
