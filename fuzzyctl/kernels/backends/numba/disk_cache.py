"""numba's cache on disk for functions of generated modules and of dwmr, where a broken entry costs only time.

numba stops where an entry is damaged or the disk is full, and of two processes that store two signatures of a function
at the same time one may find the code of the other's.
"""

from __future__ import annotations

import contextlib
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numba
from numba.core import sigutils
from numba.core.caching import FunctionCache

from fuzzyctl.support.private_folders import is_private

#: What loading an entry may raise that is damaged, or names what another version, or no module, has.
_DAMAGED: Final = (
    ImportError,
    AttributeError,
    LookupError,
    TypeError,
    ValueError,
    EOFError,
    MemoryError,
    RuntimeError,  # of LLVM
    pickle.PickleError,
)


def native(signature: str, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles a function for one signature, or loads it from disk.

    Args:
        signature: As numba writes it.
        options: What `numba.njit` takes, but `cache`.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        compiled = with_disk_cache(numba.njit(**options)(function))
        compiled.compile(signature)
        compiled.disable_compile()
        return compiled

    return decorate


def with_disk_cache(function: Any) -> Any:
    """Have the machine code of a function of numba kept on disk from now on, where a folder can be written to."""
    with contextlib.suppress(OSError, RuntimeError):  # which numba raises without a cache
        cache, named = _Cache(function.py_func), numba.config.CACHE_DIR
        if not named or is_private(Path(named)):
            function._cache = cache
    return function


class _Cache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """What numba keeps of one function."""

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Return the entry of a signature, None if it cannot be used."""
        try:
            entry = super().load_overload(signature, context)
        except OSError:
            return None
        except _DAMAGED:
            with contextlib.suppress(OSError):
                self.flush()
            return None
        return entry if entry and entry.signature.args == sigutils.normalize_signature(signature)[0] else None

    def save_overload(self, signature: Any, data: Any) -> None:
        """Store the machine code of a signature."""
        with contextlib.suppress(OSError, *_DAMAGED):
            super().save_overload(signature, data)
