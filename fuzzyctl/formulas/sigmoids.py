"""Sigmoid membership functions: one sigmoid, and the difference or product of two."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from fuzzyctl.expr import ZERO, Call, Compare, Expr, Number, Where
from fuzzyctl.formulas.formula import MembershipFormula, Parameters, Scale, not_zero, one_sided, union
from fuzzyctl.formulas.sigmoids import difference_extrema, product_extrema

_SIGMOIDS: Final = ("left", "rising", "falling", "right")
#: Multiples of its steepness at which a sigmoid ends where a file gives no range.
_STEEPNESSES: Final = 9.0


def _sigmoid_degree(x: Expr, p: Parameters) -> Expr:
    exponent = -p[1] * (x - p[0])
    return 1.0 / (1.0 + Call("exp", (exponent,)))


def _sigmoid_inverse(w: Expr, p: Parameters) -> Expr:
    odds = Where(Compare(">", w, ZERO), (1.0 - w) / w, Number(math.inf))
    return p[0] - Call("log", (odds,)) / p[1]


def _sigmoid_core(p: Parameters) -> tuple[float, float]:
    limit = math.inf if p[1] > 0.0 else -math.inf
    return limit, limit


def _sigmoids(p: Parameters) -> tuple[Parameters, Parameters]:
    left, rising, falling, right = p
    return (left, rising), (right, falling)


def _sigmoid_difference_degree(x: Expr, p: Parameters) -> Expr:
    first, second = (_sigmoid_degree(x, q) for q in _sigmoids(p))
    return Call("abs", (first - second,))


def _sigmoid_product_degree(x: Expr, p: Parameters) -> Expr:
    first, second = (_sigmoid_degree(x, q) for q in _sigmoids(p))
    return first * second


def _between_inflections(p: Parameters) -> tuple[float, float]:
    middle = 0.5 * p[0] + 0.5 * p[3]
    return middle, middle


def _extent(center: float, slope: float) -> tuple[float, float]:
    reach = _STEEPNESSES / abs(slope) if slope else 1.0
    return center - reach, center + reach


def _extent_of_two(p: Parameters) -> tuple[float, float]:
    return union(*(_extent(*q) for q in _sigmoids(p)))


def _scale(p: Parameters) -> Scale:
    return p[0], abs(1.0 / p[1]), "exponential"


def _scales_of_two(p: Parameters) -> tuple[Scale, ...]:
    left, right = _sigmoids(p)
    return _scale(left), _scale(right)


SIGMOIDS: Final[tuple[MembershipFormula, ...]] = (
    MembershipFormula(
        name="sigmoid",
        parameters=("inflection", "slope"),
        summary="1 / (1 + exp(-slope (x - inflection))); falling for slope < 0",
        degree=_sigmoid_degree,
        mistake=not_zero(slope=1),
        core=_sigmoid_core,
        inverse=_sigmoid_inverse,
        pieces=lambda p: p[:1],
        continuous=True,
        endless=True,
        cut=lambda degree, p: one_sided(_sigmoid_inverse(degree, p), rises=p[1] > 0.0),
        scales=lambda p: (_scale(p),),
        extent=lambda p: _extent(*p),
    ),
    MembershipFormula(
        name="sigmoid_difference",
        parameters=_SIGMOIDS,
        summary="|sigmoid(left, rising) - sigmoid(right, falling)|",
        degree=_sigmoid_difference_degree,
        mistake=not_zero(rising=1, falling=2),
        core=_between_inflections,
        pieces=lambda p: (p[0], p[3], *difference_extrema(p)),
        continuous=True,
        endless=True,
        scales=_scales_of_two,
        extent=_extent_of_two,
    ),
    MembershipFormula(
        name="sigmoid_product",
        parameters=_SIGMOIDS,
        summary="sigmoid(left, rising) times sigmoid(right, falling); a hill for rising > 0 and falling < 0",
        degree=_sigmoid_product_degree,
        mistake=not_zero(rising=1, falling=2),
        core=_between_inflections,
        pieces=lambda p: (p[0], p[3], *product_extrema(p)),
        continuous=True,
        endless=True,
        scales=_scales_of_two,
        extent=_extent_of_two,
    ),
)


def _clamped_difference_degree(x: Expr, p: Parameters) -> Expr:
    first, second = (_sigmoid_degree(x, q) for q in _sigmoids(p))
    return Call("max", (ZERO, first - second))


#: A difference that is 0 where the second sigmoid is the larger one.
CLAMPED_DIFFERENCE: Final = replace(SIGMOIDS[1], degree=_clamped_difference_degree)
