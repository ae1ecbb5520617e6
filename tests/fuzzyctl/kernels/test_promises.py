"""Outputs without `else`: NaN of numbers is reported, NaN of NaN is not."""

import math

import numpy as np
import pytest

from fuzzyctl import loads
from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.kernels.forms import Promises
from fuzzyctl.kernels.plan.build import plan

TEXT = """
system s
defuzzifier weighted_average
input x in [0, 10]
  low = triangle(-inf, 2, 4)
input y in [0, 1]
  any = triangle(-inf, 0, inf)
output u in [0, 1]
  a = constant(1)
output v in [0, 1] else nan
  a = constant(1)
if x is low and y is any then u is a, v is a
"""
NAN = math.nan


@pytest.fixture
def promises():
    return Promises(plan(loads(TEXT)), known=False)


@pytest.mark.parametrize(("point", "result"), [((1.0, 0.0), (0.5, NAN)), ((NAN, 0.0), (NAN, NAN))])
def test_a_promise_is_kept_where_a_number_or_an_input_is_nan(promises, point, result):
    promises.check(point, result)
    promises.check_block(np.array([point]), None, np.array([result]))


def test_the_first_point_that_breaks_one_is_named(promises):
    with pytest.raises(NoRuleFiresError, match=r"output 'u' at x = 5, y = 0"):
        promises.check((5.0, 0.0), (NAN, NAN))
    points, results = np.array([[NAN, 0.0], [6.0, 0.0], [7.0, 0.0]]), np.full((3, 2), NAN)
    with pytest.raises(NoRuleFiresError, match=r"output 'u' at x = 6, y = 0"):
        promises.check_block(points, None, results)


def test_what_is_known_to_be_kept_is_not_checked():
    Promises(plan(loads(TEXT)), known=True).check((5.0, 0.0), (NAN, NAN))
