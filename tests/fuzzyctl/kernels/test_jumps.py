"""Gradients of sets that jump beside areas and moments that are known, and which comparisons make sets jump."""

import math

import pytest

from fuzzyctl import compile as compile_system
from fuzzyctl import loads
from tests import sizes

TEXT = """
system s
implication {implication}
aggregation {aggregation}
defuzzifier centroid
hedge squared(x) = x * x
hedge wavy(x) = 0.5 - 0.5 * cos(5 * x)
input x in [0, 1]
  H = ramp(0, 1)
  all = rectangle(0, 1)
output u in [0, 1]
  R = ramp(0, 1)
  B = {term}
  C = piecewise(0, 0, 0.3, 0.2, 0.3, 0.9, 1, 1)
if x is H then u is {first}
if x is all then u is {second}
"""


def system(first, second, implication, aggregation="max", term="ramp(0, 2)"):
    own = {"implication": implication, "aggregation": aggregation, "term": term}
    return TEXT.format(first=first, second=second, **own)


def of_sum(x):
    """Of u and x u, 1 where both together reach 1: from 1 / (1 + x) on."""
    a, by = 1 / (1 + x), -1 / (1 + x) ** 2
    return a * a / 2 + 1 - a, a**3 / 3 + (1 - a * a) / 2, (a - 1) * by, (a * a - a) * by


def of_squared(x):
    """Of u / 2 and min(x, u²) where u² is above 1 - x, for x from 0.5 on: it bends at √x."""
    a, c = math.sqrt(1 - x), math.sqrt(x)
    by = -1 / (2 * a)
    area = a * a / 4 + (c**3 - a**3) / 3 + x * (1 - c)
    moment = a**3 / 6 + (c**4 - a**4) / 4 + x * (1 - c * c) / 2
    jump = a / 2 - a * a
    return area, moment, jump * by + 1 - c, a * jump * by + (1 - c * c) / 2


def of_wavy(x):
    """Of u / 2, and 1 where (1 - cos 5 u) / 2 is above 1 - x."""
    turn = math.acos(2 * x - 1)
    a, b, by = turn / 5, (2 * math.pi - turn) / 5, -1 / (5 * math.sqrt(x - x * x))
    area, moment = 0.25 + b - a - (b * b - a * a) / 4, 1 / 6 + (b * b - a * a) / 2 - (b**3 - a**3) / 6
    return area, moment, (a / 2 - 1 + b / 2 - 1) * by, (a * (a / 2 - 1) + b * (b / 2 - 1)) * by


def of_side(x):
    """Of u and x from 0.3 on, where a side is upright: this jump stays where it is."""
    area, moment = 0.045 + x * (x - 0.3) + (1 - x * x) / 2, 0.009 + x * (x * x - 0.09) / 2 + (1 - x**3) / 3
    return area, moment, x - 0.3, (x * x - 0.09) / 2


CASES = [
    (of_sum, system("R", "R", "product", "nilpotent_maximum"), (0.3, 0.5, 0.9)),
    (of_squared, system("squared R", "B", "nilpotent_minimum"), (0.55, 0.6, 0.7)),
    # At 0.5 the places are among those that the integral knows beforehand, which do not move.
    (of_wavy, system("wavy R", "B", "bounded_difference", "drastic_sum"), (0.2, 0.5, 0.6)),
    (of_side, system("C", "R", "nilpotent_minimum"), (0.4, 0.5, 0.7)),
]


@pytest.mark.parametrize("backend", sizes.BACKENDS)
@pytest.mark.parametrize(("known", "text", "points"), CASES, ids=lambda c: getattr(c, "__name__", ""))
def test_jumps_that_move_have_their_share(known, text, points, backend):
    kernel = compile_system(loads(text), backend, algorithm="rules")
    values = kernel.batch([[x] for x in points])
    slopes = kernel.gradient([[x] for x in points])[:, 0]
    for x, value, slope in zip(points, values, slopes, strict=True):
        area, moment, area_by, moment_by = known(x)
        assert value == pytest.approx(moment / area, abs=1e-13)
        assert slope == pytest.approx((moment_by - area_by * moment / area) / area, abs=1e-12)
