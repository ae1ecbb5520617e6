"""Compile what runs inside the loop with numba; where numba is missing, the same source runs as plain Python.

The only module of dwmr that knows numba. Compiled code is cached on disk between processes.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

try:
    import numba
except ImportError:  # a platform without a wheel: about a hundred times slower, and `dwmr run` says so
    numba = None

Function = TypeVar("Function", bound=Callable[..., Any])

COMPILED: bool = numba is not None


@contextmanager
def first_class_functions() -> Iterator[None]:
    """Silence numba's note that functions as values are experimental, and nothing else."""
    with warnings.catch_warnings():
        if numba is not None:
            warnings.simplefilter("ignore", numba.core.errors.NumbaExperimentalFeatureWarning)
        yield


def compiled(function: Function) -> Function:
    """Compile a function for use inside the loop, at its first call."""
    if numba is None:
        return function
    result: Function = numba.njit(cache=True, error_model="numpy")(function)
    return result


def compiled_as(signature: Callable[[Any], Any]) -> Callable[[Function], Function]:
    """Compile a function at once and to one signature, so that it can be handed to the loop as a value.

    Args:
        signature: Makes the signature out of `numba.types`; not called without numba.
    """

    def decorate(function: Function) -> Function:
        if numba is None:
            return function
        with first_class_functions():
            result: Function = numba.njit(signature(numba.types), cache=True, error_model="numpy")(function)
        return result

    return decorate


def function_type(signature: str) -> Any:
    """Return the type of a compiled function that is handed over as a value.

    Args:
        signature: As numba writes it, such as "float64(float64, float64)".
    """
    arguments, returned = numba.core.sigutils.normalize_signature(signature)
    return numba.types.FunctionType(returned(*arguments))


def first_class(function: Any) -> Any:
    """Return a function as a value the loop can be given: typed by its signature, not by its identity.

    The loop therefore stays the same machine code, whichever rule file or control law it is called with.

    Args:
        function: A dispatcher with exactly one eager signature, or a plain function.
    """
    if not hasattr(function, "overloads"):
        return function
    (overload,) = function.overloads.values()
    return numba.types.CompileResultWAP(overload)
