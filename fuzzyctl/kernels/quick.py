"""Calls at one point with as little as possible around the function itself.

A call that goes through a method of all kernels costs as much as the function: its arguments are packed, attributes are
looked up, and the interpreter cannot specialise code that calls now this function, now that. So each kernel whose call
needs no preparation gets a class of its own, whose `__call__` knows its function and its number of arguments.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

#: Stands for an argument that is not given.
_MISSING: Final[Any] = object()

#: What a function raises for arguments it does not take, and where no rule fires; found and named by the careful way.
_REFUSALS: Final = (TypeError, ValueError, ArithmeticError)

Call = Callable[..., Any]


def specialised(kernel_class: type, function: Call, inputs: int) -> type:
    """Return a class of kernels that call one function, whose result is one number.

    Args:
        kernel_class: The class of all kernels; its `_careful` takes the arguments where something is unusual.
        function: Takes the inputs.
        inputs: Their number.
    """
    make = {1: _one, 2: _two, 3: _three}.get(inputs, _any)
    return type(
        kernel_class.__name__, (kernel_class,), {"__call__": make(function, inputs), "__doc__": kernel_class.__doc__}
    )


def _given(*arguments: Any) -> tuple[Any, ...]:
    return tuple(a for a in arguments if a is not _MISSING)


def _one(function: Call, inputs: int) -> Call:
    def call(self: Any, x: Any = _MISSING, /, *more: Any) -> Any:
        if not more:
            try:
                result = function(x)
                if result == result:
                    return result
            except _REFUSALS:
                pass
        return self._careful(_given(x, *more))

    return call


def _two(function: Call, inputs: int) -> Call:
    def call(self: Any, x: Any = _MISSING, y: Any = _MISSING, /, *more: Any) -> Any:
        if not more:
            try:
                result = function(x, y)
                if result == result:
                    return result
            except _REFUSALS:
                pass
        return self._careful(_given(x, y, *more))

    return call


def _three(function: Call, inputs: int) -> Call:
    def call(self: Any, x: Any = _MISSING, y: Any = _MISSING, z: Any = _MISSING, /, *more: Any) -> Any:
        if not more:
            try:
                result = function(x, y, z)
                if result == result:
                    return result
            except _REFUSALS:
                pass
        return self._careful(_given(x, y, z, *more))

    return call


def _any(function: Call, inputs: int) -> Call:
    def call(self: Any, *arguments: Any) -> Any:
        if len(arguments) == inputs:
            try:
                result = function(*arguments)
                if result == result:
                    return result
            except _REFUSALS:
                pass
        return self._careful(arguments)

    return call
