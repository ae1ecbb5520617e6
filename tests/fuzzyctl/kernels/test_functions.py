"""Functions and operators of the language: backends compute what expressions say, at poles, ties and kinks too."""

import itertools
import math

import numpy as np
import pytest

from fuzzyctl import compile, loads
from fuzzyctl.expr import FUNCTIONS, Call, ExprError, Number, evaluate
from fuzzyctl.kernels.program.scalar import RUNTIME

#: What is computed of x and y, by the name of the output.
CALLS = {
    **{f: f"{f}({'x, y' if FUNCTIONS[f][0] == 2 else 'x'})" for f in sorted(FUNCTIONS) if f not in ("min", "max")},
    "least": "min(x, y, 0.5)",
    "largest": "max(x, y, 0.5)",
    "quotient": "x / y",
    "power": "x ^ y",
    "of_a_quotient": "log(x) / y",
    "product": "x * y - x",
    "root": "abs(x) ^ 0.5",
    "inverse": "x ^ -1",
}
TEXT = (
    "system s\ndefuzzifier weighted_average\nhedge soft(m) = sqrt(m)\ninput x in [-9, 9] extrapolate\n"
    "  any = trapezoid(-inf, -9, 9, inf)\ninput y in [-9, 9] extrapolate\n"
    + "".join(f"output u_{n} in [-9, 9] else 0\n" for n in CALLS)
    + "".join(f"if x is soft any then u_{n} is function({text})\n" for n, text in CALLS.items())
)
SPECIAL = [-math.inf, -800.0, -2.5, -1.0, -0.0, 0.0, 0.3, 1.0, 2.0, 800.0, math.inf]
POINTS = [
    *itertools.product([k / 4 for k in range(-11, 12)], (-1.5, 0.0, 0.75, 2.0)),
    *itertools.product(SPECIAL, SPECIAL),
    *[(0.49999999999999994, 1.0), (-1e17, 3.0), (2.5, math.inf), (10.0, 309.0), (-8.0, 0.5)],
]


@pytest.fixture(scope="module")
def numbers():
    return compile(loads(TEXT), "python").batch(POINTS)


def test_finite_values_are_those_of_expressions(numbers):
    known = 0
    for point, row in zip(POINTS, numbers, strict=True):
        for name, found in zip(CALLS, row.tolist(), strict=True):
            if name not in FUNCTIONS:
                continue
            try:
                expected = evaluate(Call(name, tuple(map(Number, point[: FUNCTIONS[name][0]]))), {})
            except ExprError:  # such as the remainder of a division by 0
                continue
            if math.isfinite(expected):
                assert found == pytest.approx(expected, rel=1e-15, abs=0), (name, point)
                known += 1
    assert known > 3000


@pytest.mark.parametrize("backend", ["numpy", "numba"])
def test_backends_agree_at_poles_and_infinities_too(numbers, backend):
    kernel = compile(loads(TEXT), backend)
    found = kernel.batch(POINTS) if backend == "numpy" else np.array([kernel(*point) for point in POINTS])
    # Of tan and powers the last digits differ, for arguments beyond all uses.
    np.testing.assert_allclose(found, numbers, rtol=2e-14, err_msg=", ".join(CALLS))


def test_generated_text_reaches_nothing_else():
    assert set(RUNTIME["__builtins__"]) == {"range", "type", "float", "abs"}


VALUES = (
    *("x + y", "x - y", "-x * y", "x / y", "x ^ 2", "x ^ y", "x ^ -1.5 * y", "abs(-x * y)", "atan2(x, y)"),
    *(f"{name}(x * y)" for name in ("abs", "sqrt", "exp", "log", "sin", "cos", "tan")),
    *("x * x / (y + x)", "(x + y) ^ y", "fmod(5 * x, y)", "mod(-5 * x, y)", "floor(7 * x) * y", "round(7 * x) + y"),
    *("sign(x - y) * x", "lt(x, y) * x", "min(x, y, x * y)", "max(x, y, x * y)", "clamp(3 * x, y, y + 1)"),
    *("clamp(x, y, y + 1)", "clamp(x * y, 0, 1)", "clamp(5 * x, 0, 1) * y", "where(x < y, x * y, x / y)"),
)
STEP = "controller c\ninput x\ninput y\n{}every 1 s\n"


def slopes(values, points, backend="python"):
    step = compile(
        loads(STEP.format("".join(f"output u{k} = {v}\n" for k, v in enumerate(values))), block="c"), backend
    )
    return step.gradient(points)[0], step


@pytest.mark.parametrize("backend", ["python", "numpy"])
def test_derivatives_are_those_of_central_differences(backend):
    points = np.array([(0.4, 0.7), (0.9, 0.31)])
    found, step = slopes(VALUES, points, backend)
    for axis in range(2):
        ahead, behind = (step.batch(points + side * np.eye(2)[axis])[0] for side in (1e-6, -1e-6))
        np.testing.assert_allclose(found[..., axis], (ahead - behind) / 2e-6, rtol=1e-7, atol=1e-8)


#: Values at kinks and jumps: the slope ahead counts, and of a jump that of the branch that is taken.
KINKS = [
    ("min(x, 2 * y)", (2, 1), [0, 0]),
    ("max(x, 2 * y)", (2, 1), [1, 2]),
    ("abs(x * y)", (0, -1), [1, 0]),
    *(
        (f"clamp({s}x, 0, 1)", (x, 0), [d, 0])
        for s, ds in (("", (0, 1, 0)), ("-", (-1, 0, 0)))
        for x, d in zip((-1, 0, 1), ds, strict=True)
    ),
    *((f"where(x {op} y, x - y, 0) + where(y {op} x, x - y, 0)", (1, 1), [1, -1]) for op in ("<", "<=", ">", ">=")),
    ("where(x == y or y == x, x + y, 2 * x)", (1, 1), [2, 0]),
    ("where(x != y or y != x, x + y, 2 * x)", (1, 1), [1, 1]),
    ("where(x <= y, 3 * x, 5 * x)", (1, 1), [3, 0]),
    ("where(x > 0, y / x, 2 * y)", (0, 1), [0, 2]),
    ("round(x)", (2, 0), [0, 0]),
    # What does not move has no slope, however steep the function.
    ("sqrt(max(x - 1, 0))", (0.5, 0), [0, 0]),
    ("max(x - 1, 0) ^ 0.5", (0.5, 0), [0, 0]),
]


@pytest.mark.parametrize(("value", "point", "expected"), KINKS)
def test_at_a_kink_the_slope_ahead_counts(value, point, expected):
    (found,) = slopes([value], np.array([point], float))[0].reshape(1, 2)
    np.testing.assert_array_equal(found, expected)
