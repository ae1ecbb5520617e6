"""Every membership function, norm and hedge, each written once as an expression.

`kernels` prints these expressions for numpy, numba and plain Python; analysis reads the same ones.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import Final, Literal

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Number, Where
from fuzzyctl.formulas.bells import BELLS
from fuzzyctl.formulas.curves import CURVES
from fuzzyctl.formulas.formula import Cut, MembershipFormula, Parameters, Vertex, between, first
from fuzzyctl.formulas.hedges import HEDGES, HedgeFormula, hedge, inverse_hedge
from fuzzyctl.formulas.norms import (
    AGGREGATIONS,
    CONJUNCTIONS,
    DISJUNCTIONS,
    IMPLICATIONS,
    Norm,
    aggregation,
    conjunction,
    disjunction,
    held,
    one_minus,
)
from fuzzyctl.formulas.sigmoids import CLAMPED_DIFFERENCE, SIGMOIDS
from fuzzyctl.formulas.splines import SPLINES
from fuzzyctl.formulas.trapezoids import TRAPEZOIDS

__all__ = [
    "AGGREGATIONS",
    "CONJUNCTIONS",
    "DISJUNCTIONS",
    "HEDGES",
    "IMPLICATIONS",
    "MEMBERSHIP",
    "VARIANTS",
    "Cut",
    "HedgeFormula",
    "MembershipFormula",
    "Norm",
    "Parameters",
    "Vertex",
    "aggregation",
    "alpha_cut",
    "conjunction",
    "disjunction",
    "exact_centroid_possible",
    "exact_maxima_possible",
    "exact_norms",
    "formula_of",
    "hedge",
    "held",
    "inverse_hedge",
    "is_endless",
    "is_monotone",
    "is_number",
    "is_straight",
    "one_minus",
]


def is_straight(kind: str) -> bool:
    """Return whether terms of a kind have straight sides and an area, so that they may have an exact centroid."""
    return kind in MEMBERSHIP and MEMBERSHIP[kind].straight


def is_endless(kind: str) -> bool:
    """Return whether the degree of a kind changes up to infinity on one side at least."""
    return kind in MEMBERSHIP and MEMBERSHIP[kind].endless


def is_number(kind: str) -> bool:
    """Return whether a kind is a consequent without an area: a singleton or a constant."""
    return kind in MEMBERSHIP and not MEMBERSHIP[kind].fuzzy


def alpha_cut(kind: str, degree: Expr, parameters: Parameters) -> Cut | None:
    """Return the interval where a term has at least some degree, perhaps without an end; None if unknown."""
    formula = MEMBERSHIP.get(kind)
    return formula.cut(degree, parameters) if formula is not None and formula.cut is not None else None


def exact_norms(implication: str, aggregation: str) -> bool:
    """Return whether sets with straight sides stay such sets, so that they have closed forms."""
    return IMPLICATIONS[implication].straight and AGGREGATIONS[aggregation].straight


def exact_maxima_possible(kinds: Iterable[str], implications: Collection[str], aggregation: str) -> bool:
    """Return whether the maxima of a set made of terms of some kinds, implied in some ways, have a closed form."""
    distinct = set(kinds)
    if not all(exact_norms(implication, aggregation) for implication in implications):
        return False
    if all(map(is_straight, distinct)) and len(set(implications)) == 1:
        return True
    return aggregation == "max" and all(k in MEMBERSHIP and MEMBERSHIP[k].cut is not None for k in distinct)


def exact_centroid_possible(kind: str, implication: str, aggregation: str) -> bool:
    """Return whether the exact centroid exists for terms of a kind; any height is possible.

    Elsewhere a centroid needs a resolution.
    """
    return is_straight(kind) and exact_norms(implication, aggregation)


def is_monotone(kind: str, parameters: Parameters) -> bool:
    """Return whether `tsukamoto` can invert a term."""
    formula = MEMBERSHIP.get(kind)
    return formula is not None and formula.monotone(parameters)


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


MembershipKind = Literal[
    "triangle",
    "trapezoid",
    "rectangle",
    "ramp",
    "piecewise",
    "gaussian",
    "gaussian2",
    "bell",
    "sigmoid",
    "sigmoid_difference",
    "sigmoid_product",
    "s_shape",
    "z_shape",
    "pi_shape",
    "cosine",
    "spike",
    "concave",
    "arc",
    "semi_ellipse",
    "singleton",
    "constant",
]
#: The kinds of membership functions by name, in the order of the reference.
MEMBERSHIP: Final[dict[str, MembershipFormula]] = {
    f.name: f for f in (*TRAPEZOIDS, PIECEWISE, *BELLS, *SIGMOIDS, *SPLINES, *CURVES, *SINGLETONS)
}

#: Functions as other tools compute them, by the kind that rule files write and by the difference.
VARIANTS: Final[dict[str, MembershipFormula]] = {"sigmoid_difference clamped": CLAMPED_DIFFERENCE}


def formula_of(kind: str) -> MembershipFormula:
    """Return the formula of a membership function or a variant of one."""
    return VARIANTS[kind] if kind in VARIANTS else MEMBERSHIP[kind]
