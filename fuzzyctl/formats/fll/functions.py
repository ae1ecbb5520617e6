"""Reads the formulas of `Function` terms: `2.5 * sin(x) ^ 2 - pow(y, 3)`."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import Final

from fuzzyctl.errors import counted
from fuzzyctl.expr import Binary, BinaryOp, Call, Expr, Name, Negate, Number
from fuzzyctl.formats.functions import ARGUMENTS, expanded
from fuzzyctl.source import Span

#: Deepest nesting of parentheses and signs.
_DEEPEST: Final = 50

#: Largest number of tokens.
_LONGEST: Final = 2000

_TOKEN: Final = re.compile(
    r"(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[^\W\d][\w.]*)|(?P<sign>\*\*|[-+*/%^(),!~])"
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
}


class FormulaError(ValueError):
    """Raised for a formula that cannot be read; `code` is that of the diagnostic."""

    def __init__(self, message: str, span: Span, code: str = "FZ601") -> None:
        super().__init__(message)
        self.message, self.span, self.code = message, span, code


def read_formula(span: Span, names: Collection[str]) -> Expr:
    """Return a formula as an expression.

    Args:
        span: The text.
        names: What it may name.

    Raises:
        FormulaError: For a text that is no formula, or one that uses what is not available.
    """
    return _Formula(span, names).read()


class _Formula:
    def __init__(self, span: Span, names: Collection[str]) -> None:
        self.span = span
        self.names = names
        self.tokens = self._tokens()
        self.next = 0
        self.depth = 0

    def read(self) -> Expr:
        expr = self._sum()
        if self.next < len(self.tokens):
            text, place = self.tokens[self.next]
            raise FormulaError(f"unexpected '{text[:40]}' in the formula", place)
        return expr

    def _tokens(self) -> list[tuple[str, Span]]:
        found: list[tuple[str, Span]] = []
        text, at = self.span.text, 0
        while at < len(text):
            if text[at].isspace():
                at += 1
                continue
            match = _TOKEN.match(text, at)
            end = at + 1 if match is None else match.end()
            place = Span(self.span.source, self.span.start + at, self.span.start + end)
            if match is None:
                raise FormulaError(f"'{text[at]}' has no place in a formula", place)
            found.append((match.group(), place))
            if len(found) > _LONGEST:
                raise FormulaError("the formula is too long", place)
            at = end
        return found

    def _peek(self) -> str:
        return self.tokens[self.next][0] if self.next < len(self.tokens) else ""

    def _take(self) -> tuple[str, Span]:
        if self.next >= len(self.tokens):
            end = Span(self.span.source, self.span.end, self.span.end)
            raise FormulaError("the formula ends too early", end)
        self.next += 1
        return self.tokens[self.next - 1]

    def _sum(self) -> Expr:
        left = self._product()
        while self._peek() in ("+", "-"):
            sign, place = self._take()
            left = self._binary(sign, left, self._product(), place)
        return left

    def _product(self) -> Expr:
        left = self._unary()
        while self._peek() in ("*", "/", "%"):
            sign, place = self._take()
            if sign == "%":
                raise FormulaError("there is no remainder '%' here", place, "FZ602")
            left = self._binary(sign, left, self._unary(), place)
        return left

    def _unary(self) -> Expr:
        """Return a signed power; a sign binds less than the power behind it."""
        sign = self._peek()
        if sign not in ("+", "-", "~", "!"):
            return self._power()
        _, place = self._take()
        if sign == "!":
            raise FormulaError("there is no logic in formulas here", place, "FZ602")
        self._enter(place)
        operand = self._unary()
        self.depth -= 1
        return operand if sign == "+" else Negate(operand, place)

    def _power(self) -> Expr:
        base = self._atom()
        if self._peek() not in ("^", "**"):
            return base
        _, place = self._take()
        self._enter(place)
        exponent = self._unary()
        self.depth -= 1
        return Binary("^", base, exponent, place)

    def _atom(self) -> Expr:
        text, place = self._take()
        if text == "(":
            self._enter(place)
            inner = self._sum()
            self.depth -= 1
            self._expect(")", place)
            return inner
        if text[0].isdigit() or text[0] == ".":
            return Number(float(text), span=place)
        if self._peek() == "(" and text not in self.names:
            return self._call(text, place)
        if text in self.names:
            return Name(text, place)
        if text == "pi":
            return Name("pi", place)
        if text in ("and", "or") or text in _FUNCTIONS or not text[0].isalpha():
            raise FormulaError(f"unexpected '{text[:40]}' in the formula", place)
        raise FormulaError(f"the formula names '{text[:40]}', which is no variable here", place, "FZ202")

    def _call(self, name: str, place: Span) -> Expr:
        self._enter(place)
        self._take()
        arguments: list[Expr] = []
        if self._peek() != ")":
            arguments.append(self._sum())
            while self._peek() == ",":
                self._take()
                arguments.append(self._sum())
        self._expect(")", place)
        self.depth -= 1
        if name == "pi" and not arguments:
            return Name("pi", place)
        if name not in _FUNCTIONS and name not in ARGUMENTS:
            raise FormulaError(f"there is no function '{name[:40]}' here", place, "FZ602")
        own, due = _FUNCTIONS.get(name, (name, ARGUMENTS.get(name, 2)))
        if len(arguments) != due:
            raise FormulaError(f"'{name}' takes {counted(due, 'argument')}, got {len(arguments)}", place)
        if name in ARGUMENTS:
            return expanded(name, arguments)
        return Call(own, tuple(arguments), place)

    def _binary(self, sign: str, left: Expr, right: Expr, place: Span) -> Expr:
        operators: dict[str, BinaryOp] = {"+": "+", "-": "-", "*": "*", "/": "/"}
        return Binary(operators[sign], left, right, place)

    def _enter(self, place: Span) -> None:
        self.depth += 1
        if self.depth > _DEEPEST:
            raise FormulaError("the formula is nested too deeply", place)

    def _expect(self, due: str, opened: Span) -> None:
        if self._peek() != due:
            raise FormulaError("a parenthesis is not closed", opened, "FZ103")
        self.next += 1
