import math
import re
from itertools import product

import pytest

from fuzzyctl import NoRuleFiresError, check, compile, loads
from fuzzyctl.analysis.coverage import box_search
from fuzzyctl.analysis.coverage.box_search import Hole, Undecided
from fuzzyctl.analysis.coverage.coverage import uncovered


def diagnostics(system):
    return [d for d in check(system)[1] if d.code in ("FZ401", "FZ407")]


TWO = """
system two
and {conjunction}
defuzzifier weighted_average
input x in [0, 10]
  low = triangle(-inf, 2, {end})
  high = triangle({start}, 8, inf)
input y in [-1, 1]
  low = triangle(-inf, -0.5, 0.5)
  high = triangle(-0.5, 0.5, inf)
output u in [0, 1] {otherwise}
  a = singleton(0)
  b = singleton(1)
if x is low and y is low then u is a
if x is low and y is high then u is b
if x is high and y is low then u is b
if x is high and y is high then u is {last}
"""


def two(start=2, end=8, conjunction="product", otherwise="", last="a", low="low"):
    text = TWO.format(start=start, end=end, conjunction=conjunction, otherwise=otherwise, last=last)
    return loads(text.replace("if x is low", f"if x is {low}"))


class TestComparisons:
    """Formulas of 1 and 0 cut an input where they compare it, so that the whole range is covered, or a point is not."""

    TEXT = (
        "system s\ndefuzzifier weighted_average\ninput x in [-1, 1]\n  low = function({low})\n"
        "  high = function({high})\noutput u in [0, 1]\n  terms a=0 b=1\n"
        "if x is low then u is a\nif x is high then u is b\n"
    )

    @pytest.mark.parametrize("low", ["le(x, 0.25)", "1 - gt(x, 1 / 4)", "max(lt(x, 0.25), eq(x, 0.25))"])
    def test_those_that_leave_nothing_out_cover(self, low):
        assert uncovered(loads(self.TEXT.format(low=low, high="gt(x, 0.25)"))) == {"u": None}

    @pytest.mark.parametrize(("low", "place"), [("lt(x, 0.25)", 0.25), ("le(-x, -0.3)", 0.0), ("lt(x, -0.5)", 0.0)])
    def test_a_point_that_none_holds_at_is_found(self, low, place):
        text = self.TEXT.format(low=low, high="gt(x, 0.25)")
        with pytest.raises(NoRuleFiresError):
            loads(text)(x=place)
        (found,) = diagnostics(loads(text))
        assert found.code == "FZ401"


