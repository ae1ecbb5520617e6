import math

import numpy as np
import pytest

from fuzzyctl import loads, output_bounds
from fuzzyctl.testing import check_text


class TestAverages:
    def test_the_immune_function_is_bounded_by_its_peaks_exactly(self, shipped):
        system = shipped["ais_reaction"]
        bound = output_bounds(system)["f"]
        assert (bound.lo, bound.hi, bound.exact) == (-1.0, 0.18, True)
        assert bound.hi_span is not None
        assert bound.hi_span.text.startswith("PM")
        assert bound.lo_span is not None
        assert bound.lo_span.text.startswith("NB")
        assert system(**bound.hi_at) == 0.18
        assert system(**bound.lo_at) == -1.0

    def test_what_a_caller_does_to_bounds_changes_none_that_a_system_keeps(self, shipped):
        found = output_bounds(shipped["ais_reaction"])
        bound = found.pop("f")
        assert output_bounds(shipped["ais_reaction"]) == {"f": bound}

    def test_the_boundary_layer_is_bounded_exactly(self, shipped):
        bound = output_bounds(shipped["boundary_layer"])["beta"]
        assert (bound.lo, bound.hi, bound.exact) == (0.005, 0.05, True)

    def test_a_higher_peak_raises_the_bound(self, rules):
        text = (rules / "ais_reaction.fz").read_text(encoding="utf-8")
        changed = text.replace("triangle(0.09, 0.18, inf)", "triangle(0.09, 0.19, inf)")
        assert changed != text
        assert output_bounds(loads(changed))["f"].hi == 0.19

    TEXT = """
system s
defuzzifier weighted_average
input x in [0, 1]
  a = triangle(-inf, 0, {foot})
  b = triangle({start}, 1, inf)
  far = triangle(2, 3, inf)
output u in [0, 1] {otherwise}
  A = singleton(0.25)
  B = singleton(0.75)
  F = singleton(1e6)
if x is a then u is A
if x is b then u is B
if x is far then u is F
"""

    def test_rules_that_cannot_fire_do_not_count(self):
        bound = output_bounds(loads(self.TEXT.format(foot=1, start=0, otherwise="")))["u"]
        assert bound.lo == 0.25
        assert 0.75 <= bound.hi < 0.75 + 1e-14
        assert bound.hi_span.text.startswith("B")

    def test_where_tiny_activations_occur_the_bound_is_that_of_all_rules(self):
        bound = output_bounds(loads(self.TEXT.format(foot=0.4, start=0.6, otherwise="else 0.5")))["u"]
        assert bound.hi == 1e6

    @pytest.mark.parametrize(("value", "lo"), [(-3, -3), (0.5, 0.25)])
    def test_else_counts_where_nothing_fires(self, value, lo):
        system = loads(self.TEXT.format(foot=0.4, start=0.6, otherwise=f"else {value}"))
        bound = output_bounds(system)["u"]
        assert bound.lo == lo
        assert system(**bound.lo_at) == lo

    def test_else_does_not_count_where_something_always_fires(self):
        assert output_bounds(loads(self.TEXT.format(foot=1, start=0, otherwise="else -3")))["u"].lo == 0.25

    def test_hold_for_denormal_activations(self):
        system = loads(
            """
system tiny
and product
defuzzifier weighted_average
input x in [0, 1]
  a = triangle(0, 1, inf)
input y in [0, 1]
  a = triangle(0, 1, inf)
output u in [0, 2] else 1.5
  A = singleton(1.4)
  B = singleton(1.6)
if x is a and y is a then u is A
if x is a and y is a then u is B weight 0.3
"""
        )
        bound = output_bounds(system)["u"]
        assert (bound.lo, bound.hi) == (1.4, 1.6)
        for x in np.geomspace(5e-324, 1e-300, 60):
            assert bound.lo <= system(x=float(x), y=1) <= bound.hi

    def test_bounds_of_gaussian_systems_are_not_attained(self):
        system = loads(
            """
system g
defuzzifier weighted_average
input x in [0, 1]
  a = gaussian(0, 0.3)
  b = gaussian(1, 0.3)
output u in [0, 1]
  A = singleton(0)
  B = singleton(1)
if x is a then u is A
if x is b then u is B
"""
        )
        bound = output_bounds(system)["u"]
        assert (bound.lo, bound.hi, bound.exact, bound.lo_at) == (0.0, 1.0, False, None)


