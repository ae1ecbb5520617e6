"""Machine code for a system: what numba made of its structure, and its numbers in a table.

Systems that differ in numbers only share code, so that a sweep over a param compiles no more than twice.
"""

from __future__ import annotations

import ctypes
import hashlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from fuzzyctl.kernels.backends.numba import source as numba_backend
from fuzzyctl.kernels.backends.numba.parameters import Numbers
from fuzzyctl.kernels.program.program import Program

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

    Source = Callable[[Program, Numbers], str]


#: The numbers of the first system of each structure in this process, by the digest of the code that they share.
_FIRST: Final[dict[bytes, tuple[float, ...]]] = {}


def compiled(program: Program, source: Source, *, shared: bool = False) -> tuple[Any, FloatArray]:
    """Return a compiled function and the table that is its last argument.

    The first system of its structure has code of its own, which is faster in batches of little arithmetic, where the
    numbers no longer fit into registers; all further ones share code, so that the next number costs nothing.

    Args:
        program: What it computes.
        source: What prints it.
        shared: Whether the first one is to share code, too.
    """
    numbers = Numbers(program)
    text = source(program, numbers)
    values = tuple(numbers.values)
    structure = hashlib.sha256(text.encode()).digest()
    if not shared and _FIRST.setdefault(structure, values) == values:
        text = source(program, Numbers(program, inside=True))
    return numba_backend.compile_source(text), np.array(values, dtype=np.float64)


def address_of(function: Any) -> int:
    """Return where the code of a function compiled by numba for one signature begins, for callers in C."""
    (compiled,) = function.overloads.values()
    return int(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name))


class Loop:
    """Machine code that fills the results of many points, called without the lock of the interpreter.

    Args:
        function: Compiled code of `numba_backend.batch_source`.
        table: Its numbers.
    """

    def __init__(self, function: Any, table: FloatArray) -> None:
        self.function, self.table = function, table
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
        found: int = self._c(points.ctypes.data, given, results.ctypes.data, self.table.ctypes.data, len(results))
        return found


def loop(program: Program) -> Loop:
    """Return the loop that computes a program at many points."""
    return Loop(*compiled(program, numba_backend.batch_source))
