"""Exact centroids and bisectors beside mpmath: a short form of `python tests/properties/precise_sets.py`."""

import random

import pytest

from tests import sizes
from tests.properties.precise_sets import IMPLICATIONS, Case, Drawn, drawn_case, outcome

#: Sets under each implication.
SETS = sizes.examples(3, 1)


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


def root(n, x):
    return 4 * x * (1 - x) ** n.number(0.5)


ROOT = ("4 * x * (1 - x)^0.5", root, (0, 1))
#: Own hedges with an infinite slope, by what is wrong where they are off.
STEEP = {
    "flat top": ("bisector", Drawn("bell", (0.531, 0.30477, 2.35), [ROOT], 0.169514)),
    "tail": (
        "bisector",
        Drawn("gaussian2", (0.2866, 0.53729, 0.1441, 0.05514), ["not", ROOT], 0.01696),
    ),
    "noise beside a bend": (
        "centroid",
        Drawn("bell", (0.2024, 0.03559, 2.72), [ROOT], 0.031064),
    ),
}


@pytest.mark.parametrize("name", STEEP)
@pytest.mark.parametrize("backend", sizes.BACKENDS)
def test_hedges_with_an_infinite_slope_are_off_by_what_is_reported(name, backend):
    defuzzifier, term = STEEP[name]
    found = outcome(Case(0.0, 1.0, "min", defuzzifier, [term]), backend)
    assert found.is_reported
    assert found.error <= found.bound


def test_the_reference_knows_roots_near_0():
    cube = ("4 * x * (1 - x)^3", lambda n, x: 4 * x * (1 - x) ** 3)
    term = Drawn("triangle", (0.3828, 0.8131, 0.9289), [(*cube, (0, 1)), "somewhat"], 0.001181)
    found = outcome(Case(0.0, 1.0, "min", "bisector", [term]))
    assert not found.is_reported
    assert found.error <= 1e-13
