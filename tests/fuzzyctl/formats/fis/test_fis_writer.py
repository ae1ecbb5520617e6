"""What is written as `.fis` computes the same numbers when it is read back, or the losses say so."""

import math
import re

import pytest

from fuzzyctl import DiagnosticError, as_profile, build, loads
from tests.fuzzyctl.formats.files import FORMATS, read
from tests.fuzzyctl.formats.one_term import with_membership

write = FORMATS["fis"].write

TWO = """\
system two
defuzzifier weighted_average
input x in [0, 10]{extrapolate}
  a = {a}
  b = {b}
output y in [0, 4] else {otherwise}
  p = {p}
  q = constant(3)
if x is a then y is p
if x is b then y is q
"""


A, B = "triangle(-inf, 0, 10)", "triangle(0, 10, inf)"


def two(a=A, b=B, p="constant(1)", extrapolate="", otherwise="2"):
    return loads(TWO.format(a=a, b=b, p=p, extrapolate=extrapolate, otherwise=otherwise))


def read_back(text):
    return read("fis", text)


def lost(losses):
    return [loss.what for loss in losses if not loss.exact]


class TestHeldInputs:
    @pytest.mark.parametrize(
        ("term", "written"),
        [
            ("triangle(-10, 0, 10)", "'linzmf',[0 10]"),
            ("triangle(0, 0, 10)", "'linzmf',[0 10]"),
            ("triangle(2, 10, 20)", "'linsmf',[2 10]"),
            ("trapezoid(-9, -5, 15, 19)", "'trapmf',[-Inf -Inf Inf Inf]"),
            ("triangle(0, 4, 10)", "'trimf',[0 4 10]"),
            ("trapezoid(-5, -2, 3, 6)", "'linzmf',[3 6]"),
            ("rectangle(0, 5)", "'linzmf',[5 5]"),
            ("z_shape(0, 10)", "'zmf',[0 10]"),
            ("pi_shape(0, 1, 2, 10)", "'pimf',[0 1 2 10]"),
        ],
    )
    def test_terms_become_shoulders_so_that_no_number_changes_beyond_the_range(self, term, written):
        system = two(a=term)
        text, losses = write(system)
        assert f"MF1='a':{written}\n" in text
        assert lost(losses) == []
        back = read_back(text)
        for x in (-1000.0, -5.0, -3.0, 0.0, 1.0, 2.5, 4.0, 5.0, 9.0, 10.0, 11.0, 16.0, 1000.0):
            assert back(x=x) == pytest.approx(system(x=x), rel=1e-12), x

    @pytest.mark.parametrize(
        "changes",
        [
            {"a": "triangle(-5, 2, 10)"},
            {"a": "gaussian(0, 4)"},
            {"a": "pi_shape(0, 0, 5, 10)"},
            {"a": "s_shape(-1, 10)"},
            {"a": "singleton(0)"},
            {"p": "linear(0.5, 1)"},
        ],
    )
    def test_what_goes_on_beyond_the_range_changes_numbers(self, changes):
        _, losses = write(two(**changes))
        assert lost(losses) == ["clamped to its range"]

    def test_inputs_that_extrapolate_lose_nothing(self):
        assert write(two(a="gaussian(0, 4)", extrapolate=" extrapolate"))[1] == []


