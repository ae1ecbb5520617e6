"""What is written as FCL computes the same numbers when it is read back, or the losses say so."""

import math

import pytest

from fuzzyctl import as_profile, loads
from tests.effort import at_most
from tests.fuzzyctl.formats.files import FORMATS, examined, read, replaced, write

TWO = """\
system two
defuzzifier weighted_average
input x in [0, 10]
  a = {}
  b = triangle(0, 10, inf)
output y in [0, 4] else 2
  p = constant(1)
  q = {}
if x is a then y is p
if x is b then y is q
"""
OF_FUZZYLITE = TWO.replace("defuzzifier", "semantics fuzzylite\ndefuzzifier")
INSIDE, BEYOND = (0.0, 1.0, 5.0, 10.0), (-100.0, -4.0, 100.0)


def survives(text, places):
    """Return the text of a system that computes the same numbers when it is read back."""
    system = loads(text)
    written, lossy = write("fcl", system)
    assert [x for x in lossy if x != "clamped to its range"] == []
    back = read("fcl", written)
    assert [back(x=x) for x in places] == pytest.approx([system(x=x) for x in places], rel=1e-12, nan_ok=True)
    return written, back


class TestHeldInputs:
    @pytest.mark.parametrize(
        ("term", "written"),
        [
            ("triangle(-10, 0, 10)", "(0, 1) (10, 0)"),
            ("triangle(-5, 2, 10)", "(0, 0.7142857142857143) (2, 1) (10, 0)"),
            ("triangle(0, 0, 10, height=0.5)", "(0, 0.5) (10, 0)"),
            ("triangle(0, 4, 10)", "(0, 0) (4, 1) (10, 0)"),
        ],
    )
    def test_straight_terms_stay_beyond_the_range_what_they_are_at_its_ends(self, term, written):
        assert f"TERM a := {written};" in survives(TWO.format(term, "constant(3)"), INSIDE + BEYOND)[0]
        survives(OF_FUZZYLITE.format(term, "constant(3)"), INSIDE + BEYOND)

    @pytest.mark.parametrize(
        ("text", "term", "consequent"),
        [
            (TWO, "gaussian(0, 4)", "constant(3)"),
            (TWO, "triangle(0, 4, 10)", "linear(0.1, 1)"),
            (OF_FUZZYLITE, "gaussian(0, 4)", "constant(3)"),
            # A term beyond the range stays there, since no set is empty.
            (TWO, "triangle(20, 30, 40)", "constant(3)"),
            (TWO, "rectangle(12, inf)", "constant(3)"),
        ],
    )
    def test_what_goes_on_beyond_the_range_changes_numbers(self, text, term, consequent):
        written, lossy = write("fcl", loads(text.format(term, consequent)))
        assert "clamped to its range" in lossy
        assert "LOCK :" not in written  # fuzzylite reads no word that holds an input
        assert read("fcl", written)(x=5) == loads(text.format(term, consequent))(x=5)

    def test_the_lock_of_an_output_stands_before_what_it_holds_which_it_would_take_back(self):
        # fuzzylite 6 sets both locks by LOCK: behind "DEFAULT := 2 | NC" the word RANGE alone ends the holding.
        text = OF_FUZZYLITE.replace("in [0, 4] else 2", "in [0, 4] clamp else hold(2)")
        written, _ = write("fcl", loads(text.format("gaussian(0, 4)", "constant(3)")))
        assert written.rindex("LOCK : RANGE;") < written.index("DEFAULT := 2 | NC;")

    @pytest.mark.parametrize("held", ["", " extrapolate"])
    @pytest.mark.parametrize("term", ["gaussian2(-inf, 1, 3, 2)", "gaussian2(6, 2, inf, 1)", "triangle(-inf, 3, 7)"])
    def test_sides_that_never_end_are_read_back(self, term, held):
        text = TSUKAMOTO.format(method="centroid", a=term, b="ramp(5, 10)").replace("triangle(-inf, 0, 10)", term)
        text = text.replace("[0, 10]", f"[0, 10]{held}")
        if term.startswith("gaussian2"):
            text = text.replace("system s", "system s\nsemantics fuzzylite").replace("else 0", "else nan")
        survives(text, INSIDE + (BEYOND if held else ()))


