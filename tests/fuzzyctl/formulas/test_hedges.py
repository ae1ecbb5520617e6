"""Hedges keep their laws."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fuzzyctl.expr import Name, Number
from fuzzyctl.formulas import HEDGES
from fuzzyctl.kernels.program.scalar import scalar_function
from tests.reference import formulas as reference
from tests.sizes import examples

#: Other processes may slow a test down at any time.
QUICK = settings(max_examples=examples(60, 20), deadline=None)
UNIT = st.floats(0, 1)


@pytest.mark.parametrize("name", HEDGES)
@QUICK
@given(x=UNIT)
def test_hedges_keep_degrees_between_zero_and_one(name, x):
    assert (
        0 <= scalar_function(HEDGES[name](Name("x")))(x) <= 1
        if name != "any"
        else HEDGES[name](Name("x")) == Number(1.0)
    )


@pytest.mark.parametrize("name", HEDGES)
@QUICK
@given(x=UNIT)
@example(x=0.5)
def test_hedges_are_their_formulas(name, x):
    expected = reference.HEDGES[name](reference.FLOAT, x)
    assert scalar_function(HEDGES[name](Name("x")))(x) == pytest.approx(expected, rel=1e-15)


@QUICK
@given(x=UNIT)
def test_seldom_undoes_extremely(x):
    assert scalar_function(
        HEDGES["seldom"](Number(scalar_function(HEDGES["extremely"](Name("x")))(x)))
    )() == pytest.approx(x, abs=1e-7)
