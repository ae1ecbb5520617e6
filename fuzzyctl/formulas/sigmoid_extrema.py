"""Extrema and zeros of the difference and of the product of two sigmoids."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

from fuzzyctl.formulas.formula import Parameters

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
