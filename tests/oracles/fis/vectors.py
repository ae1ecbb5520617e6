"""Parser of MATLAB vectors of numbers: `[0 1.5, -pi/4 2*(1+3) -Inf]`."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Number
from fuzzyctl.formats.common.infix import Operator, SpanParser, tokens_of
from fuzzyctl.formats.common.report import ParseError
from fuzzyctl.support.shipped import TOO_LARGE

#: Deepest nesting of parentheses.
_DEEPEST: Final = 20

#: Largest number of numbers, signs and separators.
_LONGEST: Final = 20_000

_TOKEN: Final = re.compile(r"(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?|[A-Za-z_]\w*|[-+*/^(),;]", re.ASCII)

_NAMES: Final = {"pi": math.pi, "inf": math.inf, "infinity": math.inf, "eps": 2.0**-52}

_OPERATIONS: Final[Mapping[str, Callable[[float, float], float]]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "^": operator.pow,
}

_POWER: Final = 3


def read_vector(span: Span) -> tuple[Number, ...]:
    """Return the numbers of a text, each with its place.

    Elements are separated by blanks, commas or semicolons. As in MATLAB, a sign with a blank before it and none behind
    it begins an element: `[1 -2]` has two, `[1 - 2]` one.

    Raises:
        ParseError: For what is no vector of real numbers.
    """
    return tuple(_Vector(span).read())


class _Vector(SpanParser[float]):
    infix: Mapping[str, Operator] = {
        **dict.fromkeys(("+", "-"), Operator(1)),
        **dict.fromkeys(("*", "/"), Operator(2)),
        "^": Operator(_POWER),
    }
    deepest = _DEEPEST

    def __init__(self, span: Span) -> None:
        self.end = Span(span.source, span.end, span.end)
        self.tokens = list(_tokens(span))

    def read(self) -> Iterator[Number]:
        while self.next < len(self.tokens):
            if self._text() in (",", ";"):
                self.next += 1
                continue
            first = self.tokens[self.next]
            value = self.parse()
            yield Number(value, span=first.to(self.tokens[self.next - 1]))

    def _peek(self) -> str:
        """Return the operator that comes next; a sign that begins an element is none."""
        return "" if not self.depth and self._begins_element() else self._text()

    def _begins_element(self) -> bool:
        """Whether a sign comes next with a blank before it and none behind it."""
        if self._text() not in ("+", "-") or self.next + 1 >= len(self.tokens):
            return False
        before, sign, follower = self.tokens[self.next - 1 : self.next + 2]
        return before.end < sign.start and sign.end == follower.start

    def _operand(self, least: int) -> float:
        """Take an atom with its signs, which bind less than a power, but belong to the exponent that they begin."""
        negative = False
        while (sign := self._text()) in ("+", "-"):
            negative ^= sign == "-"
            self.next += 1
        value = self.parse(_POWER) if least < _POWER else self._atom()
        return -value if negative else value

    def _atom(self) -> float:
        if self.next >= len(self.tokens):
            raise ParseError("expected a number", self.end)
        place = self._take()
        text = place.text.lower()
        if text[0] in ".0123456789":
            return _finite(float(text.replace("d", "e")), place)
        if text in _NAMES:
            return _NAMES[text]
        if text == "(":
            value = self._nested(0, place)
            if self._text() != ")":
                raise ParseError("a parenthesis is not closed", place)
            self.next += 1
            return value
        raise ParseError(f"'{place.text[:40]}' is not a number", place)

    def _too_deep(self, place: Span) -> ParseError:
        return ParseError("parentheses are nested too deeply", place)

    def _binary(self, sign: str, left: float, right: float, place: Span) -> float:
        last = self.tokens[self.next - 1]
        try:
            value = _OPERATIONS[sign](left, right)
        except (ZeroDivisionError, OverflowError):
            raise ParseError("the value cannot be computed", last) from None
        if isinstance(value, complex) or math.isnan(value):
            raise ParseError("the value is not a real number", last)
        return value if math.isinf(left) or math.isinf(right) else _finite(value, last)


def _finite(value: float, place: Span) -> float:
    if math.isinf(value):
        raise ParseError(TOO_LARGE, place, "FZ108")
    return value


def _tokens(span: Span) -> Iterator[Span]:
    for count, (place, matches) in enumerate(tokens_of(span, _TOKEN), 1):
        if not matches:
            raise ParseError(f"'{place.text}' has no place among numbers", place)
        if count > _LONGEST:
            raise ParseError("there are too many numbers", place)
        yield place