class TestFormulas:
    def test_for_fuzzylite_they_have_no_signs_before_operands_which_it_cannot_read(self):
        text = OF_FUZZYLITE.format("function(exp(-x^2) * sign(x + 1))", "function(-2 * x)")
        written, _ = survives(text, INSIDE)
        assert "TERM a := Function (exp((0 - (x ^ 2))) * (gt((x + 1), 0) - gt(0, (x + 1))));" in written
        assert "TERM q := Function ((0 - 2) * x);" in written

    @pytest.mark.parametrize("semantics", ["fuzzylite", "jfuzzylogic"])
    def test_a_variable_that_gets_the_name_of_a_param_is_not_taken_for_it(self, semantics):
        text = TWO.format("triangle(0, 4, 10)", "function(sigma * x)").replace("x", "σ")
        text = text.replace("defuzzifier", f"semantics {semantics}\nparam sigma = 3\ndefuzzifier", 1)
        written, _ = write("fcl", loads(text))
        assert ("(3 * sigma_2)" if semantics == "fuzzylite" else "FUNCTION 3 * sigma_2") in written

    def test_functions_and_shoulders_of_the_standard_keep_their_value(self):
        text = TWO.replace("[0, 10]", "[0, 1]").format("triangle(-inf, 0, 1)", "function(exp(x * -0.5))")
        written, _ = survives(text, (0.0, 0.3, 1.0))
        assert "TERM a := (0, 1) (1, 0);" in written
        assert "FUNCTION EXP(x * -0.5)" in written


MINIMAL = """\
system m
input x in [0, 1] extrapolate
  a = triangle(0, 0, 1)
output y in [0, 1] else nan
  b = triangle(0, 1, 1)
if x is a then y is b
"""


@pytest.mark.parametrize(
    ("old", "new", "lost"),
    [
        ("input", "defuzzifier centroid(resolution=101, grid=endpoints)\ninput", "defuzzifier centroid"),
        ("else nan", "else error", "else error"),
        ("else nan", "else hold", "what it holds at first"),
        ("else nan", "adaptive rate 1 else nan", "adaptive"),
        ("x is a", "x is slightly a", "hedge 'slightly'"),
        ("y is b\n", "y is b weight 0.5\n", "weight after"),
    ],
)
def test_losses_are_the_parts_that_fcl_has_no_words_for(old, new, lost):
    base = replaced(MINIMAL, ("input x", "semantics exact(weight=after)\ninput x"))
    assert write("fcl", loads(base))[1] == write("fcl", loads(MINIMAL))[1] == []
    text = replaced(MINIMAL if old == "input" else base, (old, new))
    if "adaptive" in new:
        text = replaced(text, ("input", "defuzzifier weighted_average\ninput"), ("triangle(0, 1, 1)", "constant(1)"))
    assert any(lost in x for x in write("fcl", loads(text))[1]), write("fcl", loads(text))[1]


@pytest.mark.parametrize(
    ("profile", "term", "tool"),
    [
        ("matlab", "triangle(0, 0, 1)", "exact"),
        ("exact", "gaussian(0, 1)", "jfuzzylogic"),
        ("matlab", "gaussian(0, 1)", "jfuzzylogic"),
        ("exact", "s_shape(0, 1)", "fuzzylite"),
        ("pyfuzzylite", "s_shape(0, 1)", "fuzzylite"),
        ("jfuzzylogic", "gaussian(0, 1)", "jfuzzylogic"),
        ("fuzzylite_6", "s_shape(0, 1)", "fuzzylite_6"),
        ("exact", "triangle(0, 0, 1)", "exact"),
    ],
)
def test_a_file_has_the_numerics_of_the_tool_that_reads_it_and_what_changes_is_said(profile, term, tool):
    text = replaced(MINIMAL, ("triangle(0, 0, 1)", term), ("else nan", "else 0.5"))
    system = as_profile(loads(text), profile)
    written, lossy = write("fcl", system)
    back = read("fcl", written)
    assert back.method.semantics.profile == tool
    same = system.method.defuzzifier == back.method.defuzzifier
    assert any(what.startswith("defuzzifier") for what in lossy) == (not same)
    assert bool(lossy) == (profile != tool and (not same or "least 0.0" in lossy))
    points = [0.0, 0.1, 0.25, 0.5, 0.7, 0.9]
    values = pytest.approx([system(x=p) for p in points], rel=1e-12, nan_ok=True)
    assert ([back(x=p) for p in points] == values) == same


def test_sums_have_the_words_that_fuzzylite_reads():
    sets = replaced(MINIMAL, ("input", "semantics fuzzylite\naggregation sum\ninput"))
    assert "ACCU : UnboundedSum;" in write("fcl", loads(sets))[0]
    average = ("aggregation sum", "aggregation sum\ndefuzzifier weighted_average")
    text, lossy = write("fcl", loads(replaced(sets, average, ("triangle(0, 1, 1)", "singleton(1)"))))
    assert "ACCU" not in text
    assert lossy == []
    assert "if x is a then y is b\n" in text


@pytest.mark.parametrize(
    ("name", "written"), [("σ", "sigma"), ("Qualität", "Qualitat"), ("MIN", "MIN_"), ("sin_", "sin_")]
)
def test_names_beyond_ascii_are_spelt_and_reserved_ones_changed(name, written):
    text = replaced(MINIMAL, ("input x", f"input {name}"), ("x is a", f"{name} is a"))
    text, losses = FORMATS["fcl"].write(loads(text))
    assert f"  {written} : REAL;" in text
    names = [loss.what for loss in losses if loss.what.startswith("the name")]
    assert names == ([f"the name '{name}'"] if name != written else [])


