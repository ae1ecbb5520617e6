"""Machine code for a system: what numba made of its structure, and its numbers in a table.

Systems that differ in numbers only share code, so that a sweep over a param compiles no more than twice.
"""

from __future__ import annotations

import ctypes
import hashlib
from collections.abc import Callable
from itertools import count
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numba.core import types

from fuzzyctl.kernels.backends.numba import source as numba_backend
from fuzzyctl.kernels.backends.numba import vectorcall as entry
from fuzzyctl.kernels.backends.numba.parameters import Numbers
from fuzzyctl.kernels.program.program import Program

if TYPE_CHECKING:
    import numpy.typing as npt

    from fuzzyctl.kernels.kernel import Kernel

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


def _with_pointer(program: Program, numbers: Numbers) -> str:
    return numba_backend.evaluation_source(program, numbers, pointer=True)


def _storing_with_pointer(program: Program, numbers: Numbers) -> str:
    return numba_backend.storing_source(program, numbers, pointer=True)


def call(program: Program) -> Callable[..., Any]:
    """Return a function (x0, ..., C) to be called from Python."""
    function, table = compiled(program, numba_backend.evaluation_source)

    def kernel(*arguments: Any) -> Any:
        return function(*arguments, table)

    return kernel


class Loop:
    """Machine code that fills the results of many points, called without the lock of the interpreter.

    Args:
        function: Compiled code of `numba_backend.batch_source`.
        table: Its numbers.
    """

    def __init__(self, function: Any, table: FloatArray) -> None:
        self.function, self.table = function, table
        kinds = [ctypes.c_void_p] * 4
        self._c = ctypes.CFUNCTYPE(ctypes.c_int64, *kinds, ctypes.c_int64)(entry.address_of(function))

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


class Point:
    """Machine code of a program that takes numbers and gives one, and raises nothing."""

    def __init__(self, program: Program) -> None:
        self.function, self.table = compiled(program, _with_pointer)
        self.inputs = len(program.arguments)
        kinds = [ctypes.c_double] * self.inputs
        self._c = ctypes.CFUNCTYPE(ctypes.c_double, *kinds, ctypes.c_void_p)(entry.address_of(self.function))

    def __call__(self, *arguments: float) -> float:
        """Evaluate at one point.

        Raises:
            TypeError: For anything but floats, or another number of them.
        """
        if len(arguments) != self.inputs or not all(isinstance(a, float) for a in arguments):
            raise TypeError(f"takes {self.inputs} floats")
        value: float = self._c(*arguments, self.table.ctypes.data)
        return value

    def direct(self, careful: Callable[..., Any]) -> Callable[..., Any] | None:
        """Return a C function for calls from Python, see `entry.direct_call`."""
        return entry.direct_call(self.function, self.inputs, self.table, careful)


#: Numbers of values, and the tables that their code reads.
_NAMED: Final = count(1)
_KEPT: Final[list[Any]] = []


class Value(types.WrapperAddressProtocol):
    """A function as a value for compiled code: typed by its signature, so that the code is the same for all of them.

    Args:
        function: Machine code whose last argument is the table.
        table: The table.
        kernel: Whose function it is.
        name: By which the kernel has it.
        plain: What computes the same when called from Python.
    """

    def __init__(self, function: Any, table: FloatArray, kernel: Kernel, name: str, plain: Callable[..., Any]) -> None:
        self._kernel, self._name, self._plain = kernel, name, plain
        (result,) = function.overloads.values()
        *arguments, _ = result.signature.args
        self._signature = result.signature.return_type(*arguments)
        own = f"value{next(_NAMED)}"
        code = _code(result, self._signature, entry.address_of(function), table.ctypes.data, own)
        # Compiled code may keep the address longer than anyone keeps this object: so does a list of values.
        (self._address,) = entry.loaded(code, own)
        _KEPT.append(table)

    def __reduce__(self) -> tuple[Any, ...]:
        """A value in another process is made anew there."""
        return getattr, (self._kernel, self._name)

    def __call__(self, *arguments: Any) -> Any:
        """Call it from Python."""
        return self._plain(*arguments)

    def __wrapper_address__(self) -> int:
        """Return where its code begins; what numba asks of functions that are values."""
        return self._address

    def signature(self) -> Any:
        """Return its signature, without the table."""
        return self._signature


def _code(result: Any, signature: Any, address: int, table: int, name: str) -> str:
    """Return code for LLVM that calls the function at an address with its own arguments and the table."""
    from llvmlite import ir

    context = result.target_context
    outer, inner = (context.get_value_type(types.FunctionType(s).ftype) for s in (signature, result.signature))
    module = ir.Module()
    own = ir.Function(module, outer.pointee, name)
    builder = ir.IRBuilder(own.append_basic_block())
    target = builder.inttoptr(ir.Constant(ir.IntType(64), address), inner)
    last = builder.inttoptr(ir.Constant(ir.IntType(64), table), inner.pointee.args[-1])
    builder.ret(builder.call(target, [*own.args, last]))
    return str(module)


def value(program: Program, kernel: Kernel) -> Value:
    """Return the function (x0, ..., C) of a kernel as a value."""
    function, table = compiled(program, _with_pointer, shared=True)
    return Value(function, table, kernel, "value", kernel)


def rates_value(program: Program, kernel: Kernel) -> Value:
    """Return the function (x0, ..., C, result) of a kernel as a value."""
    function, table = compiled(program, _storing_with_pointer, shared=True)
    return Value(function, table, kernel, "rates_value", lambda *arguments: kernel.jit_rates(*arguments))
