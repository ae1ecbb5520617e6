import json
import math

import pytest

from fuzzyctl import load, loads
from fuzzyctl.diagnostics.diagnostic import ArgumentError, NoRuleFiresError, UnknownNameError
from fuzzyctl.explain.trace import trace
from fuzzyctl.support.shipped import rules_folder
from tests.commands import runner

RULES = rules_folder()

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

run = runner("why")


class TestTrace:
    def test_contributions_of_an_average_add_up(self):
        system = load(RULES / "ais_reaction.fz")
        found = trace(system, {"sigma": 0.01, "dsigma": 0.3})
        output = found.outputs["f"]
        assert output == pytest.approx(system(sigma=0.01, dsigma=0.3), abs=1e-15)
        parts = [c for r in found.rules for c in r.contributions]
        assert sum(c.share for c in parts) == pytest.approx(1.0)
        assert sum(c.share * c.value for c in parts) == pytest.approx(output)
        assert sum(c.influence for c in parts) == pytest.approx(0.0, abs=1e-15)
        assert [r.activation for r in found.rules] == sorted((r.activation for r in found.rules), reverse=True)
        assert len(found.rules) + found.silent == 25

    def test_takes_apart_several_outputs_each_with_its_method(self):
        found = trace(loads(MIXED), {"x": 4.0, "y": 0.5})
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

    def test_values_beyond_the_range_count_as_they_do_in_the_system(self):
        found = trace(loads(MIXED), {"x": 99.0, "y": 5.0})
        assert found.outputs["u"] == pytest.approx(0.5 * 10 + 2 + 1)
        assert found.rules[0].contributions[0].value == pytest.approx(8.0)
        assert math.isnan(found.outputs["w"])

    def test_slopes_differ_at_an_edge(self):
        system = load(RULES / "ais_reaction.fz")
        left, right = trace(system, {"sigma": 0.015, "dsigma": 0.0}).slopes["f"]["sigma"]
        assert left == pytest.approx(-0.09 / 0.015 * 0 + (0.0 - 0.18) / 0.015, rel=1e-6)
        assert right == pytest.approx((-0.66 - 0.0) / 0.015, rel=1e-6)

    def test_refuses_what_an_evaluation_refuses(self):
        system = load(RULES / "tipper.fz")
        with pytest.raises(UnknownNameError, match="did you mean 'food'"):
            trace(system, {"service": 1, "foot": 2})
        with pytest.raises(ArgumentError, match="missing for: food"):
            trace(system, {"service": 1})
        with pytest.raises(ArgumentError, match="real number"):
            trace(system, {"service": 1, "food": "good"})
        with pytest.raises(NoRuleFiresError):
            trace(loads(MIXED.replace("else nan", "else error")), {"x": 0.0, "y": 0.0})


class TestWhy:
    def test_prints_rules_by_their_activation(self):
        result = run(str(RULES / "tipper.fz"), "service=7", "food=8")
        assert result.exit_code == 0
        lines = result.output.splitlines()
        assert lines[0] == "tip = 20.344474774540355 %"
        assert "Rules that act: 3; silent: 0" in lines
        rules = [line for line in lines if line.startswith("  ") and " if " in line]
        assert [line.split()[0] for line in rules] == ["0.5", "0.4111", "1.866e-05"]
        assert rules[0].endswith("if service is excellent or food is delicious then tip is generous")

    def test_shows_as_many_rules_as_asked_for(self):
        result = run(str(RULES / "tipper.fz"), "service=7", "food=8", "--rules", "1")
        assert "and 2 more; --rules shows more of them" in result.output

    def test_gives_data_to_programs(self, tmp_path):
        (tmp_path / "m.fz").write_text(MIXED, encoding="utf-8")
        data = json.loads(run(str(tmp_path / "m.fz"), "x=99", "y=1", "--format", "json").stdout)
        assert data["outputs"]["w"] is None
        assert data["rules"][0]["contributions"][0]["output"] == "u"
        assert data["diagnostics"][0]["code"] == "FZ504"

    @pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
    def test_draws_systems_of_every_kind(self, tmp_path, suffix):
        (tmp_path / "m.fz").write_text(MIXED, encoding="utf-8")
        picture = tmp_path / f"why.{suffix}"
        result = run(str(tmp_path / "m.fz"), "x=4", "y=0.5", "-o", str(picture))
        assert result.exit_code == 0, result.output
        assert picture.stat().st_size > 1000

    def test_a_missing_input_is_named_with_its_range(self):
        result = run(str(RULES / "tipper.fz"), "service=7")
        assert result.exit_code == 2
        assert "input 'food' has no value" in result.output
        assert "write: fuzzyctl why FILE service=VALUE food=VALUE" in result.output

    def test_a_picture_of_no_known_kind_is_refused(self, tmp_path):
        result = run(str(RULES / "tipper.fz"), "service=7", "food=8", "-o", str(tmp_path / "why.bmp"))
        assert result.exit_code == 1
        assert "no picture format" in result.output


