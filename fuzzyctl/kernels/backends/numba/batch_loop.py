"""Compiled loops over points, called without the lock of the interpreter."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

from fuzzyctl.kernels.backends.numba.source import batch_source, compile_source, sequence_source
from fuzzyctl.kernels.program.program import Program

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]


def address_of(function: Any) -> int:
    """Return where the code of a function compiled by numba for one signature begins, for callers in C."""
    (compiled,) = function.overloads.values()
    return int(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name))


class Loop:
    """Machine code that fills the results of many points, called without the lock of the interpreter.

    Args:
        function: Compiled code of `batch_source`.
    """

    def __init__(self, function: Any) -> None:
        self.function = function
        kinds = [ctypes.c_void_p] * 4
        self._c = ctypes.CFUNCTYPE(ctypes.c_int64, *kinds, ctypes.c_int64)(address_of(function))

    def __call__(self, points: FloatArray, states: FloatArray | None, results: FloatArray) -> int:
        """Fill the results.

        Args:
            points: Shape (n, inputs), contiguous and aligned, as the others are.
            states: Shape (n, states); None without a state.
            results: Shape (n, outputs).

        Returns:
            -1; or the number of kinds of refusals · the first point that was refused + the kind.
        """
        given = None if states is None else states.ctypes.data
        found: int = self._c(points.ctypes.data, given, results.ctypes.data, None, len(results))
        return found


def loop(program: Program) -> Loop:
    """Return the loop that computes a program at many points."""
    return Loop(compile_source(batch_source(program)))


def sequence(program: Program, outputs: int) -> Loop:
    """Return the loop that computes a program along time; its states are one row, which each point changes."""
    return Loop(compile_source(sequence_source(program, outputs)))
