"""Interval values of expressions: what a kernel's floats can be while its inputs run through a box.

Additions, products, quotients and comparisons round monotonically, so evaluating at the ends with the same rounding
encloses the floats that a kernel computes; only library functions need a margin.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Final

from fuzzyctl.expr import Binary, Call, Compare, Expr, Logic, Name, Negate, Number, Where

#: The least and the largest value.
Interval = tuple[float, float]

#: Relative error of `exp` in the libraries that kernels may call, generously.
_EXP_ERROR: Final = 16 * 2.0**-53
#: Below this, libraries may round to 0 instead of to the nearest tiny number.
_TINY: Final = 1e-300


def enclose(expr: Expr, box: Mapping[str, Interval]) -> Interval:
    """Enclose the values of a membership function or a firing strength.

    Args:
        expr: An expression without functions other than `min`, `max`, `exp` and `abs`.
        box: An interval for every name.

    Returns:
        An interval that holds every value.
    """
    match expr:
        case Number(value=value):
            return value, value
        case Name(name=name):
            return box[name]
        case Negate(operand=operand):
            low, high = enclose(operand, box)
            return -high, -low
        case Binary(op="*", left=left, right=right) if left == right:
            return _square(enclose(left, box))
        case Binary(op=op, left=left, right=right):
            return _binary(op, enclose(left, box), enclose(right, box))
        case Call(function=function, arguments=arguments):
            return _call(function, [enclose(a, box) for a in arguments])
        case Where(condition=condition, then=then, otherwise=otherwise):
            truth = decide(condition, box)
            if truth is None:
                return hull([enclose(then, box), enclose(otherwise, box)])
            return enclose(then if truth else otherwise, box)
    raise TypeError(f"{type(expr).__name__} has no interval")


def decide(condition: Expr, box: Mapping[str, Interval]) -> bool | None:
    """Return whether a condition holds in the whole box, nowhere in it, or (None) neither is known."""
    match condition:
        case Compare(op=op, left=left, right=right):
            return _compare(op, enclose(left, box), enclose(right, box))
        case Logic(op="not", operands=(operand,)):
            truth = decide(operand, box)
            return None if truth is None else not truth
        case Logic(op=logic, operands=operands):
            truths = [decide(o, box) for o in operands]
            settles = logic == "or"
            return settles if settles in truths else None if None in truths else not settles
    raise TypeError(f"{type(condition).__name__} is no condition")


def hull(intervals: Iterable[Interval]) -> Interval:
    """Return the smallest interval that holds all of some intervals."""
    lows, highs = zip(*intervals, strict=True)
    return min(lows), max(highs)


def _compare(op: str, a: Interval, b: Interval) -> bool | None:
    match op:
        case "<":
            return True if a[1] < b[0] else False if a[0] >= b[1] else None
        case "<=":
            return True if a[1] <= b[0] else False if a[0] > b[1] else None
        case ">" | ">=":
            return _compare("<" if op == ">" else "<=", b, a)
        case "==":
            return True if a[0] == a[1] == b[0] == b[1] else False if a[1] < b[0] or b[1] < a[0] else None
    equal = _compare("==", a, b)
    return None if equal is None else not equal


def _binary(op: str, a: Interval, b: Interval) -> Interval:
    match op:
        case "+":
            return _checked([a[0] + b[0], a[1] + b[1]])
        case "-":
            return _checked([a[0] - b[1], a[1] - b[0]])
        case "*":
            return _checked([_times(x, y) for x in a for y in b])
        case "/":
            if b[0] <= 0.0 <= b[1]:
                return -math.inf, math.inf
            return _checked([x / y for x in a for y in b])
    raise TypeError(f"{op!r} has no interval")


def _times(x: float, y: float) -> float:
    # An infinite end stands for all large numbers, and those times zero are zero.
    return 0.0 if x == 0.0 or y == 0.0 else x * y


def _checked(values: list[float]) -> Interval:
    if any(v != v for v in values):
        return -math.inf, math.inf
    return min(values), max(values)


def _square(a: Interval) -> Interval:
    ends = [a[0] * a[0], a[1] * a[1]]
    return (0.0 if a[0] <= 0.0 <= a[1] else min(ends)), max(ends)


def _call(function: str, a: list[Interval]) -> Interval:
    match function:
        case "min":
            return min(x[0] for x in a), min(x[1] for x in a)
        case "max":
            return max(x[0] for x in a), max(x[1] for x in a)
        case "abs":
            (low, high) = a[0]
            return (0.0 if low <= 0.0 <= high else min(abs(low), abs(high))), max(abs(low), abs(high))
        case "exp":
            return _exp(a[0][0])[0], _exp(a[0][1])[1]
    raise TypeError(f"function {function!r} has no interval")


def _exp(x: float) -> Interval:
    try:
        value = math.exp(x)
    except OverflowError:
        return 1e308, math.inf
    if value < _TINY:
        return 0.0, 0.0 if x < -800.0 else _TINY
    return (value, value) if x == 0.0 else (value * (1.0 - _EXP_ERROR), value * (1.0 + _EXP_ERROR))
