"""Parser of the formulas of `Function` terms: `2.5 * sin(x) ^ 2 - pow(y, 3) * lt(x, 0)`."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import Final, cast

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Binary, BinaryOp, Call, Expr, Name, Negate, Number
from fuzzyctl.formats.common.infix import Operator, SpanParser, tokens_of
from fuzzyctl.formats.common.report import ParseError, Reading
from fuzzyctl.formats.fll.formulas import ARGUMENTS, expanded, is_too_large, is_truth, negation, truth
from fuzzyctl.support.shipped import TOO_LARGE

#: Deepest nesting of parentheses and signs.
_DEEPEST: Final = 50

#: Largest number of tokens.
_LONGEST: Final = 2000

#: Most operands of a chain of `and` or `or`.
_MOST_OPERANDS: Final = 50

_TOKEN: Final = re.compile(
    r"(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)|(?P<name>[^\W\d][\w.]*)|(?P<sign>\*\*|\.[-+]|[-+*/%^(),!~])"
)

#: Functions of fuzzylite that are here too, with the number of their arguments.
_FUNCTIONS: Final[dict[str, tuple[str, int]]] = {
    "abs": ("abs", 1),
    "fabs": ("abs", 1),
    "sqrt": ("sqrt", 1),
    "exp": ("exp", 1),
    "log": ("log", 1),
    "sin": ("sin", 1),
    "cos": ("cos", 1),
    "tan": ("tan", 1),
    "atan2": ("atan2", 2),
    "min": ("min", 2),
    "max": ("max", 2),
    "floor": ("floor", 1),
    "ceil": ("ceil", 1),
    "fmod": ("fmod", 2),
    "lt": ("lt", 2),
    "le": ("le", 2),
    "gt": ("gt", 2),
    "ge": ("ge", 2),
    "eq": ("eq", 2),
    "neq": ("ne", 2),
}

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
        names: What it may name.
        python: Whether it is read as pyfuzzylite reads it, not as fuzzylite does.
        differs: Called with what the two read differently, unless `python` says whose it is.

    Raises:
        ParseError: For a text that is no formula, or one that uses what is not available.
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
        if text in self.names:
            return Name(text, place)
        if text == "pi":
            return Name("pi", place)
        if text in ("and", "or") or text in _FUNCTIONS or not text[0].isalpha():
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
        if name not in _FUNCTIONS and name not in ARGUMENTS:
            raise ParseError(f"there is no function '{name[:40]}' here", place, "FZ602")
        own, due = _FUNCTIONS.get(name, (name, ARGUMENTS.get(name, 2)))
        if len(arguments) != due:
            raise ParseError(f"'{name}' takes {counted(due, 'argument')}, got {len(arguments)}", place)
        if name not in ARGUMENTS or (name == "round" and self.python):
            return Call(own, tuple(arguments), place)
        if name == "round":
            message = "'round' of a number halfway between two whole ones gives the one farther from 0"
            self._tell(Reading(message, "in pyfuzzylite it gives the even one", "write floor(x + 0.5)", place))
        found = expanded(name, arguments)
        if found is None:
            raise ParseError("the formula is too long", place)
        return found

    def _too_deep(self, place: Span) -> ParseError:
        return ParseError("the formula is nested too deeply", place)

    def _expect_end(self, opened: Span) -> None:
        if self._text() != ")":
            raise ParseError("a parenthesis is not closed", opened, "FZ103")
        self.next += 1
