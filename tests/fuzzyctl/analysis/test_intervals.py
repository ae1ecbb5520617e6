import math

import hypothesis.strategies as st
import pytest
from hypothesis import given, settings

from fuzzyctl.analysis.intervals import decide, enclose, hull
from fuzzyctl.expr import Binary, Call, Compare, Logic, Name, Negate, Number, Where
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.kernels.python_backend import scalar_function

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


def test_hull_holds_all():
    assert hull([(0.0, 1.0), (-2.0, 0.5)]) == (-2.0, 1.0)


spot = st.floats(-2, 2) | st.integers(-4, 4).map(lambda i: i / 2)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(st.sampled_from(["triangle", "trapezoid", "gaussian", "singleton"]), st.data())
def test_every_degree_lies_in_the_interval_of_its_box(kind, data):
    formula = MEMBERSHIP[kind]
    values = [data.draw(spot) for _ in formula.parameters]
    parameters = (values[0], abs(values[1]) + 0.01) if kind == "gaussian" else tuple(sorted(values))
    degree = formula.degree(X, parameters)
    low, high = sorted((data.draw(spot), data.draw(spot)))
    function = scalar_function(degree)
    enclosed = enclose(degree, {"x": (low, high)})
    for t in (0.0, 0.25, 0.5, 1.0):
        x = min(max(low + t * (high - low), low), high)
        assert enclosed[0] <= function(x) <= enclosed[1]
