"""Enclosures of single operations: values, slopes and rounding errors, set against what functions of numbers give."""

import math
from fractions import Fraction

import numpy as np
import pytest

from fuzzyctl.expr import Binary, Call, Compare, Logic, Name, Negate, Number, Where
from fuzzyctl.kernels.interval.program import Interpreter
from fuzzyctl.kernels.interval.vector import boxes, constant
from fuzzyctl.kernels.program.program import Program
from fuzzyctl.kernels.program.scalar import scalar_function

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
    names = list(dict.fromkeys(n.name for n in _names(expr))) or ["x"]
    order = names + [n for n in "xy" if n not in names]
    return np.array([function(*(p["xy".index(n)] for n in order)) for p in points.T])


def _names(expr):
    from fuzzyctl.expr import names_in

    return names_in(expr)


@pytest.mark.parametrize("name", [*SMOOTH, *JUMPING])
def test_values_lie_inside(name):
    expr = {**SMOOTH, **JUMPING}[name]
    lo, hi, points = drawn(1)
    low, high, _, _ = enclosed(expr, lo, hi)
    for own in points:
        found = values(expr, own)
        assert np.all(low <= found)
        assert np.all(found <= high)


@pytest.mark.parametrize("name", [*SMOOTH, *JUMPING])
@pytest.mark.parametrize("axis", [0, 1])
def test_differences_lie_between_slopes(name, axis):
    expr = {**SMOOTH, **JUMPING}[name]
    lo, hi, points = drawn(2)
    _, _, (down, up), _ = enclosed(expr, lo, hi)
    for own in points[2:]:
        first, second = own.copy(), own.copy()
        first[axis], second[axis] = lo[axis], hi[axis]
        run = hi[axis] - lo[axis]
        wide = run > 1e-5
        rise = (values(expr, second) - values(expr, first))[wide]
        slack = 1e-12
        assert np.all(rise >= down[axis][wide] * run[wide] - slack)
        assert np.all(rise <= up[axis][wide] * run[wide] + slack)


def test_what_may_be_nan_compares_with_nothing():
    lo, hi = np.array([[-1.0], [0.0]]), np.array([[1.0], [0.0]])
    low, high, _, _ = enclosed(call("le", call("sqrt", X), Number(np.inf)), lo, hi)
    assert (low.tolist(), high.tolist()) == ([0.0], [1.0])


@pytest.mark.parametrize("name", SMOOTH)
def test_narrow_boxes_have_narrow_enclosures(name):
    rng = np.random.default_rng(3)
    middle = rng.uniform(-1.4, 1.4, (2, 200))
    lo, hi = middle - 1e-6, middle + 1e-6
    low, high, (down, up), error = enclosed(SMOOTH[name], lo, hi)
    assert np.median(high - low) < 1e-4
    assert np.median(up - down) < 1e-3
    assert error.max() < 1e-12


@pytest.mark.parametrize("name", ["sum", "difference", "product", "quotient", "square"])
def test_errors_hold_what_floats_are_off_by(name):
    lo, hi, points = drawn(4)
    expr = Binary("-", Binary("*", SMOOTH[name], Number(0.3)), Binary("*", X, Number(0.7)))
    _, _, _, error = enclosed(expr, lo, hi)
    for own in points:
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


def test_a_jump_has_no_slope():
    lo, hi = np.array([[-0.1], [0.0]]), np.array([[0.1], [0.5]])
    _, _, (down, up), _ = enclosed(JUMPING["choice"], lo, hi)
    assert (down[0, 0], up[0, 0]) == (-math.inf, math.inf)


def test_a_quotient_by_what_may_be_zero_is_anything():
    lo, hi = np.array([[-0.1], [0.0]]), np.array([[0.1], [0.5]])
    low, high, _, _ = enclosed(Binary("/", Y, X), lo, hi)
    assert (low[0], high[0]) == (-math.inf, math.inf)


def test_what_is_no_number_does_not_count_and_is_remembered():
    runner = Interpreter({"x": boxes(np.array([[1.0, -2.0, -1.0]]), np.array([[2.0, -1.0, 1.0]]))[0]})
    found = runner.enclose(Where(Compare(">", X, Number(0.0)), X, Number(math.nan)))
    assert found.lo.tolist() == [1.0, -2.0, -1.0]
    assert runner.void.tolist() == [False, True, False]


def test_a_statement_that_has_no_enclosure_is_refused():
    with pytest.raises(TypeError, match="no enclosure"):
        Interpreter({"x": constant(1.0)}).run(Program(("x",), 0, (), (object(),), (X,)), [0])
