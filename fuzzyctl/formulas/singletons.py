"""Consequents without area: singleton and constant."""

from __future__ import annotations

from typing import Final

from fuzzyctl.expr import ONE, ZERO, Compare, Expr, Number, Where
from fuzzyctl.formulas.formula import MembershipFormula, Parameters, Vertex, first


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
