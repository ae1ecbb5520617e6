"""Functions of fuzzylite's formulas as expressions of the functions here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from fuzzyctl.expr import COMPARISONS, MAX_DEPTH, ONE, ZERO, Call, Expr, Number, children


def _root_beside(x: Expr) -> Expr:
    """Return √(1 - x²), which has no value beyond 1."""
    return Call("sqrt", (1.0 - x * x,))


def is_truth(expr: Expr) -> bool:
    """Return whether an expression is 0 or 1, whatever its names are."""
    match expr:
        case Number(value=value):
            return value in (0.0, 1.0)
        case Call(function="min" | "max", arguments=arguments):
            return all(map(is_truth, arguments))
    return isinstance(expr, Call) and expr.function in COMPARISONS


def truth(expr: Expr, *, python: bool) -> Expr:
    """Return whether an operand of logic counts as true, as 1 or 0.

    Args:
        expr: The operand.
        python: Whether everything but 0 is true, NaN included, as in pyfuzzylite; else nothing but 1, as in fuzzylite.
    """
    if is_truth(expr):
        return expr
    return Call("ne", (expr, ZERO)) if python else Call("eq", (expr, ONE))


def negation(expr: Expr, *, python: bool) -> Expr:
    """Return 1 where an operand of logic is not true, else 0; see `truth`."""
    return Call("eq", (expr, ZERO)) if python or is_truth(expr) else Call("ne", (expr, ONE))


def _exp(x: Expr) -> Expr:
    return Call("exp", (x,))


def _log(x: Expr) -> Expr:
    return Call("log", (x,))


def _tanh(x: Expr) -> Expr:
    """Return sign(x) (1 - z)/(1 + z) with z = exp(-2|x|), which is finite everywhere."""
    z = _exp(-2.0 * Call("abs", (x,)))
    return Call("sign", (x,)) * ((1.0 - z) / (1.0 + z))


def _asinh(x: Expr) -> Expr:
    root = Call("sqrt", (x * x + 1.0,))
    return Call("sign", (x,)) * _log(Call("abs", (x,)) + root)


def _acosh(x: Expr) -> Expr:
    return _log(x + Call("sqrt", (x * x - 1.0,)))


def _away_from_zero(x: Expr) -> Expr:
    """Return the nearest whole number, of two the one farther from 0, as C rounds."""
    size = Call("abs", (x,))
    whole = Call("floor", (size,))
    return Call("sign", (x,)) * (whole + Call("ge", (size - whole, Number(0.5))))


_ONE_ARGUMENT: Final[dict[str, Callable[[Expr], Expr]]] = {
    "log10": lambda x: _log(x) / _log(Number(10.0)),
    "log1p": lambda x: _log(1.0 + x),
    "asin": lambda x: Call("atan2", (x, _root_beside(x))),
    "acos": lambda x: Call("atan2", (_root_beside(x), x)),
    "atan": lambda x: Call("atan2", (x, ONE)),
    "sinh": lambda x: 0.5 * (_exp(x) - _exp(0.0 - x)),
    "cosh": lambda x: 0.5 * (_exp(x) + _exp(0.0 - x)),
    "tanh": _tanh,
    "asinh": _asinh,
    "acosh": _acosh,
    "round": _away_from_zero,
    "atanh": lambda x: 0.5 * _log((1.0 + x) / (1.0 - x)),
}

_TWO_ARGUMENTS: Final[dict[str, Callable[[Expr, Expr], Expr]]] = {
    "pow": lambda a, b: a**b,
    "neq": lambda a, b: Call("ne", (a, b)),
}

#: Larger expressions are refused: what is nested in functions whose argument stands in them twice grows fast.
_MOST_PARTS: Final = 5000

#: How many arguments each function takes.
ARGUMENTS: Final[dict[str, int]] = {**dict.fromkeys(_ONE_ARGUMENT, 1), **dict.fromkeys(_TWO_ARGUMENTS, 2)}


def expanded(name: str, arguments: Sequence[Expr]) -> Expr | None:
    """Return what a function of `ARGUMENTS` is of as many arguments as it takes; None for what becomes too large."""
    if name in _ONE_ARGUMENT:
        found = _ONE_ARGUMENT[name](arguments[0])
    else:
        found = _TWO_ARGUMENTS[name](arguments[0], arguments[1])
    return None if is_too_large(found) else found


def is_too_large(expr: Expr) -> bool:
    """Return whether an expression has more parts, or is deeper, than rule files and kernels can hold."""
    stack, count = [(expr, 0)], 0
    while stack:
        node, depth = stack.pop()
        count += 1
        if count > _MOST_PARTS or depth > MAX_DEPTH:
            return True
        stack.extend((part, depth + 1) for part in children(node))
    return False
