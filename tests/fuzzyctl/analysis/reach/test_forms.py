"""Operations on affine forms hold the exact values, at every value of the symbols, and what floats make of them."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyctl.analysis.reach import forms
from fuzzyctl.analysis.reach.forms import DomainError
from tests.fuzzyctl.analysis.reach.exact import arb, at, holds

CENTRES = st.sampled_from(
    [0.0, 1.0, -1.0, 0.3, 7.0, math.pi / 2, math.pi, -3 * math.pi / 2, 1e3, 5e-324, 1e-300, 1e-16, -1e8, 1e15, 1e150]
) | st.floats(-10.0, 10.0)
#: Of the radius by the centre; and radii by themselves.
SIZES = st.sampled_from([0.0, 1e-300, 1e-17, 1e-12, 1e-5, 0.01, 0.5, 1.0, 3.0, 20.0, 1e6])
SHARES = st.sampled_from([0.0, 1.0, -1.0, 1.0 / 3.0, -0.7])
POINTS = [Fraction(-1), Fraction(1), Fraction(0), Fraction(1, 3), Fraction(-7, 8)]


@st.composite
def drawn(draw, symbols=2):
    """Draw a form of one box."""
    size = draw(SIZES)
    row = [draw(CENTRES), abs(draw(SHARES)) * size, *(draw(SHARES) * size for _ in range(symbols))]
    return np.array([row])


def points(symbols):
    return itertools.product(POINTS, repeat=symbols)


SUMS = {
    "plus": (forms.plus, lambda x, y: x + y),
    "minus": (forms.minus, lambda x, y: x - y),
    "times": (forms.times, lambda x, y: x * y),
    "larger": (forms.larger, max),
    "smaller": (forms.smaller, min),
}


@pytest.mark.parametrize("name", SUMS)
@settings(max_examples=60)
@given(a=drawn() | CENTRES, b=drawn() | CENTRES | drawn(symbols=0))
def test_operations_of_two_forms_hold_the_exact_values(name, a, b):
    operation, exact = SUMS[name]
    result = operation(a, b)
    for symbols in itertools.product((-1, 1, Fraction(1, 3)), repeat=2):
        for own in itertools.product((-1, 1), repeat=2):
            x, y = (v if isinstance(v, float) else at(v, symbols, e) for v, e in zip((a, b), own, strict=True))
            assert holds(result, symbols, exact(Fraction(x), Fraction(y)))


@settings(max_examples=60)
@given(a=drawn() | CENTRES, factor=CENTRES, count=st.integers(1, 7))
def test_multiples_and_parts_hold_the_exact_values(a, factor, count):
    for symbols in itertools.product((-1, 1, Fraction(1, 3)), repeat=2):
        for own in (-1, 1):
            x = Fraction(a if isinstance(a, float) else at(a, symbols, own))
            assert holds(forms.scaled(a, factor), symbols, x * Fraction(factor))
            assert holds(forms.divided(a, count), symbols, x / count)


@settings(max_examples=60)
@given(a=drawn(symbols=1), exponent=st.integers(0, 5))
def test_whole_powers_hold_the_exact_values(a, exponent):
    for (e,) in points(1):
        for own in (-1, 0, 1):
            with np.errstate(all="ignore"):
                result = forms.powered(a, float(exponent))
            assert holds(result, [e], at(a, [e], own) ** exponent)


def test_squares_of_symbols_are_not_negative():
    low, high = forms.ends(forms.times(x := np.array([[0.0, 0.0, 2.0]]), x))
    assert low[0] >= -1e-12
    assert high[0] <= 4.0 + 1e-12


FUNCTIONS = {
    "sin": (forms.sine, lambda x: x.sin(), True),
    "cos": (lambda a: forms.sine(a, math.pi / 2), lambda x: x.cos(), True),
    "exp": (forms.exponential, lambda x: x.exp(), True),
    "log": (forms.logarithm, lambda x: x.log(), False),
    "sqrt": (forms.root, lambda x: x.sqrt(), False),
    "inverse": (forms.inverse, lambda x: 1 / x, True),
    "ramp": (forms.ramp, lambda x: x.max(arb(0)), True),
    "abs": (forms.absolute, abs, True),
    "power 1/3": (lambda a: forms.powered(a, 1 / 3), lambda x: x ** arb(Fraction(1 / 3)), False),
    "power -2.5": (lambda a: forms.powered(a, -2.5), lambda x: x ** arb(Fraction(-2.5)), False),
    "power -3": (lambda a: forms.powered(a, -3.0), lambda x: x**-3, True),
}


@pytest.mark.parametrize("name", FUNCTIONS)
@settings(max_examples=150)
@given(a=drawn(symbols=1) | CENTRES, share=st.floats(-1.0, 1.0))
def test_functions_hold_the_exact_values(name, a, share):
    function, exact, is_signed = FUNCTIONS[name]
    if not is_signed:  # into the domain
        a = abs(a) if isinstance(a, float) else np.array([[abs(a[0, 0]) + np.abs(a[0, 1:]).sum() * 1.001, *a[0, 1:]]])
    try:
        with np.errstate(all="ignore"):
            result = function(a)
    except DomainError:
        return
    for e in [*POINTS, Fraction(share), *extremes(a)]:
        for own in (-1, 0, 1):
            x = Fraction(a) if isinstance(a, float) else at(a, [e], own)
            assert abs(e) > 1 or holds(result, [e], exact(arb(x)))


def extremes(a):
    """Return where the symbol of a form, alone, takes it to 0 or to a multiple of a quarter turn."""
    if isinstance(a, float) or not a[0, 2]:
        return []
    first = math.floor(a[0, 0] / (math.pi / 2)) if abs(a[0, 0]) < 1e12 else 0
    wanted = [0.0, *(k * math.pi / 2 for k in range(first - 2, first + 4))]
    return [e for x in wanted if abs(e := (Fraction(x) - Fraction(a[0, 0])) / Fraction(a[0, 2])) <= 1]


def test_the_sine_of_a_wide_range_is_its_range():
    low, high = forms.ends(forms.sine(np.array([[1000.0, 0.0, 1.6], [0.0, 0.0, 1e9]])))
    assert (low >= -1.0 - 1e-9).all()
    assert (high <= 1.0 + 1e-9).all()


@pytest.mark.parametrize("turns", [0, 1, 17, 1003, 10007, 1000003, 10000019, 1000000007])
def test_the_cosine_of_large_numbers_is_exact_at_the_ends(turns):
    """Where it falls from one end to the other."""
    a = np.array([[math.pi * (2 * turns + 0.5), 0.0, 0.9]])
    result = forms.hulled(forms.sine(a, math.pi / 2))
    assert all(holds(result, [], arb(at(a, [e])).cos()) for e in (-1, 1))


@settings(max_examples=100)
@given(
    a=drawn(symbols=1),
    b=drawn(symbols=1),
    e=st.sampled_from([-1.0, -0.5, 0.25, 1.0]),
    name=st.sampled_from(["+", "-", "*", "/", "+c"]),
)
def test_what_a_controller_computes_with_floats_is_held(a, b, e, name):
    """The float of an operation on floats of the sets, as a controller computes it."""
    x, y = (float(at(v, [e])) for v in (a, b))
    # The sets hold the floats themselves.
    a, b = (np.array([[v[0, 0], abs(v[0, 1]) + float(abs(at(v, [e]) - Fraction(f))) * 1.01, v[0, 2]]])
            for v, f in ((a, x), (b, y)))  # fmt: skip
    try:
        with np.errstate(all="ignore"):
            result, number = {
                "+": lambda: (forms.plus(a, b), x + y),
                "-": lambda: (forms.minus(a, b), x - y),
                "*": lambda: (forms.times(a, b), x * y),
                "/": lambda: (forms.times(a, forms.inverse(b)), x / y),
                "+c": lambda: (forms.plus(a, -a[0, 0]), x + -a[0, 0]),
            }[name]()
    except (DomainError, ZeroDivisionError):
        return
    assert not math.isfinite(number) or abs(number) < 1e-290 or holds(result, [e], number)


@settings(max_examples=60)
@given(a=drawn() | CENTRES, b=drawn() | CENTRES, decided=st.sampled_from(["yes", "no", "open"]))
def test_a_choice_holds_what_it_may_choose(a, b, decided):
    yes, no = np.array([decided == "yes"]), np.array([decided == "no"])
    result = forms.chosen(yes, no, a, b)
    for symbols in itertools.product((-1, 1), repeat=2):
        for own in (-1, 1):
            x, y = (Fraction(v) if isinstance(v, float) else at(v, symbols, own) for v in (a, b))
            assert decided == "no" or holds(result, symbols, x)
            assert decided == "yes" or holds(result, symbols, y)


@pytest.mark.parametrize(
    "impossible",
    [
        lambda: forms.logarithm(-1.0),
        lambda: forms.root(-1.0),
        lambda: forms.exponential(1e4),
        lambda: forms.powered(-8.0, 1 / 3),
        lambda: forms.powered(0.0, -1.0),
        lambda: forms.inverse(0.0),
        lambda: forms.inverse(np.array([[0.0, 0.0, 1.0]])),
        lambda: forms.root(np.array([[0.0, 0.0, 1.0]])),
        lambda: forms.logarithm(np.array([[1.0, 0.0, 1.0]])),
    ],
)
def test_values_beyond_a_domain_are_refused(impossible):
    with pytest.raises(DomainError):
        impossible()


def test_a_box_of_several_is_the_box_alone():
    rows = np.array([[0.3, 0.1, 0.2], [1.5, 0.0, 2.0], [-4.0, 0.5, 0.0]])
    for function in (forms.sine, forms.exponential, forms.ramp, lambda a: forms.sine(a, math.pi / 2)):
        together = forms.as_form(function(rows))
        for k in range(3):
            alone = forms.as_form(function(rows[k : k + 1]))
            assert forms.radius(together)[k] <= forms.radius(alone)[0] * (1 + 1e-12) + 1e-290
            for e in (-1, 1, Fraction(1, 3)):
                apart = abs(at(together, [e], 0, k) - at(alone, [e]))
                assert apart <= Fraction(float(together[k, 1])) * 2 + Fraction(1, 10**12)
