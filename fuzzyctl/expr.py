"""Expression language shared by rule files, formulas and kernels.

An expression is a frozen tree. Rule files write them (`param f_max = (k_h_min - G_min) / k_s`), `formulas` builds the
membership functions from them, and each interpreter (the evaluator here, the printers in `kernels`, interval
analysis) reads the same tree, so that proofs are about the expression that is computed.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import Final, Literal

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.records import record

#: Deepest nesting an expression may have; deeper ones are refused when they are built from text.
MAX_DEPTH: Final = 100

BinaryOp = Literal["+", "-", "*", "/", "^"]
CompareOp = Literal["<", "<=", ">", ">=", "==", "!="]

#: Functions that are 1 where a comparison holds and 0 where it does not, under the names of IEC 61131-3.
COMPARISONS: Final[dict[str, CompareOp]] = {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "eq": "==", "ne": "!="}

_NAMES_OF_COMPARISONS: Final = {op: name for name, op in COMPARISONS.items()}

#: Functions that are 1 or 0, and conditions as well.
TRUTHS: Final = frozenset({*COMPARISONS, "hysteresis", "pulse"})

#: Functions whose names params, inputs and terms may have as well: a parenthesis behind the name tells them apart.
SOFT: Final = frozenset({"floor", "ceil", "round", "mod", "fmod", *COMPARISONS})

#: Named constants of the language.
CONSTANTS: Final[dict[str, float]] = {"pi": math.pi, "inf": math.inf}


@record(frozen=True, slots=True)
class Expr:
    """Base of all expression nodes; `span` and the typed text take no part in equality.

    Arithmetic operators build expressions: `1.0 - x` is `Binary("-", Number(1.0), x)`. Comparisons do not, since `==`
    compares trees.
    """

    def __add__(self, other: Expr | float) -> Binary:
        return Binary("+", self, _operand(other))

    def __radd__(self, other: float) -> Binary:
        return Binary("+", Number(other), self)

    def __sub__(self, other: Expr | float) -> Binary:
        return Binary("-", self, _operand(other))

    def __rsub__(self, other: float) -> Binary:
        return Binary("-", Number(other), self)

    def __mul__(self, other: Expr | float) -> Binary:
        return Binary("*", self, _operand(other))

    def __rmul__(self, other: float) -> Binary:
        return Binary("*", Number(other), self)

    def __truediv__(self, other: Expr | float) -> Binary:
        return Binary("/", self, _operand(other))

    def __rtruediv__(self, other: float) -> Binary:
        return Binary("/", Number(other), self)

    def __pow__(self, other: Expr | float) -> Binary:
        return Binary("^", self, _operand(other))

    def __neg__(self) -> Negate:
        return Negate(self)


def _operand(value: Expr | float) -> Expr:
    return value if isinstance(value, Expr) else Number(value)


@record(frozen=True, slots=True)
class Number(Expr):
    """A number; `text` is how it was typed."""

    value: float
    text: str = field(default="", compare=False)
    span: Span | None = field(default=None, compare=False, repr=False)


@record(frozen=True, slots=True)
class Name(Expr):
    """A param, a variable or a named constant."""

    name: str
    span: Span | None = field(default=None, compare=False, repr=False)


@record(frozen=True, slots=True)
class Negate(Expr):
    """Arithmetic negation."""

    operand: Expr
    span: Span | None = field(default=None, compare=False, repr=False)


@record(frozen=True, slots=True)
class Binary(Expr):
    """An arithmetic operation; `^` is the power."""

    op: BinaryOp
    left: Expr
    right: Expr
    span: Span | None = field(default=None, compare=False, repr=False)


@record(frozen=True, slots=True)
class Compare(Expr):
    """A comparison; its value is a truth value."""

    op: CompareOp
    left: Expr
    right: Expr
    span: Span | None = field(default=None, compare=False, repr=False)


@record(frozen=True, slots=True)
class Logic(Expr):
    """`and` / `or` of two or more truth values, `not` of one."""

    op: Literal["and", "or", "not"]
    operands: tuple[Expr, ...]
    span: Span | None = field(default=None, compare=False, repr=False)


@record(frozen=True, slots=True)
class Call(Expr):
    """A function applied to arguments; in a guarantee also an output at shifted arguments."""

    function: str
    arguments: tuple[Expr, ...]
    span: Span | None = field(default=None, compare=False, repr=False)


@record(frozen=True, slots=True)
class Where(Expr):
    """`then` where the condition holds, `otherwise` elsewhere; built by formulas only, never typed."""

    condition: Expr
    then: Expr
    otherwise: Expr


@record(frozen=True, slots=True)
class Keyword(Expr):
    """`name=value` among the arguments of a call, in controllers."""

    name: str
    value: Expr
    span: Span | None = field(default=None, compare=False, repr=False)


@record(frozen=True, slots=True)
class Pair(Expr):
    """`key: value` among the arguments of a call, in loops: a time and the value from then on."""

    key: Expr
    value: Expr
    span: Span | None = field(default=None, compare=False, repr=False)


@record(frozen=True, slots=True)
class Items(Expr):
    """`[a, b, ...]` among the arguments of a call, in plants: coefficients, or the rows of a matrix."""

    items: tuple[Expr, ...]
    span: Span | None = field(default=None, compare=False, repr=False)


@record(frozen=True, slots=True)
class Text(Expr):
    """`"text"` among the arguments of a call, in plants and loops: the name of a file or of a column."""

    text: str
    span: Span | None = field(default=None, compare=False, repr=False)


ZERO: Final = Number(0.0)
ONE: Final = Number(1.0)


#: The name of an overflow in messages.
TOO_LARGE: Final = "the value is too large"
#: The names of a quotient by 0, of an argument as in log(0), and of a number as inf - inf in messages.
DIVISION: Final = "division by zero"
DOMAIN: Final = "an argument lies outside the function's domain"
NO_NUMBER: Final = "the value is not a real number"
#: How each is repaired.
REPAIRS: Final = {
    TOO_LARGE: "scale it: the largest number is 1.8e308",
    DIVISION: "give the divisor a value other than 0",
    DOMAIN: "sqrt takes numbers from 0 on, log those above 0; below 0 powers are whole",
    NO_NUMBER: "write a number in place of inf",
}


class ExprError(ValueError):
    """Raised when an expression has no value; `span` is the innermost part that fails, `help` the repair if known."""

    def __init__(self, message: str, span: Span | None) -> None:
        super().__init__(message)
        self.message, self.span = message, span
        self.help = REPAIRS.get(message, "")


def span_of(expr: Expr) -> Span | None:
    """Return the place of an expression in its text, if it came from one."""
    return getattr(expr, "span", None)


def children(expr: Expr) -> tuple[Expr, ...]:
    """Return the direct parts of an expression."""
    if type(expr) is Name or type(expr) is Number:  # most parts are
        return ()
    match expr:
        case Negate(operand=operand):
            return (operand,)
        case Binary(left=left, right=right) | Compare(left=left, right=right):
            return (left, right)
        case Logic(operands=operands):
            return operands
        case Call(arguments=arguments):
            return arguments
        case Where(condition=condition, then=then, otherwise=otherwise):
            return (condition, then, otherwise)
        case Keyword(value=value):
            return (value,)
        case Pair(key=key, value=value):
            return (key, value)
        case Items(items=items):
            return items
    return ()


def walk(expr: Expr) -> list[Expr]:
    """Return an expression and all its parts, each before its parts."""
    results: list[Expr] = []
    stack = [expr]
    while stack:
        node = stack.pop()
        results.append(node)
        if type(node) is Binary:
            stack += (node.right, node.left)
        elif type(node) is not Number and type(node) is not Name:  # which have none
            stack.extend(reversed(children(node)))
    return results


def names_in(expr: Expr) -> list[Name]:
    """Return the names an expression uses, in order of appearance."""
    if type(expr) is Number:  # nearly all expressions of a system are
        return []
    return [node for node in walk(expr) if isinstance(node, Name)]


def replace_names(expr: Expr, by: Mapping[str, Expr]) -> Expr:
    """Return an expression with some names replaced by expressions; the others stay."""
    return replace(expr, lambda node: by.get(node.name, node) if isinstance(node, Name) else node)


def replace(expr: Expr, change: Callable[[Expr], Expr]) -> Expr:
    """Return an expression rebuilt from its leaves up, each rebuilt part passed through `change`."""
    match expr:
        case Number() | Name():  # most parts are
            return change(expr)
        case Binary(op=op, left=left, right=right):
            return change(Binary(op, replace(left, change), replace(right, change)))
        case Negate(operand=operand):
            return change(Negate(replace(operand, change)))
        case Compare(op=compare, left=left, right=right):
            return change(Compare(compare, replace(left, change), replace(right, change)))
        case Logic(op=logic, operands=operands):
            return change(Logic(logic, tuple(replace(o, change) for o in operands)))
        case Call(function=function, arguments=arguments):
            return change(Call(function, tuple(replace(a, change) for a in arguments)))
        case Where(condition=condition, then=then, otherwise=otherwise):
            return change(Where(replace(condition, change), replace(then, change), replace(otherwise, change)))
        case Keyword(name=name, value=value):
            return change(Keyword(name, replace(value, change)))
        case Pair(key=key, value=value):
            return change(Pair(replace(key, change), replace(value, change)))
        case Items(items=items):
            return change(Items(tuple(replace(item, change) for item in items)))
    return change(expr)


def rebuilt(expr: Expr, parts: Sequence[Expr]) -> Expr:
    """Return an expression with other children and its span; itself if they are the same."""
    if all(part is own for part, own in zip(parts, children(expr), strict=True)):
        return expr
    match expr:
        case Binary(op=operator, span=span):
            left, right = parts
            return Binary(operator, left, right, span)
        case Call(function=function, span=span):
            return Call(function, tuple(parts), span)
        case Logic(op=op, span=span):
            return Logic(op, tuple(parts), span)
    fields = [f.name for f in dataclasses.fields(expr) if isinstance(getattr(expr, f.name), Expr)]
    return dataclasses.replace(expr, **dict(zip(fields, parts, strict=True)))


def is_condition(expr: Expr, value_of: Callable[[Name | Call], Expr | None], path: tuple[str, ...] = ()) -> bool:
    """Return whether an expression is a condition, or the name or a call of one, which is 1 or 0.

    Args:
        expr: The expression.
        value_of: Returns the expression that a name or a call stands for; None for any other.
        path: The names that led to it.
    """
    if isinstance(expr, Name | Call):
        name = expr.name if isinstance(expr, Name) else expr.function
        value = None if name in path else value_of(expr)
        if value is not None:
            return is_condition(value, value_of, (*path, name))
    match expr:  # `and`, `or` and `not` as numbers, see `as_number`
        case Call(function="min" | "max", arguments=parts):
            return all(is_condition(p, value_of, path) for p in parts)
        case Binary(op="-", left=Number(value=1.0), right=right):
            return is_condition(right, value_of, path)
    return isinstance(expr, Compare | Logic) or (isinstance(expr, Call) and expr.function in TRUTHS)


def as_number(expr: Expr) -> Expr:
    """Return an expression in which each condition is a number: 1 where it holds, else 0; locations stay."""
    match expr:
        case Compare(op=op, left=left, right=right, span=span):
            return Call(_NAMES_OF_COMPARISONS[op], (as_number(left), as_number(right)), span)
        case Logic(op="not", operands=(operand,), span=span):
            return Binary("-", ONE, as_number(operand), span)
        case Logic(op=logic, operands=operands, span=span):
            return Call("min" if logic == "and" else "max", tuple(map(as_number, operands)), span)
        case Negate(operand=operand, span=span):
            return Negate(as_number(operand), span)
        case Binary(op=arithmetic, left=left, right=right, span=span):
            return Binary(arithmetic, as_number(left), as_number(right), span)
        case Call(function=function, arguments=arguments, span=span):
            return Call(function, tuple(map(as_number, arguments)), span)
        case Keyword(name=name, value=value, span=span):
            return Keyword(name, as_number(value), span)
    return expr


def evaluate(expr: Expr, names: Mapping[str, float]) -> float:
    """Compute an arithmetic expression.

    Args:
        expr: An expression without comparisons and logic.
        names: Values of the names it uses, besides the named constants.

    Returns:
        Its value, which is infinite only where `inf` was written.

    Raises:
        ExprError: For an unknown name, a division by zero, an argument outside a function's domain, an overflow, or a
            comparison in the place of a number.
    """
    match expr:
        case Number(value=value):
            return value
        case Name(name=name, span=span):
            return _look_up(name, names, span)
        case Negate(operand=operand):
            return -evaluate(operand, names)
        case Binary(op=op, left=left, right=right, span=span):
            return _checked(_BINARY[op], (evaluate(left, names), evaluate(right, names)), span)
        case Call(function=function, arguments=arguments, span=span):
            if function not in FUNCTIONS:
                raise ExprError(f"no function {function!r}", span)
            return _checked(SCALAR_FUNCTIONS[function], tuple(evaluate(a, names) for a in arguments), span)
    raise ExprError("expected a number, found a condition", span_of(expr))


def _look_up(name: str, names: Mapping[str, float], span: Span | None) -> float:
    if name in names:
        return names[name]
    if name in CONSTANTS:
        return CONSTANTS[name]
    raise ExprError(f"no param {name!r}", span)


def _checked(compute: Callable[..., float], arguments: tuple[float, ...], span: Span | None) -> float:
    try:
        value = compute(*arguments)
    except ZeroDivisionError:
        raise ExprError(DIVISION, span) from None
    except OverflowError:
        raise ExprError(TOO_LARGE, span) from None
    except ValueError:
        raise ExprError(DOMAIN, span) from None
    if math.isnan(value):
        raise ExprError(NO_NUMBER, span)
    # Python's products and sums overflow to infinity without a word.
    if math.isinf(value) and not any(map(math.isinf, arguments)):
        raise ExprError(TOO_LARGE, span)
    return value


def sign(x: float) -> float:
    """Return -1, 0 or 1 with the sign of x; NaN for NaN."""
    return 1.0 if x > 0.0 else -1.0 if x < 0.0 else x * 0.0


def floor(x: float) -> float:
    """Return the largest whole number not above x, with the sign of x where it is 0; NaN and infinities stay."""
    return math.copysign(float(math.floor(x)), x) if abs(x) < 2.0**53 else x  # from there on all numbers are whole


def rounded(x: float) -> float:
    """Return the nearest whole number, of two the even one; NaN and infinities stay."""
    whole = float(round(x)) if abs(x) < 2.0**53 else x
    return x if whole == x else whole


def modulo(a: float, b: float) -> float:
    """Return the remainder of a / b with the sign of b, as IEEE 754's fmod gives it; NaN if undefined.

    Raises:
        ValueError: For an infinite a, and where b is 0.
    """
    rest = math.fmod(a, b)
    return rest + b if (rest < 0.0 < b) or (b < 0.0 < rest) else rest


def _power(base: float, exponent: float) -> float:
    value = base**exponent
    if isinstance(value, complex):
        raise ValueError
    return float(value)


_BINARY: Final[dict[str, Callable[[float, float], float]]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "^": _power,
}

#: The functions, with how many arguments they take (None: one or more); they raise where they have no value.
_FUNCTIONS: Final[dict[str, tuple[Callable[..., float], int | None]]] = {
    "abs": (abs, 1),
    "min": (lambda *values: min(values), None),
    "max": (lambda *values: max(values), None),
    "sqrt": (math.sqrt, 1),
    "exp": (math.exp, 1),
    "log": (math.log, 1),
    "sin": (math.sin, 1),
    "cos": (math.cos, 1),
    "tan": (math.tan, 1),
    "atan2": (math.atan2, 2),
    "sign": (sign, 1),
    "floor": (floor, 1),
    "ceil": (lambda x: -floor(-x), 1),
    "round": (rounded, 1),
    "mod": (modulo, 2),
    "fmod": (math.fmod, 2),
    "lt": (lambda a, b: float(a < b), 2),
    "le": (lambda a, b: float(a <= b), 2),
    "gt": (lambda a, b: float(a > b), 2),
    "ge": (lambda a, b: float(a >= b), 2),
    "eq": (lambda a, b: float(a == b), 2),
    "ne": (lambda a, b: float(a != b), 2),
}
#: Functions a rule file may call, with the least and the largest number of arguments that they take (None: any).
FUNCTIONS: Final[dict[str, tuple[int, int | None]]] = {n: (count or 1, count) for n, (_, count) in _FUNCTIONS.items()}
#: The functions for floats.
SCALAR_FUNCTIONS: Final[dict[str, Callable[..., float]]] = {n: function for n, (function, _) in _FUNCTIONS.items()}

_PRECEDENCE: Final = {"or": 1, "and": 2, "not": 3, "compare": 4, "+": 5, "-": 5, "*": 6, "/": 6, "neg": 7, "^": 8}


def number_text(value: float) -> str:
    """Return the shortest text that reads back as the same number, bit for bit."""
    if math.isinf(value):
        return "inf" if value > 0 else "-inf"
    if value == int(value) and abs(value) < 1e15 and not (value == 0 and math.copysign(1, value) < 0):
        return str(int(value))
    return repr(value)


def to_text(expr: Expr) -> str:
    """Return an expression as a rule file would write it, with no more parentheses than it needs."""
    return _text(expr, 0)


def _text(expr: Expr, outer: int) -> str:
    match expr:
        case Number(value=value, text=typed):
            text = typed or number_text(value)
            return f"({text})" if text.startswith("-") and outer > _PRECEDENCE["neg"] else text
        case Name(name=name):
            return name
        case Call(function=function, arguments=arguments):
            return f"{function}({', '.join(_text(a, 0) for a in arguments)})"
        case Negate(operand=operand):
            inner = _text(operand, _PRECEDENCE["neg"])
            if isinstance(operand, Number) and inner[0] not in "-(":
                inner = f"({inner})"  # else it would read back as a negative number
            return _wrap(f"-{inner}", _PRECEDENCE["neg"], outer)
        case Binary(op="^", left=left, right=right):
            own = _PRECEDENCE["^"]
            return _wrap(f"{_text(left, own + 1)}^{_text(right, _PRECEDENCE['neg'])}", own, outer)
        case Binary(op=op, left=left, right=right):
            own = _PRECEDENCE[op]
            return _wrap(f"{_text(left, own)} {op} {_text(right, own + 1)}", own, outer)
        case Compare(op=compare, left=left, right=right):
            own = _PRECEDENCE["compare"]
            return _wrap(f"{_text(left, own + 1)} {compare} {_text(right, own + 1)}", own, outer)
        case Logic(op="and", operands=(Compare(left=left) as above, Compare(right=right) as below)) if (
            above.span is not None and above.span is below.span
        ):  # written as one
            ends = f"{'[' if above.op == '>=' else '('}{to_text(above.right)}, {to_text(right)}"
            own = _PRECEDENCE["compare"]
            return _wrap(f"{_text(left, own + 1)} in {ends}{']' if below.op == '<=' else ')'}", own, outer)
        case Logic(op="not", operands=operands):
            return _wrap(f"not {_text(operands[0], _PRECEDENCE['not'])}", _PRECEDENCE["not"], outer)
        case Logic(op=logic, operands=operands):
            own = _PRECEDENCE[logic]
            return _wrap(f" {logic} ".join(_text(o, own + 1) for o in operands), own, outer)
        case Keyword(name=name, value=value):
            return f"{name}={_text(value, 0)}"
        case Pair(key=key, value=value):
            return f"{_text(key, 0)}: {_text(value, 0)}"
        case Items(items=items):
            return f"[{', '.join(_text(item, 0) for item in items)}]"
        case Text(text=text):
            return f'"{text}"'
    raise TypeError(f"{type(expr).__name__} has no text in a rule file")


def _wrap(text: str, own: int, outer: int) -> str:
    return f"({text})" if own < outer else text


def plus(a: Expr, b: Expr) -> Expr:
    """Return a + b without summands of 0."""
    return b if a == ZERO else a if b == ZERO else a + b


def minus(a: Expr, b: Expr) -> Expr:
    """Return a - b without subtrahends of 0."""
    return a if b == ZERO else a - b


def times(a: Expr, b: Expr) -> Expr:
    """Return a · b; a factor 1 is left out."""
    if a == ONE:
        return b
    if b == ONE:
        return a
    return a * b