TSUKAMOTO = """\
system s
defuzzifier {method}
input x in [0, 10]
  low = triangle(-inf, 0, 10)
  high = ramp(0, 10)
output y in [0, 20] else 0
  a = {a}
  b = {b}
if x is low then y is a
if x is high then y is b
"""


@pytest.mark.parametrize(
    ("method", "a", "b"),
    [
        ("tsukamoto", "s_shape(5, 12)", "ramp(5, 10)"),
        ("tsukamoto", "triangle(0, 8, inf)", "pi_shape(-inf, 2, 5, 9)"),
        ("tsukamoto_sum", "piecewise(5, 0, 12, 1)", "ramp(5, 10)"),
        ("inverse_tsukamoto", "triangle(0, 8, inf)", "gaussian(5, 2)"),
        ("inverse_tsukamoto_sum", "triangle(0, 8, 9)", "gaussian(5, 2)"),
    ],
)
def test_tsukamotos_methods_are_written_for_fuzzylite_and_read_back(method, a, b):
    written, back = survives(TSUKAMOTO.format(method=method, a=a, b=b), INSIDE)
    assert "METHOD : COGS" in written
    assert back.method.defuzzifier.kind == method


def test_a_system_of_fuzzylite_without_any_word_of_its_own_stays_one():
    text = replaced(
        TSUKAMOTO.format(method="weighted_average", a="singleton(3)", b="singleton(5)"),
        *(("system s", "system s\nsemantics fuzzylite"), ("[0, 10]", "[0, 10] extrapolate")),
        *(("triangle(-inf, 0, 10)", "piecewise(0, 1, 10, 0)"), ("ramp(0, 10)", "piecewise(0, 0, 10, 1)")),
    )
    assert survives(text, INSIDE)[1].method.semantics.profile == "fuzzylite"


@pytest.mark.parametrize(
    ("condition", "written"),
    [("any a", "any"), ("any very a", "any"), ("very any a", "very any"), ("not any a", "not any")],
)
def test_nothing_stands_behind_any_as_fuzzylite_takes_nothing_there(condition, written):
    text = replaced(TWO.format("ramp(10, 0)", "constant(3)"), ("x is a", f"x is {condition}"))
    assert f"if x is {written} then y is p\n" in survives(text, INSIDE)[0]


def test_a_pi_shape_without_sides_is_one_again():
    text = replaced(MINIMAL, ("input", "semantics fuzzylite\ninput"), ("triangle(0, 1, 1)", "pi_shape(0, 0, 1, 1)"))
    assert read("fcl", write("fcl", loads(text))[0]).outputs == loads(text).outputs


def test_many_terms_of_one_name_and_characters_without_meaning_take_their_time_only():
    text = write("fcl", loads(TSUKAMOTO.format(method="centroid", a="ramp(0, 9)", b="ramp(9, 0)")))[0]
    with at_most(4):
        back = read("fcl", text.replace("  TERM a :=", f"{'  TERM a := Ramp 0 9;' * 2000}\n  TERM a :=", 1))
        assert len({t.name for t in back.outputs[0].terms}) == 2002
        assert len(examined("fcl", "$@" * 20_000)[1]) < 110


TIPPER = """FUNCTION_BLOCK tipper // as jFuzzyLogic has it
VAR_INPUT service : REAL; RANGE := (0 .. 10); food : REAL; RANGE := (0 .. 10); END_VAR
VAR_OUTPUT tip : REAL; END_VAR
FUZZIFY service
 TERM poor := GAUSS 0 1.5; TERM good := GAUSS 5 1.5; TERM excellent := GAUSS 10 1.5;
END_FUZZIFY
FUZZIFY food
 TERM rancid := TRAPE -2 0 1 3; TERM delicious := TRAPE 7 9 10 12;
END_FUZZIFY
DEFUZZIFY tip
 TERM cheap := TRIAN 0 5 10; TERM average := TRIAN 10 15 20; TERM generous := TRIAN 20 25 30;
 METHOD : COG; DEFAULT := 0; RANGE := (0 .. 30);
END_DEFUZZIFY
RULEBLOCK rules
 ACCU : MAX; AND : MIN; ACT : MIN;
 RULE 1 : IF service IS poor OR food IS rancid THEN tip IS cheap;
 RULE 2 : IF service IS good THEN tip IS average;
 RULE 3 : IF service IS excellent OR food IS delicious THEN tip IS generous;
END_RULEBLOCK
END_FUNCTION_BLOCK
"""


def test_the_tipper_has_the_numbers_of_jfuzzylogic():
    # Run with jFuzzyLogic, revision 1f421d1b.
    points = {(2, 1): 7.0151131237, (4, 5): 14.4530473104, (7, 8): 20.3444408811, (1, 2): 5.5540191962}
    tipper = read("fcl", TIPPER)
    for (service, food), value in points.items():
        assert math.isclose(tipper(service=service, food=food), value, rel_tol=0, abs_tol=5e-11)  # the digits printed
