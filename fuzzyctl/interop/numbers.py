"""Numbers that a call is given: real and finite, or an error with the name and the value."""

from __future__ import annotations

from typing import Any

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ValueOutOfBoundsError


def real(name: str, values: Any) -> np.ndarray[Any, Any]:
    """Return real, finite numbers as an array.

    Args:
        name: Their name in messages.
        values: The numbers, of any shape; complex ones without an imaginary part count as real.

    Raises:
        ValueOutOfBoundsError: For anything else.
    """
    try:
        array = np.asarray(values)
        if array.dtype.kind in "US" or (np.iscomplexobj(array) and array.imag.any()):
            raise ValueOutOfBoundsError(name, values, "real")
        array = array.real.astype(np.float64)
    except (TypeError, ValueError) as error:
        if isinstance(error, ValueOutOfBoundsError):
            raise
        raise ValueOutOfBoundsError(name, values, "real") from None
    if not np.isfinite(array).all():
        raise ValueOutOfBoundsError(name, values, "finite")
    return array


def number(name: str, value: Any, unit: str = "") -> float:
    """Return one real, finite number.

    Raises:
        ValueOutOfBoundsError: For anything else.
    """
    if isinstance(value, bool) or np.ndim(value) != 0:
        raise ValueOutOfBoundsError(name, value, "a number", unit)
    return float(real(name, value))


def positive(name: str, value: Any, unit: str = "") -> float:
    """Return a finite number above 0.

    Raises:
        ValueOutOfBoundsError: For anything else.
    """
    if not number(name, value, unit) > 0.0:
        raise ValueOutOfBoundsError(name, value, "> 0", unit)
    return float(value)


def count(name: str, value: Any) -> int:
    """Return a positive integer.

    Raises:
        ValueOutOfBoundsError: For anything else.
    """
    if not (type(value) is int and value >= 1):
        raise ValueOutOfBoundsError(name, value, "a positive integer")
    return value


def span(name: str, ends: Any) -> tuple[float, float]:
    """Return the ends of a range.

    Raises:
        ValueOutOfBoundsError: For other than two finite numbers in order.
    """
    pair = real(name, ends)
    if pair.shape != (2,) or pair[0] > pair[1]:
        raise ValueOutOfBoundsError(name, ends, "two numbers, the smaller one first")
    return float(pair[0]), float(pair[1])


def numbers(values: Any) -> np.ndarray[Any, Any] | None:
    """Return real numbers, NaN and infinite ones included, as an array; None for anything else."""
    try:
        array = np.asarray(values)
        return None if np.iscomplexobj(array) else array.astype(np.float64)
    except (TypeError, ValueError):
        return None
