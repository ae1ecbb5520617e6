"""Parser of FUNCTION expressions: sums, products, powers, calls and parentheses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, cast

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Binary, BinaryOp, Call, Expr, Negate, Number, span_of
from fuzzyctl.formats.common.infix import InfixParser, Operator
from fuzzyctl.formats.common.report import ParseError
from tests.oracles.fcl.cursor import MAX_DEPTH, Cursor
from tests.oracles.fcl.tokens import Token

#: Longest chain of terms, so that no expression is deeper than any reader of it can go.
_MOST_OPERATORS: Final = 80

#: A sign binds less than a power.
_POWER: Final = 4


def formula(cursor: Cursor) -> Expr:
    """Take an expression; functions keep the names they have in the file, in small letters."""
    return _Formula(cursor).parse()


class _Formula(InfixParser[Expr, Token]):
    infix: Mapping[str, Operator] = {
        **dict.fromkeys(("+", "-"), Operator(1)),
        **dict.fromkeys(("*", "/", "%"), Operator(2)),
        "^": Operator(_POWER),
    }
    prefix: Mapping[str, int] = {"+": 3, "-": 3}
    deepest = MAX_DEPTH

    def __init__(self, cursor: Cursor) -> None:
        self._cursor = cursor
        self._operators = 0

    def _peek(self) -> str:
        return self._cursor.here.text

    def _take(self) -> Token:
        return self._cursor.take()

    def _operand(self, least: int) -> Expr:
        return self._atom() if least > _POWER and self._peek() == "+" else super()._operand(least)

    def _unary(self, sign: str, operand: Expr, place: Token) -> Expr:
        if sign == "+":
            return operand
        span = self._from(place.start, operand)
        return Number(-operand.value, "", span) if isinstance(operand, Number) else Negate(operand, span)

    def _binary(self, sign: str, left: Expr, right: Expr, place: Token) -> Expr:
        self._count(right)
        if sign == "%":
            return Call("%", (left, right), self._cursor.span(place, place))
        if sign == "^" and self._peek() == "^":
            message = "'a ^ b ^ c' is read from the left by some tools, from the right by others"
            here = self._cursor.span(self._cursor.here, self._cursor.here)
            raise ParseError(message, here, help="write parentheses")
        first = span_of(left)
        return Binary(cast(BinaryOp, sign), left, right, self._from(first.start if first is not None else 0, right))

    def _atom(self) -> Expr:
        cursor, token = self._cursor, self._cursor.here
        if cursor.accept("("):
            inside = self._nested(0, token)
            cursor.expect(")", what="')'")
            return inside
        if token.kind == "name" and cursor.after.text == "(":
            return self._call(cursor.take())
        value = cursor.value() if token.kind in ("name", "number") else None
        if value is None:
            raise cursor.unexpected("a number, a variable or '('")
        return value

    def _call(self, name: Token) -> Expr:
        cursor = self._cursor
        cursor.take()
        self._enter(name)
        arguments = [self.parse()]
        while cursor.accept(","):
            arguments.append(self.parse())
        self.depth -= 1
        cursor.expect(")", what="')'")
        return Call(name.text.lower(), tuple(arguments), cursor.span(name))

    def _count(self, last: Expr) -> None:
        """Count an operator by its right operand; there may not be any number of them."""
        self._operators += 1
        if self._operators > _MOST_OPERATORS:
            message = f"the expression has more than {_MOST_OPERATORS} operators"
            raise ParseError(message, span_of(last), "FZ106")

    def _from(self, start: int, last: Expr) -> Span:
        place = span_of(last)
        return Span(self._cursor.source, start, place.end if place is not None else self._cursor.before.end)

    def _too_deep(self, place: Token) -> ParseError:
        message = f"parentheses are nested more than {MAX_DEPTH} deep"
        return ParseError(message, self._cursor.span(self._cursor.here, self._cursor.here), "FZ106")
