"""Calls from Python straight into machine code: a C function of CPython around what numba has compiled.

numba's own way into a function looks at the type of each argument, packs the arguments, and gives up and takes back the
lock of the interpreter; that costs more than evaluating most systems. Here a few instructions, written for LLVM and
compiled in two milliseconds, look whether all arguments are floats, take their values out, and call the function by the
address that numba keeps for callers in C. Anything else, NaN as a result included, goes to a function in Python.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any, Final

import llvmlite.binding as llvm

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

#: Where CPython keeps the type of an object, and the value of a float, in bytes from the object's beginning.
_TYPE, _VALUE = 8, 16
#: The calling convention `METH_FASTCALL`: (self, arguments, their number).
_FASTCALL: Final = 0x0080

_CODE: Final = """
define i8* @call(i8* %own, i8** %given, i64 %count) {{
start:
  %right = icmp eq i64 %count, {count}
  br i1 %right, label %type0, label %careful
{typed}
type{count}:
  %f = inttoptr i64 {function} to double ({doubles}, double*)*
  %table = inttoptr i64 {table} to double*
  %y = call double %f({values}, double* %table)
  %known = fcmp ord double %y, %y
  br i1 %known, label %done, label %careful
done:
  %new = inttoptr i64 {new} to i8* (double)*
  %result = call i8* %new(double %y)
  ret i8* %result
careful:
  %python = inttoptr i64 {python} to i8* (i8*, i8**, i64, i8*)*
  %other = call i8* %python(i8* %own, i8** %given, i64 %count, i8* null)
  ret i8* %other
}}
"""

_TYPED: Final = """
type{k}:
  %place{k} = getelementptr i8*, i8** %given, i64 {k}
  %object{k} = load i8*, i8** %place{k}
  %kind{k} = getelementptr i8, i8* %object{k}, i64 {type}
  %kind_at{k} = bitcast i8* %kind{k} to i64*
  %is{k} = load i64, i64* %kind_at{k}
  %float{k} = icmp eq i64 %is{k}, {float}
  %value{k} = getelementptr i8, i8* %object{k}, i64 {value}
  %value_at{k} = bitcast i8* %value{k} to double*
  br i1 %float{k}, label %take{k}, label %careful
take{k}:
  %x{k} = load double, double* %value_at{k}
  br label %type{next}
"""


class _MethodDefinition(ctypes.Structure):
    """CPython's PyMethodDef."""

    _fields_ = [
        ("name", ctypes.c_char_p),
        ("function", ctypes.c_void_p),
        ("flags", ctypes.c_int),
        ("doc", ctypes.c_char_p),
    ]


def direct_call(
    function: Any, inputs: int, table: FloatArray, careful: Callable[..., Any]
) -> Callable[..., Any] | None:
    """Return a C function that takes real numbers and gives what compiled code computes of them.

    Args:
        function: A function compiled by numba for one signature, float64(float64, ..., CPointer(float64)), that raises
            nothing.
        inputs: The number of its arguments but the last.
        table: What its last argument points to.
        careful: Called instead for anything but floats, and where the result is NaN.

    Returns:
        The function; None where objects are laid out otherwise than in the usual build of CPython.
    """
    if not _layout_is_known():
        return None
    address = address_of(function)
    if not address:
        return None
    made: Callable[..., Any] = _new_function(ctypes.byref(_definition(address, inputs, table)), careful, None)
    return made


def address_of(function: Any) -> int:
    """Return where the code of a function compiled by numba for one signature begins, for callers in C."""
    (compiled,) = function.overloads.values()
    return int(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name))


def loaded(code: str) -> Any:
    """Return machine code written for LLVM, compiled in this process."""
    machine = llvm.Target.from_default_triple().create_target_machine(opt=2)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(code), machine)
    engine.finalize_object()
    return engine


@cache
def _layout_is_known() -> bool:
    """Return whether type and value of a float stand where they are looked for."""
    if sys.implementation.name != "cpython" or ctypes.sizeof(ctypes.c_void_p) != 8:
        return False
    sample = 0.1 + len(sys.version)
    if type(sample).__basicsize__ != _VALUE + 8:
        return False
    kind = ctypes.c_int64.from_address(id(sample) + _TYPE).value
    return kind == id(float) and ctypes.c_double.from_address(id(sample) + _VALUE).value == sample


#: Code and its definition, kept for ever: CPython reads a definition even while it takes a function down. So does numba
#: keep what it has compiled.
_KEPT: Final[list[Any]] = []


def _definition(address: int, inputs: int, table: FloatArray) -> _MethodDefinition:
    """Compile the code around the function at an address."""
    engine = loaded(_code(address, inputs, table.ctypes.data))
    definition = _MethodDefinition(b"kernel", engine.get_function_address("call"), _FASTCALL, None)
    _KEPT.append((engine, definition, table))
    return definition


def _code(address: int, inputs: int, table: int) -> str:
    typed = (_TYPED.format(k=k, next=k + 1, type=_TYPE, value=_VALUE, float=id(float)) for k in range(inputs))
    return _CODE.format(
        count=inputs,
        typed="".join(typed),
        function=address,
        table=table,
        doubles=", ".join(["double"] * inputs),
        values=", ".join(f"double %x{k}" for k in range(inputs)),
        new=_address(ctypes.pythonapi.PyFloat_FromDouble),
        python=_address(ctypes.pythonapi.PyObject_Vectorcall),
    )


def _address(function: Any) -> int:
    found = ctypes.cast(function, ctypes.c_void_p).value
    assert found is not None
    return found


_new_function: Final = ctypes.pythonapi.PyCFunction_NewEx
_new_function.argtypes = [ctypes.c_void_p, ctypes.py_object, ctypes.c_void_p]
_new_function.restype = ctypes.py_object
