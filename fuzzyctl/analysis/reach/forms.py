"""Affine forms over shared symbols, rounded outward, for many boxes at once.

A form is an array whose last axis holds the centre c, the radius r of an independent error, and a coefficient for each
symbol: the set of c + r e + g1 e1 + ... + gp ep for all e in [-1, 1]. Forms with the same symbols are correlated. An
interval is a form without symbols. Numbers are exact constants: operations on them that round return intervals.

Source:
    Stolfi, de Figueiredo: Self-validated numerical methods and applications, 1997 (affine arithmetic).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any, Final

import numpy as np
import numpy.typing as npt

Form = npt.NDArray[np.float64]
#: A number or a form of shape (boxes, 2 + symbols).
Value = float | Form
Mask = npt.NDArray[np.bool_]

#: Relative bounds of the rounding errors of a sum, and of a product with its radii.
_SUM: Final = 8 * 2.0**-53
_PRODUCT: Final = 32 * 2.0**-53
#: Relative error of a library function.
_LIBRARY: Final = 16 * 2.0**-53
#: Most points that take the place of a box.
_MOST_CORNERS: Final = 32
#: Above all that underflows.
_TINY: Final = 1e-300


class DomainError(Exception):
    """Raised if a set reaches beyond the domain of a function."""


def near(value: float, relative: float = _SUM) -> Value:
    """Return an interval around a number that rounding has changed."""
    if not math.isfinite(value):
        raise DomainError("a constant of the loop is not a finite number")
    return np.array([[value, relative * abs(value) + _TINY]])


def rounded(exact: Fraction) -> Value:
    """Return a rational number."""
    return float(exact) if Fraction(float(exact)) == exact else near(float(exact))


def _is_power_of_two(a: float) -> bool:
    return abs(math.frexp(a)[0]) == 0.5 and 1e-30 < abs(a) < 1e30


def _number_product(a: float, b: float) -> Value:
    product = a * b
    if not math.isfinite(product) or a in (0.0, 1.0, -1.0) or b in (0.0, 1.0, -1.0):
        return product
    return product if Fraction(a) * Fraction(b) == Fraction(product) else near(product)


def radius(a: Form) -> Form:
    """Return the radius of each box, shape (boxes,), rounded up."""
    return np.asarray(np.add.reduce(np.abs(a[..., 1:]), -1) * (1.0 + _SUM * a.shape[-1]))


def ends(a: Value) -> tuple[Form, Form]:
    """Return the lower and upper ends of each box, rounded outward."""
    if isinstance(a, float):
        return np.array([a]), np.array([a])
    r, c = radius(a), a[..., 0]
    slack = _SUM * (np.abs(c) + r)
    return c - r - slack, c + r + slack


def interval(low: Form, high: Form) -> Form:
    """Return the form without symbols that holds all numbers between two ends, shape (boxes, 2)."""
    c = 0.5 * (low + high)
    r = np.maximum(high - c, c - low)
    return np.stack([c, r + _SUM * (np.abs(c) + r) + _TINY], -1)


def corners(box: Form) -> Form:
    """Return the corners of a box, given by intervals of shape (sides, 2); shape (corners, sides, 2)."""
    low, high = ends(box)
    picks = np.stack(np.meshgrid(*[np.array([False, True])] * len(low), indexing="ij"), -1).reshape(-1, len(low))
    # Not the middles beside the ends: a side without width has one.
    points = np.unique(np.where(picks, high, low), axis=0)
    return np.stack([points, np.zeros_like(points)], -1)


def hull_points(points: Form) -> Form:
    """Return points whose convex hull holds that of others, shape (points, sides, 2), fewer if possible."""
    low, high = ends(points)
    box = interval(low.min(0), high.max(0))
    order = np.unique(points[..., 0], axis=0, return_index=True)[1]
    used = np.flatnonzero(np.ptp(points[..., 0], axis=0) > 0.0)
    if len(used) == 2:
        x, y = points[order][:, used, 0].T
        outline: set[int] = set()
        for turn in (1.0, -1.0):  # the lower and the upper half, from left to right
            half: list[int] = []
            for k in range(len(x)):
                while len(half) > 1 and turn * _turn(x, y, half[-2], half[-1], k) <= 0.0:
                    half.pop()
                half.append(k)
            outline |= set(half)
        order = order[sorted(outline)]
        # A point that is left out for rounding alone lies that near to the hull.
        points = points.copy()
        points[..., 1] += 1e-12 * np.abs(points[..., 0]).max(0)
    return corners(box) if len(order) > max(2 ** len(used), _MOST_CORNERS) else points[order]


def _turn(x: Form, y: Form, a: int, b: int, c: int) -> float:
    """Return twice the area of a triangle, positive if it turns to the left."""
    return float((x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a]))


def hulled(a: Form) -> Form:
    """Return a form without its symbols, shape (boxes, 2)."""
    return np.stack([a[..., 0], radius(a)], -1)


def padded(a: Form, magnitude: Any, relative: float = _SUM) -> Form:
    """Add what rounding may have done to a sum of some magnitude, in place."""
    error = a[..., 1]
    error *= 1.0 + _SUM
    error += relative * magnitude + _TINY
    return a


def _single(centre: float, error: float, magnitude: float, relative: float = _SUM) -> Form:
    """Return one interval as `padded` does; numbers take a tenth of the time of arrays of one number."""
    return np.array([[centre, error * (1.0 + _SUM) + relative * magnitude + _TINY]])


def _size(a: Form) -> Form:
    return np.asarray(np.add.reduce(np.abs(a), -1))


def negative(a: Value) -> Value:
    """Return -a."""
    if isinstance(a, float):
        return -a
    out = -a
    out[..., 1] = a[..., 1]
    return out


def plus(a: Value, b: Value) -> Value:
    """Return a + b."""
    if isinstance(a, float):
        if isinstance(b, float):
            total = a + b
            if not math.isfinite(total) or Fraction(a) + Fraction(b) == Fraction(total):
                return total
            return near(total)
        a, b = b, a
    assert not isinstance(a, float)
    if isinstance(b, float):
        if b == 0.0:
            return a
        out = a.copy()
        out[..., 0] += b
        return padded(out, _size(out))
    if a.shape == b.shape == (1, 2):
        ((ca, ra),), ((cb, rb),) = a.tolist(), b.tolist()
        return _single(ca + cb, ra + rb, abs(ca + cb) + ra + rb)
    if a.shape[-1] < b.shape[-1]:
        a, b = b, a
    if a.ndim == b.ndim == 2 and a.shape[-1] > b.shape[-1] and len(a) >= len(b):  # without a wider copy
        out = a.copy()
        out[..., : b.shape[-1]] += b
    else:
        out = a + widened(b, a.shape[-1])
    return padded(out, _size(out))


def aligned(a: Form, b: Form) -> tuple[Form, Form]:
    """Return two forms with as many symbols: an interval does not depend on any."""
    width = max(a.shape[-1], b.shape[-1])
    return widened(a, width), widened(b, width)


def widened(a: Form, width: int) -> Form:
    """Return a form with further symbols on which it does not depend."""
    missing = width - a.shape[-1]
    return np.concatenate([a, np.zeros((*a.shape[:-1], missing))], -1) if missing else a


def minus(a: Value, b: Value) -> Value:
    """Return a - b."""
    return plus(a, negative(b))


def scaled(a: Value, factor: float) -> Value:
    """Return a times a number."""
    if isinstance(a, float):
        return _number_product(a, factor)
    if factor == 1.0:
        return a
    if a.shape == (1, 2):
        ((c, r),) = (a * factor).tolist()
        return _single(c, abs(r), abs(c) + abs(r))
    out = a * factor
    out[..., 1] = np.abs(out[..., 1])
    return padded(out, _size(out))


def divided(a: Value, count: int) -> Value:
    """Return a by a whole number."""
    return rounded(Fraction(a) / count) if isinstance(a, float) else scaled(a, 1.0 / count)


def times(a: Value, b: Value) -> Value:
    """Return a b; squares of symbols lie in [0, 1]."""
    if isinstance(b, float):
        return scaled(a, b)
    if isinstance(a, float):
        return scaled(b, a)
    if a.shape[-1] == 2 or b.shape[-1] == 2:
        return _times_interval(a, b) if b.shape[-1] == 2 else _times_interval(b, a)
    if a.shape[-1] != b.shape[-1]:
        a, b = aligned(a, b)
    ca, cb = a[..., 0], b[..., 0]
    ra, rb = radius(a), radius(b)
    out = ca[..., None] * b
    out += cb[..., None] * a
    both = a[..., 2:] * b[..., 2:]
    size_a, size_b = np.abs(ca), np.abs(cb)
    out[..., 0] = ca * cb + 0.5 * np.add.reduce(both, -1)
    np.abs(both, out=both)
    out[..., 1] = size_a * b[..., 1] + size_b * a[..., 1] + np.maximum(ra * rb - 0.5 * np.add.reduce(both, -1), 0.0)
    return padded(out, (size_a + ra) * (size_b + rb), _PRODUCT * (1 + a.shape[-1]))


def _times_interval(a: Form, b: Form) -> Form:
    """Return the product of a form and an interval."""
    if a.shape == b.shape == (1, 2):
        ((ca, ra),), ((cb, rb),) = a.tolist(), b.tolist()
        error = abs(ca) * rb + abs(cb) * ra + ra * rb
        return _single(ca * cb, error, (abs(ca) + ra) * (abs(cb) + rb), _PRODUCT)
    c, r = b[..., :1], b[..., 1]
    out = np.asarray(a * c)
    size = _size(a)
    out[..., 1] = np.abs(out[..., 1]) + r * size * (1.0 + _SUM * a.shape[-1])
    return padded(out, size * (np.abs(b[..., 0]) + r), _PRODUCT)


def on_line(a: Form, slope: Any, offset: Any, error: Any) -> Form:
    """Return offset + slope (a - centre of a) + an independent error; slope and offset have one number for each box."""
    out = np.asarray(a * np.asarray(slope)[..., None])
    out[..., 1] = np.abs(out[..., 1]) + error
    out[..., 0] = offset
    return padded(out, _size(out) + np.abs(offset))


def through(
    a: Form,
    function: Callable[[Form], Form],
    curvature: Callable[[Form, Form], tuple[Form, Form]],
) -> Form:
    """Return a smooth function of a form: its secant over the range, with the error that the curvature bounds.

    For x in [l, u] the function less the secant is f''(z) (x - l) (x - u) / 2 for some z in the range.

    Args:
        a: The form.
        function: For the ends of ranges.
        curvature: Returns the ends of the second derivative over ranges, given by their ends.
    """
    low, high = ends(a)
    at_low, at_high = function(low), function(high)
    width = high - low
    slope = np.where(width > 0.0, (at_high - at_low) / np.where(width > 0.0, width, 1.0), 0.0)
    least, most = curvature(low, high)
    share = 0.125 * width * width * (1.0 + _PRODUCT)
    below, above = np.minimum(-most * share, 0.0), np.maximum(-least * share, 0.0)
    error = 0.5 * (above - below) + _LIBRARY * (np.abs(at_low) + np.abs(at_high) + np.abs(above) + np.abs(below))
    error = error + 4.0 * _LIBRARY * np.abs(slope) * (np.abs(low) + np.abs(high))
    middle = at_low + slope * (a[..., 0] - low) + 0.5 * (below + above)
    return on_line(a, slope, middle, error)


def _holds(low: Form, high: Form, first: float, period: float) -> Mask:
    """Return whether a range comes near a point of first + k period."""
    slack = 1e-9 * (1.0 + np.abs(low) + np.abs(high))
    return np.asarray(np.floor((high + slack - first) / period) > np.floor((low - slack - first) / period))


def _sine_range(low: Form, high: Form, shift: float) -> tuple[Form, Form]:
    """Return the ends of sin(x + shift)."""
    a, b = (np.cos(low), np.cos(high)) if shift else (np.sin(low), np.sin(high))
    top = _holds(low, high, math.pi / 2 - shift, 2 * math.pi)
    bottom = _holds(low, high, -math.pi / 2 - shift, 2 * math.pi)
    wide = ~((high - low) < 6.0)
    least = np.where(bottom | wide, -1.0, np.minimum(a, b) - 1e-15)
    most = np.where(top | wide, 1.0, np.maximum(a, b) + 1e-15)
    return least, most


def sine(a: Value, shift: float = 0.0) -> Value:
    """Return sin(a + shift), shift 0, or pi/2 for the cosine."""
    if isinstance(a, float):
        if a == 0.0:
            return 1.0 if shift else 0.0
        return near(math.cos(a) if shift else math.sin(a), _LIBRARY)
    function = np.cos if shift else np.sin

    def curvature(low: Form, high: Form) -> tuple[Form, Form]:
        least, most = _sine_range(low, high, shift)
        return -most, -least

    low, high = ends(a)
    if float(np.max(high - low)) > math.pi / 2:  # the secant is worse than the range
        return narrower(through(a, function, curvature), interval(*_sine_range(low, high, shift)))
    return through(a, function, curvature)


def narrower(a: Form, b: Form) -> Form:
    """Return for each box the narrower of two enclosures."""
    a, b = aligned(a, b)
    return np.where((radius(a) <= radius(b))[..., None], a, b)


def exponential(a: Value) -> Value:
    """Return exp(a)."""
    if isinstance(a, float):
        return 1.0 if a == 0.0 else near(math.exp(a) if a < 709.0 else math.inf, _LIBRARY)
    return through(a, np.exp, lambda low, high: (np.exp(low) * (1.0 - 1e-12), np.exp(high) * (1.0 + 1e-12)))


def _positive(a: Form, what: str) -> Form:
    low, _ = ends(a)
    if not bool(np.all(low > 0.0)):
        raise DomainError(f"the enclosure of the argument of {what} reaches {float(np.min(low)):.3g}")
    return low


def logarithm(a: Value) -> Value:
    """Return log(a)."""
    if isinstance(a, float):
        if a <= 0.0:
            raise DomainError(f"the argument of 'log' is {a:.3g}")
        return 0.0 if a == 1.0 else near(math.log(a), _LIBRARY)
    _positive(a, "'log'")
    return through(a, np.log, lambda low, high: (-(low**-2.0) * (1.0 + 1e-12), -(high**-2.0) * (1.0 - 1e-12)))


def root(a: Value, positive: bool = False) -> Value:
    """Return sqrt(a); at 0 the secant with the exact error of a concave function.

    Args:
        a: A number or a form.
        positive: Whether the values are known not to be negative, though the form may reach below 0.
    """
    if isinstance(a, float):
        if a < 0.0:
            raise DomainError(f"the argument of 'sqrt' is {a:.3g}")
        return math.sqrt(a) if Fraction(math.sqrt(a)) ** 2 == Fraction(a) else near(math.sqrt(a))
    low, high = ends(a)
    if positive:
        low = np.maximum(low, 0.0)
    elif bool(np.any(low < 0.0)):
        raise DomainError(f"the enclosure of the argument of 'sqrt' reaches {float(np.min(low)):.3g}")
    first, last = np.sqrt(low), np.sqrt(high)
    total = first + last
    slope = np.where(total > 0.0, 1.0 / np.where(total > 0.0, total, 1.0), 0.0)
    # The root less its secant is largest at x = (total / 2)^2.
    above = np.where(total > 0.0, (last - first) ** 2 / (4.0 * np.where(total > 0.0, total, 1.0)), 0.0)
    middle = first + slope * (a[..., 0] - low) + 0.5 * above
    return on_line(a, slope, middle, 0.5 * above * (1.0 + 1e-12) + _PRODUCT * (first + last))


def inverse(a: Value) -> Value:
    """Return 1 / a."""
    if isinstance(a, float):
        if a == 0.0:
            raise DomainError("a division by 0")
        return 1.0 / a if _is_power_of_two(a) else near(1.0 / a)
    low, high = ends(a)
    if bool(np.any((low <= 0.0) & (high >= 0.0))):
        raise DomainError(
            f"the enclosure of a divisor holds 0: from {float(np.min(low)):.3g} to {float(np.max(high)):.3g}"
        )

    def curvature(low: Form, high: Form) -> tuple[Form, Form]:
        one, other = 2.0 * low**-3.0, 2.0 * high**-3.0
        slack = 1e-12 * (np.abs(one) + np.abs(other))
        return np.minimum(one, other) - slack, np.maximum(one, other) + slack

    return through(a, lambda x: 1.0 / x, curvature)


def powered(a: Value, exponent: float) -> Value:
    """Return a to the power of a number; a whole exponent takes products."""
    if isinstance(a, float):
        try:
            return near(float(a**exponent), _LIBRARY)
        except (ArithmeticError, TypeError):  # a complex number for a negative one
            raise DomainError(f"{a:.3g} to the power of {exponent:.3g} is no finite number") from None
    if exponent == int(exponent) and 0 <= exponent <= 64:
        power, base, rest = 1.0, a, int(exponent)
        out: Value = power
        square: Value = base
        while rest:
            out = times(out, square) if rest & 1 else out
            rest >>= 1
            square = times(square, square) if rest else square
        return out
    if exponent == int(exponent):
        return powered(inverse(a), -exponent)
    _positive(a, "a power")
    factor = exponent * (exponent - 1.0)

    def curvature(low: Form, high: Form) -> tuple[Form, Form]:
        one, other = factor * low ** (exponent - 2.0), factor * high ** (exponent - 2.0)
        slack = 1e-12 * (np.abs(one) + np.abs(other))
        return np.minimum(one, other) - slack, np.maximum(one, other) + slack

    return through(a, lambda x: x**exponent, curvature)


def ramp(a: Value) -> Value:
    """Return max(a, 0)."""
    return larger(a, 0.0)


def absolute(a: Value) -> Value:
    """Return |a|, with the exact error of the secant; an independent error counts once, unlike in max(a, -a).

    For a slope s in [-1, 1] |x| - s x is convex: it is 0 at 0 and largest at an end of the range.
    """
    if isinstance(a, float):
        return abs(a)
    low, high = ends(a)
    if bool(np.all(low >= 0.0)):
        return a
    if bool(np.all(high <= 0.0)):
        return negative(a)
    width = np.where(high > low, high - low, 1.0)
    slope = np.clip(np.where(low >= 0.0, 1.0, np.where(high <= 0.0, -1.0, (high + low) / width)), -1.0, 1.0)
    gap = np.where((low >= 0.0) | (high <= 0.0), 0.0, np.maximum(high * (1.0 - slope), -low * (1.0 + slope)))
    rounding = _PRODUCT * (np.abs(low) + np.abs(high))
    return on_line(a, slope, slope * a[..., 0] + 0.5 * gap, 0.5 * gap * (1.0 + _PRODUCT) + rounding)


def larger(a: Value, b: Value) -> Value:
    """Return max(a, b), with the exact error of the secant.

    With d = a - b in [l, h] and a share s in [0, 1] max(a, b) - s a - (1 - s) b = max(d, 0) - s d is convex in d: it is
    0 at d = 0, and largest at an end, where it is (1 - s) h or -s l.
    """
    if isinstance(a, float) and isinstance(b, float):
        return max(a, b)
    low, high = ends(minus(a, b))
    if bool(np.all(low >= 0.0)):
        return a
    if bool(np.all(high <= 0.0)):
        return b
    a, b = aligned(as_form(a), as_form(b))
    inside = (low < 0.0) & (high > 0.0)
    share = np.where(inside, high / np.where(inside, high - low, 1.0), low >= 0.0)
    gap = np.where(inside, np.maximum((1.0 - share) * high, -share * low) * (1.0 + _SUM), 0.0)
    out = share[..., None] * a + (1.0 - share[..., None]) * b
    out[..., 0] += 0.5 * gap
    out[..., 1] += 0.5 * gap
    return padded(out, share * _size(a) + (1.0 - share) * _size(b) + gap)


def smaller(a: Value, b: Value) -> Value:
    """Return min(a, b)."""
    return negative(larger(negative(a), negative(b)))


def chosen(yes: Mask, no: Mask, a: Value, b: Value) -> Value:
    """Return a in boxes in which a condition surely holds, b in those in which it fails, else the hull."""
    if bool(np.all(yes)):
        return a
    if bool(np.all(no)):
        return b
    if isinstance(a, float) and isinstance(b, float) and a == b:
        return a
    first, second = as_form(a), as_form(b)
    first, second = aligned(first, second)
    first, second = np.broadcast_arrays(first, second)
    either = 0.5 * (first + second)
    either[..., 1] += 0.5 * (np.abs(first[..., 0] - second[..., 0]) + np.abs(first[..., 2:] - second[..., 2:]).sum(-1))
    either[..., 1] += 0.5 * np.abs(first[..., 1] - second[..., 1])
    either = padded(either, _size(first) + _size(second))
    return np.where(yes[..., None], first, np.where(no[..., None], second, either))


def as_form(a: Value) -> Form:
    """Return a number as a form."""
    return np.array([[a, 0.0]]) if isinstance(a, float) else a