def test_the_picture_cuts_terms_at_their_degrees(tmp_path):
    from matplotlib.figure import Figure

    from fuzzyctl.plot.rule_viewer import draw_rules

    figure = Figure()
    system = loads(MIXED)
    draw_rules(figure, system, trace(system, {"x": 4.0, "y": 0.5}), 12)
    rows = len(figure.axes) // 5
    assert rows == 5
    first = figure.axes[0]  # rule 2, x is high: the highest activation
    assert max(first.lines[0].get_ydata()) == pytest.approx(1.0)
    assert first.collections[0].get_paths()[0].vertices[:, 1].max() == pytest.approx(0.4)
    assert first.lines[1].get_xdata()[0] == 4.0


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


class TestPictureOfHedges:
    """What is drawn is what is computed with: sets as hedges leave them, or activations where hedges change those."""

    def drawn(self, text, x, most=12):
        from matplotlib.figure import Figure

        from fuzzyctl.plot.rule_viewer import draw_rules

        figure, system = Figure(), loads(text)
        draw_rules(figure, system, trace(system, {"x": x}), most)
        return figure.axes

    def top(self, ax, left, right):
        """The largest filled degree between two places."""
        vertices = ax.collections[-1].get_paths()[0].vertices
        return max(y for x, y in vertices if left <= x <= right)

    def test_a_hedged_consequent_is_the_hedged_set_cut_at_the_activation(self):
        axes = self.drawn(HEDGED, 6.0)  # rule 2 acts with 0.6, rule 1 with 0.4 squared
        of_p, of_n, together = axes[1], axes[3], axes[5]
        assert [t.get_text() for ax in (of_p, of_n) for t in ax.texts] == ["somewhat p", "not n"]
        curve = dict(zip(of_p.lines[0].get_xdata(), of_p.lines[0].get_ydata(), strict=True))
        assert curve[0.55] == pytest.approx(0.5**0.5)
        assert dict(zip(*of_n.lines[0].get_data(), strict=True))[0.2] == pytest.approx(0.0)
        assert self.top(of_p, 0, 1) == pytest.approx(0.6)
        assert self.top(of_n, 0, 0.2) == self.top(of_n, 0.4, 1) == pytest.approx(0.16)
        assert self.top(together, 0.69, 0.71) == pytest.approx(0.6)
        assert self.top(together, 0.2, 0.2) == pytest.approx(0.0)

    def test_a_hedge_of_the_activation_changes_the_cut_and_not_the_set(self):
        axes = self.drawn(HEDGED.replace("input x", "semantics fuzzylite\ninput x"), 6.0)
        of_p, of_n = axes[1], axes[3]
        assert dict(zip(*of_n.lines[0].get_data(), strict=True))[0.2] == pytest.approx(1.0)
        assert self.top(of_n, 0, 1) == pytest.approx(1 - 0.16, abs=0.005)  # on 401 points
        assert self.top(of_p, 0, 1) == pytest.approx(0.6**0.5, abs=0.005)

    def test_hedges_of_antecedents_are_drawn_too(self):
        of_low = self.drawn(HEDGED, 6.0)[2]
        assert [t.get_text() for t in of_low.texts] == ["very low"]
        assert dict(zip(*of_low.lines[0].get_data(), strict=True))[5.0] == pytest.approx(0.25)
        assert self.top(of_low, 0, 10) == pytest.approx(0.16)

    def test_sets_are_implied_and_joined_by_the_norms_of_the_output(self):
        text = HEDGED.replace("u in [0, 1]", "u in [0, 1] implication product aggregation sum").replace("not n", "p")
        together = self.drawn(text.replace("somewhat p", "p"), 6.0)[5]
        assert self.top(together, 0, 1) == pytest.approx(0.6 + 0.16)
        assert self.top(together, 0.55, 0.55) == pytest.approx(0.5 * 0.76)

    def test_each_rule_block_implies_in_its_own_way(self):
        text = HEDGED.replace("if x is high", "rules scaled\n  implication product\n  if x is high")
        of_p = self.drawn(text.replace("somewhat p", "p"), 6.0)[1]
        assert self.top(of_p, 0.55, 0.55) == pytest.approx(0.5 * 0.6)

    def test_names_of_a_variable_that_is_read_twice_stand_below_each_other(self):
        both = self.drawn(HEDGED.replace("if x is very low", "if not x is high or x is very low"), 6.0)[2]
        assert [t.get_text() for t in both.texts] == ["high", "very low"]
        assert both.texts[0].xy[1] - both.texts[1].xy[1] > 0.2

    def test_rules_that_are_not_shown_count_in_what_all_give_together(self):
        axes = self.drawn(HEDGED, 6.0, most=1)
        assert len(axes) == 4
        assert self.top(axes[3], 0, 0.1) == pytest.approx(0.16)

    def test_degrees_that_rules_pass_on_are_not_read_from_a_value(self):
        text = HEDGED.replace("input x", "semantics fuzzylite\ninput x") + "if u is p then u is n\n"
        axes = self.drawn(text, 6.0)
        by_degree = next(ax for ax in axes if [t.get_text() for t in ax.texts] == ["p", "n"])
        assert len(by_degree.collections) == 1