class TestPoints:
    @pytest.mark.parametrize(
        ("points", "written"),
        [
            ("0, 0, 5, 1, 10, 0", "'trimf',[0 5 10]"),
            ("0, 0, 2, 0, 5, 1, 6, 1, 9, 0, 10, 0", "'trapmf',[2 5 6 9]"),
            ("2, 0, 3, 1", "'linsmf',[2 3]"),
            ("2, 1, 3, 0", "'linzmf',[2 3]"),
            ("0, 0, 4, 0.5, 10, 0", "'trapmf',[0 8 -2 10]"),
        ],
    )
    def test_points_are_what_matlab_has_for_them(self, points, written):
        system = two(a=f"piecewise({points})", extrapolate=" extrapolate")
        text, losses = write(system)
        assert f"MF1='a':{written}\n" in text
        assert losses == []
        back = read_back(text)
        for x in (-1.0, 0.0, 2.25, 3.0, 4.0, 5.5, 7.0, 9.5, 12.0):
            assert back(x=x) == pytest.approx(system(x=x), rel=1e-12), x

    def test_others_are_for_fuzzylite_in_a_file_that_says_whose_numerics_it_has(self):
        system = two(a="piecewise(0, 1, 2, 0.25, 5, 0)", b="triangle(6, 8, 9)", otherwise="0")
        text, losses = write(system)
        assert text.startswith("% numerics of matlab\n[System]\n")
        lost = [(loss.what, loss.why) for loss in losses if not loss.exact]
        assert lost == [
            ("else a value", "it is 'midpoint' there where no rule fires"),
            ("the kind 'piecewise'", "only fuzzylite reads 'discretemf'"),
        ]
        back = read_back(text)
        assert (back.method.semantics.profile, back(x=5.5)) == ("matlab", 2.0)

    def test_a_file_that_says_nothing_else_needs_no_comment(self):
        assert write(two())[0].startswith("[System]\n")


class TestConstants:
    def test_an_input_that_equals_a_number_is_a_triangle_without_sides(self):
        system = two(a="singleton(3)")
        text, losses = write(system)
        assert "MF1='a':'trimf',[3 3 3]\n" in text
        assert lost(losses) == []
        for x in (2.9, 3.0, 3.1):
            assert read_back(text)(x=x) == system(x=x)

    def test_to_fuzzylite_a_constant_of_an_input_is_its_degree_everywhere(self):
        text = write(two(extrapolate=" extrapolate"))[0].replace("'linzmf',[0 10]", "'constant',[0.5]")
        # (0.5 * 1 + 0.2 * 3) / 0.7
        assert read_back(f"% numerics of fuzzylite\n{text}")(x=2.0) == pytest.approx(1.1 / 0.7)


def test_an_error_where_no_rule_fires_is_nan_in_a_file_of_fuzzylite():
    text = TWO.format(a="triangle(0, 1, 2)", b="triangle(3, 4, 5)", p="constant(1)", extrapolate="", otherwise="error")
    text, losses = write(loads(text.replace("defuzzifier", "semantics fuzzylite\ndefuzzifier")))
    assert ("else error", True) in [(loss.what, loss.exact) for loss in losses]
    assert math.isnan(read_back(text)(x=7.0))


class TestFuzzylite:
    @pytest.mark.parametrize(
        ("term", "written"),
        [
            ("triangle(-inf, 0, 10)", "'rampmf',[10 0]"),
            ("trapezoid(2, 3, 9, inf)", "'rampmf',[2 3]"),
            ("trapezoid(4, 4, 9, inf)", "'rectmf',[4 inf]"),
            ("triangle(-inf, 4, 4)", "'rectmf',[-inf 4]"),
            ("ramp(10, 0)", "'rampmf',[10 0]"),
            ("triangle(1, 2, 3)", "'trimf',[1 2 3]"),
        ],
    )
    def test_shoulders_have_the_names_that_fuzzylite_knows(self, term, written):
        system = loads(TWO.format(a=term, b="ramp(0, 10)", p="constant(1)", extrapolate="", otherwise="2"))
        fuzzylite = system.model_copy(update={"method": as_profile(system, "fuzzylite").method})
        text, _ = write(fuzzylite)
        assert f"MF1='a':{written}\n" in text
        assert not {"linsmf", "linzmf"} & set(re.findall("[a-z]+mf", text))
        back = read_back(text)
        for x in (0.0, 1.0, 2.5, 3.0, 4.0, 5.0, 9.0, 10.0):
            assert back(x=x) == pytest.approx(fuzzylite(x=x), rel=1e-12, nan_ok=True), x

    def test_no_key_holds_an_input_which_fuzzylite_would_refuse(self):
        system = as_profile(two(a="gaussian(0, 4)"), "fuzzylite")
        text, losses = write(system)
        assert "LockRange" not in text
        assert "clamped to its range" in lost(losses)
        straight, losses = write(as_profile(two(a="triangle(-9, 0, 10)"), "fuzzylite"))
        assert "MF1='a':'rampmf',[10 0]" in straight
        assert lost(losses) == []

    @pytest.mark.parametrize(("condition", "code"), [("any a", "0.99"), ("not any a", "-0.99")])
    def test_a_rule_has_a_condition_without_which_fuzzylite_reads_none(self, condition, code):
        more = f"if x is {condition} then y is q\n"
        system = as_profile(
            loads(f"{TWO}{more}".format(a=A, b=B, p="constant(1)", extrapolate="", otherwise="2")), "fuzzylite"
        )
        text, _ = write(system)
        assert text.splitlines()[-1] == f"{code}, 2 (1) : 1"
        back = read_back(text)
        for x in (0.0, 1.0, 7.5, 10.0):
            assert back(x=x) == pytest.approx(system(x=x), rel=1e-12), x


