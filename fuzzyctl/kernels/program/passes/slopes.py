"""Derivatives of the functions of one argument."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from fuzzyctl.expr import ONE, Call, Expr, Number

#: Functions that are constant between their jumps.
STEPS: Final = ("floor",)

#: Functions whose slope may be infinite.
STEEP: Final = ("sqrt", "log")

#: From an atom, the value of the function there and what names a value to the derivative.
SLOPES: Final[Mapping[str, Callable[[Expr, Expr, Callable[[Expr], Expr]], Expr]]] = {
    "sqrt": lambda x, value, let: let(Number(0.5) / value),
    "exp": lambda x, value, let: value,
    "log": lambda x, value, let: let(ONE / x),
    "sin": lambda x, value, let: let(Call("cos", (x,))),
    "cos": lambda x, value, let: let(-let(Call("sin", (x,)))),
    "tan": lambda x, value, let: let(1.0 + let(value * value)),
}
