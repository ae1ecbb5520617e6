"""Small systems that were found by chance, where profiles once computed other numbers than their tools."""

from __future__ import annotations

import math

import pytest

import fuzzyctl
from fuzzyctl.model.profiles import profile


def value(text: str, **inputs: float) -> float:
    return fuzzyctl.loads(f"system found\n{text}")(**inputs)


CHOSEN = """
semantics pyfuzzylite
activation {activation}
defuzzifier weighted_average
input a in [0, 10] extrapolate
  low = triangle(0, 2, 4)
  high = triangle(6, 8, 10)
output y in [0, 10] else nan
  small = constant(1)
  large = constant(9)
if a is low then y is any small
if a is high then y is any large
"""


@pytest.mark.parametrize(
    ("activation", "expected"),
    [
        ("general", 5.0),
        ("proportional", 1.0),
        ("first(count=1)", 1.0),
        ("highest(count=2)", 1.0),
        ("threshold(> 0.5)", 1.0),
        ("threshold(<= 0.5)", 9.0),
    ],
)
def test_any_acts_only_in_rules_that_are_chosen(activation, expected):
    assert value(CHOSEN.format(activation=activation), a=2.0) == expected


BEYOND = """
semantics {semantics}
defuzzifier tsukamoto
input a in [0, 10] extrapolate
  low = triangle(0, 2, 4)
output y in [0, 30] else 7
  term = {term}
if a is low then y is term
"""


@pytest.mark.parametrize(
    ("semantics", "term", "expected"),
    [
        ("pyfuzzylite", "ramp(0, 10, height=0.5)", 20.0),
        ("exact", "ramp(0, 10, height=0.5)", 10.0),
        ("pyfuzzylite", "sigmoid(5, 1, height=0.5)", 7.0),
        ("exact", "s_shape(0, 10, height=0.5)", 10.0),
        ("pyfuzzylite", "s_shape(0, 10, height=0.5)", 7.0),
    ],
)
def test_the_inverse_goes_on_beyond_the_height(semantics, term, expected):
    assert value(BEYOND.format(semantics=semantics, term=term), a=2.0) == expected


@pytest.mark.parametrize(("semantics", "expected"), [("pyfuzzylite", 7.0), ("fuzzylite", math.nan)])
def test_an_output_without_a_value_is_what_it_is_otherwise(semantics, expected):
    text = f"""
semantics {semantics}
defuzzifier weighted_average
input a in [0, 10] extrapolate
  low = triangle(0, 2, 4)
output y in [0, 10] else 7
  broken = function((a - a) / (a - a))
if a is low then y is broken
"""
    assert value(text, a=2.0) == pytest.approx(expected, nan_ok=True)


@pytest.mark.parametrize(("kind", "expected"), [("som", 2.0), ("lom", 6.0), ("mom", 4.0)])
def test_maxima_of_an_empty_set_are_those_of_the_range_in_octave(kind, expected):
    text = f"""
semantics octave_0_4
defuzzifier {kind}
input a in [0, 10] extrapolate
  low = triangle(0, 2, 4)
output y in [2, 6]
  left = triangle(2, 3, 4)
if a is low then y is left
"""
    assert value(text, a=9.0) == pytest.approx(expected, rel=1e-12)


def test_a_bisector_of_one_sample_is_the_sample():
    text = """
system found
semantics jfuzzylogic
input a in [0, 10] extrapolate
  low = triangle(0, 2, 4)
output y in [2, 6] else 0
  left = trapezoid(1, 2, 3, 4)
if a is low then y is left
"""
    system = fuzzyctl.loads(text)
    # FLL files may ask for one sample; rule files may not.
    method = profile("jfuzzylogic").defuzzifier("bisector").model_copy(update={"resolution": 1})
    one = system.model_copy(update={"method": system.method.model_copy(update={"defuzzifier": method})})
    assert one(a=2.0) == 2.0


@pytest.mark.parametrize(("semantics", "expected"), [("fuzzylite", 9.0), ("pyfuzzylite", 1.0)])
def test_what_is_too_little_to_act_is_not_the_lowest(semantics, expected):
    text = f"""
semantics {semantics}
activation lowest(count=1)
defuzzifier weighted_average
input a in [0, 10] extrapolate
  low = triangle(0, 2, 4)
output y in [0, 10] else nan
  small = constant(1)
  large = constant(9)
if a is low then y is small weight 1e-7
if a is low then y is large
"""
    assert value(text, a=2.0) == expected
