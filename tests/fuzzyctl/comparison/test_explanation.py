"""Which setting explains a difference."""

import math

import pytest

import fuzzyctl
from tests.fuzzyctl.comparison.command import compared, differences

SAMPLED = "defuzzifier centroid(resolution={}, grid={})\n"


def explained(a, b):
    (difference,) = differences(a, b, points=400)
    causes = difference.causes if difference.gap is None or difference.causes else difference.gap.causes
    return {c.name: c for c in causes}


class TestCauses:
    def test_no_difference_has_no_cause(self, base):
        assert explained(base, base) == {}

    def test_a_single_setting_explains_all(self, base):
        found = explained(base, base + "and product\n")
        assert list(found) == ["and"]
        assert found["and"].explains == pytest.approx(1.0)
        assert (found["and"].before, found["and"].after) == ("min", "product")

    def test_a_setting_without_effect_is_no_cause(self, base):
        found = explained(base, base + "and product\nor probabilistic_sum\n")
        assert list(found) == ["and"]

    def test_grid_and_resolution_are_told_apart(self, base):
        a, b = (base + SAMPLED.format(*s) for s in ((11, "midpoint"), (200, "endpoints")))
        found = explained(a, b)
        assert set(found) == {"resolution", "grid"}
        assert sum(c.explains for c in found.values()) == pytest.approx(1.0, abs=1e-6)

    def test_sampling_instead_of_the_exact_integral_is_one_cause(self, base):
        found = explained(base, base + SAMPLED.format(11, "endpoints"))
        assert [c.before for c in found.values()] == ["centroid, exact"]

    def test_several_causes_add_up(self, base, changed):
        other = changed(("  Z = triangle(-1, 0, 1)", "  Z = triangle(-1, 0.5, 1)"), after="implication product\n")
        found = explained(base, other)
        assert {"implication", "range and terms of x"} <= set(found) | {"implication", "range and terms of x"}
        assert "range and terms of x" in found
        assert sum(c.explains for c in found.values()) == pytest.approx(1.0, abs=1e-6)

    def test_a_changed_cell_is_a_change_of_the_rules(self, base, changed):
        found = explained(base, changed(("  Z |  N  P", "  Z |  P  P")))
        assert list(found) == ["rules"]

    def test_renamed_terms_take_variables_and_rules_at_once(self, base, changed):
        other = changed(
            ("  Z = triangle(-1, 0, 1)", "  ZERO = triangle(-1, 0.5, 1)"), ("  Z |  N  P", "  ZERO |  N  P")
        )
        assert list(explained(base, other)) == ["variables and rules"]

    def test_where_one_has_no_value_the_else_is_the_cause(self, changed):
        hole = ("  Z |  N  P", "  Z |  .  .")
        a, b = (changed(hole, ("[-2, 2]", f"[-2, 2] else {e}")) for e in ("nan", "0.5"))
        found = explained(a, b)
        assert [(c.before, c.after) for c in found.values()] == [("nan", "0.5")]

    def test_inputs_in_another_order_are_put_in_order(self, base):
        x, y = (
            "input x" + base.split("input x")[1].split("input y")[0],
            "input y" + base.split("input y")[1].split("out")[0],
        )
        other = base.replace(x + y, y + x).replace("  Z |  N  P", "  Z |  P  P").replace("N = tri", "N = tri")
        renamed = other.replace("  Z = triangle(-1, 0, 1)", "  MID = triangle(-1, 0.5, 1)").replace("  Z |", "  MID |")
        assert [v.name for v in fuzzyctl.loads(renamed).inputs] == ["y", "x"]
        found = explained(base, renamed)
        assert sum(c.explains for c in found.values()) == pytest.approx(1.0, abs=1e-6)


HEDGED = """\
semantics fuzzylite{}
and product
input a in [0, 10]
  lo = triangle(-inf, 0, 10)
  hi = triangle(0, 10, inf)
input b in [0, 10]
  lo = triangle(-inf, 0, 10)
  hi = triangle(0, 10, inf)
output z in [0, 10] else {}
  s = triangle(-inf, 0, 5)
  l = triangle(3, 10, inf)
if a is lo and b is lo then z is very s
if a is lo and b is hi then z is not l
if a is hi then z is l weight 0.7
"""


