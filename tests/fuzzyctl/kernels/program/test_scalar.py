"""What generated Python calls."""

import math

import numpy as np
import pytest

from fuzzyctl.kernels.program.scalar import RUNTIME


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
