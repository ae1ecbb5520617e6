"""Fast path for plain expressions; see `plain`."""

from __future__ import annotations

import math
import re
from typing import Any, Final, Literal, cast

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.source import SourceText, Span

NAME: Final = r"[A-Za-z_][A-Za-z0-9_]{0,50}"
NUMBER: Final = r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"

#: More operators, or more parentheses, are no plain expression; so none nests too deeply.
_MOST: Final = 95
_TOKEN: Final = re.compile(
    rf"[ \t\r\n]*(?:({NUMBER})(?![\w.])|({NAME}(?:\.{NAME})?)(?![\w.])|(<=|>=|==|!=|[-+*/^(),<>=])|$)"
)
#: Names that mean something else where an operator is expected, or everywhere.
_LOGIC: Final = frozenset({"and", "or", "not"})
_KEYWORDS: Final = _LOGIC | {"within", "when", "unit"}
#: How strongly operators bind; `^` and signs are read with their operand.
_OR, _AND, _NOT, _COMPARISON, _SUM, _PRODUCT, _POWER = range(1, 8)
_LEVELS: Final = {"or": _OR, "and": _AND, "+": _SUM, "-": _SUM, "*": _PRODUCT, "/": _PRODUCT} | dict.fromkeys(
    ("<", "<=", ">", ">=", "==", "!="), _COMPARISON
)


class NotPlainError(Exception):
    """Raised where the grammar has to read."""


class Reader:
    """Reads one expression after the other from a line.

    Args:
        source: The text.
        start: Where to begin.
        end: Where the line ends.
    """

    def __init__(self, source: SourceText, start: int, end: int) -> None:
        self.source = source
        self.number = self.name = self.sign = ""
        self._text, self._end, self.start, self.stop = source.text, end, start, start
        self._operators = self._parentheses = 0
        self.advance()

    def advance(self) -> None:
        """Take the next token; at the end of the line it is empty."""
        found = _TOKEN.match(self._text, self.stop, self._end)
        if found is None:
            raise NotPlainError
        number, name, sign = found.groups("")
        if sign == "(":
            self._parentheses += 1
        elif sign != "," and sign != ")":
            self._operators += bool(sign) or name in _LOGIC
        if self._operators > _MOST or self._parentheses > _MOST:
            raise NotPlainError
        self.number, self.name, self.sign = number, name, sign
        self.stop = found.end()
        self.start = self.stop - len(number or name or sign)

    @property
    def at_end(self) -> bool:
        """Whether nothing is left."""
        return not (self.number or self.name or self.sign)

    def claim(self) -> ex.Expr:
        """Read an expression that may be a condition."""
        return self._joined(_OR)

    def sum(self) -> ex.Expr:
        """Read an arithmetic expression."""
        return self._joined(_SUM)

    def _joined(self, weakest: int) -> ex.Expr:
        """Read operands joined by operators that bind at least as strongly as `weakest`.

        Each pair of parentheses takes few levels of Python's stack: an expression as deep as allowed is plain, too.
        """
        left = self._denied() if self.name == "not" and weakest <= _NOT else self._signed()
        while (level := _LEVELS.get(self.sign or self.name, 0)) >= weakest:
            left = self._chain(left, level) if level < _NOT else self._pair(left, level)
        return left

    def _chain(self, left: ex.Expr, level: int) -> ex.Expr:
        op = cast(Literal["and", "or"], self.name)
        operands = [left]
        while self.name == op:
            self.advance()
            operands.append(self._joined(level + 1))
        return ex.Logic(op, tuple(operands), self._join(operands[0], operands[-1]))

    def _denied(self) -> ex.Expr:
        at = Span(self.source, self.start, self.stop)
        self.advance()
        operand = self._joined(_NOT)
        return ex.Logic("not", (operand,), at.to(ex.span_of(operand) or at))

    def _pair(self, left: ex.Expr, level: int) -> ex.Expr:
        op: Any = self.sign
        self.advance()
        right = self._joined(level + 1)
        if level > _COMPARISON:
            return ex.Binary(op, left, right, self._join(left, right))
        if _LEVELS.get(self.sign) == _COMPARISON:
            raise NotPlainError
        return ex.Compare(op, left, right, self._join(left, right))

    def _signed(self) -> ex.Expr:
        if self.sign not in ("+", "-"):
            base = self._atom()
            return self._pair(base, _POWER) if self.sign == "^" else base
        sign, at = self.sign, Span(self.source, self.start, self.stop)
        self.advance()
        operand = self._signed()
        if sign == "+":
            return operand
        span = at.to(ex.span_of(operand) or at)
        if isinstance(operand, ex.Number) and not operand.text.startswith(("-", "(")):
            return ex.Number(-operand.value, f"-{operand.text}", span)
        return ex.Negate(operand, span)

    def _atom(self) -> ex.Expr:
        number, name, span = self.number, self.name, Span(self.source, self.start, self.stop)
        if number:
            self.advance()
            return ex.Number(finite(number), number, span)
        if name in _KEYWORDS:
            raise NotPlainError
        if name:
            self.advance()
            return self._call(name, span) if self.sign == "(" else ex.Name(name, span)
        self.expect("(")
        inner = self.claim()
        self.expect(")")
        return ex.Number(inner.value, f"({inner.text})", inner.span) if isinstance(inner, ex.Number) else inner

    def _call(self, name: str, span: Span) -> ex.Expr:
        arguments: list[ex.Expr] = []
        while not arguments or self.sign == ",":
            self.advance()
            arguments.append(self._argument())
        self.expect(")")
        end = ex.span_of(arguments[-1])
        return ex.Call(name, tuple(arguments), span.to(end) if end else span)

    def _argument(self) -> ex.Expr:
        """Read an argument of a call, by position or by name."""
        name, span = self.name, Span(self.source, self.start, self.stop)
        value = self.claim()
        if self.sign != "=":
            return value
        if not isinstance(value, ex.Name) or value.span != span or "." in name:
            raise NotPlainError
        self.advance()
        value = self.claim()
        return ex.Keyword(name, value, span.to(ex.span_of(value) or span))

    def parenthesis(self) -> ex.Expr:
        """Read an arithmetic expression in parentheses."""
        self.expect("(")
        inner = self.sum()
        self.expect(")")
        return inner

    def expect(self, sign: str) -> None:
        """Take a sign.

        Raises:
            NotPlainError: When the next token is another one.
        """
        if self.sign != sign:
            raise NotPlainError
        self.advance()

    def _join(self, left: ex.Expr, right: ex.Expr) -> Span | None:
        first, last = ex.span_of(left), ex.span_of(right)
        return first.to(last) if first is not None and last is not None else first or last


def finite(text: str) -> float:
    """Return the value of a number.

    Raises:
        NotPlainError: For one that a double cannot hold.
    """
    value = float(text)
    if math.isinf(value) or (value == 0.0 and any(c in "123456789" for c in text.lower().partition("e")[0])):
        raise NotPlainError
    return value