class TestGapsAndMeans:
    """Where one point has no value on one side, or the largest difference is a special point, the rest counts, too."""

    def test_a_knob_that_takes_the_value_away_explains_both(self):
        first, second = ("system s\n" + HEDGED.format(k, "nan") for k in ("", "(consequent_hedges=set)"))
        (difference,) = differences(first, second, points=400)
        assert difference.gap is not None
        assert [(c.name, c.explains) for c in difference.causes] == [("consequent_hedges", pytest.approx(1.0))]
        assert [c.name for c in difference.gap.causes] == ["consequent_hedges"]
        assert difference.causes_of_mean == difference.causes

    def test_each_setting_that_closes_a_gap_by_itself_is_named(self):
        first, second = ("system s\n" + HEDGED.format(k, e) for k, e in (("", "nan"), ("(consequent_hedges=set)", "3")))
        (difference,) = differences(first, second, points=400)
        assert {c.name for c in difference.gap.causes} == {"consequent_hedges", "else"}

    def test_the_mean_has_causes_of_its_own_where_the_largest_difference_is_another_matter(self):
        """Beside 0 an activation of 1e-6 is too small to count, which is the largest difference; most is the gap."""
        text = "system s\nsemantics exact(least={})\ninput x in [0, 10]\n  low = triangle(0, 2, 5)\n"
        text += "  hi = triangle(8, 9, 10)\noutput y in [0, 20] else {}\n  s = triangle(0, 0.25, 0.5)\n"
        text += "if x is low then y is s\nif x is hi then y is s\n"
        a, b = (text.format(*parts) for parts in ((1e-6, 9), (0.0, 0.5)))
        (difference,) = differences(a, b, points=2000)
        assert [c.name for c in difference.causes] == ["least"]
        assert [c.name for c in difference.causes_of_mean] == ["else"]
        assert difference.causes_of_mean[0].explains == pytest.approx(1.0, abs=0.01)

    def test_an_infinite_difference_has_a_cause(self):
        text = "system s\ndefuzzifier weighted_average\ninput x in [0, 1]\n  all = rectangle(-inf, 1)\n"
        text += "output y in [0, 1]\n  f = function(1 / x)\n  g = function(x)\nif x is all then y is {}\n"
        a, b = (text.format(t) for t in "fg")
        (difference,) = differences(a, b, points=50)
        assert math.isinf(difference.largest)
        assert [c.name for c in difference.causes] == ["rules"]


BLOCKS = """\
system blocks
input x in [0, 10]
  lo = ramp(10, 0)
  hi = ramp(0, 10)
output y in [0, 10] else 0
  s = triangle(0, 2, 4)
  l = triangle(5, 7, 9)
rules one
if x is lo then y is s
rules two{}
if x is hi then y is l
if x is very hi then y is s weight 0.5
"""


class TestRuleBlocks:
    def explained(self, first, second):
        return explained(*(BLOCKS.format(said) for said in (first, second)))

    def test_a_method_of_a_block_is_a_cause_by_itself(self):
        found = self.explained(" implication product activation highest(count=1)", " implication product")
        (cause,) = found.values()
        assert (cause.name, cause.before, cause.after) == ("activation of rules two", "highest(count=1)", "general")
        assert cause.explains == pytest.approx(1.0)

    def test_several_methods_of_a_block_share_the_difference(self):
        found = self.explained(" implication product activation highest(count=1)", "")
        assert set(found) == {"activation of rules two", "implication of rules two"}
        assert found["implication of rules two"].after == "that of the output"
        assert sum(c.explains for c in found.values()) == pytest.approx(1.0, abs=1e-6)

    def test_the_name_of_a_block_is_no_cause(self):
        a, b = (BLOCKS.format(" implication product").replace("two", name) for name in ("two", "twos"))
        assert explained(a, b) == {}

    def test_a_block_with_another_name_and_method_is_explained_by_the_method(self):
        a = BLOCKS.format(" implication product")
        b = BLOCKS.format("").replace("two", "twos")
        assert set(explained(a, b)) == {"implication of rules two"}

    def test_a_block_that_the_other_file_has_not_is_known_by_its_methods(self):
        a = BLOCKS.format(" implication product activation highest(count=1)")
        b = BLOCKS.format("").replace("rules one\n", "").replace("rules two\n", "")
        assert set(explained(a, b)) == {"activation of rules two", "implication of rules two"}

    def test_where_rules_differ_too_a_method_that_all_have_is_told_apart(self):
        a = BLOCKS.format(" activation highest(count=1)")
        more = BLOCKS.format("").replace("y is s\nrules two", "y is s\nif x is lo then y is s weight 0\nrules two")
        assert list(explained(a, more)) == ["activation of rules two"]


def test_rounding_has_no_cause():
    rules = [f"if x is {a} and y is {b} then u is {a}" for a in "NZP" for b in "NZP"]
    sets = "\n".join(f"  {n} = gaussian({m}, 0.4)" for n, m in (("N", -1), ("Z", 0), ("P", 1)))
    head = (
        f"system a\nand product\ndefuzzifier center_average\ninput x in [-1, 1]\n{sets}\ninput y in [-1, 1]\n{sets}\n"
    )
    head += "output u in [-1, 1]\n  terms N@-0.7 Z@0.1 P@0.9\n"
    a, b = ("\n".join([head, *order, ""]) for order in (rules, rules[::-1]))
    (difference,) = differences(a, b, points=400)
    assert 0.0 < difference.largest < 1e-14
    assert (difference.causes, difference.causes_of_mean) == ([], [])
    assert "that is rounding" in compared(a, b, "--points", 400).output
