"""A written module builds the same system."""

import pytest

import fuzzyctl
from fuzzyctl.convert.convert import written
from tests.shipped import SYSTEMS

EVERYTHING = """\
system everything "All \\ of 'it'"
source "A book"
semantics matlab(least=1e-6)
and product
or probabilistic_sum
implication product
aggregation sum
activation first(count=2, threshold=0.1)
hedge fairly(x) = x ^ 0.7
param top = 2 * 0.4 unit "m"
input x "The x" in [0, top] unit "m" extrapolate
  terms L@0 H@(top)
input y in [-1, 1]
  N = piecewise(-1, 1, 1, 0, height=0.8)
  P = ramp(-1, 1)
output u in [0, 1] clamp else hold(0.25) implication min defuzzifier centroid(resolution=50, grid=endpoints)
  A = triangle(0, 0.25, 0.5)
  B = triangle(0.5, 0.75, 1)
output v in [0, 9] else nan defuzzifier weighted_average
  C = linear(1, 2, 3)
  D = function(x * y)
with x is fairly L
table u, v = x x y
      N        P
  L | A/C      .
  H | B/4*0.5  B/linear(1,1,1)
table v = y
      N  P
   |  C  D
if x is not L or (y is very P and x is H) then u is B, v is D weight (top / 2)
require u <= 1 within 1e-9 when x >= 0
"""


def built(system):
    namespace = {}
    exec(written(system, "python")[0], namespace)
    return namespace["system"]


@pytest.mark.parametrize("path", SYSTEMS, ids=lambda p: p.stem)
def test_the_module_of_a_shipped_file_builds_an_equal_system(path):
    system = fuzzyctl.load(path)
    assert built(system) == system


def test_every_feature_is_written():
    system = fuzzyctl.loads(EVERYTHING)
    assert built(system) == system


def test_texts_with_quotes_and_backslashes_stay_texts():
    system = fuzzyctl.loads(EVERYTHING.replace('"A book"', "\"''' \\ \\n {x} '\""))
    assert "\\n" in system.citation
    assert built(system) == system
