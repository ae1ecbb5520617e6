"""Builder of programs: names, sums, maxima and what is left out."""

import math

from fuzzyctl.expr import ONE, ZERO, Binary, Call, Name, Number, Where, plus, times
from fuzzyctl.kernels.program.builder import Builder, any_nan, clip
from fuzzyctl.kernels.program.scalar import scalar_function

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
