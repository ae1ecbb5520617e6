"""Scalar interval arithmetic of expressions: encloses a kernel's floats over a box.

Additions, products, quotients and comparisons round monotonically, so evaluating at the ends with the same rounding
encloses the floats that a kernel computes; only library functions need a margin.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Final

from fuzzyctl.expr import (
    COMPARISONS,
    SCALAR_FUNCTIONS,
    Binary,
    Call,
    Compare,
    Expr,
    Logic,
    Name,
    Negate,
    Number,
    Where,
    floor,
    rounded,
    sign,
)
from fuzzyctl.kernels.program.scalar import power

#: The least and the largest value.
Interval = tuple[float, float]

#: Any number, or NaN: results that depend on it may again be anything.
ANYTHING: Final = (-math.inf, math.inf)
#: Relative error of functions in the libraries that kernels may call, generously.
_ERROR: Final = 16 * 2.0**-53
#: Angles beyond this are not reduced.
_FAR: Final = 1e6
#: Below this, libraries may round to 0 instead of to the nearest tiny number.
_TINY: Final = 1e-300


def enclose(expr: Expr, box: Mapping[str, Interval]) -> Interval:
    """Enclose the values of an expression.

    Args:
        expr: An expression.
        box: An interval for every name.

    Returns:
        An interval that holds every value; `ANYTHING` where some may be NaN.
    """
    match expr:
        case Number(value=value):
            return value, value
        case Name(name=name):
            return box[name]
        case Call(function=function, arguments=arguments):
            return applied(function, [enclose(a, box) for a in arguments])
        case Negate(operand=operand):
            low, high = enclose(operand, box)
            return -high, -low
        case Binary(op="*", left=left, right=right) if left == right:
            return _square(enclose(left, box))
        case Binary(op=op, left=left, right=right):
            return _binary(op, enclose(left, box), enclose(right, box))
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
            return _checked([x * y for x in a for y in b])
        case "/":
            return _quotient(a, b)
        case "^":
            return raised(a, b)
    raise TypeError(f"{op!r} has no interval")


def _quotient(a: Interval, b: Interval) -> Interval:
    return ANYTHING if b[0] <= 0.0 <= b[1] else _checked([x / y for x in a for y in b])


def _checked(values: list[float]) -> Interval:
    if any(map(math.isnan, values)):
        return ANYTHING
    return min(values), max(values)


def _square(a: Interval) -> Interval:
    if a == ANYTHING:
        return ANYTHING
    ends = [a[0] * a[0], a[1] * a[1]]
    return (0.0 if a[0] <= 0.0 <= a[1] else min(ends)), max(ends)


def applied(function: str, a: list[Interval]) -> Interval:
    """Enclose a function of the expression language.

    Raises:
        TypeError: When there is no enclosure of it.
    """
    match function:
        case "min" | "smaller" if a[-1] != ANYTHING:
            lows, highs = zip(*a, strict=True)
            return min(lows), min(highs)
        case "max" | "larger" if a[-1] != ANYTHING:
            lows, highs = zip(*a, strict=True)
            return max(lows), max(highs)
        case "held":
            return (0.0, 1.0) if a[0] == ANYTHING else (_held(a[0][0]), _held(a[0][1]))
        case comparison if comparison in COMPARISONS:
            truth = None if ANYTHING in a else _compare(COMPARISONS[comparison], a[0], a[1])
            return (0.0, 1.0) if truth is None else (float(truth), float(truth))
    if ANYTHING in a:
        return ANYTHING
    low, high = a[0]
    match function:
        case "divide":
            return _quotient(a[0], a[1])
        case "abs":
            return (0.0 if low <= 0.0 <= high else min(abs(low), abs(high))), max(abs(low), abs(high))
        case "exp":
            return _exp(low)[0], _exp(high)[1]
        case "sqrt":
            return ANYTHING if low < 0.0 else (math.sqrt(low), math.sqrt(high))
        case "log":
            return ANYTHING if low < 0.0 else _widened([_log(low), _log(high)])
        case "sin":
            return _cosine((low - 0.5 * math.pi, high - 0.5 * math.pi))
        case "cos":
            return _cosine(a[0])
        case "tan":
            return _tangent(low, high)
        case "atan2":
            return _angle(a[0], a[1])
        case "sign":
            return sign(low), sign(high)
        case "floor":
            return floor(low), floor(high)
        case "ceil":
            return -floor(-low), -floor(-high)
        case "round":
            return rounded(low), rounded(high)
        case "mod" | "fmod":
            return _remainder(function, a[0], a[1])
    raise TypeError(f"function {function!r} has no interval")


def _remainder(function: str, a: Interval, b: Interval) -> Interval:
    """Enclose remainders: monotone in a as long as nothing wraps around, else between 0 and the divisor."""
    if b[0] <= 0.0 <= b[1] or math.isinf(a[0]) or math.isinf(a[1]):
        return ANYTHING
    divisor = max(abs(b[0]), abs(b[1]))
    low, high = (0.0 if b[0] > 0.0 else -divisor), (divisor if b[0] > 0.0 else 0.0)
    if function == "fmod":
        most = min(divisor, max(abs(a[0]), abs(a[1])))
        low, high = (-most if a[0] < 0.0 else 0.0), (most if a[1] > 0.0 else 0.0)
    if b[0] == b[1] and a[1] - a[0] < 0.5 * divisor and (function == "mod" or a[0] >= 0.0 or a[1] <= 0.0):
        ends = [SCALAR_FUNCTIONS[function](x, b[0]) for x in a]
        return (ends[0], ends[1]) if ends[0] <= ends[1] else (low, high)
    return low, high


def _held(x: float) -> float:
    return min(max(x, 0.0), 1.0)


def _log(x: float) -> float:
    return math.log(x) if x > 0.0 else -math.inf


def _widened(values: list[float]) -> Interval:
    """Return the hull of values that libraries compute with a relative error."""
    low, high = _checked(values)
    below = 0.0 if 0.0 <= low < _TINY else low - _margin(low)
    return below, (_TINY if 0.0 < high < _TINY else high + _margin(high))


def _margin(value: float) -> float:
    return 0.0 if math.isinf(value) else abs(value) * _ERROR


def _cosine(a: Interval) -> Interval:
    """Enclose cosines; a little slack covers the rounding of the angle, which `sin` shifts, and of the libraries."""
    low, high = a
    if math.isinf(low) or math.isinf(high):
        return ANYTHING
    if max(abs(low), abs(high)) > _FAR or high - low >= 2.0 * math.pi:
        return -1.0, 1.0
    slack = 1e-9
    turns = range(math.floor((low - slack) / math.pi), math.ceil((high + slack) / math.pi) + 1)
    tops = {n % 2 for n in turns if low - slack <= n * math.pi <= high + slack}
    ends, error = [math.cos(low), math.cos(high)], _ERROR * (1.0 + max(abs(low), abs(high)))
    return (
        -1.0 if 1 in tops else max(-1.0, min(ends) - error),
        1.0 if 0 in tops else min(1.0, max(ends) + error),
    )


def _tangent(low: float, high: float) -> Interval:
    """Enclose tangents between two poles."""
    if max(abs(low), abs(high)) > _FAR:
        return ANYTHING
    branches = {math.floor((x + side) / math.pi + 0.5) for x in (low, high) for side in (-1e-9, 1e-9)}
    return _widened([math.tan(low), math.tan(high)]) if len(branches) == 1 else ANYTHING


def _angle(y: Interval, x: Interval) -> Interval:
    """Enclose atan2, which is monotone in both arguments away from its cut."""
    if x[0] > 0.0 or y[0] > 0.0 or y[1] < 0.0:
        return _widened([math.atan2(v, u) for v in y for u in x])
    return -math.pi, math.pi


def raised(a: Interval, b: Interval) -> Interval:
    """Enclose powers; monotone in base and exponent where the base is not negative."""
    if ANYTHING in (a, b):
        return ANYTHING
    if a[0] <= 0.0 <= a[1] and b[0] < 0.0 and (b[0] != b[1] or b[0] % 2.0 == 1.0):
        return ANYTHING  # a negative odd power of -0.0 is -inf, and of 0.0 it is inf
    if a[0] >= 0.0:
        exponents = b if b[0] != b[1] else b[:1]
        return _widened([power(x, y) for x in a for y in exponents])
    if b[0] != b[1] or b[0] % 1.0 != 0.0:
        return ANYTHING
    if b[0] % 2.0 == 0.0:
        return raised(applied("abs", [a]), b)
    return _widened([power(x, b[0]) for x in a])


def _exp(x: float) -> Interval:
    try:
        value = math.exp(x)
    except OverflowError:
        return 1e308, math.inf
    if value < _TINY:
        return 0.0, 0.0 if x < -800.0 else _TINY
    return (value, value) if x == 0.0 else (value * (1.0 - _ERROR), value * (1.0 + _ERROR))
