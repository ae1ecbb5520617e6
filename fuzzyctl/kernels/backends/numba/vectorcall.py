"""Calls from Python straight into machine code: a C function of CPython around what numba has compiled.

numba's own way into a function looks at the type of each argument, packs the arguments, and gives up and takes back the
lock of the interpreter; that costs more than evaluating most systems. Here a few instructions, written for LLVM, look
whether all arguments are floats, take their values out, and call the function by the address that numba keeps for
callers in C. Anything else, names and NaN as a result included, goes to a function in Python. The instructions are the
same for all kernels of so many inputs: what differs stands in the tuple that is the C function's `self`.
"""

from __future__ import annotations

import ctypes
import struct
import sys
from collections.abc import Callable
from functools import cache
from threading import RLock
from typing import TYPE_CHECKING, Any, Final

import llvmlite.binding as llvm

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

#: Where CPython keeps the type of an object, the value of a float, the first entry of a tuple and the first byte of
#: bytes, from the object's beginning.
_TYPE, _VALUE = 8, 16
_ENTRY, _BYTE = tuple.__basicsize__, bytes.__basicsize__ - 1
#: The calling convention `METH_FASTCALL | METH_KEYWORDS`: (self, arguments, number of those without a name, names).
_FASTCALL: Final = 0x0080 | 0x0002

_CODE: Final = """
define i8* @call{count}(i8* %own, i8** %given, i64 %count, i8* %names) {{
start:
  %right = icmp eq i64 %count, {count}
  %nameless = icmp eq i8* %names, null
  %usual = and i1 %right, %nameless
  br i1 %usual, label %type0, label %careful
{typed}
type{count}:
  %pair_at = getelementptr i8, i8* %own, i64 {second}
  %pair_place = bitcast i8* %pair_at to i8**
  %pair = load i8*, i8** %pair_place
  %f_at = getelementptr i8, i8* %pair, i64 {byte}
  %f_place = bitcast i8* %f_at to double ({doubles}, double*)**
  %f = load double ({doubles}, double*)*, double ({doubles}, double*)** %f_place, align 1
  %table_at = getelementptr i8, i8* %f_at, i64 8
  %table_place = bitcast i8* %table_at to double**
  %table = load double*, double** %table_place, align 1
  %y = call double %f({values}, double* %table)
  %known = fcmp ord double %y, %y
  br i1 %known, label %done, label %careful
done:
  %new = inttoptr i64 {new} to i8* (double)*
  %result = call i8* %new(double %y)
  ret i8* %result
careful:
  %function_at = getelementptr i8, i8* %own, i64 {first}
  %function_place = bitcast i8* %function_at to i8**
  %function = load i8*, i8** %function_place
  %python = inttoptr i64 {python} to i8* (i8*, i8**, i64, i8*)*
  %other = call i8* %python(i8* %function, i8** %given, i64 %count, i8* %names)
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
    # What the machine code reads, and what must last as long as the C function does.
    own = (careful, struct.pack("=qq", address, table.ctypes.data), table)
    made: Callable[..., Any] = _new_function(ctypes.byref(_definition(inputs)), own, None)
    return made


def address_of(function: Any) -> int:
    """Return where the code of a function compiled by numba for one signature begins, for callers in C."""
    (compiled,) = function.overloads.values()
    return int(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name))


#: One thread at a time adds machine code, and the handler of a signal that interrupts it.
_LOADING: Final = RLock()


def loaded(code: str, *names: str) -> tuple[int, ...]:
    """Compile code written for LLVM, and return the addresses of some of its functions, which stay for ever.

    All of it goes to one engine: one for each function would take three quarters of a megabyte.

    Args:
        code: The code; its functions must have names that no other code has.
        names: The functions.
    """
    with _LOADING:
        engine = _engine()
        engine.add_module(llvm.parse_assembly(code))
        engine.finalize_object()
        return tuple(int(engine.get_function_address(name)) for name in names)


@cache
def _engine() -> Any:
    llvm.initialize_native_target()  # numba does so, too, once it compiles something
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine(opt=2)
    return llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)


@cache
def _layout_is_known() -> bool:
    """Return whether type and value of a float stand where they are looked for."""
    if sys.implementation.name != "cpython" or ctypes.sizeof(ctypes.c_void_p) != 8:
        return False
    sample = 0.1 + len(sys.version)
    if type(sample).__basicsize__ != _VALUE + 8:
        return False
    kind = ctypes.c_int64.from_address(id(sample) + _TYPE).value
    value = ctypes.c_double.from_address(id(sample) + _VALUE).value
    pair = (b"12345678", sample)
    entry = ctypes.c_int64.from_address(id(pair) + _ENTRY + 8).value
    return (kind, value, entry) == (id(float), sample, id(sample)) and ctypes.string_at(id(pair[0]) + _BYTE) == pair[0]


@cache
def _definition(inputs: int) -> _MethodDefinition:
    """Return what the C functions of so many inputs are; CPython reads it even while it takes a function down."""
    (address,) = loaded(_code(inputs), f"call{inputs}")
    return _MethodDefinition(b"kernel", address, _FASTCALL, None)


def _code(inputs: int) -> str:
    typed = (_TYPED.format(k=k, next=k + 1, type=_TYPE, value=_VALUE, float=id(float)) for k in range(inputs))
    return _CODE.format(
        count=inputs,
        typed="".join(typed),
        first=_ENTRY,
        second=_ENTRY + 8,
        byte=_BYTE,
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
