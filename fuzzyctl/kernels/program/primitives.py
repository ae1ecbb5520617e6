"""Table of primitives: every function that printed programs call, with its text for each target.

A target is one column. Texts are values over the arguments; a single word is a function of the target's library. Python
has functions in `ieee`, and intervals in `interval`. `lowering` makes comparisons and roundings of these.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple


class Primitive(NamedTuple):
    """One function.

    Args:
        arguments: Names of its arguments.
        numpy: For arrays.
        numba: For compiled Python, after the header of its modules.
        c: For C99, with literals of the precision for {zero} and {one}.
        st: For IEC 61131-3, with arguments by position; empty where it has no such function.
        javascript: For JavaScript; a word with a dot is a function of its library.
    """

    arguments: str
    numpy: str
    numba: str
    c: str
    st: str
    javascript: str


def _library(arguments: str, name: str, st: str, *, numpy: str = "", c: str = "", javascript: str = "") -> Primitive:
    return Primitive(arguments, numpy or name, name, c or name, st, javascript or f"Math.{name}")


#: By name; the comment says what it computes where the name does not.
PRIMITIVES: Final[Mapping[str, Primitive]] = {
    # Quotient of IEEE 754: infinite or NaN for a divisor of 0.
    "divide": Primitive("a b", "divide", "a / b", "a / b", "({0} / {1})", "a / b"),
    # The second argument where one of them is NaN.
    "smaller": Primitive("a b", "where(a < b, a, b)", "smaller", "(a < b) ? a : b", "MIN", "a < b ? a : b"),
    "larger": Primitive("a b", "where(a > b, a, b)", "larger", "(a > b) ? a : b", "MAX", "a > b ? a : b"),
    # The first argument held between the others; NaN stays NaN.
    "clip": Primitive(
        "x low high",
        "clip",
        "clip",
        "(x < low) ? low : ((x > high) ? high : x)",
        "LIMIT({1}, {0}, {2})",
        "x < low ? low : x > high ? high : x",
    ),
    # The argument held within [0, 1], 0 for NaN.
    "held": Primitive(
        "x",
        "where(x > 0.0, where(x < 1.0, x, 1.0), 0.0)",
        "(x if x < 1.0 else 1.0) if x > 0.0 else 0.0",
        "(x > {zero}) ? ((x < {one}) ? x : {one}) : {zero}",
        "LIMIT({zero}, {0}, {one})",
        "x > 0 ? (x < 1 ? x : 1) : 0",
    ),
    "abs": _library("x", "abs", "ABS", c="(x > {zero}) ? x : ({zero} - x)"),
    # JavaScript's own is NaN where IEEE 754 has 1.
    "power": _library(
        "a b",
        "power",
        "EXPT",
        c="pow",
        javascript="a === 1 || (a === -1 && Math.abs(b) === Infinity) ? 1 : Math.pow(a, b)",
    ),
    "sqrt": _library("x", "sqrt", "SQRT"),
    "exp": _library("x", "exp", "EXP"),
    "log": _library("x", "log", "LN"),
    "sin": _library("x", "sin", "SIN"),
    "cos": _library("x", "cos", "COS"),
    "tan": _library("x", "tan", "TAN"),
    "atan2": _library("y x", "atan2", "", numpy="arctan2"),
    # The largest whole number that is not above the argument.
    "floor": _library("x", "floor", ""),
    # The remainder with the sign of the first argument.
    "fmod": _library("a b", "fmod", "", javascript="a % b"),
}

#: Other names of primitives: what `expr` calls them.
ALIASES: Final[Mapping[str, str]] = {"min": "smaller", "max": "larger"}
