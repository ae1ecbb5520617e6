"""Every membership function, norm and hedge, each written once as an expression.

`kernels` prints these expressions for numpy, numba and plain Python; analysis reads the same ones.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Final, Literal

from fuzzyctl.expr import Expr
from fuzzyctl.formulas.bells import BELLS
from fuzzyctl.formulas.curves import CURVES
from fuzzyctl.formulas.formula import Cut, MembershipFormula, Parameters, Vertex
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
from fuzzyctl.formulas.polygons import PIECEWISE, SINGLETONS, TRAPEZOIDS
from fuzzyctl.formulas.sigmoids import CLAMPED_DIFFERENCE, SIGMOIDS
from fuzzyctl.formulas.splines import SPLINES

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
