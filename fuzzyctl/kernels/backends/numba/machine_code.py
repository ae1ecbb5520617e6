"""Machine code of kernels: loops over points without the lock of the interpreter, and values for compiled code.

Systems that differ in numbers only share machine code, which takes the numbers as a last argument. A value binds its
own numbers to that code: a function of two instructions, which LLVM makes in a millisecond.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from itertools import count
from threading import RLock
from typing import TYPE_CHECKING, Any, Final

import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir
from numba.core import types

from fuzzyctl.kernels.backends.numba import source as numba_backend
from fuzzyctl.kernels.backends.numba.source import Numbers, batch_source, compile_source, sequence_source
from fuzzyctl.kernels.program.program import Program

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]


#: Numbers of values, and the tables that their code reads.
_NAMED: Final = count(1)
_KEPT: Final[list[Any]] = []


class Value(types.WrapperAddressProtocol):
    """A function as a value for compiled code: typed by its signature, so that the code is the same for all of them.

    Args:
        function: Machine code whose last argument is the table.
        table: The table.
        plain: The same function for calls from Python.
        origin: The object whose attribute it is, and the name of the attribute, from which other processes get it.
    """

    def __init__(self, function: Any, table: FloatArray, plain: Callable[..., Any], origin: tuple[object, str]) -> None:
        self._plain, self._origin = plain, origin
        (result,) = function.overloads.values()
        *arguments, _ = result.signature.args
        self._signature = result.signature.return_type(*arguments)
        name = f"value{next(_NAMED)}"
        code = _code(result, self._signature, address_of(function), table.ctypes.data, name)
        # Compiled code may keep the address longer than anyone keeps this object: so does a list of values.
        self._address = _loaded(code, name)
        _KEPT.append(table)

    def __reduce__(self) -> tuple[Any, ...]:
        """A value in another process is made anew there."""
        return getattr, self._origin

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
    context = result.target_context
    outer, inner = (context.get_value_type(types.FunctionType(s).ftype) for s in (signature, result.signature))
    module = ir.Module()
    outer_function = ir.Function(module, outer.pointee, name)
    builder = ir.IRBuilder(outer_function.append_basic_block())
    target = builder.inttoptr(ir.Constant(ir.IntType(64), address), inner)
    last = builder.inttoptr(ir.Constant(ir.IntType(64), table), inner.pointee.args[-1])
    builder.ret(builder.call(target, [*outer_function.args, last]))
    return str(module)


#: One thread at a time adds machine code, and the handler of a signal that interrupts it.
_LOADING: Final = RLock()


def _loaded(code: str, name: str) -> int:
    """Compile code written for LLVM, and return the address of its function, which stays for ever.

    All of it goes to one engine: one for each function would take three quarters of a megabyte.
    """
    with _LOADING:
        engine = _engine()
        engine.add_module(llvm.parse_assembly(code))
        engine.finalize_object()
        return int(engine.get_function_address(name))


@cache
def _engine() -> Any:
    llvm.initialize_native_target()  # numba does so, too, once it compiles something
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine(opt=2)
    return llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)


def value(program: Program, plain: Callable[..., Any], origin: tuple[object, str]) -> Value:
    """Return the function (x0, ..., C) of a program as a value; see `Value`."""
    return _value(program, numba_backend.evaluation_source, plain, origin)


def storing_value(program: Program, plain: Callable[..., Any], origin: tuple[object, str]) -> Value:
    """Return the function (x0, ..., C, result) of a program as a value; see `Value`."""
    return _value(program, numba_backend.storing_source, plain, origin)


def _value(
    program: Program, source: Callable[[Program, Numbers], str], plain: Callable[..., Any], origin: tuple[object, str]
) -> Value:
    numbers = Numbers(program)
    function = numba_backend.compile_source(source(program, numbers))
    return Value(function, np.array(numbers.values, dtype=np.float64), plain, origin)


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
        address = None if states is None else states.ctypes.data
        status: int = self._c(points.ctypes.data, address, results.ctypes.data, None, len(results))
        return status


def loop(program: Program) -> Loop:
    """Return the loop that computes a program at many points."""
    return Loop(compile_source(batch_source(program)))


def sequence(program: Program, outputs: int) -> Loop:
    """Return the loop that computes a program along time; its states are one row, which each point changes."""
    return Loop(compile_source(sequence_source(program, outputs)))
