"""Vector interval arithmetic: enclosures of values, slopes and rounding errors over many boxes.

Operations are rounded outward by several ulp, so that an enclosure holds the real value and what any backend computes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from fuzzyctl.expr import COMPARISONS
from fuzzyctl.kernels.interval import scalar as intervals
from fuzzyctl.records import record

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
#: Bounds of slopes, two arrays of shape (inputs, boxes); None for 0.
Slopes = tuple[Array, Array] | None

#: Relative error of an operation, that of another form of the same program included.
ULPS: Final = 8 * 2.0**-53
#: Quotients of smaller numbers have lost their digits.
_LEAST: Final = 1e-290


@record(frozen=True)
class Enclosure:
    """A value over some boxes.

    Args:
        lo, hi: Bounds of the real value and of the floats of kernels; shape (boxes,), or () for a constant.
        slopes: Two arrays of shape (inputs, boxes): between them lie the slopes of the real value along each input;
            infinite where it may jump; None for 0.
        error: How far floats may be from the real value.
    """

    lo: Array
    hi: Array
    slopes: tuple[Array, Array] | None
    error: Array

    @property
    def size(self) -> Array:
        """The largest magnitude."""
        return np.maximum(np.abs(self.lo), np.abs(self.hi))

    def taken(self, mask: Mask) -> Enclosure:
        """Return the enclosures over some of the boxes, with slopes of shape (inputs, boxes) or (1, boxes)."""
        zero = np.zeros((1, 1))
        arrays = [np.broadcast_to(a, (*a.shape[:-1], len(mask)))[..., mask] for a in (self.lo, self.hi, self.error)]
        slopes = [np.broadcast_to(s, (len(s), len(mask)))[:, mask] for s in self.slopes or (zero, zero)]
        return Enclosure(arrays[0], arrays[1], (slopes[0], slopes[1]), arrays[2])


def joined(parts: Sequence[Enclosure]) -> Enclosure:
    """Return the enclosures over the boxes of several, as `Enclosure.taken` returns them."""
    lo, hi, error = (np.concatenate(rows) for rows in zip(*((e.lo, e.hi, e.error) for e in parts), strict=True))
    pairs = [e.slopes for e in parts if e.slopes is not None]
    inputs = max(len(s[0]) for s in pairs)
    below, above = (
        np.concatenate([np.broadcast_to(s[side], (inputs, s[side].shape[1])) for s in pairs], 1) for side in (0, 1)
    )
    return Enclosure(lo, hi, (below, above), error)


def constant(low: float, high: float | None = None, *, error: float = 0.0) -> Enclosure:
    """Return the enclosure of a number, or of one that is only known to lie between two."""
    return Enclosure(np.array(low), np.array(low if high is None else high), None, np.array(error))


def boxes(lo: Array, hi: Array) -> list[Enclosure]:
    """Return the enclosure of each input over boxes whose ends have the shape (inputs, boxes)."""
    enclosures = []
    for i in range(len(lo)):
        unit = np.zeros((len(lo), 1))
        unit[i] = 1.0
        enclosures.append(Enclosure(lo[i], hi[i], (unit, unit), np.array(0.0)))
    return enclosures


def sound(lo: Array, hi: Array, slopes: tuple[Array, Array] | None, error: Array) -> Enclosure:
    """Return an enclosure in which a value that may be NaN is any number; for the arguments see `Enclosure`."""
    bad = np.isnan(lo) | np.isnan(hi)
    if bad.any():
        lo, hi = np.where(bad, -np.inf, lo), np.where(bad, np.inf, hi)
        error = np.where(bad, np.inf, error)
        if slopes is not None:
            slopes = np.where(bad, -np.inf, slopes[0]), np.where(bad, np.inf, slopes[1])
    if slopes is not None:
        slopes = (
            np.where(np.isnan(slopes[0]), -np.inf, slopes[0]),
            np.where(np.isnan(slopes[1]), np.inf, slopes[1]),
        )
    return Enclosure(lo, hi, slopes, np.where(np.isnan(error), np.inf, error))


def outward(lo: Array, hi: Array) -> tuple[Array, Array]:
    """Return bounds, of any shape, moved apart by the error of an operation."""
    return lo - np.abs(lo) * ULPS, hi + np.abs(hi) * ULPS


def hull_of_products(a: tuple[Array, Array], b: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return bounds of the products of two values with bounds; shapes are broadcast."""
    return outward(*least_and_largest([x * y for x in a for y in b]))


