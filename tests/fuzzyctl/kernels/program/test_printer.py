"""Texts of expressions for scalars and arrays."""

import math

import pytest

from fuzzyctl.expr import ONE, Binary, Call, Compare, Logic, Name, Negate, Number, Where
from fuzzyctl.kernels.program.printer import ARRAYS, SCALAR, number, text

X, Y = Name("x"), Name("y")


class TestPrinter:
    EXPR = Where(
        Logic("and", (Compare("<", X, ONE), Logic("not", (Compare("==", Y, Number(-2.0)),)))),
        Binary("/", Negate(X), Call("max", (X, Y))),
        Number(math.inf),
    )

    def test_writes_comparisons_for_scalars_and_calls_for_arrays(self):
        assert text(self.EXPR, SCALAR) == (
            "(((-x) / (x if x > y else y)) if ((x < 1.0) and (not ((y == (-2.0))))) else inf)"
        )
        assert text(self.EXPR, ARRAYS) == (
            "where(((x < 1.0) & (logical_not((y == (-2.0))))), divide((-x), maximum(x, y)), inf)"
        )

    @pytest.mark.parametrize("value", [0.1, -0.1, 1e-320, 1e308, -0.0, 1 / 3, math.inf, -math.inf])
    def test_numbers_read_back_bit_for_bit(self, value):
        back = eval(number(value), {"inf": math.inf})
        assert (back, math.copysign(1, back)) == (value, math.copysign(1, value))

    def test_what_has_no_text_is_refused(self):
        with pytest.raises(TypeError, match="object has no text"):
            text(object(), SCALAR)
