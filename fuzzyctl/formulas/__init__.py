"""Every membership function, norm and hedge, each written once as an expression.

`kernels` prints these expressions for numpy, numba and plain Python; analysis reads the same ones.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Final

from fuzzyctl.formulas.formula import MembershipFormula, Parameters, Vertex
from fuzzyctl.formulas.hedges import HEDGE_SUMMARIES, HEDGES, Hedge, hedge, inverse_hedge
from fuzzyctl.formulas.memberships import MEMBERSHIP, VARIANTS, formula_of
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

__all__ = [
    "AGGREGATIONS",
    "CONJUNCTIONS",
    "DISJUNCTIONS",
    "EXACT_AGGREGATIONS",
    "EXACT_IMPLICATIONS",
    "FINITE",
    "HEDGES",
    "HEDGE_SUMMARIES",
    "IMPLICATIONS",
    "INVERTIBLE",
    "MEMBERSHIP",
    "VARIANTS",
    "Hedge",
    "MembershipFormula",
    "Norm",
    "Parameters",
    "Vertex",
    "aggregation",
    "conjunction",
    "disjunction",
    "exact_centroid_possible",
    "exact_maxima_possible",
    "exact_norms",
    "formula_of",
    "hedge",
    "held",
    "inverse_hedge",
    "is_monotone",
    "one_minus",
    "piecewise_linear",
]

#: Implications and aggregations for which the centroid of piecewise-linear sets has a closed form.
EXACT_IMPLICATIONS: Final = ("min", "product")
EXACT_AGGREGATIONS: Final = ("max", "sum")


def piecewise_linear(kind: str) -> bool:
    """Return whether terms of a kind have straight sides and an area, so that they may have an exact centroid."""
    formula = MEMBERSHIP.get(kind)
    return formula is not None and formula.fuzzy and kind in _STRAIGHT


_STRAIGHT: Final = ("triangle", "trapezoid", "rectangle", "ramp", "piecewise")


#: Curved kinds that are 0 beyond their feet.
FINITE: Final = ("s_shape", "z_shape", "pi_shape", "cosine", "arc", "semi_ellipse")

#: Curved kinds whose alpha-cuts are known in closed form.
INVERTIBLE: Final = ("gaussian", "gaussian2", "bell", "sigmoid", "spike", "concave", *FINITE)


def exact_norms(implication: str, aggregation: str) -> bool:
    """Return whether sets with straight sides stay such sets, so that they have closed forms."""
    return implication in EXACT_IMPLICATIONS and aggregation in EXACT_AGGREGATIONS


def exact_maxima_possible(kinds: Iterable[str], implications: Collection[str], aggregation: str) -> bool:
    """Return whether the maxima of a set made of terms of some kinds, implied in some ways, have a closed form."""
    own = set(kinds)
    if not all(exact_norms(implication, aggregation) for implication in implications):
        return False
    if all(map(piecewise_linear, own)) and len(set(implications)) == 1:
        return True
    return aggregation == "max" and all(k in INVERTIBLE or (piecewise_linear(k) and k != "piecewise") for k in own)


def exact_centroid_possible(kind: str, implication: str, aggregation: str) -> bool:
    """Return whether the exact centroid exists for terms of a kind; any height is possible.

    Elsewhere a centroid needs a resolution.
    """
    return piecewise_linear(kind) and implication in EXACT_IMPLICATIONS and aggregation in EXACT_AGGREGATIONS


def is_monotone(kind: str, parameters: Parameters) -> bool:
    """Return whether `tsukamoto` can invert a term."""
    formula = MEMBERSHIP.get(kind)
    return formula is not None and formula.monotone(parameters)
