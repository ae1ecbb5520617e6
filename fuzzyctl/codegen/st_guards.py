"""Domain guards for Structured Text, which has no NaN: functions are called only where they have a value."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Final

from fuzzyctl.expr import ZERO, Binary, Call, Compare, Expr, Name, Number, Where, children, walk
from fuzzyctl.kernels.program.program import NAN

#: Functions without a value, or with an infinite one, somewhere.
PARTIAL: Final = frozenset(["divide", "power", "sqrt", "log", "sin", "cos", "tan"])
#: Behind the name of a function whose arguments were tested.
TESTED: Final = "!"
#: Selections that take the second operand if the first is NaN.
_SECOND: Final = frozenset(["smaller", "larger", "min", "max"])
_INFINITE: Final = Number(math.inf)
#: Above this a number is taken to be no integer: whole numbers are found through those of 32 bits.
_COUNTABLE: Final = Number(2e9)


def guarded(function: str, arguments: Sequence[Expr], absent: Sequence[Expr]) -> Expr:
    """Return a call of a function that is computed only where it has a value.

    Infinite values become the largest number. Values are those of IEEE 754 and C's pow, -0 counting as 0.

    Args:
        function: One of `PARTIAL`, `held`, or a selection.
        arguments: Atoms.
        absent: Those of them that may have no value.
    """
    tested = Call(function + TESTED, tuple(arguments))
    first = arguments[0]
    if function in _SECOND:
        return Where(_missing(first), arguments[1], tested) if first in absent else tested
    if function == "held":
        return Where(_missing(first), ZERO, tested) if first in absent else tested
    value = _valued(function, arguments, tested)
    for argument in absent:
        value = Where(_missing(argument), NAN, value)
    return value


def _missing(atom: Expr) -> Expr:
    return Compare("!=", atom, atom)


def _valued(function: str, arguments: Sequence[Expr], tested: Expr) -> Expr:
    x = arguments[0]
    negative = Compare("<", x, ZERO)
    match function:
        case "sqrt":
            return Where(negative, NAN, tested)
        case "log":
            return Where(Compare(">", x, ZERO), tested, Where(negative, NAN, Number(-math.inf)))
        case "divide" if isinstance(arguments[1], Number) and arguments[1].value != 0.0:
            return tested
        case "divide":
            infinite = Where(Compare("==", x, ZERO), NAN, Where(negative, Number(-math.inf), _INFINITE))
            return Where(Compare("==", arguments[1], ZERO), infinite, tested)
        case "power":
            return _power(x, arguments[1], tested)
    return Where(Compare("<=", Call("abs", (x,)), _INFINITE), tested, NAN)


def _power(x: Expr, exponent: Expr, tested: Expr) -> Expr:
    negative, pole = Compare("<", x, ZERO), Compare("==", x, ZERO)
    if isinstance(exponent, Number):
        value = Where(pole, _INFINITE, tested) if exponent.value < 0 else tested
        return value if exponent.value.is_integer() else Where(negative, NAN, value)
    whole = Where(Compare("==", Call("whole", (exponent,)), exponent), tested, NAN)
    counted = Where(Compare("<", Call("abs", (exponent,)), _COUNTABLE), whole, NAN)
    above = Where(pole, Where(Compare("<", exponent, ZERO), _INFINITE, tested), tested)
    return Where(negative, counted, above)


def may_fail(value: Expr) -> bool:
    """Return whether a function is called that may have no value: not powers with whole exponents, nor parts of one."""
    match value:
        case Binary(op="^", right=Number(value=exponent)):
            return not exponent.is_integer()
        case Call(function="divide", arguments=(_, Number(value=divisor))):
            return divisor == 0.0
    return function_of(value) in PARTIAL


def may_be_infinite(value: Expr, names: Collection[str]) -> bool:
    """Return whether a value may be infinite where some names may be."""
    match value:
        case Number(value=number):
            return math.isinf(number)
        case Name(name=name):
            return name in names
        case Where(then=then, otherwise=otherwise):
            return may_be_infinite(then, names) or may_be_infinite(otherwise, names)
        case Call(function="clip", arguments=(_, low, high)):
            return may_be_infinite(low, names) or may_be_infinite(high, names)
        case Call(function="held" | "sin" | "cos"):
            return False
    return any(may_be_infinite(part, names) for part in children(value))


def may_be_undefined(value: Expr, names: Collection[str]) -> bool:
    """Return whether arithmetic may give NaN where some names may be infinite: ∞ - ∞, 0 · ∞, ∞ / ∞."""

    def undefined(node: Expr) -> bool:
        match node:
            case Binary(op="+" | "-" | "/", left=left, right=right):
                return may_be_infinite(left, names) and may_be_infinite(right, names)
            case Binary(op="*", left=left, right=right):
                pairs = ((left, right), (right, left))
                return any(may_be_infinite(a, names) and not _is_factor(b) for a, b in pairs)
        return False

    return any(undefined(node) for node in walk(value))


def _is_factor(value: Expr) -> bool:
    """Return whether a factor is a number that is neither 0 nor infinite."""
    return isinstance(value, Number) and value.value != 0.0 and math.isfinite(value.value)


def function_of(value: Expr) -> str:
    """Return the function that an expression calls, or an empty string."""
    match value:
        case Call(function=function):
            return function
        case Binary(op="^"):
            return "power"
    return ""


def needs_guard(function: str) -> bool:
    """Return whether a function may have no value, or may have one although an argument has none."""
    return function in PARTIAL or function in _SECOND or function == "held"


def is_named(value: Expr) -> bool:
    """Return whether an argument can be tested as it is."""
    return isinstance(value, Name | Number)
