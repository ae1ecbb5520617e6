import math

import numpy as np
import pytest

from fuzzyctl.expr import ONE, ZERO, Binary, Call, Compare, Logic, Name, Negate, Number, Where
from fuzzyctl.kernels.program.builder import Builder, any_nan, clip, plus, times
from fuzzyctl.kernels.program.printer import ARRAYS, SCALAR, number, text
from fuzzyctl.kernels.program.scalar import RUNTIME, scalar_function

X, Y = Name("x"), Name("y")


class TestBuilder:
    def test_computes_each_value_once(self):
        builder = Builder()
        assert builder.let(Binary("*", X, Y)) == builder.let(Binary("*", X, Y)) == Name("v1")
        assert len(builder.statements) == 1

    def test_names_the_operands_of_min_and_max(self):
        builder = Builder()
        builder.let(Call("max", (Binary("+", X, ONE), Y, Call("min", (X, Binary("*", Y, Y))))))
        for statement in builder.statements:
            for node in (statement.value,):
                if isinstance(node, Call):
                    assert all(isinstance(a, Name | Number) for a in node.arguments)

    def test_the_body_of_a_loop_shares_names_and_tables(self):
        builder = Builder()
        inner = builder.inner()
        assert builder.fresh() != inner.fresh()
        assert inner.table([1.0]) == builder.table([1.0])
        assert inner.table([2.0]) != builder.table([1.0])

    def test_sums_and_maxima_of_nothing_are_zero(self):
        assert Builder().total([]) == Builder().largest([]) == ZERO

    def test_nothing_is_added_or_multiplied_in_vain(self):
        assert plus(ZERO, X) == plus(X, ZERO) == times(ONE, X) == times(X, ONE) == X


class TestClip:
    def test_holds_within_and_lets_nan_through(self):
        function = scalar_function(clip(X, -1.0, 2.0))
        assert [function(v) for v in (-math.inf, -1.0, 0.5, 3.0)] == [-1.0, -1.0, 0.5, 2.0]
        assert math.isnan(function(math.nan))

    def test_any_nan_tells_nan_only(self):
        function = scalar_function(Where(any_nan([X, Y]), ONE, ZERO))
        assert [function(1.0, math.inf), function(math.nan, 0.0), function(0.0, math.nan)] == [0.0, 1.0, 1.0]


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


class TestRuntime:
    @pytest.mark.parametrize(
        ("name", "arguments"),
        [
            ("divide", (1.0, 0.0)),
            ("divide", (-1.0, 0.0)),
            ("divide", (1.0, -0.0)),
            ("divide", (0.0, 0.0)),
            ("divide", (math.nan, 0.0)),
            ("divide", (3.0, 4.0)),
            ("power", (0.0, -1.0)),
            ("power", (-0.0, -1.0)),
            ("power", (0.0, -2.0)),
            ("power", (-8.0, 0.5)),
            ("power", (-10.0, 309.0)),
            ("power", (10.0, 400.0)),
            ("power", (2.0, 0.5)),
            ("log", (0.0,)),
            ("log", (-1.0,)),
            ("log", (2.0,)),
            ("sqrt", (-1.0,)),
            ("exp", (1000.0,)),
            ("sin", (math.inf,)),
            ("atan2", (1.0, -0.0)),
        ],
    )
    def test_plain_python_follows_ieee_754_as_numpy_does(self, name, arguments):
        functions = {"atan2": np.arctan2}
        with np.errstate(all="ignore"):
            expected = functions.get(name, getattr(np, name, None))(*map(np.float64, arguments))
        np.testing.assert_allclose(RUNTIME[name](*arguments), expected, rtol=1e-15)

    def test_generated_text_reaches_nothing_else(self):
        assert set(RUNTIME["__builtins__"]) == {"range", "type", "float", "abs"}