def test_the_normalized_sum_of_fuzzylite_is_the_bounded_one():
    text, _ = write(two(p="constant(1)"))
    assert read_back(text.replace("OrMethod='max'", "OrMethod='normalized_sum'")).method.disjunction == "bounded_sum"


@pytest.mark.parametrize("formula", ["atan2(x, 2)", "max(1, x)", "gt(x, 1)"])
def test_formulas_with_commas_are_refused_since_fuzzylite_parts_terms_at_them(formula):
    system = as_profile(two(p=f"function({formula})", otherwise="nan"), "fuzzylite")
    with pytest.raises(DiagnosticError, match="term 'p' of 'y' is a formula with a function of several numbers"):
        write(system)
    text, _ = write(as_profile(two(p="function(abs(x) + sin(x))", otherwise="nan"), "fuzzylite"))
    assert "'function',[(abs(x) + sin(x))]" in text


def test_a_triangle_of_no_height_has_no_word():
    with pytest.raises(DiagnosticError, match="term 'a' of 'x' has the height 0"):
        write(with_membership(two(a="triangle(0, 4, 10)"), height=build.expression(0)))


HYBRID = """\
system hybrid
semantics fuzzylite
input x in [0, 10]
  low = triangle(-inf, 0, 10)
  high = ramp(0, 10)
output y in [0, 4] defuzzifier weighted_average aggregation {aggregation}
  p = constant(1)
output z in [0, 4] defuzzifier centroid aggregation max
  q = triangle(0, 1, 4)
if x is low then y is p, z is q
"""


class TestAggregations:
    """A file names one aggregation for all outputs."""

    @pytest.mark.parametrize(("aggregation", "lost"), [("sum", ["aggregation max"]), ("max", [])])
    def test_rules_of_one_term_are_joined_before_an_average(self, aggregation, lost):
        text = f"{HYBRID.format(aggregation=aggregation)}if x is high then y is p\n"
        _, losses = write(loads(text))
        assert [x.what for x in losses if x.what.startswith("aggregation")] == lost

    def test_an_average_that_joins_rules_otherwise_is_a_loss_behind_sets(self):
        text = f"{HYBRID.format(aggregation='sum')}if x is high then y is p\n"
        y, z = text.index("output y"), text.index("output z")
        rules = text.index("if x is low")
        _, losses = write(loads(text[:y] + text[z:rules] + text[y:z] + text[rules:]))
        assert [x.what for x in losses if x.what.startswith("aggregation")] == ["aggregation sum"]

    def test_an_average_that_joins_nothing_leaves_the_choice_to_sets(self):
        written, losses = write(loads(HYBRID.format(aggregation="sum")))
        assert "AggMethod='max'" in written
        assert [x.what for x in losses if x.what.startswith("aggregation")] == []
