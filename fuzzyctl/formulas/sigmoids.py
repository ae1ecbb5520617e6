"""Sigmoid membership functions: one sigmoid, and the difference or product of two."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Final

from fuzzyctl.expr import ZERO, Call, Compare, Expr, Number, Where
from fuzzyctl.formulas.formula import MembershipFormula, Parameters, Scale, not_zero, one_sided, union

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


#: Largest width of a bracket, relative to its first one, before the search by doubling is given up.
_DOUBLINGS = 200


@cache
def difference_extrema(p: Parameters) -> tuple[float, ...]:
    """Return where |sigmoid(left, rising) - sigmoid(right, falling)| is 0 and where it is largest on either side.

    The two are equal where their exponents are. Slopes of equal sign make two hills: the derivatives r s (1 - s) are
    equal where √r_steep cosh(e_flat) = √r_flat cosh(e_steep), with e half an exponent; the logarithm of the quotient
    falls up to one place and rises from there on, and is negative where the exponents are equal.
    """
    left, rising, falling, right = p
    if rising == falling:
        return _finite(0.5 * left + 0.5 * right)
    equal = left + (left - right) * (falling / (rising - falling))
    if (rising > 0.0) != (falling > 0.0) or not math.isfinite(equal):
        return _finite(equal)
    (flat, at_flat), (steep, at_steep) = sorted([(abs(rising), left), (abs(falling), right)])
    shift = 0.5 * math.log(steep / flat)

    def apart(x: float) -> float:
        return _log_cosh(0.5 * steep * (x - at_steep)) - _log_cosh(0.5 * flat * (x - at_flat)) - shift

    return _finite(_root(apart, equal, -1.0 / steep), equal, _root(apart, equal, 1.0 / steep))


@cache
def product_extrema(p: Parameters) -> tuple[float, ...]:
    """Return where sigmoid(left, rising) · sigmoid(right, falling) is largest; nothing where it is monotone.

    Its logarithm has the slope r₁ (1 - s₁) + r₂ (1 - s₂), which falls everywhere.
    """
    left, rising, falling, right = p
    if (rising > 0.0) == (falling > 0.0):
        return ()

    def slope(x: float) -> float:
        return -rising * _sigmoid(-rising * (x - left)) - falling * _sigmoid(-falling * (x - right))

    start, step = min(left, right), 1.0 / min(abs(rising), abs(falling))
    while slope(start) > 0.0 and step < math.inf:
        start, step = start - step, 2.0 * step
    return _finite(_root(slope, start, step))


def _root(function: Callable[[float], float], start: float, step: float) -> float:
    """Return where a function that is not positive at a start becomes so in the direction of a step; NaN if nowhere."""
    low = start
    for _ in range(_DOUBLINGS):
        high = start + step
        if not function(high) <= 0.0:
            return bisected(lambda x: function(x) > 0.0, low, high)
        low, step = high, 2.0 * step
    return math.nan


def bisected(holds: Callable[[float], bool], without: float, with_it: float) -> float:
    """Return the first float at which a condition holds, between one where it does not and one where it does."""
    while without != (middle := 0.5 * without + 0.5 * with_it) != with_it:
        if holds(middle):
            with_it = middle
        else:
            without = middle
    return with_it


def _log_cosh(x: float) -> float:
    return abs(x) + math.log1p(math.exp(-2.0 * abs(x))) - math.log(2.0)


def _sigmoid(exponent: float) -> float:
    return 1.0 / (1.0 + math.exp(-exponent)) if exponent > -700.0 else 0.0


def _finite(*places: float) -> tuple[float, ...]:
    return tuple(x for x in places if math.isfinite(x))


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
