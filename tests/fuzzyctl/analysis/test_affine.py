"""Expressions are read as sums in exact arithmetic, or not at all."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl import loads
from fuzzyctl.analysis.affine import Line, Reader, Taken
from fuzzyctl.expr import Binary, Call, Name, Negate, Number
from tests.fuzzyctl.analysis.proving import LINE

READER = Reader(loads(LINE))
E, DE, U = Name("e"), Name("de"), Name("u")
NUMBERS = st.floats(-100, 100).map(Number)


def sums():
    """Sums of inputs and numbers, with what they are exactly as a function of a point."""
    leaves = st.one_of(NUMBERS, st.sampled_from([E, DE]))

    def grow(inner):
        return st.one_of(
            st.builds(Binary, st.sampled_from(["+", "-"]), inner, inner),
            st.builds(lambda n, a: Binary("*", n, a), NUMBERS, inner),
            st.builds(lambda a, n: Binary("/", a, n), inner, NUMBERS.filter(lambda n: n.value != 0.0)),
            inner.map(Negate),
        )

    return st.recursive(leaves, grow, max_leaves=6)


def exactly(expr, point):
    match expr:
        case Number(value=value):
            return Fraction(value)
        case Name(name=name):
            return point[name]
        case Negate(operand=operand):
            return -exactly(operand, point)
    a, b = exactly(expr.left, point), exactly(expr.right, point)
    return {"+": a.__add__, "-": a.__sub__, "*": a.__mul__, "/": a.__truediv__}[expr.op](b)


@given(sums(), st.fractions(-9, 9), st.fractions(-9, 9))
def test_a_sum_has_the_value_of_the_expression(expr, e, de):
    found = READER.read(expr)
    assert not found.outputs
    assert all(found.inputs.values())
    value = found.number + sum(factor * (e, de)[i] for i, factor in found.inputs.items())
    assert value == exactly(expr, {"e": e, "de": de})


@pytest.mark.parametrize(
    "expr",
    [
        Binary("*", E, DE),
        Binary("*", U, U),
        Binary("/", Number(1.0), E),
        Binary("/", E, Number(0.0)),
        Binary("^", E, Number(2.0)),
        Call("abs", (E,)),
        Call("u", (Binary("*", E, E), DE)),
        Call("u", (U, DE)),
        Call("u", (Binary("+", E, DE), DE)),
        Name("nothing"),
        Number(float("inf")),
    ],
    ids=str,
)
def test_what_is_no_sum_is_not_read(expr):
    assert READER.read(expr) is None
    assert READER.read(Binary("+", E, expr)) is None


def test_params_count_as_numbers():
    assert READER.read(Binary("*", Binary("+", Name("c"), Number(1.0)), E)).inputs == {0: 2}


def test_an_output_is_taken_at_its_arguments():
    here = Taken(0, (Line(0, Fraction(1), Fraction(0)), Line(1, Fraction(1), Fraction(0))))
    assert READER.read(U).outputs == {here: 1}
    moved = READER.read(Binary("-", U, Call("u", (Negate(E), Binary("+", DE, Number(0.5))))))
    there = Taken(0, (Line(0, Fraction(-1), Fraction(0)), Line(1, Fraction(1), Fraction(1, 2))))
    assert moved.outputs == {here: 1, there: -1}
    assert READER.read(Binary("-", U, Call("u", (E, DE)))).outputs == {}


def test_a_line_is_exact_where_floats_do_not_round():
    assert READER.read(Negate(E)).line().is_exact
    assert not READER.read(Binary("+", E, Number(0.5))).line().is_exact
    assert READER.read(Binary("+", E, DE)).line() is None
    assert READER.read(Number(2.0)).line() == Line(None, Fraction(0), Fraction(2))
    assert Line(1, Fraction(2), Fraction(1)).at((Fraction(5), Fraction(3))) == 7
