"""Calls at one point with as little as possible around the function itself.

A call that goes through a method of all kernels costs as much as the function: its arguments are packed, attributes are
looked up, and the interpreter cannot specialise code that calls now this function, now that. So each kernel whose call
needs no preparation gets a class of its own, whose `__call__` is its function: generated Python, or machine code.
"""

from __future__ import annotations

from collections.abc import Callable
from types import MethodType
from typing import TYPE_CHECKING, Any

from fuzzyctl.kernels.backends.python import backend as python_backend

if TYPE_CHECKING:
    from fuzzyctl.kernels.kernel import Kernel
    from fuzzyctl.kernels.program.program import Program

Call = Callable[..., Any]


def specialised(kernel: Kernel, program: Program) -> type[Kernel]:
    """Return a class for one kernel whose result is one number, and whose inputs are all that it takes.

    Args:
        kernel: The kernel; its own class's `__call__` takes the arguments where something is unusual.
        program: What it computes.
    """
    general = type(kernel)
    if kernel.backend != "numba":
        call: Call = python_backend.compile_call(program)
    elif kernel.raises:  # in a C function nobody would hear of it
        call = _guarded(kernel._function, len(program.arguments))
    else:
        careful = MethodType(general.__call__, kernel)
        call = kernel._function.direct(careful) or _guarded(kernel._function, len(program.arguments))
    return type(general.__name__, (general,), {"__call__": call, "__doc__": general.__doc__})


def _guarded(function: Call, inputs: int) -> Call:
    """Return a method that calls a function, and what is careful where that refuses its arguments or gives NaN."""

    def call(self: Any, *arguments: Any, **named: Any) -> Any:
        if len(arguments) == inputs and not named:
            try:
                result = function(*arguments)
                if result == result:
                    return result
            except python_backend.REFUSALS:
                pass
        return self._careful(arguments, named)

    return call
