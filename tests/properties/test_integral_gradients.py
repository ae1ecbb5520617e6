"""Gradients of adaptive integrals beside central differences: every pair of norms, own hedges, free numbers.

Degrees that count as equal up to a number, as in fuzzylite, are among them.
"""

import math

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import assume, given

from fuzzyctl import compile as compile_system
from fuzzyctl import loads
from fuzzyctl.formulas import AGGREGATIONS, IMPLICATIONS
from tests.properties.running import quick

TEXT = """
system s
semantics SEMANTICS
and product
implication IMPLICATION
aggregation AGGREGATION
defuzzifier DEFUZZIFIER
hedge odd(x) = x * (1.4 - 0.4 * x)
hedge wavy(x) = 0.5 - 0.5 * cos(5 * x)
input e in [-1, 1]
  terms N Z P
input d in [-1, 1]
  N = gaussian(-1, 0.4)
  P = gaussian(1, 0.5)
output u in [-1, 2]
  A = gaussian(-0.5, 0.3)
  B = spike(0.2, 1.1)
  C = sigmoid_difference(0.8, 9, 1.6, 11)
  D = triangle(0.2, 1, 1.5)
if e is N and d is N then u is A
if e is Z and d is N then u is HEDGE B
if e is N and d is P then u is C
if e is P and d is N then u is wavy D
if e is P and d is P then u is odd C
if e is Z and d is P then u is A
"""
PAIRS = [(i, a) for i in IMPLICATIONS for a in AGGREGATIONS]
#: Under these the sets jump at places that move.
JUMPING = [
    (i, a)
    for i, a in PAIRS
    if i == "nilpotent_minimum" or a == "nilpotent_maximum" or (i, a) == ("bounded_difference", "drastic_sum")
]
#: Away from 0, where the terms of an input bend: kinks of both sides may cancel in central differences.
DEGREES = st.builds(math.copysign, st.floats(0.01, 0.95), st.sampled_from((-1.0, 1.0)))


def difference(function, x, step):
    """The central difference with its error of the third order taken away; inf where both steps disagree, at a bend.

    Args:
        function: From an array of points to their values.
        x: A point.
        step: The longer of two steps.
    """
    moves = step * np.concatenate([side * np.eye(len(x)) for side in (1.0, -1.0, 0.5, -0.5)])
    ahead, behind, near_ahead, near_behind = function(x + moves).reshape(4, len(x))
    coarse, fine = (ahead - behind) / (2 * step), (near_ahead - near_behind) / step
    return fine + (fine - coarse) / 3 if np.allclose(fine, coarse, rtol=1e-5, atol=1e-8) else np.full(len(x), np.inf)


@pytest.mark.parametrize("defuzzifier", ["centroid", "bisector"])
@quick(200, 3)
@given(
    pair=st.sampled_from(PAIRS) | st.sampled_from(JUMPING),
    hedge=st.sampled_from(["", "odd", "wavy"]),
    semantics=st.sampled_from(["exact", "exact(equal=1e-6)"]),
    point=st.tuples(DEGREES, DEGREES),
)
def test_are_those_of_central_differences(defuzzifier, pair, hedge, semantics, point):
    text = TEXT.replace("IMPLICATION", pair[0]).replace("AGGREGATION", pair[1]).replace("HEDGE", hedge)
    text = text.replace("DEFUZZIFIER", defuzzifier).replace("SEMANTICS", semantics)
    system, x = loads(text), np.array(point)
    kernel = compile_system(system, "numpy")
    expected = difference(kernel.batch, x, 2e-4)
    assume(np.isfinite(expected).all())
    np.testing.assert_allclose(kernel.gradient(x), expected, rtol=1e-6, atol=1e-8)
    free = compile_system(system, "numpy", free=["e.Z.peak", "d.N.sigma", "u.weights[2]"])
    values = np.array([0.1, 0.45, 0.8])
    expected = difference(lambda v: free.batch(x, v), values, 2e-4)
    assume(np.isfinite(expected).all())
    np.testing.assert_allclose(free.gradient(x, values, by="state"), expected, rtol=1e-6, atol=1e-8)


def test_a_part_of_a_set_between_two_nodes_counts():
    """One rule has the largest degrees in a narrow part of the range only, where no derivative was looked at."""
    text = TEXT.replace("IMPLICATION", "hamacher_product").replace("AGGREGATION", "max").replace("HEDGE", "")
    text = (
        text.replace("DEFUZZIFIER", "bisector")
        .replace("SEMANTICS", "exact")
        .replace("gaussian(-1, 0.4)", "gaussian(-1, 0.45)")
    )
    free = compile_system(loads(text), "numpy", free=["e.Z.peak", "u.weights"])
    x, values = np.array([0.6546361566920957, 0.031787743967468085]), np.array([0.1, 0.9, 0.8, 0.9, 0.7, 0.8, 0.9])
    expected = difference(lambda v: free.batch(x, v), values, 2e-4)
    assert abs(expected[2]) > 1e-3
    np.testing.assert_allclose(free.gradient(x, values, by="state"), expected, rtol=1e-6, atol=1e-8)
