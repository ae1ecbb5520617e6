"""Piecewise-linear membership function with any number of corners."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal

from fuzzyctl.expr import Call, Compare, Expr, Number, Where
from fuzzyctl.formulas.formula import MembershipFormula, Parameters, Vertex, between


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
