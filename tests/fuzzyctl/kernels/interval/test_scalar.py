import math

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from fuzzyctl.expr import FUNCTIONS, SOFT, Binary, Call, Compare, Logic, Name, Negate, Number, Where, names_in
from fuzzyctl.formulas import CONJUNCTIONS, DISJUNCTIONS, MEMBERSHIP
from fuzzyctl.kernels.backends.numpy_backend import array_function
from fuzzyctl.kernels.interval.scalar import decide, enclose, hull
from fuzzyctl.kernels.program.scalar import scalar_function
from tests.sizes import examples

X = Name("x")
BOX = {"x": (1.0, 2.0), "y": (-1.0, 3.0), "far": (2.0, math.inf), "zero": (0.0, 1.0)}


@pytest.mark.parametrize(
    ("expr", "expected"),
    [
        (Binary("+", X, Name("y")), (0.0, 5.0)),
        (Binary("-", X, Name("y")), (-2.0, 3.0)),
        (Binary("*", X, Name("y")), (-2.0, 6.0)),
        (Binary("*", Name("y"), Name("y")), (0.0, 9.0)),
        (Binary("*", Name("zero"), Name("far")), (-math.inf, math.inf)),
        (Binary("/", Name("y"), X), (-1.0, 3.0)),
        (Binary("/", X, Name("y")), (-math.inf, math.inf)),
        (Negate(X), (-2.0, -1.0)),
        (Call("min", (X, Name("y"))), (-1.0, 2.0)),
        (Call("max", (X, Name("y"))), (1.0, 3.0)),
        (Call("abs", (Name("y"),)), (0.0, 3.0)),
        (Where(Compare("<", X, Number(3.0)), X, Number(99.0)), (1.0, 2.0)),
        (Where(Compare("<", X, Number(1.5)), X, Number(99.0)), (1.0, 99.0)),
    ],
)
def test_encloses(expr, expected):
    assert enclose(expr, BOX) == expected


@pytest.mark.parametrize(
    ("op", "limit", "expected"),
    [
        ("<", 2.0, None),
        ("<", 2.5, True),
        ("<", 1.0, False),
        ("<=", 2.0, True),
        ("<=", 1.0, None),
        (">", 1.0, None),
        (">=", 1.0, True),
        ("==", 1.0, None),
        ("==", 0.0, False),
        ("!=", 0.0, True),
    ],
)
def test_decides_comparisons_only_where_they_hold_everywhere(op, limit, expected):
    assert decide(Compare(op, X, Number(limit)), BOX) is expected


def test_decides_logic_of_three_values():
    yes, no = Compare("<", X, Number(9.0)), Compare(">", X, Number(9.0))
    unknown = Compare("<", X, Number(1.5))
    assert decide(Logic("and", (unknown, no)), BOX) is False
    assert decide(Logic("and", (unknown, yes)), BOX) is None
    assert decide(Logic("or", (unknown, yes)), BOX) is True
    assert decide(Logic("not", (unknown,)), BOX) is None
    assert decide(Logic("not", (no,)), BOX) is True


@pytest.mark.parametrize(
    ("exponent", "expected"),
    [(-1.0, (-math.inf, math.inf)), (-2.0, (1.0, math.inf)), (-3.0, (-math.inf, math.inf)), (-0.5, (1.0, math.inf))],
)
def test_negative_odd_powers_tell_the_zeros_apart(exponent, expected):
    low, high = enclose(Binary("^", Name("zero"), Number(exponent)), BOX)
    value = scalar_function(Binary("^", X, Number(exponent)))
    assert (low, high) == pytest.approx(expected)
    assert all(low <= value(x) <= high for x in (-0.0, 0.0, 1.0))


def test_hull_holds_all():
    assert hull([(0.0, 1.0), (-2.0, 0.5)]) == (-2.0, 1.0)


far = st.floats(-20, 20) | st.integers(-6, 6).map(float) | st.floats(-1e7, 1e7)
NEAR, ROOT = {"x": (0.5, 2.0), "y": (-1.0, 1.0)}, Call("sqrt", (Name("y"),))


