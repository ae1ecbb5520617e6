"""Calls at one point with as little as possible around the function itself.

A call that goes through a method of all kernels costs as much as the function: its arguments are packed, attributes are
looked up, and the interpreter cannot specialise code that calls now this function, now that. So each kernel whose call
needs no preparation gets a class of its own, whose `__call__` is its function.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzyctl.kernels.backends.python import backend as python_backend

if TYPE_CHECKING:
    from fuzzyctl.kernels.kernel import Kernel
    from fuzzyctl.kernels.program.program import Program


def specialised(kernel: Kernel, program: Program) -> type[Kernel]:
    """Return a class for one kernel of generated Python whose result is one number and whose inputs are all it takes.

    Args:
        kernel: The kernel; its own class's `__call__` takes the arguments where something is unusual.
        program: What it computes.
    """
    general = type(kernel)
    call = python_backend.compile_call(program)
    return type(general.__name__, (general,), {"__call__": call, "__doc__": general.__doc__})
