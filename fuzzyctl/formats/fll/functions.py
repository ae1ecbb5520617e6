"""Parser of the formulas of `Function` terms: `2.5 * sin(x) ^ 2 - pow(y, 3) * lt(x, 0)`."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Binary, BinaryOp, Call, Expr, Name, Negate, Number
from fuzzyctl.formats.common.report import Reading
from fuzzyctl.formats.fuzzylite.functions import ARGUMENTS, expanded, is_too_large, is_truth, negation, truth
from fuzzyctl.support.numerals import TOO_LARGE

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


class FormulaError(ValueError):
    """Raised for a formula that cannot be read; `code` is that of the diagnostic."""

    def __init__(self, message: str, span: Span, code: str = "FZ601") -> None:
        super().__init__(message)
        self.message, self.span, self.code = message, span, code


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
        FormulaError: For a text that is no formula, or one that uses what is not available.
    """
    return _Formula(span, names, python, differs).read()


class _Formula:
    def __init__(self, span: Span, names: Collection[str], python: bool, differs: Callable[[Reading], None]) -> None:
        self.span = span
        self.names = names
        self.python = python
        self.differs = differs
        self.tokens = self._tokens()
        self.next = 0
        self.depth = 0

    def read(self) -> Expr:
        expr = self._either()
        if self.next < len(self.tokens):
            text, place = self.tokens[self.next]
            raise FormulaError(f"unexpected '{text[:40]}' in the formula", place)
        if is_too_large(expr):
            raise FormulaError("the formula is too long", self.span)
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

    def _either(self) -> Expr:
        """Return a chain of `or`, which binds less than `and`, as that does than sums."""
        return self._joined("or", "max", lambda: self._joined("and", "min", self._sum))

    def _joined(self, word: str, function: str, part: Callable[[], Expr]) -> Expr:
        operands = [part()]
        while self._peek() == word and word not in self.names:
            _, place = self._take()
            if len(operands) > _MOST_OPERANDS:
                raise FormulaError("the formula is too long", place)
            if len(operands) == 1:
                operands = [self._truth(operands[0], place)]
            operands.append(self._truth(part(), place))
        return operands[0] if len(operands) == 1 else Call(function, tuple(operands))

    def _truth(self, operand: Expr, place: Span) -> Expr:
        self._warn_of_number(operand, place)
        return truth(operand, python=self.python)

    def _warn_of_number(self, operand: Expr, place: Span) -> None:
        if not is_truth(operand):
            message = f"an operand of '{place.text}' may be another number than 0 and 1; it is true where it is 1"
            self._tell(Reading(message, "in pyfuzzylite it is true unless it is 0", "compare it", place))

    def _tell(self, reading: Reading) -> None:
        if not self.python:
            self.differs(reading)

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
            right = self._unary()
            left = self._remainder(left, right, place) if sign == "%" else self._binary(sign, left, right, place)
        return left

    def _remainder(self, left: Expr, right: Expr, place: Span) -> Expr:
        message = "the remainder '%' has the sign of what is divided"
        self._tell(Reading(message, "in pyfuzzylite it has that of the divisor", "write fmod(a, b)", place))
        return Call("mod" if self.python else "fmod", (left, right), place)

    def _unary(self) -> Expr:
        """Return a signed power; a sign binds less than the power behind it."""
        if self._peek() not in _SIGNS:
            return self._power()
        sign, place = self._take()
        self._enter(place)
        operand = self._unary()
        self.depth -= 1
        return Negate(operand, place) if sign.endswith("-") else operand

    def _power(self) -> Expr:
        base = self._prefixed()
        if self._peek() not in ("^", "**"):
            return base
        _, place = self._take()
        self._enter(place)
        exponent = self._unary()
        self.depth -= 1
        return Binary("^", base, exponent, place)

    def _prefixed(self) -> Expr:
        """Return an atom, perhaps negated by `~` or `!`, which bind more than powers."""
        if self._peek() not in ("~", "!"):
            return self._atom()
        sign, place = self._take()
        self._enter(place)
        operand = self._unary() if self._peek() in _SIGNS else self._prefixed()
        self.depth -= 1
        if sign == "~":
            return Negate(operand, place)
        self._warn_of_number(operand, place)
        return negation(operand, python=self.python)

    def _atom(self) -> Expr:
        text, place = self._take()
        if text == "(":
            self._enter(place)
            inner = self._either()
            self.depth -= 1
            self._expect(")", place)
            return inner
        if text[0] in "0123456789.":
            if math.isinf(float(text)):
                raise FormulaError(TOO_LARGE, place, "FZ108")
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
            arguments.append(self._either())
            while self._peek() == ",":
                self._take()
                arguments.append(self._either())
        self._expect(")", place)
        self.depth -= 1
        if name == "pi" and not arguments:
            return Name("pi", place)
        if name not in _FUNCTIONS and name not in ARGUMENTS:
            raise FormulaError(f"there is no function '{name[:40]}' here", place, "FZ602")
        own, due = _FUNCTIONS.get(name, (name, ARGUMENTS.get(name, 2)))
        if len(arguments) != due:
            raise FormulaError(f"'{name}' takes {counted(due, 'argument')}, got {len(arguments)}", place)
        if name not in ARGUMENTS or (name == "round" and self.python):
            return Call(own, tuple(arguments), place)
        if name == "round":
            message = "'round' of a number halfway between two whole ones gives the one farther from 0"
            self._tell(Reading(message, "in pyfuzzylite it gives the even one", "write floor(x + 0.5)", place))
        found = expanded(name, arguments)
        if found is None:
            raise FormulaError("the formula is too long", place)
        return found

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
