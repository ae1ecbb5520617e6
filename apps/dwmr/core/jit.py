"""Compilation of the loop's functions with numba; where numba is missing, the same source runs as plain Python.

The only module of dwmr that knows numba. Compiled code is cached on disk between processes, in a folder named after the
sources of this package: numba looks only at the file of a function, so a change in robot.py would leave the loop
as it was.
"""

from __future__ import annotations

import hashlib
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

try:
    import numba

    from fuzzyctl.kernels.backends.numba.disk_cache import with_disk_cache
    from fuzzyctl.support.private_folders import cache_folder, is_private
except ImportError:  # a platform without a wheel: about a hundred times slower, and `dwmr run` says so
    numba = None
else:
    if numba.config.DISABLE_JIT:  # as debuggers and tools that count lines ask for
        numba = None

Function = TypeVar("Function", bound=Callable[..., Any])

COMPILED: bool = numba is not None


@contextmanager
def first_class_functions() -> Iterator[None]:
    """Silence numba's note that functions as values are experimental, but no other warning."""
    with warnings.catch_warnings():
        if numba is not None:
            warnings.simplefilter("ignore", numba.core.errors.NumbaExperimentalFeatureWarning)
        yield


def compiled(function: Function) -> Function:
    """Compile a function for use inside the loop, at its first call."""
    return function if numba is None else _jit(function)


def compiled_as(signature: Callable[[Any], Any], *, checked: bool = False) -> Callable[[Function], Function]:
    """Compile a function at once and to one signature, so that it can be handed to the loop as a value.

    Args:
        signature: Makes the signature out of `numba.types`; not called without numba.
        checked: Whether an index beyond the end of an array and a division by zero are errors, as in Python. Otherwise
            the first changes foreign memory, and the second gives an infinite number, of integers 0.
    """

    def decorate(function: Function) -> Function:
        if numba is None:
            return function
        with first_class_functions():
            return _jit(function, signature(numba.types), checked=checked)

    return decorate


#: All functions that are compiled, or will be.
_FUNCTIONS: list[Any] = []


@contextmanager
def watched(report: Callable[[float], None]) -> Iterator[None]:
    """Report the compiled share of all functions, in percent, after each compilation.

    Functions count from their import on, so the loop should be imported before; those on disk are there at once.
    """
    if numba is None:
        yield
        return
    from numba.core import event

    class Listener(event.Listener):  # type: ignore[misc]  # numba has no types
        def on_start(self, event: Any) -> None:
            pass

        def on_end(self, event: Any) -> None:
            report(100.0 * sum(bool(one.overloads) for one in _FUNCTIONS) / len(_FUNCTIONS))

    with event.install_listener("numba:compile", Listener()):
        yield


def _jit(function: Function, *signatures: Any, checked: bool = False) -> Function:
    # Divisions by zero give infinities, which the loop reports as divergence. A call with the dozens of arguments that
    # the loop's tuples and arrays are takes longer than the called code, so all but functions as values are inlined.
    # Inlined code does not allocate: its arrays belong to the caller, and counting references to them, each an
    # atomic operation, took a third of the loop's time. Users' laws may allocate.
    inlined, model = not signatures, "python" if checked else "numpy"
    options = {"error_model": model, "forceinline": inlined, "boundscheck": checked, "_nrt": checked}
    result = numba.njit(**options)(function)
    _FUNCTIONS.append(result)
    before = numba.config.CACHE_DIR
    try:
        numba.config.CACHE_DIR = str(_cache_folder())
        if is_private(_cache_root(), *_cache_folder().relative_to(_cache_root()).parts):
            with_disk_cache(result)
    except (RuntimeError, OSError):  # no home, or no folder for the cache: compile for this process only
        pass
    finally:
        numba.config.CACHE_DIR = before
    for signature in signatures:
        result.compile(signature)
    if signatures:
        result.disable_compile()
    compiled_function: Function = result
    return compiled_function


@cache
def _cache_folder() -> Path:
    """Return the folder for compiled code of exactly these sources."""
    digest, package = hashlib.sha256(), Path(__file__).parents[1]
    for source in sorted(package.rglob("*.py")):
        digest.update(source.read_bytes())
    return _cache_root() / "dwmr" / digest.hexdigest()[:16]


def _cache_root() -> Path:
    """Return the folder of all caches; numba's own variable counts where ours is not set."""
    named = numba.config.CACHE_DIR if not os.environ.get("FUZZYCTL_CACHE_DIR") else ""
    return Path(named) if named else cache_folder()


@contextmanager
def collected_errors() -> Iterator[list[BaseException]]:
    """Collect the first error of compiled functions that are called as values: their callers never see it.

    Numba gives such an error to `sys.unraisablehook`, and the call returns zeros.
    """
    errors: list[BaseException] = []
    before = sys.unraisablehook

    def keep(raised: Any) -> None:
        if "numba" not in str(raised.object) or raised.exc_value is None:
            before(raised)
        elif not errors:
            errors.append(raised.exc_value)

    sys.unraisablehook = keep
    try:
        yield errors
    finally:
        sys.unraisablehook = before


def reason(error: BaseException) -> str:
    """Return the line of an error with its cause; numba puts the failed step before it."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    reasons = [line for line in lines if not line.startswith("Failed in ")]
    return next(iter(reasons or lines), "no reason given")


def function_type(signature: str) -> Any:
    """Return the type of a compiled function that is handed over as a value.

    Args:
        signature: As numba writes it, such as "float64(float64, float64)".
    """
    arguments, returned = numba.core.sigutils.normalize_signature(signature)
    return numba.types.FunctionType(returned(*arguments))


def record_type(dtype: Any) -> Any:
    """Return the type of a record of an array."""
    return numba.from_dtype(dtype)


def first_class(function: Any) -> Any:
    """Return a function as a value the loop can be given: typed by its signature, not by its identity.

    The loop therefore stays the same machine code, whichever rule file or control law it is called with.

    Args:
        function: A dispatcher with exactly one eager signature, or a plain function.
    """
    if not hasattr(function, "overloads"):
        return function
    (overload,) = function.overloads.values()
    return numba.types.CompileResultWAP(overload)
