"""Comparisons and roundings are in every kernel what they are where numbers are computed, ties and signs included."""

import itertools
import math

import pytest

from fuzzyctl import compile, loads
from fuzzyctl.expr import FUNCTIONS, SOFT, Call, ExprError, Number, evaluate

NAMES = sorted(SOFT)
TEXT = (
    "system steps\ndefuzzifier weighted_average\ninput x in [-9, 9] extrapolate\n  any = trapezoid(-inf, -9, 9, inf)\n"
    "input y in [-9, 9] extrapolate\n"
    + "".join(f"output u_{n} in [-9, 9] else 0\n" for n in NAMES)
    + "".join(f"if x is any then u_{n} is function({n}({'x, y' if FUNCTIONS[n][0] == 2 else 'x'}))\n" for n in NAMES)
)
QUARTERS = [k / 4 for k in range(-11, 12)]
POINTS = [
    *itertools.product(QUARTERS, (-1.5, 0.0, 0.75, 2.0)),
    (0.49999999999999994, 1.0),
    (-1e17, 3.0),
    (2.5, math.inf),
]


def computed(function, *arguments):
    call = Call(function, tuple(map(Number, arguments[: FUNCTIONS[function][0]])))
    try:
        return evaluate(call, {})
    except ExprError:  # there is no remainder of a division by 0
        return math.nan


@pytest.mark.parametrize("backend", ["python", "numpy", "numba"])
def test_kernels_compute_what_expressions_say(backend):
    kernel = compile(loads(TEXT), backend=backend)
    for point in POINTS:
        found = dict(zip(NAMES, map(float, kernel(*point)), strict=True))
        assert found == pytest.approx({n: computed(n, *point) for n in NAMES}, abs=0, rel=0, nan_ok=True), point