@pytest.mark.parametrize(
    ("expr", "expected"),
    [
        (Call("sqrt", (X,)), (math.sqrt(0.5), math.sqrt(2.0))),
        (Call("log", (X,)), (math.log(0.5), math.log(2.0))),
        (Call("sin", (X,)), (math.sin(0.5), 1.0)),
        (Call("cos", (X,)), (math.cos(2.0), math.cos(0.5))),
        (Call("cos", (Name("y"),)), (math.cos(1.0), 1.0)),
        (Call("tan", (Name("y"),)), (math.tan(-1.0), math.tan(1.0))),
        (Call("tan", (X,)), (-math.inf, math.inf)),
        (Call("atan2", (Name("y"), X)), (math.atan2(-1.0, 0.5), math.atan2(1.0, 0.5))),
        (Call("atan2", (X, Name("y"))), (math.atan2(0.5, 1.0), math.atan2(0.5, -1.0))),
        (Call("sign", (Name("y"),)), (-1.0, 1.0)),
        (Call("floor", (Name("y"),)), (-1.0, 1.0)),
        (Call("floor", (X,)), (0.0, 2.0)),
        (Call("ceil", (X,)), (1.0, 2.0)),
        (Call("round", (X,)), (0.0, 2.0)),
        (Call("mod", (X, Number(4.0))), (0.5, 2.0)),
        (Call("mod", (X, Number(1.0))), (0.0, 1.0)),
        (Call("mod", (Name("y"), Number(-4.0))), (-4.0, 0.0)),
        (Call("fmod", (Name("y"), Number(4.0))), (-1.0, 1.0)),
        (Call("fmod", (X, Number(-9.0))), (0.5, 2.0)),
        (Call("mod", (X, Name("y"))), (-math.inf, math.inf)),
        (Call("lt", (X, Name("y"))), (0.0, 1.0)),
        (Call("lt", (X, Number(0.5))), (0.0, 0.0)),
        (Call("le", (X, Number(2.0))), (1.0, 1.0)),
        (Call("gt", (X, Number(2.0))), (0.0, 0.0)),
        (Call("ge", (X, Number(0.5))), (1.0, 1.0)),
        (Call("eq", (X, Number(3.0))), (0.0, 0.0)),
        (Call("ne", (X, Number(3.0))), (1.0, 1.0)),
        (Call("lt", (ROOT, Number(9.0))), (0.0, 1.0)),
        (Call("le", (ROOT, Number(math.inf))), (0.0, 1.0)),
        (Call("divide", (Name("y"), X)), (-2.0, 2.0)),
        (Call("smaller", (Name("y"), X)), (-1.0, 1.0)),
        (Call("held", (Name("y"),)), (0.0, 1.0)),
        (Binary("^", X, Number(3.0)), (0.125, 8.0)),
        (Binary("^", Name("y"), Number(2.0)), (0.0, 1.0)),
        (Binary("^", Name("y"), Number(3.0)), (-1.0, 1.0)),
        (Binary("^", X, Name("y")), (0.5, 2.0)),
        (Binary("^", Name("y"), X), (-math.inf, math.inf)),
    ],
)
def test_encloses_functions(expr, expected):
    found = enclose(expr, NEAR)
    assert found == pytest.approx(expected, rel=1e-13, abs=1e-14)
    assert found[0] <= expected[0]
    assert expected[1] <= found[1]


@pytest.mark.parametrize("function", ["abs", "exp", "sin", "cos", "sign", "sqrt", "log", "tan"])
def test_what_may_have_no_value_may_be_anything(function):
    """A root of a negative number is NaN, and so is what is computed from it."""
    assert enclose(Binary("+", Number(1.0), Call(function, (ROOT,))), NEAR) == (-math.inf, math.inf)
    assert enclose(Call("held", (ROOT,)), NEAR) == (0.0, 1.0)


spot = st.floats(-2, 2) | st.integers(-8, 8).map(lambda i: i / 4)


@settings(max_examples=examples(300, 100), deadline=None)
@given(st.data())
def test_every_step_of_a_function_lies_in_its_interval(data):
    """Ends are often multiples of 1/4, where comparisons, roundings and remainders change."""
    function = data.draw(st.sampled_from(sorted(SOFT)))
    names = (X, Name("y"))[: FUNCTIONS[function][0]]
    box = {n.name: tuple(sorted((data.draw(spot), data.draw(spot)))) for n in names}
    expr = Call(function, names)
    low, high = enclose(expr, box)
    for t in (0.0, 0.25, 0.3, 0.5, 1.0):
        for u in (0.0, 0.5, 0.9, 1.0):
            point = {n: min(max(a + s * (b - a), a), b) for (n, (a, b)), s in zip(box.items(), (t, u), strict=False)}
            value = scalar_function(expr)(*point.values())
            assert (low, high) == (-math.inf, math.inf) or low <= value <= high, (box, point, value)


