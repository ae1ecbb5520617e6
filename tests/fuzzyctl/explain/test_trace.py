import math

import pytest

from fuzzyctl import ArgumentError, NoRuleFiresError, UnknownNameError, compile, load, loads, why
from fuzzyctl.testing import run_command

MIXED = """
system mixed
defuzzifier weighted_average
input x in [0, 10]
  low  = triangle(-inf, 0, 10)
  high = triangle(0, 10, inf)
input y in [-1, 1]
  terms N P
output u in [0, 9]
  flat = constant(4)
  tilt = linear(0.5, 2, 1)
output v in [0, 1] else 0 defuzzifier centroid implication product
  a = triangle(0, 0.2, 0.4)
  b = triangle(0.5, 0.7, 0.9)
output w in [0, 1] else nan
  one = constant(1)
if x is low then u is flat, v is a weight 0.5
if x is high then u is tilt
if x is high and y is P then v is b
if x is high and y is N then w is one
"""


def test_contributions_of_an_average_add_up():
    system = load("ais_reaction")
    found = why(system, sigma=0.01, dsigma=0.3)
    output = found.outputs["f"]
    assert output == pytest.approx(system(sigma=0.01, dsigma=0.3), abs=1e-15)
    parts = [c for r in found.rules for c in r.contributions]
    assert sum(c.share for c in parts) == pytest.approx(1.0)
    assert sum(c.share * c.value for c in parts) == pytest.approx(output)
    assert sum(c.influence for c in parts) == pytest.approx(0.0, abs=1e-15)
    assert [r.activation for r in found.rules] == sorted((r.activation for r in found.rules), reverse=True)
    assert len(found.rules) + found.silent == 25


def test_several_outputs_are_taken_apart_each_with_its_method():
    found = why(loads(MIXED), x=4.0, y=0.5)
    assert found.degrees == {"x": {"low": 0.6, "high": 0.4}, "y": {"N": 0.25, "P": 0.75}}
    rules = {r.number: r for r in found.rules}
    assert set(rules) == {1, 2, 3, 4}
    assert rules[1].activation == 0.3
    of_u, of_v = rules[1].contributions
    assert (of_u.output, of_u.term, of_u.value, of_u.share) == ("u", "flat", 4.0, pytest.approx(0.3 / 0.7))
    assert (of_v.output, of_v.value, of_v.influence) == ("v", None, None)
    assert of_v.share == pytest.approx(0.3 / 0.7)
    (tilted,) = rules[2].contributions
    assert tilted.value == pytest.approx(0.5 * 4 + 2 * 0.5 + 1)


def test_slopes_differ_at_an_edge():
    left, right = why(load("ais_reaction"), sigma=0.015, dsigma=0.0).slopes["f"]["sigma"]
    assert left == pytest.approx((0.0 - 0.18) / 0.015, rel=1e-6)
    assert right == pytest.approx((-0.66 - 0.0) / 0.015, rel=1e-6)


def test_what_an_evaluation_refuses_is_refused():
    system = load("tipper")
    with pytest.raises(UnknownNameError, match="did you mean 'food'"):
        why(system, {"service": 1, "foot": 2})
    with pytest.raises(ArgumentError, match="missing for: food"):
        why(system, {"service": 1})
    with pytest.raises(ArgumentError, match="real number"):
        why(system, {"service": 1, "food": "good"})
    with pytest.raises(NoRuleFiresError):
        why(loads(MIXED.replace("else nan", "else error")), {"x": 0.0, "y": 0.0})


def test_shares_are_of_what_consequents_feel_and_functions_read_outputs():
    text = (
        "system s\nsemantics pyfuzzylite\ndefuzzifier weighted_average\ninput a in [0, 10]\n"
        "  lo = triangle(-inf, 0, 10)\n  hi = triangle(0, 10, inf)\n"
        "output y in [0, 10] else 0\n  one = function(a + 1)\n  two = constant(3)\n"
        "output z in [0, 10] clamp\n  seven = function(y * 7)\n"
        "if a is lo then y is very one, z is seven\nif a is hi then y is not two\nif y is one then z is seven\n"
    )
    found = why(loads(text), {"a": 2.0})
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
    (rule,) = why(loads(TWICE, "twice.fll"), {"x": 2.0}).rules
    assert [(c.output, c.term, c.effective_activation) for c in rule.contributions] == [
        ("y", "very m", pytest.approx(0.64)),
        ("y", "l", pytest.approx(0.64)),
    ]
    assert [c.share for c in rule.contributions] == [0.5, 0.5]


READS = """
system s
defuzzifier weighted_average
input x in [0, 1]
  low  = triangle(0, 0.2, 0.4)
  high = triangle(0.6, 0.8, 1)
input y in [0, 1]
  terms N P
output u in [0, 1] else nan
  lo = triangle(-inf, 0, 0.5)
  hi = triangle(0.5, 1, inf)
output v in [0, 1] else 0.25
  p = constant(0)
  q = constant(1)
if x is low then u is lo
if x is high then u is hi
if u is lo then v is p
if u is not hi then v is q
if not (u is lo or u is hi) and y is P then v is q
if y is N then v is p
"""


