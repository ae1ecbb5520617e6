import pytest

from fuzzyctl.kernels.tracing import trace
from fuzzyctl.loading import loads


def test_shares_are_of_what_consequents_feel_and_functions_read_outputs():
    text = (
        "system s\nsemantics pyfuzzylite\ndefuzzifier weighted_average\ninput a in [0, 10]\n"
        "  lo = triangle(-inf, 0, 10)\n  hi = triangle(0, 10, inf)\n"
        "output y in [0, 10] else 0\n  one = function(a + 1)\n  two = constant(3)\n"
        "output z in [0, 10] clamp\n  seven = function(y * 7)\n"
        "if a is lo then y is very one, z is seven\nif a is hi then y is not two\nif y is one then z is seven\n"
    )
    found = trace(loads(text), {"a": 2.0})
    first, third, second = found.rules
    assert (first.number, second.number, third.number) == (1, 2, 3)
    assert first.activation == 0.8
    assert first.contributions[0].share == pytest.approx(0.64 / (0.64 + 0.8))
    assert second.contributions[0].share == pytest.approx(0.8 / (0.64 + 0.8))
    assert first.contributions[1].value == pytest.approx(7 * found.outputs["y"])
    assert found.outputs["z"] == 10.0


TWICE = """\
Engine: twice
InputVariable: x
  range: 0 10
  term: low Triangle -10 0 10
OutputVariable: y
  range: 0 1
  aggregation: Maximum
  defuzzifier: Centroid 100
  term: m Triangle 0.25 0.5 0.75
  term: l Triangle 0.5 0.75 1
RuleBlock:
  implication: Minimum
  activation: General
  rule: if x is low then y is very m and y is l
"""


def test_a_rule_that_sets_an_output_twice_contributes_twice():
    """A hedge of fuzzylite's consequents is carried on to the next one: 0.8 squared for both."""
    (rule,) = trace(loads(TWICE, "twice.fll"), {"x": 2.0}).rules
    assert [(c.output, c.term, c.felt) for c in rule.contributions] == [
        ("y", "very m", pytest.approx(0.64)),
        ("y", "l", pytest.approx(0.64)),
    ]
    assert [c.share for c in rule.contributions] == [0.5, 0.5]
