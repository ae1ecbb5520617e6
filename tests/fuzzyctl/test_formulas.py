import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl.expr import Name, Number
from fuzzyctl.formulas import CONJUNCTIONS, DISJUNCTIONS, MEMBERSHIP
from fuzzyctl.kernels.python_backend import scalar_function

UNIT = st.floats(0, 1)
FINITE = st.floats(-100, 100, allow_subnormal=False)


def degree(kind, *parameters):
    return scalar_function(MEMBERSHIP[kind].degree(Name("x"), parameters))


def norm(among, name):
    return scalar_function(among[name](Name("a"), Name("b")))


class TestMembership:
    @pytest.mark.parametrize(
        ("parameters", "points"),
        [
            ((0, 1, 3), {-1: 0, 0: 0, 0.5: 0.5, 1: 1, 2: 0.5, 3: 0, 4: 0}),
            ((-math.inf, 1, 3), {-1e300: 1, 1: 1, 2: 0.5, 3: 0}),
            ((0, 1, math.inf), {0: 0, 0.25: 0.25, 1: 1, 1e300: 1}),
            ((1, 1, 3), {0.999: 0, 1: 1, 2: 0.5}),
            ((0, 3, 3), {1.5: 0.5, 3: 1, 3.001: 0}),
        ],
    )
    def test_a_triangle_rises_to_its_peak_and_falls(self, parameters, points):
        f = degree("triangle", *parameters)
        assert {x: f(x) for x in points} == points

    def test_a_trapezoid_is_flat_between_its_tops(self):
        f = degree("trapezoid", 0, 1, 2, 4)
        assert [f(x) for x in (0, 0.5, 1, 1.5, 2, 3, 4)] == [0, 0.5, 1, 1, 1, 0.5, 0]

    def test_a_gaussian_is_e_to_the_minus_half_at_one_sigma(self):
        f = degree("gaussian", 5, 1.5)
        assert f(5) == 1
        assert f(6.5) == f(3.5) == pytest.approx(math.exp(-0.5), rel=1e-15)

    def test_a_singleton_is_one_at_its_value_only(self):
        f = degree("singleton", 2)
        assert [f(x) for x in (1.999, 2, 2.001)] == [0, 1, 0]

    @given(st.lists(FINITE, min_size=4, max_size=4).map(sorted), st.floats(allow_nan=False))
    def test_a_trapezoid_stays_between_zero_and_one(self, p, x):
        assert 0 <= degree("trapezoid", *p)(x) <= 1

    @given(st.lists(FINITE, min_size=4, max_size=4).map(sorted))
    def test_the_core_has_degree_one_and_the_vertices_their_degrees(self, p):
        formula = MEMBERSHIP["trapezoid"]
        f = degree("trapezoid", *p)
        assert [f(x) for x in formula.core(tuple(p))] == [1, 1]
        corners = formula.vertices(tuple(p))
        for x, y in corners:
            # The larger degree holds where two corners share their place.
            assert f(x) == max(v for u, v in corners if u == x)
            assert y <= f(x)

    @pytest.mark.parametrize(
        ("kind", "parameters", "part"),
        [
            ("triangle", (0, -1, 2), "left = 0 is greater than peak = -1"),
            ("trapezoid", (0, 1, 0.5, 2), "left_top = 1 is greater than right_top = 0.5"),
            ("gaussian", (0, 0), "must be > 0"),
        ],
    )
    def test_bad_parameters_are_named(self, kind, parameters, part):
        assert part in MEMBERSHIP[kind].mistake(parameters)


class TestNorms:
    @pytest.mark.parametrize("name", CONJUNCTIONS)
    @given(a=UNIT, b=UNIT, c=UNIT)
    def test_a_t_norm_is_commutative_monotone_and_has_one_as_unit(self, name, a, b, c):
        t = norm(CONJUNCTIONS, name)
        # A few roundings of numbers up to 1, each at most 2^-53.
        assert t(a, b) == pytest.approx(t(b, a), abs=4.5e-16)
        assert t(a, 1.0) == a
        assert t(a, 0.0) == 0
        low, high = sorted((b, c))
        assert t(a, low) <= t(a, high)
        assert 0 <= t(a, b) <= min(a, b) + 2.3e-16

    @pytest.mark.parametrize("name", DISJUNCTIONS)
    @given(a=UNIT, b=UNIT, c=UNIT)
    def test_an_s_norm_is_commutative_monotone_and_has_zero_as_unit(self, name, a, b, c):
        s = norm(DISJUNCTIONS, name)
        assert s(a, b) == pytest.approx(s(b, a), abs=4.5e-16)
        assert s(a, 0.0) == a
        assert s(a, 1.0) == 1
        low, high = sorted((b, c))
        # Rounding of a + b(1 - a) is at most one unit in the last place of 1.
        assert s(a, low) <= s(a, high) + 2.3e-16
        assert max(a, b) - 2.3e-16 <= s(a, b) <= 1

    def test_the_probabilistic_sum_is_a_plus_b_minus_ab(self):
        assert scalar_function(DISJUNCTIONS["probabilistic_sum"](Number(0.5), Number(0.5)))() == 0.75
