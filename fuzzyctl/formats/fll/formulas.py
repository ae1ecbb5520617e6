"""Writes expressions as formulas of `Function` terms."""

from __future__ import annotations

from typing import Final

from fuzzyctl.expr import ZERO, Binary, Call, Expr, Name, Negate, Number, number_text

#: Functions of the model that fuzzylite has under the same name; `min` and `max` take two arguments there.
_FUNCTIONS: Final = frozenset({"abs", "sqrt", "exp", "log", "sin", "cos", "tan", "atan2", "min", "max"})


def formula(expr: Expr, params: dict[str, float]) -> str | None:
    """Return an expression as a formula, with parentheses around every operation; None for what has none.

    Args:
        expr: The expression.
        params: Values of the names that are not variables.
    """
    match expr:
        case Number(value=value):
            return number_text(value) if value >= 0 else f"(0 - {number_text(-value)})"
        case Name(name=name):
            return number_text(params[name]) if name in params and params[name] >= 0 else _name(name, params)
        case Negate(operand=operand):
            inner = formula(operand, params)
            return None if inner is None else f"(0 - {inner})"
        case Binary(op=op, left=left, right=right):
            a, b = formula(left, params), formula(right, params)
            return None if a is None or b is None else f"({a} {op} {b})"
        case Call(function="max", arguments=(Number(value=0.0), Call(function="sign", arguments=(inside,)))):
            return _comparison("gt", inside, params)
        case Call(function="abs", arguments=(Call(function="sign", arguments=(inside,)),)):
            return _comparison("neq", inside, params)
        case Call(function="sign", arguments=(inside,)):
            text = formula(inside, params)
            return None if text is None else f"(gt({text}, 0) - gt(0, {text}))"
        case Call(function=function, arguments=arguments) if function in _FUNCTIONS:
            return _call(function, [formula(a, params) for a in arguments])
    return None


def _comparison(function: str, difference: Expr, params: dict[str, float]) -> str | None:
    """Return the comparison of two expressions, or of one with 0, that a sign of their difference is."""
    two = isinstance(difference, Binary) and difference.op == "-"
    left, right = (difference.left, difference.right) if two and isinstance(difference, Binary) else (difference, ZERO)
    return _call(function, [formula(left, params), formula(right, params)])


def _name(name: str, params: dict[str, float]) -> str:
    return f"(0 - {number_text(-params[name])})" if name in params else name


def _call(function: str, arguments: list[str | None]) -> str | None:
    given = [a for a in arguments if a is not None]
    if len(given) < len(arguments):
        return None
    if function not in ("min", "max"):
        return f"{function}({', '.join(given)})"
    text = given[0]
    for other in given[1:]:
        text = f"{function}({text}, {other})"
    return text
