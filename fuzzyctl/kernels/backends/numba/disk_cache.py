"""Machine code on disk that runs only if it is what was written, and for the function that it was written for.

numba keeps what it compiles, and runs what it finds. A file that a failing disk has changed may then do anything, and
of two processes that store two signatures at a time one may find the other's. Here each file ends with a digest of all
before it, and each entry says what it is for.
"""

from __future__ import annotations

import contextlib
import hashlib
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numba
from numba.core.caching import FunctionCache, IndexDataCacheFile

from fuzzyctl.support.private_folders import is_private

_DIGEST: Final = hashlib.sha256().digest_size


def native(signature: str, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles a function for one signature, or takes what is kept on disk.

    Args:
        signature: As numba writes it.
        options: What `numba.njit` takes, but `cache`.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        compiled = kept(numba.njit(**options)(function))
        compiled.compile(signature)
        compiled.disable_compile()
        return compiled

    return decorate


def kept(function: Any) -> Any:
    """Have the machine code of a function of numba kept on disk from now on, where a folder can be written to."""
    with contextlib.suppress(OSError, RuntimeError):  # which numba raises where there is none
        cache, named = _Cache(function.py_func), numba.config.CACHE_DIR
        if not named or is_private(Path(named)):
            function._cache = cache
    return function


#: What loading an entry may raise although it is whole: it names what another version, or no module, has.
_UNUSABLE: Final = (OSError, ImportError, AttributeError, LookupError, TypeError, ValueError, pickle.UnpicklingError)


class _Cache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """What numba keeps of one function; what cannot be read or written is no reason to stop."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = _Files(self.cache_path, self._impl.filename_base, stamp)

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Return what is kept for a signature, None for nothing that can be loaded."""
        with contextlib.suppress(*_UNUSABLE):
            return super().load_overload(signature, context)
        return None

    def save_overload(self, signature: Any, data: Any) -> None:
        """Keep what was compiled for a signature."""
        with contextlib.suppress(OSError):
            super().save_overload(signature, data)


class _Files(IndexDataCacheFile):  # type: ignore[misc]  # numba has no types
    """An index of signatures and a file for each, all with a digest at the end."""

    def save(self, key: Any, data: Any) -> None:
        """Write an entry; another process may write another one to the same file."""
        super().save(key, (key, data))

    def load(self, key: Any) -> Any:
        """Return the entry of a key, None for none."""
        found = super().load(key)
        return found[1] if found is not None and found[0] == key else None

    def _dump(self, thing: Any) -> bytes:
        data: bytes = super()._dump(thing)
        return data + hashlib.sha256(data).digest()

    def _load_index(self) -> dict[Any, str]:
        try:
            whole = Path(self._index_path).read_bytes()
        except FileNotFoundError:
            return {}
        version = pickle.dumps(self._version, protocol=-1)
        data = _undamaged(whole[len(version) :]) if whole.startswith(version) else None
        stamp, entries = pickle.loads(data) if data else (None, {})
        return entries if stamp == self._source_stamp else {}

    def _load_data(self, name: str) -> Any:
        data = _undamaged(Path(self._data_path(name)).read_bytes())
        return pickle.loads(data) if data else None


def _undamaged(whole: bytes) -> bytes | None:
    """Return what stands before the digest, None where that is another's."""
    data, digest = whole[:-_DIGEST], whole[-_DIGEST:]
    return data if hashlib.sha256(data).digest() == digest else None
