"""Degrees by where an input lies are the degrees themselves, bit for bit."""

import math
from bisect import bisect_right

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl.expr import Name
from fuzzyctl.kernels.inference.degrees.branched import branched
from fuzzyctl.kernels.plan.build import SetPlan
from fuzzyctl.kernels.program.scalar import scalar_function

PARTITION = (
    SetPlan("triangle", (-math.inf, -0.1, 0.3)),
    SetPlan("triangle", (-0.1, 0.3, 0.7)),
    SetPlan("triangle", (0.3, 0.7, math.inf), height=0.7),
)
APART = (SetPlan("trapezoid", (0.1, 0.2, 0.3, 0.5)), SetPlan("trapezoid", (0.7, 0.8, 0.8, 1.1)))
CORNERS = sorted({c for s in (*PARTITION, *APART) for c, _ in s.vertices})


@pytest.mark.parametrize("sets", [PARTITION, APART, PARTITION + APART], ids=["partition", "apart", "both"])
@given(x=st.one_of(st.floats(-1, 2), st.sampled_from(CORNERS), st.sampled_from([-math.inf, math.inf])))
def test_each_stretch_has_the_degrees_there(sets, x):
    found = branched(tuple(f"d{k}" for k in range(len(sets))), Name("x"), sets)
    assert list(found.cuts) == sorted(set(found.cuts))
    own = found.values[bisect_right(found.cuts, x)]
    assert [scalar_function(v)(x) for v in own] == [scalar_function(s.degree(Name("x")))(x) for s in sets]


def test_a_stretch_has_no_choices_left():
    found = branched(("a", "b", "c"), Name("x"), PARTITION)
    assert "Where" not in repr(found.values)
    assert len(found.values) == len(found.cuts) + 1
