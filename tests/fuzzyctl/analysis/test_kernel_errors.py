"""Claims are about what kernels return, also where these look at the rules that act alone."""

import math

import pytest

from fuzzyctl import Proved, loads, prove
from fuzzyctl import compile as compile_system
from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.plan.build import plan

#: A falls to 0 behind 0.3, where B is 1: two corners that differ by less than 1e-14 of the range and count as one.
ROUNDED = """
system s
and {norm}
defuzzifier weighted_average
input x in [0, 2]
  A = triangle(-inf, 0, {foot!r})
  B = triangle(0, 0.3, 1)
  C = triangle(0.3, 1, 2)
  D = triangle(1, 2, inf)
output u in [0, 10]
  p = constant(0)
  q = constant(10)
  r = linear(5, 0)
if x is A then u is p
if x is B then u is q
if x is C then u is r weight 0.5
if x is D then u is p
"""


@pytest.mark.parametrize(("weight", "expected"), [("0.2", "active"), ("0.05", "rules"), ("1e-12", "rules")])
def test_where_corners_count_as_one_a_rule_that_hardly_counts_is_as_good_as_missing(weight, expected):
    text = ROUNDED.format(norm="min", foot=0.300000000000004).replace("then u is q", f"then u is q weight {weight}")
    assert algorithm_of(plan(loads(text))).name == expected


def test_what_is_proved_holds_for_rules_that_are_looked_up():
    text = ROUNDED.format(norm="min", foot=0.300000000000004)
    kernel = compile_system(loads(text), "python", algorithm="active")
    below = math.nextafter(kernel(0.2985), 0.0)
    rules = compile_system(loads(text), "python", algorithm="rules")(0.2985)
    assert rules < below - 1e-13
    claims = [f"require u <= {bound!r} when x >= 0.2985 and x <= 0.2985" for bound in (below, rules + 1e-13, 9.96)]
    verdicts = prove(loads("\n".join([text, *claims, ""])))
    assert [isinstance(v, Proved) for v in verdicts] == [False, False, True]
