"""Kernels as values for compiled code: typed by their signature, so that code that takes them is compiled once.

Systems that differ in numbers only share machine code, which takes the numbers as a last argument. A value binds its
own numbers to that code: a function of two instructions, which LLVM makes in a millisecond.
"""

from __future__ import annotations

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
from fuzzyctl.kernels.backends.numba.batch_loop import address_of
from fuzzyctl.kernels.backends.numba.parameters import Numbers
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
        plain: What computes the same when called from Python.
        origin: The object whose attribute it is, and the name of the attribute, from which other processes get it.
    """

    def __init__(self, function: Any, table: FloatArray, plain: Callable[..., Any], origin: tuple[object, str]) -> None:
        self._plain, self._origin = plain, origin
        (result,) = function.overloads.values()
        *arguments, _ = result.signature.args
        self._signature = result.signature.return_type(*arguments)
        own = f"value{next(_NAMED)}"
        code = _code(result, self._signature, address_of(function), table.ctypes.data, own)
        # Compiled code may keep the address longer than anyone keeps this object: so does a list of values.
        self._address = _loaded(code, own)
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
    own = ir.Function(module, outer.pointee, name)
    builder = ir.IRBuilder(own.append_basic_block())
    target = builder.inttoptr(ir.Constant(ir.IntType(64), address), inner)
    last = builder.inttoptr(ir.Constant(ir.IntType(64), table), inner.pointee.args[-1])
    builder.ret(builder.call(target, [*own.args, last]))
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
