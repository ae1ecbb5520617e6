"""Functions of vector intervals, rounded outward to hold the values of any library."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from fuzzyctl.expr import COMPARISONS
from fuzzyctl.kernels.interval import scalar as intervals
from fuzzyctl.kernels.interval.vector import (
    ULPS,
    Array,
    Enclosure,
    Mask,
    chosen,
    constant,
    divided,
    hull_of_products,
    jumping,
    larger,
    negative,
    outward,
    slope_times,
    smaller,
    sound,
)

#: Boxes where a condition surely holds, and where it surely does not.
Truths = tuple[Mask, Mask]

#: What a library function may be off by, relative to its value.
_LIBRARY: Final = 64 * 2.0**-53
#: Exponentials below it count as any number from 0 up to it.
_TINY: Final = 1e-300


def applied(function: str, a: list[Enclosure]) -> Enclosure:
    """Enclose a function of the expression language.

    Raises:
        TypeError: When there is no enclosure of it.
    """
    match function:
        case "min" | "max" | "smaller" | "larger":
            join = smaller if function in ("min", "smaller") else larger
            found = a[0]
            for other in a[1:]:
                found = _unless_nan(join(found, other), other)
            return found
        case "divide":
            return divided(a[0], a[1])
        case "clip":
            return _held(a[0], a[1], a[2])
        case "held":
            return _held(a[0], constant(0.0), constant(1.0))
        case "abs":
            return larger(a[0], negative(a[0]))
        case "exp":
            return _exp(a[0])
        case "sqrt":
            return _sqrt(a[0])
        case "sign":
            return _sign(a[0])
        case comparison if comparison in COMPARISONS:
            return _truth(COMPARISONS[comparison], a[0], a[1])
        case "log" | "sin" | "cos":
            return _by_scalars(function, a[0])
        case "atan2" | "tan" | "floor" | "ceil" | "round" | "mod" | "fmod":
            return jumping(*_scalars(lambda *x: intervals.applied(function, list(x)), a))
    raise TypeError(f"function {function!r} has no enclosure")


def _held(q: Enclosure, low: Enclosure, high: Enclosure) -> Enclosure:
    return smaller(larger(q, low), high)


def _unless_nan(found: Enclosure, second: Enclosure) -> Enclosure:
    """Return a smaller or larger value; what may be NaN, the second operand hands on."""
    bad = np.isneginf(second.lo) & np.isposinf(second.hi)
    if not bad.any():
        return found
    return sound(np.where(bad, np.nan, found.lo), found.hi, found.slopes, found.error)


def _exp(a: Enclosure) -> Enclosure:
    low, high = np.exp(a.lo), np.exp(a.hi)
    lo = np.where(low < _TINY, 0.0, low * (1.0 - _LIBRARY))
    hi = np.where(high < _TINY, np.where(a.hi < -800.0, 0.0, _TINY), high * (1.0 + _LIBRARY))
    lo, hi = np.where(a.lo == 0.0, 1.0, lo), np.where(a.hi == 0.0, 1.0, hi)
    slopes = None if a.slopes is None else slope_times((lo, hi), a.slopes)
    return sound(lo, hi, slopes, hi * (np.expm1(np.minimum(a.error, 1.0)) * 1.01 + _LIBRARY))


def _sqrt(a: Enclosure) -> Enclosure:
    lo, hi = outward(np.sqrt(a.lo), np.sqrt(a.hi))
    with_root = np.where(lo > 0.0, lo, 1.0)
    slopes = None
    if a.slopes is not None:
        steep = np.where(lo > 0.0, 0.5 / with_root, np.inf) * (1.0 + ULPS)
        slopes = slope_times((0.5 / np.where(hi > 0.0, hi, 1.0) * (1.0 - ULPS), steep), a.slopes)
    error = np.where(lo * lo > 2.0 * a.error, a.error / with_root, np.sqrt(3.0 * a.error)) + hi * ULPS
    return sound(lo, hi, slopes, error)


def compared(op: str, a: Enclosure, b: Enclosure) -> Truths:
    """Return where a comparison surely holds, and where it surely does not."""
    match op:
        case "<":
            return a.hi < b.lo, a.lo >= b.hi
        case "<=":
            return a.hi <= b.lo, a.lo > b.hi
        case ">" | ">=":
            return compared("<" if op == ">" else "<=", b, a)
        case "==":
            return (a.lo == a.hi) & (b.lo == b.hi) & (a.lo == b.lo), (a.hi < b.lo) | (b.hi < a.lo)
    yes, no = compared("==", a, b)
    return no, yes


def _truth(op: str, a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose the function that is 1 where a comparison holds, else 0; what may be NaN is compared without a result."""
    yes, no = compared(op, a, b)
    known = ~(np.isneginf(a.lo) & np.isposinf(a.hi) | np.isneginf(b.lo) & np.isposinf(b.hi))
    return chosen(yes & known, no & known, constant(1.0), constant(0.0))


def _sign(a: Enclosure) -> Enclosure:
    return jumping(np.sign(a.lo), np.sign(a.hi))


def _scalars(function: Callable[..., intervals.Interval], a: Sequence[Enclosure]) -> tuple[Array, Array]:
    """Apply a function of intervals box by box."""
    ends = np.broadcast_arrays(*(x for e in a for x in (e.lo, e.hi)))
    shape = ends[0].shape
    flat = [e.reshape(-1).tolist() for e in ends]
    found = [function(*((row[2 * k], row[2 * k + 1]) for k in range(len(a)))) for row in zip(*flat, strict=True)]
    values = np.array(found, dtype=np.float64).reshape((*shape, 2))
    return values[..., 0], values[..., 1]


def _by_scalars(function: str, a: Enclosure) -> Enclosure:
    lo, hi = _scalars(lambda x: intervals.applied(function, [x]), [a])
    if function == "log":
        steep = divided(constant(1.0), Enclosure(a.lo, a.hi, None, np.array(0.0)))
        derivative = steep.lo, steep.hi
    else:
        other = "cos" if function == "sin" else "sin"
        derivative = _scalars(lambda x: intervals.applied(other, [x]), [a])
        if function == "cos":
            derivative = -derivative[1], -derivative[0]
    return _through(a, lo, hi, derivative)


def _through(a: Enclosure, lo: Array, hi: Array, derivative: tuple[Array, Array]) -> Enclosure:
    """Return a function of a with given values and derivatives."""
    slopes = None if a.slopes is None else slope_times(derivative, a.slopes)
    steep = np.maximum(np.abs(derivative[0]), np.abs(derivative[1]))
    error = np.where(a.error == 0.0, 0.0, steep * a.error * 2.0) + np.maximum(np.abs(lo), np.abs(hi)) * _LIBRARY
    return sound(lo, hi, slopes, error)


def power(a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose a^b; slopes are known for exponents that are numbers."""
    lo, hi = _scalars(intervals.raised, [a, b])
    if b.slopes is not None or (b.lo != b.hi).any():
        return jumping(lo, hi)
    lower = _scalars(intervals.raised, [a, Enclosure(b.lo - 1.0, b.hi - 1.0, None, b.error)])
    derivative = hull_of_products((b.lo, b.hi), lower)
    bad = np.isnan(derivative[0]) | np.isnan(derivative[1])
    return _through(a, lo, hi, (np.where(bad, -np.inf, derivative[0]), np.where(bad, np.inf, derivative[1])))
