"""Choices among numbers as single instructions, for generated modules that numba compiles.

Written as `a if a < b else b` each would be a branch until LLVM has seen through it, and what numba does before that
grows with the square of their number: of 49 rules it takes three times as long. Clamps stay branches, which processors
foresee.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import types
from numba.extending import intrinsic

Lowering = tuple[Any, Callable[..., Any]]


def _pair(comparison: str) -> Lowering:
    def lowered(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        a, b = arguments
        return builder.select(builder.fcmp_ordered(comparison, a, b), a, b)

    return types.float64(types.float64, types.float64), lowered


@intrinsic  # type: ignore[untyped-decorator]  # numba has no types
def smaller(_typing: Any, _a: Any, _b: Any) -> Lowering:
    """Return `a if a < b else b`."""
    return _pair("<")


@intrinsic  # type: ignore[untyped-decorator]  # numba has no types
def larger(_typing: Any, _a: Any, _b: Any) -> Lowering:
    """Return `a if a > b else b`."""
    return _pair(">")
