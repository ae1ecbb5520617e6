"""Functions of arrays under numpy's names."""

from __future__ import annotations

import math
import operator
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import repeat
from math import inf, nan
from typing import Any, Final

from fuzzyctl.studio.arrays.array import (
    asarray,
    broadcast_arrays,
    folded,
    larger,
    ndarray,
    smaller,
)

float64, bool_, newaxis = float, bool, None
ascontiguousarray = asarray


def full(shape: Any, value: Any) -> ndarray:
    """Return an array of one number."""
    sizes = (shape,) if isinstance(shape, int) else tuple(shape)
    return ndarray([value] * math.prod(sizes), sizes)


def zeros(shape: Any) -> ndarray:
    """Return an array of 0."""
    return full(shape, 0.0)


def zeros_like(a: Any) -> ndarray:
    """Return an array of 0 of the same shape and kind."""
    like = asarray(a)
    return full(like.shape, False if isinstance(next(iter(like.items), None), bool) else 0.0)


def arange(count: int) -> ndarray:
    """Return the numbers from 0 on."""
    return ndarray(list(range(count)), (count,))


def squeeze(a: Any, axis: int) -> ndarray:
    """Return an array without an axis of length 1."""
    source = asarray(a)
    axis %= len(source.shape)
    return ndarray(source.items, source.shape[:axis] + source.shape[axis + 1 :])


def concatenate(arrays: Sequence[Any]) -> ndarray:
    """Return arrays one after the other along their first axis."""
    parts = [asarray(a) for a in arrays]
    return ndarray([x for a in parts for x in a.items], (sum(a.shape[0] for a in parts), *parts[0].shape[1:]))


def hstack(arrays: Sequence[Any]) -> ndarray:
    """Return arrays side by side: along their second axis, or the only one."""
    parts = [asarray(a) for a in arrays]
    return concatenate(parts) if len(parts[0].shape) == 1 else concatenate([a.T for a in parts]).T


# -- element by element


def _each(function: Callable[..., Any]) -> Callable[..., ndarray]:
    """Return a function of numbers as one of arrays."""

    def applied(*arrays: Any) -> ndarray:
        operands = [a if isinstance(a, ndarray) else asarray(a) for a in arrays]
        shape = max((a.shape for a in operands), key=len)
        if not all(a.shape == shape or not a.shape for a in operands):
            operands = list(broadcast_arrays(*operands))
            shape = operands[0].shape
        columns = [a.items if a.shape == shape else repeat(a.items[0]) for a in operands]
        return ndarray(list(map(function, *columns)), shape)

    return applied


def _over(function: Callable[..., float], beyond: float) -> Callable[..., float]:
    """Return a function of the C library with what it gives where it has no number: infinite, or NaN."""

    def applied(*x: float) -> float:
        try:
            return function(*x)
        except OverflowError:
            return beyond
        except ValueError:
            return nan

    return applied


def _quotient(x: float, y: float) -> float:
    if y:
        return x / y
    return nan if x != x or y != y or not x else math.copysign(inf, x) * math.copysign(1.0, y)


def _power(x: float, y: float) -> float:
    if y == 2.0:
        return x * x
    try:
        return math.pow(x, y)
    except OverflowError:
        return -inf if x < 0.0 and y % 2.0 == 1.0 else inf
    except ValueError:  # 0 to a negative power, or a root of a negative number
        return nan if x else math.copysign(inf, x) if y % 2.0 == 1.0 else inf


_exp, _expm1, _sqrt = (_over(f, inf) for f in (math.exp, math.expm1, math.sqrt))


class _Ufunc:
    """A function of two arrays, which can be folded along the first axis of one."""

    def __init__(self, function: Callable[[Any, Any], Any]) -> None:
        self._function, self._applied = function, _each(function)

    def __call__(self, a: Any, b: Any) -> ndarray:
        return self._applied(a, b)

    def reduce(self, a: Any) -> Any:
        """Return the function of all elements along the first axis."""
        return asarray(a).reduced(folded(self._function), 0)


add, subtract, multiply, divide = map(_Ufunc, (operator.add, operator.sub, operator.mul, _quotient))
minimum, maximum, logical_or = map(_Ufunc, (smaller, larger, lambda x, y: bool(x or y)))
fmin = _each(lambda x, y: y if x != x else x if y != y else smaller(x, y))
fmax = _each(lambda x, y: y if x != x else x if y != y else larger(x, y))
where = _each(lambda c, x, y: x if c else y)
clip = _each(lambda x, low, high: smaller(larger(x, low), high))
sign = _each(lambda x: nan if x != x else float((x > 0.0) - (x < 0.0)))
isnan, isfinite, isinf = map(_each, (math.isnan, math.isfinite, math.isinf))
isposinf, isneginf = _each(lambda x: x == inf), _each(lambda x: x == -inf)
nextafter = _each(math.nextafter)
exp, expm1, sqrt = map(_each, (_exp, _expm1, _sqrt))

