"""Rules that never act, terms that never matter."""

import pytest

from fuzzyctl import check, loads

HEAD = """system s
{settings}
param off = 0
input x in [0, 10]
  A = triangle(-inf, 2, 4)
  B = triangle(3, 5, 8)
  C = triangle(6, 8, inf)
  D = triangle(12, 14, inf)
input y in [-1, 1]
  N = gaussian(-1, 0.2)
  P = gaussian(1, 0.2)
output u in [0, 1]
  low  = triangle(-inf, 0, 0.5)
  mid  = triangle(0, 0.5, 1)
  high = triangle(0.5, 1, inf)
if x is A then u is low
if x is B or x is C then u is high
"""


def diagnostics(system):
    return [d for d in check(system)[1] if d.code in ("FZ403", "FZ404")]


def found(*rules, settings=""):
    system = loads(HEAD.format(settings=settings) + "\n".join(rules) + "\n")
    return [(d.code, d.span.line, " ".join((d.message, *d.facts))) for d in diagnostics(system)]


class TestDeadRules:
    @pytest.mark.parametrize(
        ("rule", "reason"),
        [
            ("if x is A and x is C then u is mid", "do not overlap"),
            ("if x is A and (x is C and y is N) then u is mid", "do not overlap"),
            ("if y is N then u is mid weight 0", "weight is 0"),
        ],
    )
    def test_each_is_reported_with_the_reason(self, rule, reason):
        ((code, line, text),) = found(rule)
        assert (code, line) == ("FZ403", 18)
        assert reason in text

    @pytest.mark.parametrize(
        "rule",
        [
            "if x is A and x is B then u is mid",
            "if x is A and y is N then u is mid",
            "if x is not A and x is not B and x is not C then u is mid",
            "if y is N then u is mid weight (off)",
            "if x is A or x is D then u is mid",
        ],
    )
    def test_what_may_act_is_not(self, rule):
        assert [f for f in found(rule) if f[0] == "FZ403"] == []

    def test_a_threshold_that_is_never_reached_is_named(self):
        (one,) = found("if y is N then u is mid weight 0.3", settings="activation threshold(>= 0.5)")
        assert one[:2] == ("FZ403", 18)
        assert "threshold is 0.5" in one[2]

    def test_a_term_that_only_dead_rules_name_is_named_with_them(self):
        ((_, _, text),) = found("if x is A and x is C then u is mid")
        assert "term 'mid' of 'u' never matters" in text
        ((_, _, text),) = found("if x is A and x is C then u is low")
        assert "matters" not in text


class TestCoveredRules:
    @pytest.mark.parametrize(
        ("rule", "other"),
        [
            ("if x is A and y is N then u is low", 16),
            ("if y is N and x is A then u is low weight 0.9", 16),
            ("if x is B then u is high", 17),
            ("if x is C and y is P then u is high", 17),
        ],
    )
    def test_one_that_another_outdoes_changes_nothing(self, rule, other):
        for norms in ("", "and product", "or probabilistic_sum"):
            system = loads(HEAD.format(settings=norms) + rule + "\n")
            (d,) = diagnostics(system)
            assert (d.code, d.span.line, d.notes[0].span.line) == ("FZ403", 18, other)

    @pytest.mark.parametrize(
        "rule",
        [
            "if x is A and y is N then u is mid",
            "if x is B and y is N then u is low",
            "if y is N then u is low",
            "if x is somewhat A and y is N then u is low",
        ],
    )
    def test_what_is_not_outdone_is_fine(self, rule):
        assert found(rule) == []

    def test_a_larger_weight_or_a_sum_makes_it_count(self):
        weak = HEAD.replace("if x is A then u is low", "if x is A then u is low weight 0.5")
        system = loads(weak.format(settings="") + "if x is A and y is N then u is low\n")
        assert diagnostics(system) == []
        for settings in ("aggregation sum\nimplication product", "defuzzifier center_average"):
            assert found("if x is A and y is N then u is low", settings=settings) == []


class TestDeadTerms:
    def test_a_term_outside_the_range_is_reported_once_with_its_rules(self):
        ((code, line, text),) = found("if x is D then u is mid", "if x is D and y is N then u is low")
        assert (code, line) == ("FZ404", 8)
        assert "2 rules with it never fire" in text
        assert "term 'mid' of 'u' never matters" in text

    def test_extrapolated_inputs_have_no_outside(self):
        system = loads(HEAD.format(settings="").replace("[0, 10]", "[0, 10] extrapolate") + "if x is D then u is mid\n")
        assert diagnostics(system) == []