def test_data_say_how_far_an_output_feels_a_rule():
    found = trace(loads(HEDGED.replace("input x", "semantics fuzzylite\ninput x")), {"x": 6.0})
    parts = {c.term: (r.activation, c.effective_activation) for r in found.rules for c in r.contributions}
    assert parts["not n"] == (pytest.approx(0.16), pytest.approx(0.84))
    assert parts["somewhat p"] == (pytest.approx(0.6), pytest.approx(0.6**0.5))


class TestPictureOfValues:
    SUMS = (
        "system s\ndefuzzifier weighted_sum\ninput x in [0, 1]\n  terms a b\n"
        "output y in [0, 10]\n  p = linear(0, {})\nif x is a then y is p\n"
    )

    def last(self, text, x):
        from matplotlib.figure import Figure

        from fuzzyctl.plot.rule_viewer import draw_rules

        figure, system = Figure(), loads(text)
        draw_rules(figure, system, trace(system, {"x": x}), 12)
        return figure.axes[-1], figure.axes[1]

    @pytest.mark.parametrize(("value", "side"), [(1, "right"), (9, "left")])
    def test_the_number_stands_where_its_line_is_not(self, value, side):
        ax, _ = self.last(self.SUMS.format(value), 0.0)
        assert [t.get_ha() for t in ax.texts] == [side]
        assert ax.get_xlim() == (0.0, 10.0)

    @pytest.mark.parametrize("value", [-6, 25])
    def test_values_beyond_the_range_are_on_the_axis(self, value):
        for ax in self.last(self.SUMS.format(value), 0.0):
            low, high = ax.get_xlim()
            assert low < value < high
            assert low <= 0.0
            assert high >= 10.0


