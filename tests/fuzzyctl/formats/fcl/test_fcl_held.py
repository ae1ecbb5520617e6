"""Inputs that are held within their ranges become FCL: shoulders where they do the same, else a loss of numbers."""

import pytest

from fuzzyctl.diagnostics.diagnostic import render_all
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.fcl import read, write
from fuzzyctl.loading.load import loads

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


@pytest.mark.parametrize(
    ("term", "written"),
    [
        ("triangle(-10, 0, 10)", "(0, 1) (10, 0)"),
        ("triangle(-5, 2, 10)", "(0, 0.7142857142857143) (2, 1) (10, 0)"),
        ("triangle(0, 0, 10, height=0.5)", "(0, 0.5) (10, 0)"),
        ("triangle(0, 4, 10)", "(0, 0) (4, 1) (10, 0)"),
    ],
)
def test_straight_terms_stay_beyond_the_range_what_they_are_at_its_ends(term, written):
    system = loads(TWO.format(term, "constant(3)"))
    text, losses = write(system)
    assert f"TERM a := {written};" in text
    assert [str(loss) for loss in losses if not loss.exact] == []
    back, diagnostics = read(SourceText("t.fcl", text))
    assert back is not None, render_all(diagnostics)
    for x in (-100.0, -4.0, 0.0, 1.0, 5.0, 10.0, 100.0):
        assert back(x=x) == pytest.approx(system(x=x), rel=1e-12), x


@pytest.mark.parametrize(
    ("term", "consequent"), [("gaussian(0, 4)", "constant(3)"), ("triangle(0, 4, 10)", "linear(0.1, 1)")]
)
def test_what_goes_on_beyond_the_range_changes_numbers(term, consequent):
    _, losses = write(loads(TWO.format(term, consequent)))
    assert "clamped to its range" in [loss.what for loss in losses if not loss.exact]


OF_FUZZYLITE = TWO.replace("defuzzifier", "semantics fuzzylite\ndefuzzifier")


def test_fuzzylite_reads_no_word_that_holds_an_input_so_none_is_written():
    written, losses = write(loads(OF_FUZZYLITE.format("gaussian(0, 4)", "constant(3)")))
    assert "LOCK :" not in written
    assert "clamped to its range" in [loss.what for loss in losses if not loss.exact]


def test_in_the_dialect_of_fuzzylite_straight_terms_get_shoulders_too():
    system = loads(OF_FUZZYLITE.format("triangle(-10, 0, 10)", "constant(3)"))
    written, losses = write(system)
    assert [str(loss) for loss in losses if not loss.exact] == []
    back, diagnostics = read(SourceText("t.fcl", written))
    assert back is not None, render_all(diagnostics)
    for x in (-100.0, -4.0, 0.0, 5.0, 100.0):
        assert back(x=x) == pytest.approx(system(x=x), rel=1e-12), x


def test_the_lock_of_an_output_stands_before_what_it_holds_which_it_would_take_back():
    # fuzzylite 6 sets both locks by LOCK: behind "DEFAULT := 2 | NC" the word RANGE alone ends the holding.
    text = OF_FUZZYLITE.replace("in [0, 4] else 2", "in [0, 4] clamp else hold(2)")
    written, _ = write(loads(text.format("gaussian(0, 4)", "constant(3)")))
    assert written.rindex("LOCK : RANGE;") < written.index("DEFAULT := 2 | NC;")


@pytest.mark.parametrize("term", ["triangle(20, 30, 40)", "rectangle(12, inf)"])
def test_a_term_that_lies_beyond_the_range_stays_there_since_no_set_is_empty(term):
    text, losses = write(loads(TWO.format(term, "constant(3)")))
    assert "clamped to its range" in [loss.what for loss in losses if not loss.exact]
    back, diagnostics = read(SourceText("t.fcl", text))
    assert back is not None, render_all(diagnostics)
    assert back(x=5) == 3


def test_formulas_for_fuzzylite_have_no_signs_before_operands_which_it_cannot_read():
    system = loads(OF_FUZZYLITE.format("function(exp(-x^2) * sign(x + 1))", "function(-2 * x)"))
    text, losses = write(system)
    assert "TERM a := Function (exp((0 - (x ^ 2))) * (gt((x + 1), 0) - gt(0, (x + 1))));" in text
    assert "TERM q := Function ((0 - 2) * x);" in text
    assert not [loss for loss in losses if loss.what.startswith("function")]
    back, diagnostics = read(SourceText("t.fcl", text))
    assert back is not None, render_all(diagnostics)
    assert back(x=0.5) == pytest.approx(system(x=0.5), rel=1e-15)


@pytest.mark.parametrize("semantics", ["fuzzylite", "jfuzzylogic"])
def test_a_variable_that_gets_the_name_of_a_param_is_not_taken_for_it(semantics):
    text = TWO.format("triangle(0, 4, 10)", "function(sigma * x)").replace("x", "σ")
    system = loads(text.replace("defuzzifier", f"semantics {semantics}\nparam sigma = 3\ndefuzzifier", 1))
    written, _ = write(system)
    assert "(3 * sigma_2)" in written if semantics == "fuzzylite" else "FUNCTION 3 * sigma_2" in written
