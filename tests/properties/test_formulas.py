"""Laws of lets and formulas: a let is an input at its value, and functions are what they stand for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fuzzyctl
from tests import sizes

NUMBERS = st.integers(-8, 8).map(lambda n: n / 4)
BACKENDS = ("python", "numpy", "numba")

RULES = """
output u in [-3, 3]
  terms N Z P
output v in [-50, 50]
table u = z x y
       N  Z  P
  N |  P  P  Z
  Z |  P  Z  N
  P |  Z  N  N
if z is N or y is P then v is function(z * y + 1)
if z is not N then v is function(u - z)
"""
HEAD = "system s\ndefuzzifier {method}\nand {norm}\ninput x in [-1, 1]\n"
Y = "input y in [-1, 1]\n  terms N Z P\n"


#: How an expression is written, and what numpy makes of it.
FORMS = [
    ("({} + {})", np.add),
    ("({} - {})", np.subtract),
    ("({} * {})", np.multiply),
    ("max({}, {})", np.maximum),
    ("min({}, {})", np.minimum),
    ("abs({0} - {1})", lambda a, b: np.abs(a - b)),
    ("(round({}) + {})", lambda a, b: np.round(a) + b),
]


@st.composite
def expressions(draw, names=("x", "y"), depth=3):
    """Draw an expression over names and numbers that has a value everywhere: its text, and the function of an array."""
    if depth == 0 or draw(st.booleans()):
        if draw(st.booleans()):
            number = draw(NUMBERS)
            return f"({number})", lambda *columns: np.full_like(columns[0], number)
        k = draw(st.integers(0, len(names) - 1))
        return names[k], lambda *columns: columns[k]
    (a, f), (b, g) = draw(expressions(names, depth - 1)), draw(expressions(names, depth - 1))
    text, join = draw(st.sampled_from(FORMS))
    return text.format(a, b), lambda *columns: join(f(*columns), g(*columns))


@given(expressions(), st.sampled_from(["center_average", "weighted_average"]), st.sampled_from(["min", "product"]))
def test_a_let_is_an_input_at_its_value(expression, method, norm):
    text, value = expression
    head = HEAD.format(method=method, norm=norm)
    with_let = fuzzyctl.loads(f"{head}{Y}let z in [-2, 2] = {text}\n  terms N Z P\n{RULES}")
    with_input = fuzzyctl.loads(f"{head}{Y}input z in [-2, 2] extrapolate\n  terms N Z P\n{RULES}")
    points = np.random.default_rng(3).uniform(-1, 1, (20, 2))
    z = value(*points.T)
    # Antecedents read a let within its range, expressions its value: here terms are flat beyond the range.
    expected = fuzzyctl.compile(with_input, "numpy").batch(np.column_stack([points, z]))
    for backend in ("python", "numpy"):
        found = fuzzyctl.compile(with_let, backend).batch(points)
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    assert fuzzyctl.loads(fuzzyctl.dumps(with_let)) == with_let


@given(expressions(), expressions(names=("a",), depth=2))
def test_bounds_of_formulas_hold_and_functions_are_what_they_stand_for(expression, function):
    (text, inner), (body, outer) = expression, function
    source = f"function f(a) = {body}\nsystem s\ninput x in [-1, 1]\ninput y in [-1, 1]\n"
    system = fuzzyctl.loads(f"{source}output u in [-9, 9] = f({text})\n")
    points = np.random.default_rng(4).uniform(-1, 1, (40, 2))
    found = fuzzyctl.compile(system, "numpy").batch(points)
    np.testing.assert_allclose(found, outer(inner(*points.T)), rtol=1e-12, atol=1e-12)
    bound = fuzzyctl.output_bounds(system)["u"]
    assert bound.lo <= found.min() <= found.max() <= bound.hi


@pytest.mark.parametrize("backend", sizes.BACKENDS)
@given(st.lists(st.floats(0.01, 0.99), min_size=2, max_size=2), st.floats(0.1, 10))
def test_places_of_formulas_have_the_degrees(backend, degrees, c):
    text = (
        f"param c = {c!r}\nsystem s\ndefuzzifier tsukamoto_sum\ninput a in [0, 1]\n  on = ramp(0, 1)\n"
        "output y in [0, 1] else 0\n  S = function(-log(y) / c)\nif a is on then y is S\n"
    )
    kernel = fuzzyctl.compile(fuzzyctl.loads(text), backend)
    for w in degrees:
        assert kernel(w) == pytest.approx(w * np.exp(-c * w), rel=1e-12)