class TestPictureOfPlaces:
    """Tsukamoto's method takes places of consequents: no set is cut, and there is no union."""

    TEXT = (
        "system t\n{}defuzzifier tsukamoto\ninput x in [0, 10]\n  low = ramp(10, 0)\n  high = ramp(0, 10)\n"
        "output z in [0, 100]\n  cheap = ramp(80, 10)\n  dear = ramp(50, 100)\n"
        "if x is low then z is cheap\nif x is high then z is {}\n"
    )

    def drawn(self, text, x):
        from matplotlib.figure import Figure

        from fuzzyctl.plot.rule_viewer import draw_rules

        figure, system = Figure(), loads(text)
        draw_rules(figure, system, trace(system, {"x": x}), 12)
        return figure.axes

    def spikes(self, ax):
        """Places and how high they are; anything filled would be no line of two points."""
        ends = [segment for c in ax.collections for segment in c.get_segments()]
        return sorted((x, top) for (x, _), (_, top) in ends)

    def test_each_rule_has_its_place_and_all_stand_together(self):
        axes = self.drawn(self.TEXT.format("", "dear"), 3.0)
        places = [(pytest.approx(31.0), pytest.approx(0.7)), (pytest.approx(65.0), pytest.approx(0.3))]
        assert self.spikes(axes[1]) == places[:1]
        assert self.spikes(axes[3]) == places[1:]
        assert self.spikes(axes[5]) == places
        assert dict(zip(*axes[1].lines[0].get_data(), strict=True))[10.0] == 1.0

    def test_rules_of_one_term_leave_one_place_where_the_sum_runs_over_terms(self):
        (spike,) = self.spikes(self.drawn(self.TEXT.format("semantics exact(merge=terms)\n", "cheap"), 3.0)[5])
        assert spike == (pytest.approx(31.0), pytest.approx(0.7))

    def test_a_name_stands_at_the_end_where_it_hides_less(self):
        low, cheap, high, dear = self.drawn(self.TEXT.format("", "dear"), 3.0)[:4]
        assert [t.get_ha() for ax in (low, cheap, high, dear) for t in ax.texts] == ["right", "right", "left", "left"]

    def test_a_line_hides_less_behind_a_name_than_a_curve(self):
        assert [t.get_ha() for t in self.drawn(self.TEXT.format("", "dear"), 9.0)[2].texts] == ["right"]

    def test_a_name_leaves_room_for_a_place_at_the_left(self):
        numbers = self.TEXT.replace("ramp(80, 10)", "constant(5)").replace("ramp(50, 100)", "constant(90)")
        text = numbers.replace("tsukamoto", "weighted_average").format("", "dear")
        sides = [[t.get_ha() for t in self.drawn(text, x)[1].texts] for x in (0.2, 9.0)]
        assert sides == [["right"], ["left"]]


class TestPictureOfInputsBeyond:
    TEXT = (
        "system t\ninput x in [0, 10]{}\n  low = ramp(12, 0)\noutput z in [0, 100] else nan\n  cheap = ramp(80, 10)\n"
        "  dear = ramp(50, 100)\nif x is low then z is cheap\nif x is very low then z is dear\n"
    )

    def drawn(self, said, x):
        from matplotlib.figure import Figure

        from fuzzyctl.plot.rule_viewer import draw_rules

        figure, system = Figure(), loads(self.TEXT.format(said))
        draw_rules(figure, system, trace(system, {"x": x}), 12)
        return figure.axes

    @pytest.mark.parametrize(("said", "reaches"), [("", 10.0), (" extrapolate", 11.0)])
    def test_the_line_is_on_the_axis_and_the_term_as_far_as_it_is_read(self, said, reaches):
        (term, line), (low, high) = self.drawn(said, 11.0)[0].lines, self.drawn(said, 11.0)[0].get_xlim()
        assert set(line.get_xdata()) == {11.0}
        assert low == 0.0 < 11.0 < high
        assert term.get_xdata().max() >= reaches
        assert (term.get_xdata().max() == 10.0) == (said == "")

    def test_an_output_without_a_value_says_so(self):
        (*_, last) = self.drawn(" extrapolate", 13.0)
        assert [t.get_text() for t in last.texts] == ["no value"]


def test_the_values_of_lets_are_shown(tmp_path):
    path = tmp_path / "let.fz"
    path.write_text(
        "system s\nand product\ndefuzzifier center_average\ninput x in [-1, 1]\ninput y in [-1, 1]\n"
        'let z in [-2, 2] unit "m" = x - y\n  terms N P\n'
        "output u in [-1, 1]\n  terms N P\ntable u = z\n   N P\n | N P\n",
        encoding="utf-8",
    )
    result = run(path, "x=0.5", "y=0.25")
    assert "\nLets\n  z = 0.25 m\n" in result.output
    assert json.loads(run(path, "x=0.5", "y=0.25", "--format", "json").output)["lets"] == {"z": 0.25}
