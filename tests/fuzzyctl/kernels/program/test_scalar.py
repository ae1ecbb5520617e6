"""What generated Python calls."""

import math
import re
import traceback

import numpy as np
import pytest

from fuzzyctl.expr import Binary, Call, Name
from fuzzyctl.kernels.backends.numpy_backend import array_function
from fuzzyctl.kernels.program.scalar import RUNTIME, scalar_function


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


class TestPrintedText:
    @pytest.mark.parametrize("function", [scalar_function, array_function])
    def test_of_any_number_of_values_there_is_a_least_and_a_largest(self, function):
        x, y, z = map(Name, "xyz")
        least, largest = function(Call("min", (x, y, z))), function(Call("max", (x, y, z)))
        assert [least(3.0, 1.0, 2.0), largest(3.0, 1.0, 2.0), function(Call("min", (x,)))(4.0)] == [1.0, 3.0, 4.0]

    @pytest.mark.parametrize(
        ("name", "count", "message"),
        [
            ("foo", 1, "no function 'foo'"),
            ("sin", 2, "'sin' takes 1 argument, not 2"),
            ("atan2", 1, "'atan2' takes 2 arguments, not 1"),
            ("min", 0, "'min' takes 1 argument, not 0"),
        ],
    )
    def test_a_call_that_cannot_be_computed_is_refused_when_its_text_is_made(self, name, count, message):
        for function in (scalar_function, array_function):
            with pytest.raises(TypeError, match=re.escape(message)):
                function(Call(name, (Name("x"),) * count))

    @pytest.mark.parametrize("function", [scalar_function, array_function])
    def test_tracebacks_show_its_lines(self, function):
        with pytest.raises(TypeError) as raised:
            function(Binary("*", Name("x"), Call("sqrt", (Name("y"),))))(1.0, "text")
        assert "return (x * sqrt(y))" in "".join(traceback.format_exception(raised.value))
