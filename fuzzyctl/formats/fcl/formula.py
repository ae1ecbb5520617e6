"""Parser of FUNCTION expressions: sums, products, powers, calls and parentheses."""

from __future__ import annotations

from typing import Final, cast

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Binary, BinaryOp, Call, Expr, Negate, Number, span_of
from fuzzyctl.formats.fcl.cursor import MAX_DEPTH, Cursor, Slip

#: Longest chain of terms, so that no expression is deeper than any reader of it can go.
_MOST_OPERATORS: Final = 80


def formula(cursor: Cursor) -> Expr:
    """Take an expression; functions keep the names they have in the file, in small letters."""
    return _Formula(cursor).sum(0)


class _Formula:
    def __init__(self, cursor: Cursor) -> None:
        self._cursor = cursor
        self._operators = 0

    def sum(self, depth: int) -> Expr:
        left = self._product(depth)
        while (token := self._cursor.accept("+", "-")) is not None:
            left = self._joined(cast(BinaryOp, token.text), left, self._product(depth))
        return left

    def _product(self, depth: int) -> Expr:
        left = self._signed(depth)
        while (token := self._cursor.accept("*", "/", "%")) is not None:
            right = self._signed(depth)
            if token.text == "%":
                self._count(right)
                left = Call("%", (left, right), self._cursor.span(token, token))
            else:
                left = self._joined(cast(BinaryOp, token.text), left, right)
        return left

    def _signed(self, depth: int) -> Expr:
        token = self._cursor.accept("+", "-")
        if token is None:
            return self._power(depth)
        self._deeper(depth)
        operand = self._signed(depth + 1)
        if token.text == "+":
            return operand
        place = self._from(token.start, operand)
        return Number(-operand.value, "", place) if isinstance(operand, Number) else Negate(operand, place)

    def _power(self, depth: int) -> Expr:
        base = self._atom(depth)
        if self._cursor.accept("^") is None:
            return base
        power = self._joined("^", base, self._signed(depth) if self._cursor.here.text == "-" else self._atom(depth))
        if self._cursor.here.text == "^":
            message = "'a ^ b ^ c' is read from the left by some tools, from the right by others"
            place = self._cursor.span(self._cursor.here, self._cursor.here)
            raise Slip(Diagnostic("FZ601", message, place, help="write parentheses"))
        return power

    def _atom(self, depth: int) -> Expr:
        cursor, token = self._cursor, self._cursor.here
        if cursor.accept("("):
            self._deeper(depth)
            inside = self.sum(depth + 1)
            cursor.expect(")", what="')'")
            return inside
        if token.kind == "name" and cursor.after.text == "(":
            return self._call(depth)
        value = cursor.value() if token.kind in ("name", "number") else None
        if value is None:
            raise cursor.unexpected("a number, a variable or '('")
        return value

    def _call(self, depth: int) -> Expr:
        cursor, token = self._cursor, self._cursor.take()
        cursor.take()
        self._deeper(depth)
        arguments = [self.sum(depth + 1)]
        while cursor.accept(","):
            arguments.append(self.sum(depth + 1))
        cursor.expect(")", what="')'")
        return Call(token.text.lower(), tuple(arguments), cursor.span(token))

    def _joined(self, op: BinaryOp, left: Expr, right: Expr) -> Expr:
        self._count(right)
        place = span_of(left)
        return Binary(op, left, right, self._from(place.start if place is not None else 0, right))

    def _count(self, last: Expr) -> None:
        """Count an operator by its right operand; there may not be any number of them."""
        self._operators += 1
        if self._operators > _MOST_OPERATORS:
            message = f"the expression has more than {_MOST_OPERATORS} operators"
            raise Slip(Diagnostic("FZ106", message, span_of(last)))

    def _from(self, start: int, last: Expr) -> Span:
        place = span_of(last)
        return Span(self._cursor.source, start, place.end if place is not None else self._cursor.before.end)

    def _deeper(self, depth: int) -> None:
        if depth >= MAX_DEPTH:
            message = f"parentheses are nested more than {MAX_DEPTH} deep"
            raise Slip(Diagnostic("FZ106", message, self._cursor.span(self._cursor.here, self._cursor.here)))
