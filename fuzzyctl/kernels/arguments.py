"""What callers may hand to a kernel: anything that is real numbers, and nothing else."""

from __future__ import annotations

from numbers import Real
from typing import TYPE_CHECKING, Any

from fuzzyctl.errors import ArgumentError, ValueOutOfBoundsError

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]


def overflows(value: Any) -> bool:
    """Return whether a number is too large for a float."""
    try:
        if isinstance(value, Real):
            float(value)
    except OverflowError:
        return True
    return False


def writable(array: FloatArray) -> FloatArray:
    """Return an array as compiled code takes it: it declares arrays that could be written to, though it only reads."""
    import numpy as np

    return np.require(array, requirements=["C", "W"])


def number_array(values: Any, what: str) -> Any:
    """Return an array of numbers of any type, as it is: what is large is converted block by block.

    Raises:
        ArgumentError: For what is no array of real numbers.
    """
    import numpy as np

    if isinstance(values, np.ndarray) and values.dtype.kind in "biuf" and not isinstance(values, np.ma.MaskedArray):
        return values
    return float_array(values, what)


def float_array(values: Any, what: str) -> FloatArray:
    """Return an array of floats.

    Raises:
        ArgumentError: For what is no array of real numbers.
        ValueOutOfBoundsError: For numbers beyond the range of floats.
    """
    import numpy as np

    try:
        if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
            raise ArgumentError(f"{what} has masked entries; fill them first")
        array = np.asarray(values)
        if array.dtype.kind not in "biuf":
            # Texts, complex numbers and None would be turned into floats without a word; Fractions may be.
            kinds = all(isinstance(v, Real) for v in array.flat) if array.dtype.kind == "O" else False
            if not kinds:
                raise ArgumentError(f"{what} must be an array of real numbers, got {array.dtype}")
        return np.asarray(array, dtype=np.float64)
    except OverflowError:
        raise ValueOutOfBoundsError(what, type(values), "within the range of floats") from None
    except ArgumentError:
        raise
    except (TypeError, ValueError) as error:
        raise ArgumentError(f"{what} must be an array of real numbers: {error}") from None