def least_and_largest(four: Sequence[Array]) -> tuple[Array, Array]:
    """Return the least and the largest of four arrays, place by place; NaN where one is."""
    lo = np.minimum(np.minimum(four[0], four[1]), np.minimum(four[2], four[3]))
    hi = np.maximum(np.maximum(four[0], four[1]), np.maximum(four[2], four[3]))
    return lo, hi


def slope_times(factor: tuple[Array, Array], slopes: tuple[Array, Array]) -> tuple[Array, Array]:
    """Multiply slopes, shape (inputs, boxes), by a factor, shape (boxes,); 0 times one that is not known is 0."""
    products = [np.where((x == 0.0) | (y == 0.0), 0.0, x * y) for x in factor for y in slopes]
    return outward(*least_and_largest(products))


def _plus_slopes(a: Slopes, b: Slopes) -> Slopes:
    if a is None or b is None:
        return b if a is None else a
    return outward(a[0] + b[0], a[1] + b[1])


def negative(a: Enclosure) -> Enclosure:
    """Enclose -a."""
    return Enclosure(-a.hi, -a.lo, None if a.slopes is None else (-a.slopes[1], -a.slopes[0]), a.error)


def plus(a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose a + b."""
    lo, hi = outward(a.lo + b.lo, a.hi + b.hi)
    error = a.error + b.error + np.maximum(np.abs(lo), np.abs(hi)) * ULPS
    return sound(lo, hi, _plus_slopes(a.slopes, b.slopes), error)


def minus(a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose a - b."""
    return plus(a, negative(b))


def times(a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose a · b."""
    lo, hi = hull_of_products((a.lo, a.hi), (b.lo, b.hi))
    slopes = _plus_slopes(
        None if b.slopes is None else slope_times((a.lo, a.hi), b.slopes),
        None if a.slopes is None else slope_times((b.lo, b.hi), a.slopes),
    )
    error = a.size * b.error + b.size * a.error + a.error * b.error + np.maximum(np.abs(lo), np.abs(hi)) * ULPS
    return sound(lo, hi, slopes, error)


def square(a: Enclosure) -> Enclosure:
    """Enclose a², which is not negative; anything where a may be."""
    ends = a.lo * a.lo, a.hi * a.hi
    inside = (a.lo <= 0.0) & (a.hi >= 0.0)
    lo, hi = outward(np.where(inside, 0.0, np.minimum(*ends)), np.maximum(*ends))
    lo = np.where(np.isneginf(a.lo) & np.isposinf(a.hi), np.nan, lo)
    slopes = None if a.slopes is None else slope_times((2.0 * a.lo, 2.0 * a.hi), a.slopes)
    return sound(lo, hi, slopes, (2.0 * a.size + a.error) * a.error + hi * ULPS)


def divided(a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose a / b; anything where b may be 0, or so small that its digits are lost."""
    bad = (b.lo <= _LEAST) & (b.hi >= -_LEAST)
    low, high = np.where(bad, 1.0, b.lo), np.where(bad, 1.0, b.hi)
    inverse = 1.0 / high, 1.0 / low
    lo, hi = least_and_largest([x / y for x in (a.lo, a.hi) for y in (low, high)])
    lo, hi = outward(np.where(bad, np.nan, lo), np.where(bad, np.nan, hi))
    slopes = None
    above = a.slopes
    if b.slopes is not None:
        above = _plus_slopes(above, slope_times((-hi, -lo), b.slopes))
    if above is not None:
        slopes = slope_times(outward(*inverse), above)
    least = np.minimum(np.abs(low), np.abs(high))
    size = np.maximum(np.abs(lo), np.abs(hi))
    rest = least - b.error
    error = np.where(rest > 0.0, (a.error + size * b.error) / np.where(rest > 0.0, rest, 1.0), np.inf)
    return sound(lo, hi, slopes, error + size * ULPS)


def smaller(a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose min(a, b)."""
    slopes = either(a.hi <= b.lo, b.hi <= a.lo, a.slopes, b.slopes)
    return Enclosure(np.minimum(a.lo, b.lo), np.minimum(a.hi, b.hi), slopes, _larger_error(a, b))


def larger(a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose max(a, b)."""
    slopes = either(a.lo >= b.hi, b.lo >= a.hi, a.slopes, b.slopes)
    return Enclosure(np.maximum(a.lo, b.lo), np.maximum(a.hi, b.hi), slopes, _larger_error(a, b))


def _larger_error(a: Enclosure, b: Enclosure) -> Array:
    """Return the error of the smaller or the larger of two values, which differs by what both lie between at most."""
    return np.maximum(a.error, b.error)


def either(first: Mask, second: Mask, a: Slopes, b: Slopes) -> Slopes:
    """Return slopes of one, of the other, or of both where neither `first` nor `second` says which counts."""
    if a is None and b is None:
        return None
    zero = np.zeros((1, 1))
    a, b = a or (zero, zero), b or (zero, zero)
    lo = np.where(first, a[0], np.where(second, b[0], np.minimum(a[0], b[0])))
    hi = np.where(first, a[1], np.where(second, b[1], np.maximum(a[1], b[1])))
    return lo, hi


def chosen(yes: Mask, no: Mask, a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose a choice; where it is not clear which, the value may jump."""
    lo = np.where(yes, a.lo, np.where(no, b.lo, np.minimum(a.lo, b.lo)))
    hi = np.where(yes, a.hi, np.where(no, b.hi, np.maximum(a.hi, b.hi)))
    open_ = ~(yes | no)
    error = np.where(yes, a.error, np.where(no, b.error, hi - lo))
    slopes = either(yes, no, a.slopes, b.slopes)
    if open_.any():
        low, high = slopes or (np.zeros((1, 1)), np.zeros((1, 1)))
        slopes = np.where(open_, -np.inf, low), np.where(open_, np.inf, high)
    return Enclosure(lo, hi, slopes, error)


def jumping(lo: Array, hi: Array) -> Enclosure:
    """Return an enclosure with known ends and unknown slopes, shape (boxes,) or ()."""
    flat = lo == hi
    steep = np.where(flat, 0.0, np.inf)[None]
    return sound(lo, hi, (-steep, steep), hi - lo)


#: Boxes where a condition surely holds, and where it surely does not.
Truths = tuple[Mask, Mask]

#: Relative error of a library function.
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
            enclosure = a[0]
            for other in a[1:]:
                enclosure = _unless_nan(join(enclosure, other), other)
            return enclosure
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


def _unless_nan(enclosure: Enclosure, second: Enclosure) -> Enclosure:
    """Return a smaller or larger value; if it may be NaN, the second operand decides."""
    bad = np.isneginf(second.lo) & np.isposinf(second.hi)
    if not bad.any():
        return enclosure
    return sound(np.where(bad, np.nan, enclosure.lo), enclosure.hi, enclosure.slopes, enclosure.error)


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
    """Enclose the function that is 1 where a comparison holds, else 0; operands that may be NaN have no result."""
    yes, no = compared(op, a, b)
    certain = ~(np.isneginf(a.lo) & np.isposinf(a.hi) | np.isneginf(b.lo) & np.isposinf(b.hi))
    return chosen(yes & certain, no & certain, constant(1.0), constant(0.0))


def _sign(a: Enclosure) -> Enclosure:
    return jumping(np.sign(a.lo), np.sign(a.hi))


def _scalars(function: Callable[..., intervals.Interval], a: Sequence[Enclosure]) -> tuple[Array, Array]:
    """Apply a function of intervals box by box."""
    ends = np.broadcast_arrays(*(x for e in a for x in (e.lo, e.hi)))
    shape = ends[0].shape
    flat = [e.reshape(-1).tolist() for e in ends]
    results = [function(*((row[2 * k], row[2 * k + 1]) for k in range(len(a)))) for row in zip(*flat, strict=True)]
    values = np.array(results, dtype=np.float64).reshape((*shape, 2))
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
