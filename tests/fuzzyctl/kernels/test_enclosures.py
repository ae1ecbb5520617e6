"""Enclosures of single operations: values, slopes and rounding errors, beside what functions of numbers give."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl import compile, loads, output_bounds
from fuzzyctl.expr import FUNCTIONS, Binary, Call, Compare, Logic, Name, Negate, Number, Where, names_in
from fuzzyctl.kernels.interval.program import Interpreter
from fuzzyctl.kernels.interval.vector import boxes
from fuzzyctl.kernels.program.scalar import scalar_function
from tests.properties.running import quick

X, Y = Name("x"), Name("y")


def call(name, *arguments):
    return Call(name, arguments)


SMOOTH = {
    "sum": Binary("+", X, Y),
    "difference": Binary("-", X, Y),
    "product": Binary("*", X, Y),
    "quotient": Binary("/", X, Binary("+", Y, Number(3.0))),
    "square": Binary("*", X, X),
    "negation": Negate(Binary("*", X, Number(3.0))),
    "minimum": call("min", X, Y),
    "maximum": call("max", X, Binary("*", Number(2.0), Y)),
    "clip": call("clip", Binary("*", Number(2.0), X), Number(-0.5), Number(0.75)),
    "held": call("held", Binary("+", X, Y)),
    "magnitude": call("abs", Binary("+", X, Y)),
    "exponential": call("exp", Binary("*", X, Y)),
    "root": call("sqrt", Binary("+", Binary("*", X, X), Number(1.0))),
    "logarithm": call("log", Binary("+", X, Number(3.0))),
    "sine": call("sin", Binary("*", Number(3.0), X)),
    "cosine": call("cos", Binary("*", Number(3.0), Y)),
    "power": Binary("^", call("abs", X), Number(2.5)),
    "cube": Binary("^", X, Number(3.0)),
    "gaussian": call("exp", Binary("*", Number(-0.5), Binary("*", X, X))),
}
JUMPING = {
    "choice": Where(Compare("<", X, Y), X, Number(2.0)),
    "logic": Where(Logic("or", (Compare(">", X, Number(0.0)), Compare("==", Y, X))), Y, Number(-1.0)),
    "negated": Where(Logic("not", (Compare("<=", X, Y),)), X, Y),
    "angle": call("atan2", X, Y),
    "tangent": call("tan", X),
    "sign": call("sign", Binary("+", X, Y)),
    "less": call("lt", X, Y),
    "equal": call("eq", X, call("max", X, Y)),
    "unequal or less": Binary("+", call("ne", X, Number(0.0)), call("ge", X, Y)),
    "floor": call("floor", Binary("*", Number(3.0), X)),
    "ceiling": Binary("-", call("ceil", X), call("round", Y)),
    "remainder": call("mod", X, Number(0.4)),
    "truncated remainder": call("fmod", Binary("*", Number(3.0), X), Y),
}


def drawn(seed, count=300):
    rng = np.random.default_rng(seed)
    middle = rng.uniform(-1.4, 1.4, (2, count))
    width = rng.choice([0.0, 1e-9, 1e-3, 0.3, 1.0], (2, count))
    lo, hi = middle - width * rng.uniform(size=(2, count)), middle + width * rng.uniform(size=(2, count))
    points = [lo, hi, *(np.clip(lo + rng.uniform(size=lo.shape) * (hi - lo), lo, hi) for _ in range(6))]
    return lo, hi, points


def enclosed(expr, lo, hi):
    with np.errstate(all="ignore"):
        e = Interpreter(dict(zip("xy", boxes(lo, hi), strict=True))).enclose(expr)
    count = lo.shape[1]
    slopes = (np.zeros_like(lo),) * 2 if e.slopes is None else tuple(np.broadcast_to(s, lo.shape) for s in e.slopes)
    return np.broadcast_to(e.lo, count), np.broadcast_to(e.hi, count), slopes, np.broadcast_to(e.error, count)


def values(expr, points):
    function = scalar_function(Binary("+", expr, Binary("*", Number(0.0), Binary("+", X, Y))))
    names = list(dict.fromkeys(n.name for n in names_in(expr))) or ["x"]
    order = names + [n for n in "xy" if n not in names]
    return np.array([function(*(p["xy".index(n)] for n in order)) for p in points.T])


@pytest.mark.parametrize("name", [*SMOOTH, *JUMPING])
def test_values_lie_inside_and_differences_between_slopes(name):
    expr = {**SMOOTH, **JUMPING}[name]
    lo, hi, points = drawn(1)
    low, high, (down, up), _ = enclosed(expr, lo, hi)
    for own in points:
        found = values(expr, own)
        assert np.all(low <= found)
        assert np.all(found <= high)
        for axis in range(2):
            first, second = own.copy(), own.copy()
            first[axis], second[axis] = lo[axis], hi[axis]
            run = hi[axis] - lo[axis]
            wide = run > 1e-5
            rise = (values(expr, second) - values(expr, first))[wide]
            assert np.all(rise >= down[axis][wide] * run[wide] - 1e-12)
            assert np.all(rise <= up[axis][wide] * run[wide] + 1e-12)


@pytest.mark.parametrize("name", SMOOTH)
def test_narrow_boxes_have_narrow_enclosures(name):
    middle = np.random.default_rng(3).uniform(-1.4, 1.4, (2, 200))
    low, high, (down, up), error = enclosed(SMOOTH[name], middle - 1e-6, middle + 1e-6)
    assert np.median(high - low) < 1e-4
    assert np.median(up - down) < 1e-3
    assert error.max() < 1e-12


@pytest.mark.parametrize("name", ["sum", "difference", "product", "quotient", "square"])
def test_errors_hold_what_floats_are_off_by(name):
    lo, hi, points = drawn(4)
    expr = Binary("-", Binary("*", SMOOTH[name], Number(0.3)), Binary("*", X, Number(0.7)))
    _, _, _, error = enclosed(expr, lo, hi)
    for own in points[:3]:
        for k, (x, y) in enumerate(own.T):
            exact = _exact(expr, {"x": Fraction(x), "y": Fraction(y)})
            assert abs(Fraction(float(values(expr, own[:, [k]])[0])) - exact) <= Fraction(float(error[k]))


def _exact(expr, names):
    match expr:
        case Number(value=value):
            return Fraction(value)
        case Name(name=name):
            return names[name]
        case Binary(op=op, left=left, right=right):
            a, b = _exact(left, names), _exact(right, names)
            return {"+": lambda: a + b, "-": lambda: a - b, "*": lambda: a * b, "/": lambda: a / b}[op]()


@pytest.mark.parametrize(
    ("expr", "values_", "slopes"),
    [
        (JUMPING["choice"], None, (-math.inf, math.inf)),
        (Binary("/", Y, X), (-math.inf, math.inf), None),
        # What may be NaN compares with nothing.
        (call("le", call("sqrt", X), Number(math.inf)), (0.0, 1.0), None),
    ],
)
def test_of_jumps_poles_and_nan_nothing_is_known(expr, values_, slopes):
    low, high, (down, up), _ = enclosed(expr, np.array([[-0.1], [0.0]]), np.array([[0.1], [0.5]]))
    assert values_ in (None, (low[0], high[0]))
    assert slopes in (None, (down[0, 0], up[0, 0]))


def test_what_is_no_number_does_not_count_and_is_remembered():
    runner = Interpreter({"x": boxes(np.array([[1.0, -2.0, -1.0]]), np.array([[2.0, -1.0, 1.0]]))[0]})
    found = runner.enclose(Where(Compare(">", X, Number(0.0)), X, Number(math.nan)))
    assert found.lo.tolist() == [1.0, -2.0, -1.0]
    assert runner.void.tolist() == [False, True, False]


# --- bounds of formulas, by intervals of numbers ---------------------------------------------------------------------

#: Least and largest value over x in [0.5, 2] and y in [-1, 1]; none where a value may be missing.
NOTHING = (-math.inf, math.inf)
KNOWN = {
    "x + y": (-0.5, 3),
    "x - y": (-0.5, 3),
    "x * y": (-2, 2),
    "y * y": (0, 1),
    "y / x": (-2, 2),
    "x / y": NOTHING,
    "-x": (-2, -0.5),
    "min(x, y)": (-1, 1),
    "max(x, y)": (0.5, 2),
    "abs(y)": (0, 1),
    "sqrt(x)": (math.sqrt(0.5), math.sqrt(2)),
    "log(x)": (math.log(0.5), math.log(2)),
    "exp(y)": (1 / math.e, math.e),
    "sin(x)": (math.sin(0.5), 1),
    "cos(x)": (math.cos(2), math.cos(0.5)),
    "cos(y)": (math.cos(1), 1),
    "tan(y)": (math.tan(-1), math.tan(1)),
    "tan(x)": NOTHING,
    "atan2(x, y)": (math.atan2(0.5, 1), math.atan2(0.5, -1)),
    "sign(y)": (-1, 1),
    "floor(y)": (-1, 1),
    "floor(x)": (0, 2),
    "ceil(x)": (1, 2),
    "round(x)": (0, 2),
    "mod(x, 4)": (0.5, 2),
    "mod(x, 1)": (0, 1),
    "mod(y, -4)": (-4, 0),
    "fmod(y, 4)": (-1, 1),
    "fmod(x, -9)": (0.5, 2),
    "mod(x, y)": NOTHING,
    "lt(x, y)": (0, 1),
    "lt(x, 0.5)": (0, 0),
    "le(x, 2)": (1, 1),
    "gt(x, 2)": (0, 0),
    "ge(x, 0.5)": (1, 1),
    "eq(x, 3)": (0, 0),
    "ne(x, 3)": (1, 1),
    "lt(sqrt(y), 9)": (0, 1),
    "x ^ 3": (0.125, 8),
    "y ^ 2": (0, 1),
    "y ^ 3": (-1, 1),
    "x ^ y": (0.5, 2),
    "y ^ x": NOTHING,
    "y ^ -1": NOTHING,
    "y ^ -2": (1, math.inf),
    **{f"1 + {f}(sqrt(y))": NOTHING for f in ("abs", "exp", "sin", "sign", "sqrt", "log", "tan")},
}


def formula(text, x=(0.5, 2.0), y=(-1.0, 1.0)):
    inputs = "".join(f"input {n} in [{low!r}, {high!r}]\n" for n, (low, high) in (("x", x), ("y", y)))
    return loads(f"system s\n{inputs}output u in [-1e9, 1e9] = {text}\noutput v in [-9, 9] = 0 * y\n")


@pytest.mark.parametrize("text", KNOWN)
def test_bounds_of_formulas_are_tight(text):
    found, (low, high) = output_bounds(formula(text))["u"], KNOWN[text]
    assert (found.lo, found.hi) == pytest.approx((low, high), rel=1e-13, abs=1e-14)
    assert found.lo <= low
    assert high <= found.hi


ENDS = st.one_of(st.floats(-20, 20), st.integers(-8, 8).map(lambda i: i / 4), st.floats(-1e7, 1e7))
CALLS = ["x ^ y", *(f"{f}({'x, y' if FUNCTIONS[f][0] == 2 else 'x'})" for f in FUNCTIONS if f not in ("min", "max"))]


@pytest.mark.parametrize("backend", ["python", "numpy"])
@given(st.sampled_from(CALLS), *[st.lists(ENDS, min_size=2, max_size=2, unique=True).map(sorted)] * 2)
@quick(600, 60)
def test_every_value_of_a_function_lies_within_its_bounds(backend, text, x, y):
    system = formula(text, x, y)
    bound = output_bounds(system)["u"]
    shares = np.array([(s, t) for s in (0.0, 0.25, 0.3, 0.5, 1.0) for t in (0.0, 0.5, 0.9, 1.0)])
    points = np.array([x[0], y[0]]) + shares * np.array([x[1] - x[0], y[1] - y[0]])
    found = compile(system, backend).batch(points)[:, 0]
    if (bound.lo, bound.hi) != NOTHING:
        assert np.all((bound.lo <= found) & (found <= bound.hi)), points
