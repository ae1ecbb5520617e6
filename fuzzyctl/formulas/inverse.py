"""Inverse of an expression that names its variable once, such as exp(-4 w) of -log(x) / 4."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from fuzzyctl.expr import ZERO, Binary, Call, Expr, Name, Negate, names_in

#: Inverses of functions of one argument; the place of a value out of reach is the nearest end.
_UNDONE: Final[dict[str, Callable[[Expr], Expr]]] = {
    "exp": lambda w: Call("log", (Call("larger", (w, ZERO)),)),
    "log": lambda w: Call("exp", (w,)),
    "sqrt": lambda w: Call("larger", (w, ZERO)) * Call("larger", (w, ZERO)),
}


def solved(expr: Expr, name: str, value: Expr) -> Expr | None:
    """Return the place where an expression has a value.

    Args:
        expr: The expression, over the name and numbers.
        name: The variable.
        value: The value, an expression.

    Returns:
        The place as an expression; None where the name occurs more than once, or under anything but `+`, `-`,
        `*` and `/` by numbers, `exp`, `log` and `sqrt`.
    """
    while not isinstance(expr, Name):
        match expr:
            case Negate(operand=operand):
                expr, value = operand, -value
            case Call(function=function, arguments=(inner,)) if function in _UNDONE:
                expr, value = inner, _UNDONE[function](value)
            case Binary(op=op, left=left, right=right):
                step = _step(op, left, right, name, value)
                if step is None:
                    return None
                expr, value = step
            case Call(function="divide", arguments=(left, right)):
                step = _step("/", left, right, name, value)
                if step is None:
                    return None
                expr, value = step
            case _:
                return None
    return value if expr.name == name else None


def _step(op: str, left: Expr, right: Expr, name: str, value: Expr) -> tuple[Expr, Expr] | None:
    """Return the operand that names the variable, and its value; None where both do, or neither."""
    is_left, is_right = (any(n.name == name for n in names_in(part)) for part in (left, right))
    if is_left == is_right:
        return None
    match op, is_left:
        case "+", _:
            return (left, value - right) if is_left else (right, value - left)
        case "-", True:
            return left, value + right
        case "-", False:
            return right, left - value
        case "*", _:
            return (left, _over(value, right)) if is_left else (right, _over(value, left))
        case "/", True:
            return left, value * right
    return None


def _over(value: Expr, factor: Expr) -> Expr:
    return Call("divide", (value, factor))