class TestUncovered:
    def test_shipped_rule_files_are_covered(self, shipped):
        for system in shipped.values():
            assert set(uncovered(system).values()) == {None}

    def test_table_8_as_printed_has_a_hole_at_zero(self, rules):
        text = (rules / "boundary_layer.fz").read_text(encoding="utf-8")
        printed = text.replace("VS = triangle(-inf, 0.0050, 0.0162)", "VS = triangle(1e-6, 0.0050, 0.0162)")
        assert printed != text
        hole = uncovered(loads(printed))["beta"]
        assert isinstance(hole, Hole)
        assert str(hole) == "abs_sigma in [0, 1e-06]"
        assert 0 <= hole.witness["abs_sigma"] <= 1e-6

    def test_a_gap_between_two_terms_is_closed_at_their_feet(self):
        hole = uncovered(two(start=7, end=4))["u"]
        assert str(hole) == "x in [4, 7], y in [-1, 1]"

    def test_terms_that_touch_leave_a_hole_of_one_point(self):
        hole = uncovered(two(start=5, end=5))["u"]
        assert hole.region["x"].lower == hole.region["x"].upper == 5
        assert hole.witness["x"] == 5

    def test_terms_that_overlap_by_one_ulp_leave_none(self):
        assert uncovered(two(start=math.nextafter(5, 0), end=math.nextafter(5, 9)))["u"] is None

    def test_an_empty_corner_of_a_table_is_open_where_others_begin(self):
        text = TWO.replace("if x is high and y is high then u is {last}\n", "").format(
            start=2, end=8, conjunction="product", otherwise=""
        )
        hole = uncovered(loads(text))["u"]
        assert str(hole) == "x in [8, 10], y in [0.5, 1]"

    def test_an_extrapolated_input_is_covered_to_infinity_or_not(self):
        system = two()
        free = tuple(i.model_copy(update={"extrapolate": True}) for i in system.inputs)
        assert uncovered(system.model_copy(update={"inputs": free}))["u"] is None
        text = TWO.replace("8, inf", "8, 12").format(start=2, end=8, conjunction="min", otherwise="", last="a")
        system = loads(text)
        free = tuple(i.model_copy(update={"extrapolate": True}) for i in system.inputs)
        assert uncovered(system)["u"] is None
        hole = uncovered(system.model_copy(update={"inputs": free}))["u"]
        assert str(hole).startswith("x in [12, inf)")
        assert 12 <= hole.witness["x"] < math.inf

    def test_gaussians_cover_until_they_vanish(self):
        text = """
system bump
defuzzifier weighted_average
input x in [0, 1]
  mid = gaussian(0.5, {sigma})
output u in [0, 1]
  a = singleton(1)
if x is mid then u is a
"""
        assert uncovered(loads(text.format(sigma=0.1)))["u"] is None
        hole = uncovered(loads(text.format(sigma=0.005)))["u"]
        assert isinstance(hole, Hole)
        assert abs(hole.witness["x"] - 0.5) > 0.15

    def test_too_many_cells_leave_it_undecided(self, monkeypatch):
        monkeypatch.setattr(box_search, "BUDGET", 10)
        verdict = uncovered(two(low="not high"))["u"]
        assert isinstance(verdict, Undecided)
        assert verdict.spent

    @pytest.mark.parametrize("where", ["activation threshold(>= 0.2)\n", ""])
    def test_a_hedge_makes_nothing_of_a_rule_below_the_threshold(self, where):
        """`not` of an activation of 0 is 1, but only for rules that act."""
        head = "system s\nsemantics exact(least=none, consequent_hedges=activation)\ndefuzzifier weighted_average\n"
        variables = (
            "input x in [0, 10]\n  lo = triangle(-inf, 0, 4)\noutput y in [0, 1] else nan\n  one = constant(1)\n"
        )
        block = "" if where else "rules b activation threshold(>= 0.2)\n"
        system = loads(f"{head}{where}{variables}{block}if x is lo then y is not one\n")
        assert math.isnan(compile(system, "python")(9.0))
        assert uncovered(system)["y"] is not None

    def test_a_strength_close_to_zero_leaves_it_undecided(self):
        text = """
system s
defuzzifier weighted_average
input x in [0, 1]
  zero = singleton(0)
  rest = triangle(0, 1, inf)
output u in [0, 1]
  a = singleton(1)
if x is zero then u is a
if x is rest then u is a
"""
        assert isinstance(uncovered(loads(text))["u"], Undecided)


class TestLargeTables:
    @pytest.mark.parametrize("conjunction", ["min", "product"])
    def test_complete_ones_are_decided_input_by_input(self, conjunction, monkeypatch):
        monkeypatch.setattr(box_search, "BUDGET", 0)
        assert uncovered(table(40, conjunction))["u"] is None

    @pytest.mark.parametrize(
        ("count", "words", "hedge"),
        [
            (10, "and product", ""),
            (7, "and min", "very "),
            (7, "and product", "very "),
            (7, "and hamacher_product", "very "),
            (7, "semantics fuzzylite", ""),
        ],
    )
    def test_complete_ones_are_however_many_inputs_there_are(self, count, words, hedge, monkeypatch):
        """Each cell has points where a term is next to 0, but none where both are; no product of these underflows."""
        monkeypatch.setattr(box_search, "BUDGET", 0)
        assert uncovered(grid(count, words, hedge))["u"] is None

    def test_complete_ones_are_not_where_products_underflow(self, monkeypatch):
        monkeypatch.setattr(box_search, "BUDGET", 0)
        text = grid_text(7, "and product", "").replace("terms a b", "a = gaussian(0, {s})\n  b = gaussian(1, {s})")
        assert uncovered(loads(text.replace("{s}", "0.1")))["u"] is None  # degrees of 4e-6 where both meet
        assert uncovered(loads(text.replace("{s}", "0.03")))["u"] is not None  # of 5e-61

    @pytest.mark.parametrize("words", ["and bounded_difference", "and drastic_product", "and nilpotent_minimum"])
    def test_complete_ones_are_not_where_norms_of_positive_degrees_are_zero(self, words, monkeypatch):
        monkeypatch.setattr(box_search, "BUDGET", 0)
        assert uncovered(grid(3, words))["u"] is not None

    @pytest.mark.parametrize("norm", ["product", "hamacher_product"])
    def test_rules_of_dozens_of_inputs_are(self, norm, monkeypatch):
        monkeypatch.setattr(box_search, "BUDGET", 0)
        inputs = "".join(f"input x{i} in [0, 1]\n  any = triangle(-inf, 0.5, inf)\n" for i in range(90))
        output = "output u in [0, 1]\n  o = singleton(0)\n"
        rule = f"if {' and '.join(f'x{i} is any' for i in range(90))} then u is o\n"
        system = loads(f"system s\nand {norm}\ndefuzzifier weighted_average\n{inputs}{output}{rule}")
        assert uncovered(system)["u"] is None


