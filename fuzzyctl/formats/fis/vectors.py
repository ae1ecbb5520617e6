"""Vectors of numbers as MATLAB reads them: `[0 1.5, -pi/4 2*(1+3) -Inf]`."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Number
from fuzzyctl.formats.common.infix import Operator, SpanParser, tokens_of
from fuzzyctl.formats.common.report import Findings, ParseError
from fuzzyctl.support.numerals import TOO_LARGE

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


def trimmed(span: Span, start: int = 0, end: int | None = None) -> Span:
    """Return a part of a text without the blanks around it; the places of its ends are counted within the text."""
    text = span.text[start:end]
    left = len(text) - len(text.lstrip())
    first = span.start + min(start, len(span.text))
    return Span(span.source, first + left, first + max(left, len(text.rstrip())))


def inside_brackets(span: Span, findings: Findings) -> Span | None:
    """Return the text between brackets, which are optional; report a mistake and return None."""
    text = span.text.rstrip(";, ")
    if not text.startswith("["):
        return Span(span.source, span.start, span.start + len(text))
    close = text.find("]")
    if close < 0:
        findings.error("FZ103", "the bracket is not closed", Span(span.source, span.start, span.start + 1))
        return None
    rest = trimmed(span, close + 1, len(text))
    if rest.text:
        findings.error("FZ601", f"unexpected text behind the bracket: '{rest.text[:40]}'", rest)
        return None
    return Span(span.source, span.start + 1, span.start + close)


def vector(span: Span, findings: Findings) -> tuple[Number, ...] | None:
    """Return the numbers of a vector with their places; report a mistake and return None.

    Elements are separated by blanks, commas or semicolons. As in MATLAB, a sign with a blank before it and none behind
    it begins an element: `[1 -2]` has two, `[1 - 2]` one.
    """
    inner = inside_brackets(span, findings)
    if inner is None:
        return None
    try:
        return tuple(_Vector(inner).numbers())
    except ParseError as error:
        findings.refuse(error)
        return None


class _Vector(SpanParser[float]):
    infix: Mapping[str, Operator] = {
        **dict.fromkeys(("+", "-"), Operator(1)),
        **dict.fromkeys(("*", "/"), Operator(2)),
        "^": Operator(_POWER),
    }
    deepest = 20

    def __init__(self, span: Span) -> None:
        self.end = Span(span.source, span.end, span.end + 1)
        self.tokens = list(_tokens(span))

    def numbers(self) -> Iterator[Number]:
        while self.next < len(self.tokens):
            if self._text() in (",", ";"):
                self.next += 1
                continue
            first = self.tokens[self.next]
            value = self.parse()
            yield Number(value, span=first.to(self.tokens[self.next - 1]))

    def _peek(self) -> str:
        """Return the operator that comes next, and nothing for a sign that begins an element."""
        return "" if not self.depth and self._begins_element() else self._text()

    def _begins_element(self) -> bool:
        """Whether the next token is a sign with a blank before it and none behind it."""
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
            raise _mistake("expected a number", self.end)
        place = self._take()
        text = place.text.lower()
        if text[0] in ".0123456789":
            return _finite(float(text.replace("d", "e")), place)
        if text in _NAMES:
            return _NAMES[text]
        if text != "(":
            raise _mistake(f"'{place.text[:40]}' {'is not a number' if text == 'nan' else 'is no number'}", place)
        value = self._nested(0, place)
        if self._text() != ")":
            raise _mistake("a parenthesis is not closed", place)
        self.next += 1
        return value

    def _too_deep(self, place: Span) -> ParseError:
        return _mistake("parentheses are nested too deeply", place)

    def _binary(self, sign: str, left: float, right: float, place: Span) -> float:
        last = self.tokens[self.next - 1]
        try:
            value = _OPERATIONS[sign](left, right)
        except (ZeroDivisionError, OverflowError):
            raise _mistake("the value cannot be computed", last) from None
        if isinstance(value, complex) or math.isnan(value):
            raise _mistake("the value is not a real number", last)
        return value if math.isinf(left) or math.isinf(right) else _finite(value, last)


def _mistake(message: str, place: Span) -> ParseError:
    return ParseError(message, place, help="parameters are numbers, such as [0 2.5 pi/2]")


def _finite(value: float, place: Span) -> float:
    if math.isinf(value):
        raise ParseError(TOO_LARGE, place, "FZ108", help="write Inf")
    return value


def _tokens(span: Span) -> Iterator[Span]:
    for count, (place, matches) in enumerate(tokens_of(span, _TOKEN), 1):
        if not matches:
            raise _mistake(f"'{place.text}' has no place among numbers", place)
        if count > _LONGEST:
            raise _mistake("there are too many numbers", place)
        yield place