_OPERATORS: Final[dict[str, Callable[[Any, Any], Any]]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "truediv": _quotient,
    "pow": _power,
    "and": operator.and_,
    "or": operator.or_,
}
for _name, _function in _OPERATORS.items():
    _applied = _each(_function)
    setattr(ndarray, f"__{_name}__", _applied)
    setattr(ndarray, f"__r{_name}__", lambda a, b, _applied=_applied: _applied(b, a))
for _name in ("lt", "le", "gt", "ge", "eq", "ne"):
    setattr(ndarray, f"__{_name}__", _each(getattr(operator, _name)))
for _name, _single in (("neg", operator.neg), ("abs", operator.abs), ("invert", operator.not_)):
    setattr(ndarray, f"__{_name}__", _each(_single))
ndarray.__hash__ = None  # type: ignore[assignment]  # as numpy's


# -- of whole arrays


def flatnonzero(a: Any) -> ndarray:
    """Return the places of the elements that are true."""
    places = [k for k, x in enumerate(asarray(a).items) if x]
    return ndarray(places, (len(places),))


def argsort(a: Any, kind: str = "stable") -> ndarray:
    """Return the places of the elements in order, of equal ones in theirs; NaN is last."""
    items = asarray(a).items
    return ndarray(sorted(range(len(items)), key=lambda k: (items[k] != items[k], items[k])), (len(items),))


def searchsorted(a: Any, values: Any) -> ndarray:
    """Return before which elements of a sorted array values belong."""
    return _each(lambda x: bisect_left(a.items, x))(values)


def diff(a: Any) -> Any:
    """Return the differences of neighbouring elements."""
    return a[1:] - a[:-1]


def append(a: Any, value: float) -> ndarray:
    """Return an array with a number behind it."""
    return concatenate([a, [value]])


def interp(x: Any, xp: Any, fp: Any) -> ndarray:
    """Return straight lines between points at some places, before and after them the ends."""
    at, values = asarray(xp).items, asarray(fp).items

    def value(x: float) -> Any:
        if x != x:
            return x
        k = bisect_right(at, x) - 1
        if k < 0 or k == len(at) - 1:
            return values[max(k, 0)]
        slope = (values[k + 1] - values[k]) / (at[k + 1] - at[k])
        return slope * (x - at[k]) + values[k]

    return _each(value)(x)


def dot(a: Any, b: Any) -> float:
    """Return the sum of products."""
    return float(sum(map(operator.mul, asarray(a).items, asarray(b).items)))


def quantile(a: Any, parts: Sequence[float]) -> ndarray:
    """Return the values below which parts of the elements lie, on straight lines between elements."""
    items = sorted(asarray(a).items)

    def value(part: float) -> Any:
        place = part * (len(items) - 1)
        low, high = items[int(place)], items[min(int(place) + 1, len(items) - 1)]
        rest = place - int(place)
        return low + (high - low) * rest if rest < 0.5 else high - (high - low) * (1.0 - rest)

    return ndarray(list(map(value, parts)), (len(parts),))


def median(a: Any) -> Any:
    """Return the middle element, or the mean of the two middle ones."""
    return quantile(a, [0.5])[0]


def nanargmax(a: Any) -> Any:
    """Return the place of the first largest element that is a number."""
    items = asarray(a).items
    return max((k for k, x in enumerate(items) if x == x), key=lambda k: items[k])


def prod(a: Any, axis: int | None = None) -> Any:
    """Return the product of the elements."""
    return asarray(a).reduced(lambda row: math.prod(row, start=1.0), axis)


def argmax(a: Any) -> Any:
    """Return the place of the first largest element."""
    return asarray(a).argmax()


def mean(a: Any) -> float:
    """Return the mean of all elements."""
    return asarray(a).mean()


@contextmanager
def errstate(**_: str) -> Iterator[None]:
    """Do nothing: arithmetic here never warns."""
    yield


#: Functions that are called as Python's own are.
LIKE_PYTHON: Final[dict[str, Callable[..., Any]]] = {
    "all": lambda a: asarray(a).all(),
    "any": lambda a: asarray(a).any(),
    "max": lambda a: asarray(a).max(),
    "min": lambda a: asarray(a).min(),
    "abs": _each(operator.abs),
}
