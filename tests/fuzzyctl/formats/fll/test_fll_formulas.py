"""Formulas of fuzzylite and of pyfuzzylite: what they are here, and how they are written."""

import math

import pytest

from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.expr import Binary, Call, Name, Number, evaluate, names_in
from fuzzyctl.formats.fll import read, write
from fuzzyctl.formats.fll.formulas import formula, read_formula
from fuzzyctl.loading.load import examine
from tests.fuzzyctl.formats.fll.small import SMALL, changed, system


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        *((f"{name}(0.3)", getattr(math, name)(0.3)) for name in ("asin", "acos", "atan", "sinh", "cosh", "tanh")),
        *((f"{name}(-0.3)", getattr(math, name)(-0.3)) for name in ("asin", "atan", "sinh", "tanh", "asinh", "atanh")),
        ("acosh(1.5)", math.acosh(1.5)),
        ("asinh(2)", math.asinh(2)),
        ("log10(1000)", 3),
        ("log1p(0.5)", math.log1p(0.5)),
        ("tanh(1000)", 1),
        ("lt(1, 2) + 10*lt(2, 2) + 100*lt(3, 2)", 1),
        ("le(1, 2) + 10*le(2, 2) + 100*le(3, 2)", 11),
        ("gt(1, 2) + 10*gt(2, 2) + 100*gt(3, 2)", 100),
        ("ge(1, 2) + 10*ge(2, 2) + 100*ge(3, 2)", 110),
        ("eq(1, 2) + 10*eq(2, 2) + 100*eq(3, 2)", 10),
        ("neq(1, 2) + 10*neq(2, 2) + 100*neq(3, 2)", 101),
        ("pow(2, 3)", 8),
    ],
)
def test_functions_of_fuzzylite_are_expressions_of_those_here(text, expected):
    source = SourceText("t", text)
    found = read_formula(Span(source, 0, len(text)), [])
    assert evaluate(found, {}) == pytest.approx(expected, rel=1e-14)
    written = formula(found, {})
    again = read_formula(Span(SourceText("t", written), 0, len(written)), [])
    assert evaluate(again, {}) == evaluate(found, {})


@pytest.mark.parametrize("function", ["lt", "le", "gt", "ge", "eq", "neq", "floor", "ceil", "fmod"])
def test_functions_of_both_are_written_as_they_are_read(function):
    text = f"{function}(x)" if function in ("floor", "ceil") else f"{function}(x, 2)"
    found = read_formula(Span(SourceText("t", text), 0, len(text)), ["x"])
    assert formula(found, {}) == text


def test_a_formula_of_x_is_a_set_of_the_output_and_written_so():
    text = changed("term: high Ramp 0.0 1.0\nRuleBlock", "term: high Function 1 - abs(x - 0.75) * pi\nRuleBlock")
    found = system(text)
    membership = found.outputs[0].terms[1].membership
    assert membership.kind == "formula"
    assert {n.name for n in names_in(membership.arguments[0])} == {"y", "pi"}
    written, losses = write(found)
    assert "term: high Function (1 - (abs((x - 0.75)) * pi))" in written
    assert not [loss for loss in losses if not loss.exact]
    assert system(written).outputs[0].terms == found.outputs[0].terms


@pytest.mark.parametrize(
    ("formula", "aggregation", "reported"),
    [
        ("2 * x", "Maximum", ["the degree of 'high' is 2 at y = 1, and held within [0, 1] here"]),
        ("x - 1", "Maximum", []),
        ("x - 1", "AlgebraicSum", ["the degree of 'high' is -1 at y = 0, and held within [0, 1] here"]),
        ("x * gt(x, 0.5)", "AlgebraicSum", []),
    ],
)
def test_sets_that_leave_0_to_1_are_reported_where_that_matters(formula, aggregation, reported):
    text = changed("term: high Ramp 0.0 1.0\nRuleBlock", f"term: high Function {formula}\nRuleBlock")
    _, diagnostics = read(SourceText("t.fll", changed("aggregation: Maximum", f"aggregation: {aggregation}", text)))
    assert [d.message for d in diagnostics] == reported


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("term: high Ramp 0.0 1.0\nRuleBlock", "term: high Function x * a\nRuleBlock", "names 'x', its place, beside"),
        ("defuzzifier: Centroid 100", "defuzzifier: WeightedAverage TakagiSugeno", "'inverse_tsukamoto' takes"),
    ],
)
def test_what_is_no_set_of_one_place_is_refused(old, new, message):
    text = changed("term: high Ramp 0.0 1.0\nRuleBlock", "term: high Function x\nRuleBlock")
    text = changed(old, new) if "x * a" in new else changed(old, new, text)
    _, diagnostics = examine(SourceText("t.fll", text))
    assert any(message in d.message for d in diagnostics), diagnostics


@pytest.mark.parametrize(
    ("text", "theirs", "pythons"),
    [("a % b", -2.0, 1.0), ("b and ~a", 0.0, 1.0), ("!b", 1.0, 0.0), ("round(a / 2)", -3.0, -2.0)],
)
def test_what_the_two_engines_read_differently_is_reported(text, theirs, pythons):
    span = Span(SourceText("t", text), 0, len(text))
    reported = []
    assert evaluate(read_formula(span, "ab", differs=reported.append), {"a": -5.0, "b": 3.0}) == theirs
    assert reported
    assert all(t.span.text in text and "pyfuzzylite" in t.other for t in reported)
    reported.clear()
    assert evaluate(read_formula(span, "ab", python=True, differs=reported.append), {"a": -5.0, "b": 3.0}) == pythons
    assert not reported


def test_a_file_says_whose_formulas_it_has():
    text = SMALL.replace("Ramp 1.0 0.0", "Function a % 3", 1)
    system, (warning,) = read(SourceText("t.fll", text))
    assert (warning.code, warning.severity, warning.span.text) == ("FZ609", "warning", "%")
    assert system.inputs[0].terms[0].membership.arguments[0].function == "fmod"
    system, warnings = read(SourceText("t.fll", "# numerics of pyfuzzylite\n" + text))
    assert system.inputs[0].terms[0].membership.arguments[0].function == "mod"
    assert warnings == []


@pytest.mark.parametrize(
    ("expr", "fuzzylites", "pythons"),
    [
        (Call("mod", (Name("x"), Number(2.0))), None, "(x % 2)"),
        (Call("round", (Name("x"),)), None, "round(x)"),
        (Call("min", (Name("x"), Number(-1.5), Name("p"))), *["min(min(x, (0 - 1.5)), 0.00000025)"] * 2),
        (Binary("*", Number(1e300), Name("x")), *[f"(1{'0' * 300} * x)"] * 2),
    ],
)
def test_formulas_are_written_in_the_words_of_the_engine(expr, fuzzylites, pythons):
    """Exponents have no place there: a minus in one is taken for a difference."""
    assert formula(expr, {"p": 2.5e-7}) == fuzzylites
    assert formula(expr, {"p": 2.5e-7}, python=True) == pythons


def test_a_sign_is_the_difference_of_two_comparisons():
    written = formula(Call("sign", (Name("x"),)), {})
    assert written == "(gt(x, 0) - gt(0, x))"
    read_back = read_formula(Span(SourceText("t", written), 0, len(written)), ["x"])
    assert [evaluate(read_back, {"x": x}) for x in (-2.0, 0.0, 0.5)] == [-1.0, 0.0, 1.0]
