"""Exact centroids and bisectors beside mpmath: a short form of `python tests/properties/precise_sets.py`."""

import random

import pytest

from tests.properties.precise_sets import IMPLICATIONS, drawn_case, outcome

#: Sets under each implication.
SETS = 3


def drawn(implication, seed=0):
    draw = random.Random(f"{seed} {implication}")
    found = (outcome(drawn_case(draw, implication)) for _ in range(10 * SETS))
    return [o for _, o in zip(range(SETS), (o for o in found if o is not None), strict=False)]


@pytest.mark.parametrize("implication", IMPLICATIONS)
def test_sets_that_hedges_and_sigmoids_make_are_integrated_to_the_stated_bound(implication):
    found = drawn(implication)
    assert len(found) == SETS
    for one in found:
        assert one.error <= one.bound, one.case.text
