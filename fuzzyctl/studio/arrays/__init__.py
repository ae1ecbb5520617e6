"""Arrays in plain Python, under numpy's names: the part of numpy that proofs and measures take, for browsers.

`install` makes `import numpy` find them where there is no numpy. Element by element they have the bits of numpy, but
for `exp` and its kin, which are the C library's; sums, which are Python's, may differ too. Indexing copies.
What is not here raises `ModuleNotFoundError`, as numpy does where it is missing. No proof relies on a last bit: ends of
intervals are moved outward by more than any of these differences, see `kernels/interval/vector.py`.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

from fuzzyctl.studio.arrays import array, functions
from fuzzyctl.studio.arrays.array import lacking


def module() -> ModuleType:
    """Return what `numpy` is where it is missing."""
    numpy, typing = ModuleType("numpy"), ModuleType("numpy.typing")
    typing.__dict__.update(NDArray=list, ArrayLike=object)
    numpy.__dict__.update(
        vars(array) | vars(functions) | functions.LIKE_PYTHON | {"typing": typing, "__name__": "numpy"}
    )
    numpy.__dict__["__getattr__"] = _missing
    return numpy


def install() -> None:
    """Make `import numpy` find `module()`."""
    numpy = module()
    sys.modules.update({"numpy": numpy, "numpy.typing": numpy.typing})


def _missing(name: str) -> Any:
    raise AttributeError(name) if name.startswith("__") else lacking()
