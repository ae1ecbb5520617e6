"""Taylor coefficients of expressions over sets hold those of every curve in them."""

import itertools
import math
from fractions import Fraction

import flint
import numpy as np
import pytest

from fuzzyctl.analysis.reach.series import Nodes, NotSmoothError, Series
from tests.fuzzyctl.analysis.reach.exact import PRECISION, arb, at, expression, holds

ORDER = 5
THIRD = Fraction(1 / 3)
CURVES = {
    "x * x - 3 * x + 1 / 3": lambda x: x * x - 3 * x + arb(Fraction(1, 3)),
    "x / 3 - 0.1 * 7": lambda x: x / 3 - arb(Fraction(0.1) * 7),
    "sin(x) * cos(2 * x)": lambda x: x.sin() * (2 * x).cos(),
    "tan(x / 4)": lambda x: (x / 4).tan(),
    "exp(-x) * x": lambda x: (-x).exp() * x,
    "log(2 + x ** 2)": lambda x: (2 + x * x).log(),
    "sqrt(3 + sin(x))": lambda x: (3 + x.sin()).sqrt(),
    "(4 + x) ** 0.7": lambda x: ((4 + x).log() * arb(Fraction(0.7))).exp(),
    "(4 + x) ** -1.5": lambda x: ((4 + x).log() * arb(Fraction(-1.5))).exp(),
    "(4 + x) ** x": lambda x: ((4 + x).log() * x).exp(),
    "x / (2 + x ** 2)": lambda x: x / (2 + x * x),
    "x ** -3 + (5 + x) ** 5": lambda x: 1 / (x * x * x) + (5 + x) ** 5,
    "abs(x) + max(x, -1) - min(x, 7, 8)": lambda x: (1 if x[0] > 0 else -1) * x + (x if x[0] > -1 else -1) - x,
    "where(x > 0, x ** 2, sin(x))": lambda x: x * x if x[0] > 0 else x.sin(),
    "clip(x, -10, 10) * exp(0.3)": lambda x: x * arb(Fraction(0.3)).exp(),
    "sqrt(2) * x + log(3) + sin(1) - cos(1)": lambda x: x * arb(2).sqrt() + arb(3).log() + arb(1).sin() - arb(1).cos(),
}
#: Of order 0 and 1 of the curves; one symbol is that of both, and those of higher order are numbers.
STARTS = [
    (np.array([[0.8, 0.0, 0.3]]), np.array([[-1.0, 0.1, 0.5]])),
    (np.array([[-2.0, 0.2, 1e-3]]), np.array([[0.3, 0.0, -1.0]])),
    (np.array([[math.pi / 2, 1e-9, 0.0]]), 1.0),
    (np.array([[-math.pi, 0.0, 1e-12]]), np.array([[0.0, 0.0, 1e-3]])),
]


@pytest.mark.parametrize("text", CURVES)
def test_coefficients_hold_those_of_each_curve(text):
    flint.ctx.prec = PRECISION
    nodes = Nodes(["x"], [], [expression(text)])
    for first, second in STARTS:
        inputs = [first, second, 0.5, 0.0, -0.25, 0.0]
        series = Series(nodes, [first])
        results = [series.extend()[0], *(series.extend([i])[0] for i in inputs[1:])]
        for e, own in itertools.product((-1, 1, THIRD), (-1, 1)):
            curve = [arb(Fraction(i) if isinstance(i, float) else at(i, [e], own)) for i in inputs]
            exact = CURVES[text](flint.arb_series(curve, prec=ORDER + 1))
            coefficients = exact.coeffs() if isinstance(exact, flint.arb_series) else [exact]
            for k, result in enumerate(results):
                assert holds(result, [e], coefficients[k] if k < len(coefficients) else Fraction(0)), (k, e, own)


@pytest.mark.parametrize(
    "text", ["abs(x)", "max(x, 0.1)", "min(2 * x, x)", "where(x >= 0, 1, 0)", "where(not x < 0.1 or x > 1, 1, 0)",
             "floor(x)", "sign(x)", "mod(x, 1)", "atan2(x, -1)", "clip(x, -1, 0)", "ge(x, 0)"]
)  # fmt: skip
def test_no_derivative_is_made_up_where_a_value_bends_or_jumps(text):
    series = Series(Nodes(["x"], [], [expression(text)]), [np.array([[0.0, 0.0, 0.5]])])
    series.extend()
    with pytest.raises(NotSmoothError):
        series.extend([1.0])


def test_a_choice_between_constants_that_time_does_not_change_has_no_derivative():
    series = Series(Nodes(["x", "u"], [], [expression("where(u >= 0, 1, 0) * x")]), [1.0, np.array([[0.0, 0.0, 0.5]])])
    series.extend()
    assert series.extend([0.0, 0.0]) == [0.0]


@pytest.mark.parametrize(("slope", "derivative"), [(1.0, 1), (-1.0, -1)])
def test_at_a_bend_the_side_is_that_of_the_set_around(slope, derivative):
    nodes = Nodes(["x"], [], [expression("abs(x)")])
    whole = Series(nodes, [np.array([[0.5 * slope, 0.49]])])
    whole.extend()
    start = Series(nodes, [np.array([[0.0, 0.0]])], whole)
    start.extend()
    assert holds(start.extend([slope])[0], [], Fraction(derivative) * Fraction(slope))
