"""Membership functions of one formula: cosine, spike, concave, and arcs of an ellipse."""

from __future__ import annotations

import math
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Call, Compare, CompareOp, Expr, Number, Where, minus, plus, times
from fuzzyctl.formulas.formula import (
    EDGE,
    Cut,
    MembershipFormula,
    Parameters,
    around,
    between,
    compare,
    different,
    first,
    one_sided,
    positive,
    rising,
    scaled,
    second,
    square,
    union,
)


def _cosine_degree(x: Expr, p: Parameters) -> Expr:
    center, width = p
    wave = Call("cos", (2.0 * math.pi * scaled(x, center, width),))
    inside = Compare("<", Call("abs", (scaled(x, center, width),)), Number(0.5))
    return Where(inside, 0.5 * (1.0 + wave), ZERO)


def _spike_degree(x: Expr, p: Parameters) -> Expr:
    return Call("exp", (-10.0 * Call("abs", (scaled(x, p[0], p[1]),)),))


def _concave_degree(x: Expr, p: Parameters) -> Expr:
    """Compute (end - inflection) / (2 end - inflection - x) before the end; both directions share the formula."""
    inflection, end = p
    before: CompareOp = "<" if inflection < end else ">"
    rest = 1.0 + scaled(x, end, inflection - end)
    return Where(compare(before, x, end), 1.0 / rest, ONE)


def _concave_inverse(w: Expr, p: Parameters) -> Expr:
    inflection, end = p
    away = Where(Compare(">", w, ZERO), (1.0 - w) / w, Number(math.inf))
    return end - (end - inflection) * away


def _arc_degree(x: Expr, p: Parameters) -> Expr:
    start, end = p
    after: CompareOp = ">=" if start < end else "<="
    return Where(compare(after, x, end), ONE, _circle(scaled(x, end, end - start)))


def _circle(u: Expr) -> Expr:
    inside = Compare("<", Call("abs", (u,)), ONE)
    return Where(inside, Call("sqrt", (1.0 - square(u),)), ZERO)


def _arc_inverse(w: Expr, p: Parameters) -> Expr:
    start, end = p
    return end - (end - start) * Call("sqrt", (1.0 - square(w),))


def _semi_ellipse_degree(x: Expr, p: Parameters) -> Expr:
    start, end = p
    return _circle(scaled(x, 0.5 * start + 0.5 * end, 0.5 * (end - start)))


def _middle(p: Parameters) -> tuple[float, float]:
    return 0.5 * p[0] + 0.5 * p[1], 0.5 * p[0] + 0.5 * p[1]


def _cosine_cut(degree: Expr, p: Parameters) -> Cut:
    """Compute acos(2 degree - 1) by its cosine and sine, without cancellation near the top."""
    sine = Call("sqrt", (times(Number(4.0), times(degree, minus(ONE, degree))),))
    angle = Call("atan2", (sine, minus(times(Number(2.0), degree), ONE)))
    reach = times(Number(p[1] / (2.0 * math.pi)), angle)
    return around(p[0], reach, p[0], reach)


def _spike_cut(degree: Expr, p: Parameters) -> Cut:
    reach = times(Number(-0.1 * p[1]), Call("log", (degree,)))
    return around(p[0], reach, p[0], reach)


def _semi_ellipse_cut(degree: Expr, p: Parameters) -> Cut:
    half = Call("sqrt", (times(minus(ONE, degree), plus(ONE, degree)),))
    reach, (center, _) = times(Number(0.5 * (p[1] - p[0])), half), _middle(p)
    return around(center, reach, center, reach)


CURVES: Final[tuple[MembershipFormula, ...]] = (
    MembershipFormula(
        name="cosine",
        parameters=("center", "width"),
        summary="(1 + cos(2π (x - center) / width)) / 2 within width / 2 of the center, 0 elsewhere",
        degree=_cosine_degree,
        mistake=positive(width=1),
        core=first,
        pieces=lambda p: (p[0] - 0.5 * p[1], p[0], p[0] + 0.5 * p[1]),
        peaked=True,
        continuous=True,
        cut=_cosine_cut,
        extent=lambda p: (p[0] - p[1] / 2.0, p[0] + p[1] / 2.0),
    ),
    MembershipFormula(
        name="spike",
        parameters=("center", "width"),
        summary="exp(-10 |x - center| / width)",
        degree=_spike_degree,
        mistake=positive(width=1),
        core=first,
        pieces=lambda p: p[:1],
        peaked=True,
        continuous=True,
        endless=True,
        cut=_spike_cut,
        scales=lambda p: ((p[0], 0.1 * p[1], "exponential"),),
        extent=lambda p: (p[0] - p[1], p[0] + p[1]),
    ),
    MembershipFormula(
        name="concave",
        parameters=("inflection", "end"),
        summary="(end - inflection) / (2 end - inflection - x) before the end, 1 beyond; falling where "
        "end < inflection",
        degree=_concave_degree,
        mistake=different(("inflection", "end")),
        core=second,
        inverse=_concave_inverse,
        continuous=True,
        endless=True,
        cut=lambda degree, p: one_sided(_concave_inverse(degree, p), rises=p[1] > p[0]),
        scales=lambda p: ((p[1], abs(p[1] - p[0]), "power"),),
        extent=lambda p: union(between(p), (2 * p[0] - p[1], 2 * p[0] - p[1])),
    ),
    MembershipFormula(
        name="arc",
        parameters=EDGE,
        summary="a quarter of an ellipse from 0 at start to 1 at end, 1 beyond: sqrt(1 - u²) with "
        "u = (x - end) / (end - start); falling where end < start",
        degree=_arc_degree,
        mistake=different(EDGE),
        core=second,
        inverse=_arc_inverse,
        cut=lambda degree, p: one_sided(_arc_inverse(degree, p), rises=p[1] > p[0]),
    ),
    MembershipFormula(
        name="semi_ellipse",
        parameters=EDGE,
        summary="half an ellipse from start to end: sqrt(1 - u²) with u = (2 x - start - end) / (end - start)",
        degree=_semi_ellipse_degree,
        mistake=rising(EDGE),
        core=_middle,
        pieces=lambda p: (p[0], 0.5 * p[0] + 0.5 * p[1], p[1]),
        cut=_semi_ellipse_cut,
    ),
)
