"""The rule viewer draws what is computed: sets as hedges leave them, cut at the activations of rules."""

import pytest

import fuzzyctl

HEDGED = """
system hedged
input x in [0, 10]
  low  = triangle(-inf, 0, 10)
  high = triangle(0, 10, inf)
output u in [0, 1]
  n = triangle(0, 0.2, 0.4)
  p = triangle(0.4, 0.7, 1)
if x is very low then u is not n
if x is high then u is somewhat p
"""


def drawn(text, x, most=12):
    """Return the axes of the viewer at a point: for each rule its antecedents and consequents, then all together."""
    return fuzzyctl.plot.rules(fuzzyctl.loads(text), x=x, most=most).figure.axes


def curve(line):
    return dict(zip(*line.get_data(), strict=True))


def sides(ax):
    return [text.get_ha() for text in ax.texts]


def names(ax):
    return [text.get_text() for text in ax.texts]


def top(ax, left, right):
    """Return the largest filled degree between two places."""
    vertices = ax.collections[-1].get_paths()[0].vertices
    return max(y for x, y in vertices if left <= x <= right)


class TestHedges:
    def test_a_hedged_consequent_is_the_hedged_set_cut_at_the_activation(self):
        axes = drawn(HEDGED, 6.0)  # rule 2 acts with 0.6, rule 1 with 0.4 squared
        of_high, of_p, of_low, of_n, _, together = axes
        assert [*names(of_p), *names(of_n), *names(of_low)] == ["somewhat p", "not n", "very low"]
        assert (of_high.lines[1].get_xdata()[0], top(of_high, 0, 10)) == (6.0, pytest.approx(0.6))
        assert curve(of_p.lines[0])[0.55] == pytest.approx(0.5**0.5)
        assert curve(of_n.lines[0])[0.2] == pytest.approx(0.0)
        assert curve(of_low.lines[0])[5.0] == pytest.approx(0.25)
        assert top(of_low, 0, 10) == pytest.approx(0.16)
        assert top(of_p, 0, 1) == pytest.approx(0.6)
        assert top(of_n, 0, 0.2) == top(of_n, 0.4, 1) == pytest.approx(0.16)
        assert top(together, 0.69, 0.71) == pytest.approx(0.6)
        assert top(together, 0.2, 0.2) == pytest.approx(0.0)

    def test_a_hedge_of_the_activation_changes_the_cut_and_not_the_set(self):
        _, of_p, _, of_n, *_ = drawn(HEDGED.replace("input x", "semantics fuzzylite\ninput x"), 6.0)
        assert curve(of_n.lines[0])[0.2] == pytest.approx(1.0)
        assert top(of_n, 0, 1) == pytest.approx(1 - 0.16, abs=0.005)  # on 401 points
        assert top(of_p, 0, 1) == pytest.approx(0.6**0.5, abs=0.005)

    def test_sets_are_implied_and_joined_by_the_norms_of_the_output_or_of_the_rule_block(self):
        text = HEDGED.replace("u in [0, 1]", "u in [0, 1] implication product aggregation sum").replace("not n", "p")
        together = drawn(text.replace("somewhat p", "p"), 6.0)[5]
        assert top(together, 0, 1) == pytest.approx(0.6 + 0.16)
        assert top(together, 0.55, 0.55) == pytest.approx(0.5 * 0.76)
        text = HEDGED.replace("if x is high", "rules scaled\n  implication product\n  if x is high")
        assert top(drawn(text.replace("somewhat p", "p"), 6.0)[1], 0.55, 0.55) == pytest.approx(0.5 * 0.6)

    def test_names_of_a_variable_that_is_read_twice_are_below_each_other(self):
        both = drawn(HEDGED.replace("if x is very low", "if not x is high or x is very low"), 6.0)[2]
        assert names(both) == ["high", "very low"]
        assert both.texts[0].xy[1] - both.texts[1].xy[1] > 0.2

    def test_rules_that_are_not_shown_count_in_what_all_give_together(self):
        axes = drawn(HEDGED, 6.0, most=1)
        assert len(axes) == 4
        assert top(axes[3], 0, 0.1) == pytest.approx(0.16)

    def test_degrees_that_rules_pass_on_are_not_read_from_a_value(self):
        text = HEDGED.replace("input x", "semantics fuzzylite\ninput x") + "if u is p then u is n\n"
        by_degree = next(ax for ax in drawn(text, 6.0) if names(ax) == ["p", "n"])
        assert len(by_degree.collections) == 1