class TestWithoutAValue:
    """What reads a variable that has no value does not act, and an output that depends on one has none."""

    def test_rules_that_read_an_output_without_a_value_are_silent(self):
        found = why(loads(READS), {"x": 0.5, "y": 0.25})  # no rule fires for u
        assert all(math.isnan(value) for value in found.outputs.values())
        assert [r.number for r in found.rules] == [6]
        assert all(math.isnan(d) for d in found.degrees["u"].values())
        (own,) = found.rules[0].contributions
        assert (own.value, own.share, own.influence) == (0.0, 1.0, None)

    def test_rules_that_read_an_input_without_a_value_are_silent(self):
        found = why(loads(READS), {"x": 0.2, "y": math.nan})
        assert all(math.isnan(value) for value in found.outputs.values())
        assert 6 not in [r.number for r in found.rules]

    def test_so_are_those_that_read_how_far_these_have_activated_a_term(self):
        text = READS.replace("defuzzifier", "semantics fuzzylite\ndefuzzifier")
        assert why(loads(text), {"x": math.nan, "y": 0.0}).rules[0].text == "if y is N then v is p"
        assert [r.number for r in why(loads(text), {"x": math.nan, "y": 0.0}).rules] == [6]


AVERAGE = """
system s
{}
defuzzifier weighted_average
input x in [0, 10]
  terms a b c
output y in [0, 10]{}
  p = constant({})
  q = constant(4)
if x is a then y is p weight 0.5
if x is b then y is q
if x is c then y is q
"""


@pytest.mark.parametrize(
    ("settings", "clamp", "p", "x"),
    [
        ("semantics exact(merge=terms)", "", 1, 7.0),  # b and c are one before the sum: max(0.6, 0.4)
        ("semantics exact(total=strengths)", "", 1, 2.0),
        ("", " clamp", -30, 2.0),
    ],
)
def test_rules_pull_where_the_output_is_the_mean_of_what_they_say(settings, clamp, p, x):
    weight = "" if "terms" not in settings else "if x is b then y is p weight 0.5\n"
    text = AVERAGE.format(settings, clamp, p) + weight
    parts = [c for r in why(loads(text), {"x": x}).rules for c in r.contributions]
    assert len(parts) > 1
    assert all(c.value is not None for c in parts)
    assert [c.influence for c in parts] == [None] * len(parts)
    plain = [c for r in why(loads(AVERAGE.format("", "", 1)), {"x": 2.0}).rules for c in r.contributions]
    assert sum(c.influence for c in plain) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("start", [0.0, 1e6, 1e9, 1e12])
def test_slopes_far_from_0_are_slopes(start):
    """Beside 1e12 the neighbours of a float are 1e-4 away, further than a millionth of the range."""
    text = (
        f"system s\ndefuzzifier weighted_average\ninput x in [{start}, {start + 1}]\n  terms a b\n"
        "output u in [0, 1]\n  p = constant(0)\n  q = constant(1)\nif x is a then u is p\nif x is b then u is q\n"
    )
    slopes = why(loads(text), {"x": start + 0.25}).slopes["u"]["x"]
    assert slopes == (pytest.approx(1.0, rel=1e-9), pytest.approx(1.0, rel=1e-9))


@pytest.mark.parametrize(("error", "change"), [(0.0, 0.0), (5.0, 1.0), (-10.0, -1.0)])
def test_slopes_that_are_0_are_exactly_0(error, change, tmp_path):
    """A set that has just begun to be cut has an area of second order, so that its height moves no centroid."""
    run_command("new", "tip", folder=tmp_path)
    assert why(load(tmp_path / "tip.fz"), {"error": error, "change": change}).slopes["power"]["error"] == (0.0, 0.0)


def test_slopes_of_a_curved_surface_are_those_of_the_kernel():
    system = load("tipper")
    slopes = why(system, {"service": 7.0, "food": 8.0}).slopes["tip"]
    exact = compile(system).gradient([[7.0, 8.0]])[0]
    for name, slope in zip(("service", "food"), exact, strict=True):
        assert slopes[name] == (pytest.approx(slope, rel=1e-8), pytest.approx(slope, rel=1e-8))


def test_slopes_at_infinity_are_those_of_an_input_that_is_held():
    assert why(loads(AVERAGE.format("", "", 1)), {"x": math.inf}).slopes == {"y": {"x": (0.0, 0.0)}}


def test_inputs_of_controllers_are_found_as_the_file_spells_them():
    found = why(loads("controller c\ninput µ in [0, 1]\noutput y = 2 * µ\nevery 1 s\n", block="c"), µ=0.25)
    assert found.outputs == {"y": 0.5}