def grid_text(count, words, hedge):
    """A rule for each combination of two terms that make a partition, of a number of inputs."""
    inputs = "".join(f"input x{i} in [0, 1]\n  terms a b\n" for i in range(count))
    rules = (
        f"if {' and '.join(f'x{i} is {hedge}{name}' for i, name in enumerate(names))} then u is o\n"
        for names in product("ab", repeat=count)
    )
    output = "output u in [0, 1]\n  o = singleton(1)\n"
    return f"system s\n{words}\ndefuzzifier weighted_average\n{inputs}{output}{''.join(rules)}"


def grid(count, words, hedge=""):
    return loads(grid_text(count, words, hedge))


def table(count, conjunction, missing="a"):
    names = " ".join(f"T{i}" for i in range(count))
    rows = "\n".join(
        f"  T{i} | {' '.join(missing if i == j == 1 else 'a' for j in range(count))}" for i in range(count)
    )
    return loads(
        f"system s\nand {conjunction}\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms {names}\n"
        f"input y in [-1, 1]\n  terms {names}\noutput u in [0, 1] else error\n  a = singleton(1)\n"
        f"table u = x x y\n  {names}\n{rows}\n"
    )


class TestDiagnostics:
    def test_a_hole_without_else_is_an_error_at_the_output(self):
        (found,) = diagnostics(two(start=7, end=4))
        assert (found.code, found.severity) == ("FZ401", "error")
        assert found.message == "no rule fires for output 'u' where x in [4, 7], y in [-1, 1]"
        assert found.facts[0] == "for example at x = 5.5, y = 0"
        assert found.span is not None
        assert found.span.line == 11
        assert "else" in found.help

    @pytest.mark.parametrize(
        ("tool", "word", "value"),
        [
            ("MATLAB", "midpoint", 0.5),
            ("fuzzylite", "nan", math.nan),
            ("Octave", "nan", math.nan),
            ("jFuzzyLogic", "hold", math.nan),
            ("simpful", "0", 0.0),
            ("scikit-fuzzy", "error", math.nan),  # no result for one point; of many the others go on
        ],
    )
    def test_what_other_tools_do_in_a_hole_is_what_their_profiles_do(self, tool, word, value):
        (found,) = diagnostics(two(start=7, end=4))
        assert re.search(rf"\b{tool}\b[^']*'else {word}'", found.facts[-1])
        text = TWO.format(start=7, end=4, conjunction="product", otherwise="", last="a")
        semantics = f"semantics {tool.lower().replace('-', '_')}\nor max\nimplication min\naggregation max\n"
        found = loads(text.replace("and product", f"{semantics}and product"))(x=5.5, y=0)
        assert found == pytest.approx(value, nan_ok=True)

    def test_what_is_undecided_asks_for_an_else(self, monkeypatch):
        monkeypatch.setattr(box_search, "BUDGET", 10)
        (found,) = diagnostics(two(low="not high"))
        assert (found.code, found.severity) == ("FZ407", "warning")
        assert found.message == "it cannot be decided whether some rule always fires for output 'u'"
        assert "else VALUE" in found.help


CHAIN = """
system chain
defuzzifier weighted_average
{activation}
input e in [-1, 1]
  terms N Z P
output m in [0, 1]
  lo = triangle(-inf, 0, {foot})
  hi = triangle({start}, 1, inf)
output u in [-5, 5]
  a = constant(1)
  b = constant(2)
table m = e
     N   Z   P
  |  lo  hi  hi
if m is lo then u is a
if m is hi then u is b
"""