class TestValues:
    SUMS = (
        "system s\ndefuzzifier weighted_sum\ninput x in [0, 1]\n  terms a b\n"
        "output y in [0, 10]\n  p = linear(0, {})\nif x is a then y is p\n"
    )

    @pytest.mark.parametrize(("value", "side"), [(1, "right"), (9, "left"), (-6, "left"), (25, "right")])
    def test_the_number_is_where_its_line_is_not_and_on_the_axis(self, value, side):
        axes = drawn(self.SUMS.format(value), 0.0)
        if 0 <= value <= 10:
            assert sides(axes[-1]) == [side]
            assert axes[-1].get_xlim() == (0.0, 10.0)
            return
        for low, high in (axes[k].get_xlim() for k in (1, -1)):
            assert low < value < high
            assert low <= 0.0 < 10.0 <= high


class TestPlaces:
    """Tsukamoto's method takes places of consequents: no set is cut, and there is no union."""

    TEXT = (
        "system t\n{}defuzzifier tsukamoto\ninput x in [0, 10]\n  low = ramp(10, 0)\n  high = ramp(0, 10)\n"
        "output z in [0, 100]\n  cheap = ramp(80, 10)\n  dear = ramp(50, 100)\n"
        "if x is low then z is cheap\nif x is high then z is {}\n"
    )

    def spikes(self, ax):
        """Places and how high they are; anything filled would be no line of two points."""
        ends = [segment for c in ax.collections for segment in c.get_segments()]
        return sorted((x, height) for (x, _), (_, height) in ends)

    def test_each_rule_has_its_place_and_all_are_shown_together(self):
        axes = drawn(self.TEXT.format("", "dear"), 3.0)
        places = [(pytest.approx(31.0), pytest.approx(0.7)), (pytest.approx(65.0), pytest.approx(0.3))]
        assert [self.spikes(axes[k]) for k in (1, 3, 5)] == [places[:1], places[1:], places]
        assert curve(axes[1].lines[0])[10.0] == 1.0

    def test_rules_of_one_term_leave_one_place_if_the_sum_runs_over_terms(self):
        (spike,) = self.spikes(drawn(self.TEXT.format("semantics exact(merge=terms)\n", "cheap"), 3.0)[5])
        assert spike == (pytest.approx(31.0), pytest.approx(0.7))

    def test_a_name_is_at_the_end_where_it_hides_less(self):
        axes = drawn(self.TEXT.format("", "dear"), 3.0)[:4]
        assert [sides(ax) for ax in axes] == [["right"], ["right"], ["left"], ["left"]]
        assert sides(drawn(self.TEXT.format("", "dear"), 9.0)[2]) == ["right"]
        numbers = self.TEXT.replace("ramp(80, 10)", "constant(5)").replace("ramp(50, 100)", "constant(90)")
        text = numbers.replace("tsukamoto", "weighted_average").format("", "dear")
        assert [sides(drawn(text, x)[1]) for x in (0.2, 9.0)] == [["right"], ["left"]]


class TestInputsBeyond:
    TEXT = (
        "system t\ninput x in [0, 10]{}\n  low = ramp(12, 0)\noutput z in [0, 100] else nan\n  cheap = ramp(80, 10)\n"
        "  dear = ramp(50, 100)\nif x is low then z is cheap\nif x is very low then z is dear\n"
    )

    @pytest.mark.parametrize(("clause", "reaches"), [("", 10.0), (" extrapolate", 11.0)])
    def test_the_line_is_on_the_axis_and_the_term_as_far_as_it_is_read(self, clause, reaches):
        ax = drawn(self.TEXT.format(clause), 11.0)[0]
        (term, line), (low, high) = ax.lines, ax.get_xlim()
        assert set(line.get_xdata()) == {11.0}
        assert low == 0.0 < 11.0 < high
        assert term.get_xdata().max() >= reaches
        assert (term.get_xdata().max() == 10.0) == (clause == "")

    def test_an_output_without_a_value_says_so(self):
        assert names(drawn(self.TEXT.format(" extrapolate"), 13.0)[-1]) == ["no value"]


def test_a_trace_draws_itself():
    trace = fuzzyctl.why(fuzzyctl.loads(HEDGED), x=4)
    assert len(trace.plot()[0].figure.axes) == len(drawn(HEDGED, 4))
