"""Functions of other tools' formulas that are expressions of the functions here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Binary, BinaryOp, Call, Expr, Number

_HALF: Final = Number(0.5)


def _op(sign: BinaryOp, left: Expr, right: Expr) -> Expr:
    return Binary(sign, left, right)


def _root_beside(x: Expr) -> Expr:
    """Return √(1 - x²), which has no value beyond 1."""
    return Call("sqrt", (_op("-", ONE, _op("*", x, x)),))


def less(a: Expr, b: Expr) -> Expr:
    """Return 1 where a is less than b, else 0."""
    return Call("max", (ZERO, Call("sign", (_op("-", b, a),))))


def unequal(a: Expr, b: Expr) -> Expr:
    """Return 1 where a differs from b, else 0."""
    return Call("abs", (Call("sign", (_op("-", a, b),)),))


def _exp(x: Expr) -> Expr:
    return Call("exp", (x,))


def _log(x: Expr) -> Expr:
    return Call("log", (x,))


def _tanh(x: Expr) -> Expr:
    """Return sign(x) (1 - z)/(1 + z) with z = exp(-2|x|), which is finite everywhere."""
    z = _exp(_op("*", Number(-2.0), Call("abs", (x,))))
    return _op("*", Call("sign", (x,)), _op("/", _op("-", ONE, z), _op("+", ONE, z)))


def _asinh(x: Expr) -> Expr:
    root = Call("sqrt", (_op("+", _op("*", x, x), ONE),))
    return _op("*", Call("sign", (x,)), _log(_op("+", Call("abs", (x,)), root)))


def _acosh(x: Expr) -> Expr:
    return _log(_op("+", x, Call("sqrt", (_op("-", _op("*", x, x), ONE),))))


_ONE_ARGUMENT: Final[dict[str, Callable[[Expr], Expr]]] = {
    "log10": lambda x: _op("/", _log(x), _log(Number(10.0))),
    "log1p": lambda x: _log(_op("+", ONE, x)),
    "asin": lambda x: Call("atan2", (x, _root_beside(x))),
    "acos": lambda x: Call("atan2", (_root_beside(x), x)),
    "atan": lambda x: Call("atan2", (x, ONE)),
    "sinh": lambda x: _op("*", _HALF, _op("-", _exp(x), _exp(_op("-", ZERO, x)))),
    "cosh": lambda x: _op("*", _HALF, _op("+", _exp(x), _exp(_op("-", ZERO, x)))),
    "tanh": _tanh,
    "asinh": _asinh,
    "acosh": _acosh,
    "atanh": lambda x: _op("*", _HALF, _log(_op("/", _op("+", ONE, x), _op("-", ONE, x)))),
}

_TWO_ARGUMENTS: Final[dict[str, Callable[[Expr, Expr], Expr]]] = {
    "pow": lambda a, b: _op("^", a, b),
    "lt": less,
    "gt": lambda a, b: less(b, a),
    "le": lambda a, b: _op("-", ONE, less(b, a)),
    "ge": lambda a, b: _op("-", ONE, less(a, b)),
    "neq": unequal,
    "eq": lambda a, b: _op("-", ONE, unequal(a, b)),
}

#: How many arguments each function takes.
ARGUMENTS: Final[dict[str, int]] = {**dict.fromkeys(_ONE_ARGUMENT, 1), **dict.fromkeys(_TWO_ARGUMENTS, 2)}


def expanded(name: str, arguments: Sequence[Expr]) -> Expr:
    """Return what a function of `ARGUMENTS` is of as many arguments as it takes."""
    if name in _ONE_ARGUMENT:
        return _ONE_ARGUMENT[name](arguments[0])
    return _TWO_ARGUMENTS[name](arguments[0], arguments[1])
