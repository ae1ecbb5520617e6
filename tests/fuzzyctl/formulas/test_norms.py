"""Norms and hedges keep their laws."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fuzzyctl.expr import Name, Number
from fuzzyctl.formulas import (
    AGGREGATIONS,
    CONJUNCTIONS,
    DISJUNCTIONS,
    HEDGES,
    IMPLICATIONS,
)
from fuzzyctl.kernels.program.scalar import scalar_function
from tests.reference import formulas as reference
from tests.sizes import examples

#: Other processes may slow a test down at any time.
QUICK = settings(max_examples=examples(60, 20), deadline=None)
UNIT = st.floats(0, 1)


def norm(among, name):
    return scalar_function(among[name](Name("a"), Name("b")))


class TestNorms:
    @pytest.mark.parametrize("name", CONJUNCTIONS)
    @QUICK
    @given(a=UNIT, b=UNIT, c=UNIT)
    def test_a_t_norm_is_commutative_monotone_and_has_one_as_unit(self, name, a, b, c):
        t = norm(CONJUNCTIONS, name)
        # A few roundings of numbers up to 1, each at most 2^-53.
        assert t(a, b) == pytest.approx(t(b, a), abs=4.5e-16)
        assert t(a, 1.0) == a
        assert t(1.0, a) == pytest.approx(a, abs=2.3e-16)
        assert t(a, 0.0) == 0
        low, high = sorted((b, c))
        assert t(a, low) <= t(a, high) + 2.3e-16
        assert 0 <= t(a, b) <= min(a, b) + 2.3e-16
        assert t(a, b) <= 1

    @pytest.mark.parametrize("name", DISJUNCTIONS)
    @QUICK
    @given(a=UNIT, b=UNIT, c=UNIT)
    def test_an_s_norm_is_commutative_monotone_and_has_zero_as_unit(self, name, a, b, c):
        s = norm(DISJUNCTIONS, name)
        assert s(a, b) == pytest.approx(s(b, a), abs=4.5e-16)
        assert s(a, 0.0) == a
        assert s(0.0, a) == a
        assert s(a, 1.0) == 1
        low, high = sorted((b, c))
        # Rounding of a + b(1 - a) is at most one unit in the last place of 1.
        assert s(a, low) <= s(a, high) + 4.5e-16
        assert max(a, b) - 2.3e-16 <= s(a, b) <= 1

    @pytest.mark.parametrize("name", CONJUNCTIONS)
    @QUICK
    @given(a=st.integers(0, 16), b=st.integers(0, 16), c=st.integers(0, 16))
    def test_a_t_norm_is_associative(self, name, a, b, c):
        t, (a, b, c) = norm(CONJUNCTIONS, name), (a / 16, b / 16, c / 16)
        assert t(t(a, b), c) == pytest.approx(t(a, t(b, c)), abs=1e-15)

    @pytest.mark.parametrize(("t", "s"), list(zip(CONJUNCTIONS, DISJUNCTIONS, strict=True)))
    @QUICK
    @given(a=st.integers(0, 16), b=st.integers(0, 16))
    def test_each_s_norm_is_the_dual_of_the_t_norm_on_its_place(self, t, s, a, b):
        a, b = a / 16, b / 16
        assert norm(DISJUNCTIONS, s)(a, b) == pytest.approx(1 - norm(CONJUNCTIONS, t)(1 - a, 1 - b), abs=1e-15)

    @pytest.mark.parametrize("name", reference.NORMS)
    @QUICK
    @given(a=UNIT, b=UNIT)
    @example(a=0.5, b=0.75)
    def test_each_norm_is_its_formula(self, name, a, b):
        found = norm({**CONJUNCTIONS, **AGGREGATIONS}, name)(a, b)
        jump = name.startswith("nilpotent") and a + b == 1.0  # whether the sum is above 1 is a matter of rounding
        assert jump or found == pytest.approx(reference.norm(reference.FLOAT, name, a, b), rel=1e-14, abs=1e-15)

    def test_quotients_have_their_limits(self):
        assert norm(CONJUNCTIONS, "hamacher_product")(0.0, 0.0) == 0
        assert norm(DISJUNCTIONS, "hamacher_sum")(1.0, 1.0) == 1
        assert norm(CONJUNCTIONS, "hamacher_product")(1e-200, 1e-200) == pytest.approx(5e-201)
        assert norm(CONJUNCTIONS, "nilpotent_minimum")(1e-30, 1.0) == 1e-30

    def test_implications_are_t_norms_and_aggregations_a_plain_sum_too(self):
        assert IMPLICATIONS.keys() == CONJUNCTIONS.keys()
        assert AGGREGATIONS.keys() == {"sum", *DISJUNCTIONS}
        assert norm(AGGREGATIONS, "sum")(0.75, 0.75) == 1.5


def hedge(name, x):
    return scalar_function(HEDGES[name](Name("x")))(x)


class TestHedges:
    @pytest.mark.parametrize("name", sorted(set(HEDGES) - {"any"}))
    @QUICK
    @given(x=UNIT)
    @example(x=0.5)
    def test_are_their_formulas_and_keep_degrees_between_zero_and_one(self, name, x):
        assert 0 <= hedge(name, x) <= 1
        assert hedge(name, x) == pytest.approx(reference.HEDGES[name](reference.FLOAT, x), rel=1e-15)

    def test_any_is_one_everywhere(self):
        assert HEDGES["any"](Name("x")) == Number(1.0)

    @QUICK
    @given(x=UNIT)
    def test_seldom_undoes_extremely(self, x):
        assert hedge("seldom", hedge("extremely", x)) == pytest.approx(x, abs=1e-7)