@settings(max_examples=examples(400, 100), deadline=None)
@given(st.data())
def test_every_value_of_a_function_lies_in_its_interval(data):
    function = data.draw(st.sampled_from(["sin", "cos", "tan", "exp", "log", "sqrt", "abs", "atan2", "^"]))
    arguments = (X, Name("y")) if function in ("atan2", "^") else (X,)
    expr = Binary("^", X, Name("y")) if function == "^" else Call(function, arguments)
    box = {n.name: tuple(sorted((data.draw(far), data.draw(far)))) for n in arguments}
    enclosed = enclose(expr, box)
    compute = array_function(expr)
    for t in (0.0, 0.3, 0.5, 0.9, 1.0):
        point = [np.array([min(max(a + t * (b - a), a), b)]) for a, b in box.values()]
        (value,) = compute(*point)
        assert enclosed == (-math.inf, math.inf) or enclosed[0] <= value <= enclosed[1]


EXAMPLES = [
    ("triangle", (-1.0, 0.0, 1.5)),
    ("trapezoid", (-1.0, -0.5, 1.0, 1.5)),
    ("rectangle", (-1.0, 0.5)),
    ("ramp", (1.0, -0.5)),
    ("piecewise", (-1.0, 0.2, 0.0, 1.0, 0.0, 0.4, 1.5, 0.0)),
    ("gaussian", (0.5, 0.3)),
    ("gaussian2", (-0.5, 0.3, 0.5, 1.0)),
    ("bell", (0.5, 0.3, 2.5)),
    ("sigmoid", (0.5, -8.0)),
    ("sigmoid_difference", (-0.5, 8.0, 7.0, 0.5)),
    ("sigmoid_product", (-0.5, 8.0, -7.0, 0.5)),
    ("s_shape", (-0.5, 1.0)),
    ("z_shape", (-0.5, 1.0)),
    ("pi_shape", (-1.0, -0.5, 0.5, 1.5)),
    ("cosine", (0.5, 1.5)),
    ("spike", (0.5, 1.5)),
    ("concave", (-0.5, 1.0)),
    ("arc", (-0.5, 1.0)),
    ("semi_ellipse", (-0.5, 1.0)),
    ("singleton", (0.5,)),
    ("constant", (0.5,)),
]


def test_every_kind_has_an_example():
    assert [kind for kind, _ in EXAMPLES] == list(MEMBERSHIP)


@pytest.mark.parametrize(("kind", "parameters"), EXAMPLES)
@settings(max_examples=examples(60, 20), deadline=None)
@given(st.data())
def test_every_degree_lies_in_the_interval_of_its_box(kind, parameters, data):
    degree = MEMBERSHIP[kind].degree(X, parameters)
    low, high = sorted((data.draw(spot), data.draw(spot)))
    enclosed = enclose(degree, {"x": (low, high)})
    for function in (scalar_function(degree), lambda x: float(array_function(degree)(np.array([x]))[0])):
        for t in (0.0, 0.25, 0.5, 1.0):
            x = min(max(low + t * (high - low), low), high)
            assert enclosed[0] <= function(x) <= enclosed[1]


@pytest.mark.parametrize("among", [CONJUNCTIONS, DISJUNCTIONS])
@settings(max_examples=examples(150, 50), deadline=None)
@given(st.data())
def test_every_truth_lies_in_the_interval_of_its_box(among, data):
    name = data.draw(st.sampled_from(list(among)))
    expr = among[name](Name("a"), Name("b"))
    box = {n: tuple(sorted((data.draw(st.floats(0, 1)), data.draw(st.floats(0, 1))))) for n in "ab"}
    function, enclosed = scalar_function(expr), enclose(expr, box)
    for s in (0.0, 0.5, 1.0):
        for t in (0.0, 0.5, 1.0):
            point = {n: min(max(a + u * (b - a), a), b) for u, (n, (a, b)) in zip((s, t), box.items(), strict=True)}
            # A formula may name its operands in another order.
            value = function(*(point[n] for n in dict.fromkeys(m.name for m in names_in(expr))))
            assert enclosed[0] <= value <= enclosed[1]
