"""Primitives for floats as IEEE 754 has them: infinities and NaN where Python raises.

Generated modules hold the text of these functions, so they name nothing but each other, `math`, `inf` and `nan`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from math import inf, nan
from typing import Final

from fuzzyctl.expr import floor


def divide(a: float, b: float) -> float:
    """Return a / b."""
    if b != 0.0:
        return a / b
    if a == 0.0 or a != a or b != b:
        return nan
    return math.copysign(inf, a) * math.copysign(1.0, b)


def smaller(a: float, b: float) -> float:
    """Return the smaller number, the second one where one of them is NaN."""
    return a if a < b else b


def larger(a: float, b: float) -> float:
    """Return the larger number, the second one where one of them is NaN."""
    return a if a > b else b


def clip(x: float, low: float, high: float) -> float:
    """Return a number held between two others; NaN stays NaN."""
    return low if x < low else high if x > high else x


def held(x: float) -> float:
    """Return a number held within [0, 1], 0 for NaN."""
    return (x if x < 1.0 else 1.0) if x > 0.0 else 0.0


def power(a: float, b: float) -> float:
    """Return a^b."""
    try:
        return math.pow(a, b)
    except OverflowError:
        return math.copysign(inf, a) if b % 2.0 == 1.0 else inf
    except ValueError:
        return divide(1.0, math.copysign(0.0, a) if b % 2.0 == 1.0 else 0.0) if a == 0.0 else nan


def sqrt(x: float) -> float:
    """Return the square root, NaN of a negative number."""
    return math.sqrt(x) if x >= 0.0 else nan


def exp(x: float) -> float:
    """Return the exponential."""
    try:
        return math.exp(x)
    except OverflowError:
        return inf


def log(x: float) -> float:
    """Return the natural logarithm, -∞ of 0 and NaN of a negative number."""
    return -inf if x == 0.0 else math.log(x) if x > 0.0 else nan


def sin(x: float) -> float:
    """Return the sine, NaN of an infinite angle."""
    return math.sin(x) if -inf < x < inf else nan


def cos(x: float) -> float:
    """Return the cosine, NaN of an infinite angle."""
    return math.cos(x) if -inf < x < inf else nan


def tan(x: float) -> float:
    """Return the tangent, NaN of an infinite angle."""
    return math.tan(x) if -inf < x < inf else nan


def fmod(a: float, b: float) -> float:
    """Return the remainder of a / b with the sign of a, NaN where there is none."""
    try:
        return math.fmod(a, b)
    except ValueError:
        return nan


#: The primitives.
FUNCTIONS: Final[Mapping[str, Callable[..., float]]] = {
    **{f.__name__: f for f in (divide, smaller, larger, clip, held, power, sqrt, exp, log, sin, cos, tan, floor, fmod)},
    "abs": abs,
    "atan2": math.atan2,
}