class TestChains:
    def test_terms_of_an_output_that_cover_its_range_cover_what_reads_it(self):
        assert diagnostics(loads(CHAIN.format(activation="", foot=0.6, start=0.4))) == []

    def test_a_gap_between_them_is_shown_at_a_point(self):
        (found,) = diagnostics(loads(CHAIN.format(activation="", foot=0.4, start=0.6)))
        assert (found.code, found.severity) == ("FZ401", "error")
        assert found.message == "no rule fires for output 'u' at e = -0.5"
        assert found.facts[-1].endswith("how far around it none does: all that is known of m is the range")

    def test_a_narrow_gap_is_found_by_going_to_where_rules_fire_less(self):
        text = CHAIN.format(activation="", foot=0.371, start=0.3723)
        (found,) = diagnostics(loads(text))
        point = float(found.message.removeprefix("no rule fires for output 'u' at e = "))
        with pytest.raises(NoRuleFiresError):
            compile(loads(text), "python")(point)
        assert len(repr(point)) <= len("-0.629")

    def test_a_gap_that_no_input_reaches_stays_undecided(self):
        text = CHAIN.format(activation="", foot=0.4, start=0.6).replace("lo  hi  hi", "hi  hi  hi")
        text = text.replace("lo = triangle(-inf, 0, 0.4)\n", "").replace("if m is lo then u is a\n", "")
        (found,) = diagnostics(loads(text))
        assert found.message == "it cannot be decided whether some rule always fires for output 'u'"
        assert found.facts[0] == "all that is known of m is the range"


class TestReasons:
    """What keeps a rule that fires from moving the output is said."""

    TEXT = """
system s
{settings}
input e in [-1, 1]
  terms N Z P
output u in [0, 10]
  a = triangle(1, 2, 3)
  b = triangle(3.9, 4, 4.1)
table u = e
     N  Z    P
  |  a  {z}  a
"""

    @pytest.mark.parametrize(
        ("settings", "z", "words"),
        [
            ("defuzzifier centroid(resolution=10)", "b", "its consequent has no area at the 10 samples"),
            ("defuzzifier weighted_average", "b*0", "their weight is 0"),
            (
                "defuzzifier weighted_average\nactivation threshold(> 0.6)",
                "b",
                "'activation threshold' leaves them out",
            ),
        ],
    )
    def test_for_a_rule_that_fires(self, settings, z, words):
        (found,) = [d for d in diagnostics(loads(self.TEXT.format(settings=settings, z=z))) if d.code == "FZ401"]
        assert found.message.startswith("no rule moves output 'u' where e")
        assert words in " ".join(found.facts)

    def test_none_where_none_fires(self):
        text = self.TEXT.format(settings="defuzzifier weighted_average", z=".")
        (found,) = [d for d in diagnostics(loads(text)) if d.code == "FZ401"]
        assert found.message.startswith("no rule fires for output 'u' where e = 0")


class TestEmptyCells:
    TEXT = """\
system s
defuzzifier weighted_average
input e in [-1, 1]
  terms N Z P
input d in [0, 1]
  terms A B
output u in [-5, 5]
  terms a=0 b=1
table u = d x e
       N  Z  P
  A |  a  a  b
  B |  a  .  .
"""

    def test_are_named_where_no_rule_fires(self):
        (found,) = diagnostics(loads(self.TEXT))
        assert [(n.span.line, n.message) for n in found.notes] == [
            (12, "the cell of row 'B', column 'Z' is empty"),
            (12, "the cell of row 'B', column 'P' is empty"),
        ][: len(found.notes)]
        assert found.notes
        assert found.help.startswith("fill the empty cell")

    def test_so_is_that_of_a_one_way_table(self):
        text = self.TEXT.replace("d x e", "e").replace("  A |  a  a  b\n  B |  a  .  .\n", "    |  a  .  b\n")
        (found,) = diagnostics(loads(text))
        assert [n.message for n in found.notes] == ["the cell of column 'Z' is empty"]

    def test_a_gap_between_terms_names_none(self):
        text = self.TEXT.replace(
            "  terms N Z P", "  N = triangle(-inf, -1, 0)\n  Z = triangle(0.2, 0.4, 1)\n  P = ramp(0.4, 1)"
        )
        (found,) = diagnostics(loads(text.replace(".  .", "a  a")))
        assert found.notes == ()
        assert "let a term of the inputs reach there" in found.help


@pytest.mark.parametrize("implication", ["einstein_product", "hamacher_product"])
def test_a_hedge_whose_enclosure_exceeds_1_is_a_degree_all_the_same(implication):
    """Above 1 the Einstein product divides by zero."""
    one = loads(
        f"system s\ndefuzzifier bisector\nimplication {implication}\naggregation max\n"
        "hedge h(x) = 4 * x * (1 - x)^0.5\ninput x in [0, 1]\n  r = ramp(0, 1)\n"
        "output y in [-3, 5] else 0\n  t = spike(3.3615, 4.24889)\nif x is r then y is extremely h t\n"
    )
    assert isinstance(uncovered(one)["y"], Hole)