class TestOthers:
    def test_an_adaptive_output_stays_in_its_range(self, shipped):
        bound = output_bounds(shipped["fcafsmc"])["F"]
        assert (bound.lo, bound.hi, bound.exact) == (-2.0, 2.0, True)

    def test_a_centroid_lies_between_the_ends_of_the_supports(self, shipped):
        bound = output_bounds(shipped["tipper"])["tip"]
        assert (bound.lo, bound.hi, bound.exact) == (0.0, 30.0, False)

    def test_a_centroid_does_not_reach_where_no_consequent_is(self):
        text = """
system s
{defuzzifier}
input x in [0, 1]
  a = triangle(-inf, 0, 1)
  b = triangle(0, 1, inf)
output u in [0, 10]
  A = triangle(2, 3, 4)
  B = triangle(5, 6, 7)
if x is a then u is A
if x is b then u is B
"""
        bound = output_bounds(loads(text.format(defuzzifier="defuzzifier centroid")))["u"]
        assert (bound.lo, bound.hi) == (2.0, 7.0)
        bound = output_bounds(loads(text.format(defuzzifier="defuzzifier centroid(resolution=10)")))["u"]
        assert (bound.lo, bound.hi) == (2.5, 6.5)

    def test_nan_is_no_bound(self):
        text = TestAverages.TEXT.format(foot=0.4, start=0.6, otherwise="else nan")
        assert not math.isnan(output_bounds(loads(text))["u"].lo)


class TestBeyondTheRange:
    """Hints where the proved bounds of a function or a sum exceed the declared range."""

    TEXT = """system s
defuzzifier {defuzzifier}
input x in [-1, 1]{where}
  terms N P
output u in [-2, 2]{clauses}
  {terms}
if x is N then u is {first}
if x is P then u is {second}
"""

    def hints(self, first, second, *, defuzzifier="weighted_average", where="", clauses="", terms=""):
        text = self.TEXT.format(
            defuzzifier=defuzzifier, where=where, clauses=clauses, terms=terms, first=first, second=second
        )
        return [d for d in check_text(text, "s.fz")[1] if d.code == "FZ408"]

    @pytest.mark.parametrize(
        ("first", "second", "bounds"),
        [
            ("linear(3, 0)", "linear(1, 0)", "[-3, 3]"),
            ("function(4 * x - 1)", "constant(2)", "[-5, 3]"),
            ("linear(2, 0)", "function(x * x)", None),
            ("constant(-2)", "linear(1, 1)", None),
        ],
    )
    def test_functions(self, first, second, bounds):
        found = self.hints(first, second)
        assert [d.severity for d in found] == (["hint"] if bounds else [])
        if bounds:
            assert found[0].message == f"output 'u' is proved to lie within {bounds}, and may leave its range [-2, 2]"

    def test_sums(self):
        (found,) = self.hints("constant(2)", "constant(2)", defuzzifier="weighted_sum")
        assert "[0, 4]" in found.message
        assert self.hints("constant(1)", "constant(1)", defuzzifier="weighted_sum") == []

    def test_what_is_held_within_the_range_cannot_leave_it(self):
        assert self.hints("linear(3, 0)", "linear(3, 0)", clauses=" clamp") == []
        assert self.hints("A", "B", clauses=" adaptive rate x", terms="terms A=0 B=0") == []

    def test_a_number_outside_has_a_warning_of_its_own(self):
        assert self.hints("A", "B", terms="terms A=-5 B=5") == []

    def test_where_nothing_is_proved_nothing_is_said(self):
        assert self.hints("linear(3, 0)", "linear(1, 0)", where=" extrapolate") == []
