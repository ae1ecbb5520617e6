"""Parser of MATLAB vectors of numbers: `[0 1.5, -pi/4 2*(1+3) -Inf]`."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Number
from fuzzyctl.support.numerals import TOO_LARGE

#: Deepest nesting of parentheses.
_DEEPEST: Final = 20

#: Largest number of numbers, signs and separators.
_LONGEST: Final = 20_000

_TOKEN: Final = re.compile(
    r"(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?)|(?P<name>[A-Za-z_]\w*)|(?P<sign>[-+*/^(),;])", re.ASCII
)

_NAMES: Final = {"pi": math.pi, "inf": math.inf, "infinity": math.inf, "eps": 2.0**-52}

_Token = tuple[str, str, int, int, bool]


class VectorError(ValueError):
    """Raised for a text that is no vector; `start` and `end` are places in the text."""

    def __init__(self, message: str, start: int, end: int, code: str = "FZ601") -> None:
        super().__init__(message)
        self.message, self.start, self.end, self.code = message, start, end, code


def read_vector(span: Span) -> tuple[Number, ...]:
    """Return the numbers of a text, each with its place.

    Elements are separated by blanks, commas or semicolons. As in MATLAB, a sign with a blank before it and none behind
    it begins an element: `[1 -2]` has two, `[1 - 2]` one.

    Raises:
        VectorError: For what is no vector of real numbers; its places count from the start of the source.
    """
    try:
        return _Vector(span.text).read(span)
    except VectorError as error:
        raise VectorError(error.message, span.start + error.start, span.start + error.end, error.code) from None


class _Vector:
    def __init__(self, text: str) -> None:
        self.text = text
        self.tokens = list(_tokens(text))
        self.next = 0
        self.depth = 0

    def read(self, span: Span) -> tuple[Number, ...]:
        found = []
        while self.next < len(self.tokens):
            if self._peek() in (",", ";"):
                self.next += 1
                continue
            first = self.tokens[self.next][2]
            value = self._sum()
            last = self.tokens[self.next - 1][3]
            found.append(Number(value, span=Span(span.source, span.start + first, span.start + last)))
        return tuple(found)

    def _peek(self) -> str:
        return self.tokens[self.next][1] if self.next < len(self.tokens) else ""

    def _sum(self) -> float:
        value = self._product()
        while self._peek() in ("+", "-") and not self._begins_element():
            operation = operator.add if self._take() == "+" else operator.sub
            value = self._computed(operation, value, self._product())
        return value

    def _begins_element(self) -> bool:
        """Whether the sign that comes next has a blank before it and none behind it; not within parentheses."""
        if self.depth:
            return False
        blank_before = self.tokens[self.next][4]
        follower = self.tokens[self.next + 1] if self.next + 1 < len(self.tokens) else None
        return blank_before and follower is not None and not follower[4]

    def _product(self) -> float:
        value = self._signed()
        while self._peek() in ("*", "/"):
            times = self._take() == "*"
            value = self._computed((lambda a, b: a * b) if times else (lambda a, b: a / b), value, self._signed())
        return value

    def _signed(self) -> float:
        negative = False
        while self._peek() in ("+", "-"):
            negative ^= self._take() == "-"
        value = self._power()
        return -value if negative else value

    def _power(self) -> float:
        value = self._atom()
        while self._peek() == "^":
            self._take()
            negative = False
            while self._peek() in ("+", "-"):
                negative ^= self._take() == "-"
            exponent = self._atom()
            value = self._computed(lambda a, b: a**b, value, -exponent if negative else exponent)
        return value

    def _atom(self) -> float:
        if self.next >= len(self.tokens):
            raise VectorError("expected a number", len(self.text), len(self.text))
        kind, text, start, end, _ = self.tokens[self.next]
        self.next += 1
        if kind == "number":
            return _finite(float(text.replace("d", "e").replace("D", "e")), start, end)
        if kind == "name" and text.lower() in _NAMES:
            return _NAMES[text.lower()]
        if text == "(":
            return self._inner(start, end)
        what = "is not a number" if text.lower() == "nan" else "is no number"
        raise VectorError(f"'{text[:40]}' {what}", start, end)

    def _inner(self, start: int, end: int) -> float:
        if self.depth >= _DEEPEST:
            raise VectorError("parentheses are nested too deeply", start, end)
        self.depth += 1
        value = self._sum()
        self.depth -= 1
        if self._peek() != ")":
            raise VectorError("a parenthesis is not closed", start, end)
        self.next += 1
        return value

    def _take(self) -> str:
        self.next += 1
        return self.tokens[self.next - 1][1]

    def _computed(self, operation: Callable[[float, float], float], left: float, right: float) -> float:
        start, end = self.tokens[self.next - 1][2:4]
        try:
            value = operation(left, right)
        except (ZeroDivisionError, OverflowError):
            raise VectorError("the value cannot be computed", start, end) from None
        if isinstance(value, complex) or math.isnan(value):
            raise VectorError("the value is not a real number", start, end)
        return value if math.isinf(left) or math.isinf(right) else _finite(value, start, end)


def _finite(value: float, start: int, end: int) -> float:
    if math.isinf(value):
        raise VectorError(TOO_LARGE, start, end, "FZ108")
    return value


def _tokens(text: str) -> list[_Token]:
    """Return kind, text, start, end and whether a blank stands before it, of each token."""
    found: list[_Token] = []
    at = 0
    blank = False
    while at < len(text):
        if text[at].isspace():
            at, blank = at + 1, True
            continue
        match = _TOKEN.match(text, at)
        if match is None:
            raise VectorError(f"'{text[at]}' has no place among numbers", at, at + 1)
        if len(found) >= _LONGEST:
            raise VectorError("there are too many numbers", at, match.end())
        found.append((str(match.lastgroup), match.group(), at, match.end(), blank))
        at, blank = match.end(), False
    return found
