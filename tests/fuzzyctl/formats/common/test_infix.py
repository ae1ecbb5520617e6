"""Expressions are grouped by a table of operators, as Python groups them where its table is the same."""

import ast
import re

import hypothesis.strategies as st
import pytest
from hypothesis import given

from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.formats.common.infix import Operator, SpanParser, tokens_of

TOKEN = re.compile(r"\*\*|[a-z]+|[-+*/()]")
SIGNS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**", ast.And: "and", ast.Or: "or"}


INFIX = {
    "or": Operator(1, run=True),
    "and": Operator(2, run=True),
    **dict.fromkeys("+-", Operator(3)),
    **dict.fromkeys("*/", Operator(4)),
    "**": Operator(6, right=True),
}


class Grouped(SpanParser):
    """Text with parentheses around every operation."""

    infix = INFIX
    prefix = dict.fromkeys("-", 5)
    deepest = 30

    def __init__(self, text):
        self.tokens = [span for span, _ in tokens_of(Span(SourceText("t", text), 0, len(text)), TOKEN)]

    def _atom(self):
        place = self._take()
        if place.text != "(":
            return place.text
        found = self._nested(0, place)
        assert self._take().text == ")"
        return found

    def _unary(self, sign, operand, place):
        return f"({sign}{operand})"

    def _binary(self, sign, left, right, place):
        return f"({left} {sign} {right})"

    def _joined(self, sign, operands, places):
        assert len(places) == len(operands) - 1
        return f"({f' {sign} '.join(operands)})"

    def _too_deep(self, place):
        return RecursionError(place.text)


def grouped_by_python(node):
    match node:
        case ast.Name(id=name):
            return name
        case ast.UnaryOp(operand=operand):
            return f"(-{grouped_by_python(operand)})"
        case ast.BinOp(left=left, op=op, right=right):
            return f"({grouped_by_python(left)} {SIGNS[type(op)]} {grouped_by_python(right)})"
        case ast.BoolOp(op=op, values=values):
            return f"({f' {SIGNS[type(op)]} '.join(map(grouped_by_python, values))})"


def texts(parts):
    joined = st.tuples(parts, st.sampled_from([*SIGNS.values()]), parts).map(" ".join)
    return joined | parts.map("-({})".format) | parts.map("({})".format)


@given(st.recursive(st.sampled_from("abc"), texts, max_leaves=12))
def test_operators_bind_as_the_table_says(text):
    assert Grouped(text).parse() == grouped_by_python(ast.parse(text, mode="eval").body)


def test_a_run_of_one_operator_is_one_node():
    assert Grouped("a and b and (c and d) or a").parse() == "((a and b and (c and d)) or a)"


@pytest.mark.parametrize("text", ["(" * 31 + "a", "-" * 31 + "a", "a ** " * 31 + "a"])
def test_deep_nesting_is_refused(text):
    with pytest.raises(RecursionError):
        Grouped(text).parse()
    Grouped(text.removeprefix("a ** ").removeprefix("(").removeprefix("-").replace("(", "-")).parse()
