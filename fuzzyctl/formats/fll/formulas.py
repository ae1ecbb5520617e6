"""Formulas of `Function` terms, `2.5 * sin(x) ^ 2 - pow(y, 3) * lt(x, 0)`: their functions, parser and writer."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from decimal import Decimal
from typing import Final, cast

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import (
    COMPARISONS,
    FUNCTIONS,
    MAX_DEPTH,
    ONE,
    ZERO,
    Binary,
    BinaryOp,
    Call,
    Expr,
    Name,
    Negate,
    Number,
    children,
    number_text,
)
from fuzzyctl.formats.common.infix import Operator, SpanParser, tokens_of
from fuzzyctl.formats.common.report import ParseError, Reading
from fuzzyctl.formats.common.words import first_words
from fuzzyctl.support.files import TOO_LARGE

#: Limits of a formula: nesting of parentheses and signs, tokens, operands of a chain of `and` or `or`.
_DEEPEST: Final = 50
_LONGEST: Final = 2000
_MOST_OPERANDS: Final = 50

#: Larger expressions are refused: nested functions that use their argument twice grow fast.
_MOST_PARTS: Final = 5000

# --- functions -----------------------------------------------------------------------------------------------------

#: Functions of fuzzylite with the same function of the model.
_SAME: Final[dict[str, str]] = {
    **{n: n for n in ("abs", "sqrt", "exp", "log", "sin", "cos", "tan", "atan2", "min", "max")},
    **{n: n for n in ("floor", "ceil", "fmod", "lt", "le", "gt", "ge", "eq")},
    "fabs": "abs",
    "neq": "ne",
}


def _cathetus(x: Expr) -> Expr:
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
    """Return 1 if an operand of logic is true, else 0.

    Args:
        expr: The operand.
        python: Whether all but 0 is true, NaN included, as in pyfuzzylite; else 1 alone, as in fuzzylite.
    """
    if is_truth(expr):
        return expr
    return Call("ne", (expr, ZERO)) if python else Call("eq", (expr, ONE))


def negation(expr: Expr, *, python: bool) -> Expr:
    """Return 1 if an operand of logic is not true, else 0; see `truth`."""
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


#: The other functions, as expressions of those of the model.
_EXPRESSIONS: Final[dict[str, Callable[..., Expr]]] = {
    "log10": lambda x: _log(x) / _log(Number(10.0)),
    "log1p": lambda x: _log(1.0 + x),
    "asin": lambda x: Call("atan2", (x, _cathetus(x))),
    "acos": lambda x: Call("atan2", (_cathetus(x), x)),
    "atan": lambda x: Call("atan2", (x, ONE)),
    "sinh": lambda x: 0.5 * (_exp(x) - _exp(0.0 - x)),
    "cosh": lambda x: 0.5 * (_exp(x) + _exp(0.0 - x)),
    "tanh": _tanh,
    "asinh": _asinh,
    "acosh": _acosh,
    "round": _away_from_zero,
    "atanh": lambda x: 0.5 * _log((1.0 + x) / (1.0 - x)),
    "pow": lambda a, b: a**b,
    "neq": lambda a, b: Call("ne", (a, b)),
}

#: Number of arguments of each function of `expanded`.
ARGUMENTS: Final[dict[str, int]] = {name: 2 if name in ("pow", "neq") else 1 for name in _EXPRESSIONS}

#: Names that no variable may have, since fuzzylite sees functions in rules too.
FUNCTION_WORDS: Final = frozenset({*_SAME, *ARGUMENTS})


def expanded(name: str, arguments: Sequence[Expr]) -> Expr | None:
    """Return a call of a function of `ARGUMENTS` as an expression of the model; None if it is too large."""
    expr = _EXPRESSIONS[name](*arguments)
    return None if is_too_large(expr) else expr


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


# --- parser --------------------------------------------------------------------------------------------------------

_TOKEN: Final = re.compile(
    r"(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)|(?P<name>[^\W\d][\w.]*)|(?P<sign>\*\*|\.[-+]|[-+*/%^(),!~])"
)

#: Signs of numbers, which bind less than powers; pyfuzzylite has them with a dot.
_SIGNS: Final = ("+", "-", ".+", ".-")


def read_formula(
    span: Span,
    names: Collection[str],
    *,
    python: bool = False,
    differs: Callable[[Reading], None] = lambda reading: None,
) -> Expr:
    """Return a formula as an expression.

    Args:
        span: The text.
        names: Names that it may use.
        python: Whether pyfuzzylite reads it, not fuzzylite.
        differs: Called with each difference between the two, unless `python` is set.

    Raises:
        ParseError: If the text is not a formula, or uses unknown names and functions.
    """
    return _Formula(span, names, python, differs).read()


#: Operators with their levels: a sign binds less than a power, `~` and `!` bind more. Logic binds least of all.
_OPERATORS: Final = {
    "or": Operator(1, run=True),
    "and": Operator(2, run=True),
    **dict.fromkeys(("+", "-"), Operator(3)),
    **dict.fromkeys(("*", "/", "%"), Operator(4)),
    **dict.fromkeys(("^", "**"), Operator(6, right=True)),
}
_LOGIC: Final = {"or": "max", "and": "min"}


class _Formula(SpanParser[Expr]):
    infix = _OPERATORS
    prefix: Mapping[str, int] = {**dict.fromkeys(_SIGNS, 5), "~": 7, "!": 7}
    deepest = _DEEPEST

    def __init__(self, span: Span, names: Collection[str], python: bool, differs: Callable[[Reading], None]) -> None:
        self.span = span
        self.names = names
        self.python = python
        self.differs = differs
        self.tokens = list(self._tokens())

    def read(self) -> Expr:
        expr = self.parse()
        if self.next < len(self.tokens):
            place = self.tokens[self.next]
            raise ParseError(f"unexpected '{place.text[:40]}' in the formula", place)
        if is_too_large(expr):
            raise ParseError("the formula is too long", self.span)
        return expr

    def _tokens(self) -> Iterator[Span]:
        for count, (place, matches) in enumerate(tokens_of(self.span, _TOKEN), 1):
            if not matches:
                raise ParseError(f"'{place.text}' has no place in a formula", place)
            if count > _LONGEST:
                raise ParseError("the formula is too long", place)
            yield place

    def _peek(self) -> str:
        text = self._text()
        return "" if text in _LOGIC and text in self.names else text

    def _take(self) -> Span:
        if self.next >= len(self.tokens):
            end = Span(self.span.source, self.span.end, self.span.end)
            raise ParseError("the formula ends too early", end)
        return super()._take()

    def _joined(self, sign: str, operands: Sequence[Expr], places: Sequence[Span]) -> Expr:
        if len(operands) > _MOST_OPERANDS + 1:
            raise ParseError("the formula is too long", places[_MOST_OPERANDS])
        return Call(_LOGIC[sign], tuple(operands))

    def _of_run(self, operand: Expr, place: Span) -> Expr:
        self._warn_of_number(operand, place)
        return truth(operand, python=self.python)

    def _warn_of_number(self, operand: Expr, place: Span) -> None:
        if not is_truth(operand):
            message = f"an operand of '{place.text}' may be another number than 0 and 1; it is true where it is 1"
            self._tell(Reading(message, "in pyfuzzylite it is true unless it is 0", "compare it", place))

    def _tell(self, reading: Reading) -> None:
        if not self.python:
            self.differs(reading)

    def _binary(self, sign: str, left: Expr, right: Expr, place: Span) -> Expr:
        if sign != "%":
            return Binary("^" if sign == "**" else cast(BinaryOp, sign), left, right, place)
        message = "the remainder '%' has the sign of what is divided"
        self._tell(Reading(message, "in pyfuzzylite it has that of the divisor", "write fmod(a, b)", place))
        return Call("mod" if self.python else "fmod", (left, right), place)

    def _unary(self, sign: str, operand: Expr, place: Span) -> Expr:
        if sign == "!":
            self._warn_of_number(operand, place)
            return negation(operand, python=self.python)
        return operand if sign.endswith("+") else Negate(operand, place)

    def _atom(self) -> Expr:
        place = self._take()
        text = place.text
        if text == "(":
            inner = self._nested(0, place)
            self._expect_end(place)
            return inner
        if text[0] in "0123456789.":
            if math.isinf(float(text)):
                raise ParseError(TOO_LARGE, place, "FZ108")
            return Number(float(text), span=place)
        if self._text() == "(" and text not in self.names:
            return self._call(text, place)
        if text in self.names or text == "pi":
            return Name(text, place)
        if text in ("and", "or") or text in _SAME or not text[0].isalpha():
            raise ParseError(f"unexpected '{text[:40]}' in the formula", place)
        raise ParseError(f"the formula names '{text[:40]}', which is no variable here", place, "FZ202")

    def _call(self, name: str, place: Span) -> Expr:
        self._enter(place)
        self._take()
        arguments: list[Expr] = []
        if self._text() != ")":
            arguments.append(self.parse())
            while self._text() == ",":
                self._take()
                arguments.append(self.parse())
        self._expect_end(place)
        self.depth -= 1
        if name == "pi" and not arguments:
            return Name("pi", place)
        if name not in _SAME and name not in ARGUMENTS:
            raise ParseError(f"there is no function '{name[:40]}' here", place, "FZ602")
        count = ARGUMENTS[name] if name in ARGUMENTS else FUNCTIONS[_SAME[name]][1] or 2
        if len(arguments) != count:
            raise ParseError(f"'{name}' takes {counted(count, 'argument')}, got {len(arguments)}", place)
        if name in _SAME or (name == "round" and self.python):
            return Call(_SAME.get(name, name), tuple(arguments), place)
        if name == "round":
            message = "'round' of a number halfway between two whole ones gives the one farther from 0"
            self._tell(Reading(message, "in pyfuzzylite it gives the even one", "write floor(x + 0.5)", place))
        expr = expanded(name, arguments)
        if expr is None:
            raise ParseError("the formula is too long", place)
        return expr

    def _too_deep(self, place: Span) -> ParseError:
        return ParseError("the formula is nested too deeply", place)

    def _expect_end(self, opened: Span) -> None:
        if self._text() != ")":
            raise ParseError("a parenthesis is not closed", opened, "FZ103")
        self.next += 1


# --- writer --------------------------------------------------------------------------------------------------------

_WRITTEN: Final = first_words(_SAME)


def formula(expr: Expr, params: Mapping[str, float], *, python: bool = False) -> str | None:
    """Return an expression as a formula with parentheses around every operation; None if fuzzylite has no such one.

    Args:
        expr: The expression.
        params: Values of the names that are not variables.
        python: Whether pyfuzzylite reads it, whose `%` and `round` are those of the model, unlike fuzzylite's.
    """

    def joined(form: str, *parts: Expr) -> str | None:
        texts = [text for part in parts if (text := written(part)) is not None]
        return form.format(*texts) if len(texts) == len(parts) else None

    def written(expr: Expr) -> str | None:
        match expr:
            case Number(value=value):
                return _number(value)
            case Name(name=name):
                return _number(params[name]) if name in params else name
            case Negate(operand=operand):
                return joined("(0 - {})", operand)
            case Binary(op=op, left=left, right=right):
                return joined(f"({{}} {op} {{}})", left, right)
            case Call(function="sign", arguments=arguments):
                return joined("(gt({0}, 0) - gt(0, {0}))", *arguments)
            case Call(function="mod", arguments=(left, right)) if python:
                return joined("({} % {})", left, right)
            case Call(function="round", arguments=arguments) if python:
                return joined("round({})", *arguments)
            case Call(function="min" | "max" as function, arguments=arguments):  # of two there
                form = "{}"
                for _ in arguments[1:]:
                    form = f"{function}({form}, {{}})"
                return joined(form, *arguments)
            case Call(function=function, arguments=arguments) if function in _WRITTEN:
                return joined(f"{_WRITTEN[function]}({', '.join('{}' for _ in arguments)})", *arguments)
        return None

    return written(expr)


def _number(value: float) -> str:
    """Return a number without a sign and without an exponent, which formulas there take for sums."""
    text = number_text(abs(value))
    text = f"{Decimal(text):f}" if "e" in text else text
    return text if value >= 0 else f"(0 - {text})"
