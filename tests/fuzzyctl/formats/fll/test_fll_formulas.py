"""Formulas of fuzzylite and of pyfuzzylite: their values, and how they are written."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl import DiagnosticError, loads
from tests.fuzzyctl.formats.files import FORMATS, SMALL, errors, examined, lines, read, replaced

INPUT = "InputVariable: {}\n  range: -1000 1000\n  term: all Rectangle -1000 1000\n"
FORMULA = (
    f"Engine: e\n{INPUT.format('a')}{INPUT.format('b')}OutputVariable: y\n  range: 0 1\n"
    "  defuzzifier: WeightedAverage\n  term: f Function {}\nRuleBlock:\n  conjunction: Minimum\n"
    "  rule: if a is all and b is all then y is f\n"
)
PYTHON = "# numerics of pyfuzzylite\n"


def value(text, a=3.0, b=4.0, before=""):
    """Return the value of a formula, which is also that of the formula as it is written again."""
    system = read("fll", before + FORMULA.format(text))
    found = system(a=a, b=b)
    assert read("fll", FORMATS["fll"].write(system)[0])(a=a, b=b) == pytest.approx(found, rel=1e-14)
    return found


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 + 2 * 3", 7),
        ("-a ^ 2", -9),
        ("2 ^ -1", 0.5),
        ("2 ** 3 ^ 2", 512),
        ("(1 + 2) * a - 4 / 2", 7),
        ("max(a, min(b, 7))", 4),
        ("pow(a, 2) + fabs(-b)", 13),
        ("sin(0) + cos(pi - pi) + exp(0) + sqrt(4)", 4),
        ("1e2 + .5", 100.5),
        ("~a ^ 2", 9),
        (".-a ^ 2 + .+b", -5),
        ("2 ^ .-1", 0.5),
        ("!lt(a, b) + !0 * 2", 2),
        ("lt(a, b) and gt(a, b) or eq(a, 3)", 1),
        ("1 or 1 and 0", 1),
        ("(1 or 1) and 0", 0),
        ("0 and 0 + 1", 0),
        ("a and 1", 0),
        ("~b % a + 1.5 % a", 0.5),
        ("round(2.5) + round(~2.5) + round(a / 2)", 2),
        ("floor(~0.5) + ceil(a / 2) + fmod(~b, a)", 0),
        ("--a", 3),
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
def test_formulas_have_the_values_of_fuzzylite(text, expected):
    assert value(text) == pytest.approx(expected, rel=1e-14, abs=1e-12)


def operations(parts):
    return st.tuples(parts, st.sampled_from("+-*/"), parts).map(" ".join) | parts.map("({})".format)


@given(st.recursive(st.sampled_from(["a", "b", "1.5", "7"]), operations, max_leaves=9))
def test_operators_bind_as_in_python(text):
    a, b = 3.0, 4.0
    try:
        expected = eval(text)
    except ZeroDivisionError:
        return
    assert read("fll", FORMULA.format(text))(a=a, b=b) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        *(("1 +", "FZ601"), ("1 2", "FZ601"), ("a $ b", "FZ601"), ("(a", "FZ103"), ("sin(a", "FZ103")),
        *(("sin(a, b)", "FZ601"), ("expm1(a)", "FZ602"), ("ne(a, b)", "FZ602"), ("mod(a, b)", "FZ602")),
        *(("a %", "FZ601"), ("a and", "FZ601"), ("or a", "FZ601"), ("a ! b", "FZ601"), ("c + 1", "FZ202")),
        ("asinh(" * 12 + "a" + ")" * 12, "FZ601"),
        ("(" * 60 + "a" + ")" * 60, "FZ601"),
        ("-" * 60 + "a", "FZ601"),
        ("+".join("a" * 1500), "FZ601"),
    ],
)
def test_what_is_no_formula_is_reported(text, code):
    assert [d.code for d in errors("fll", FORMULA.format(text))] == [code]


@pytest.mark.parametrize(
    ("text", "theirs", "pythons"),
    [("a % b", -2.0, 1.0), ("b and ~a", 0.0, 1.0), ("!b", 1.0, 0.0), ("round(a / 2)", -3.0, -2.0)],
)
def test_what_the_two_engines_read_differently_is_reported(text, theirs, pythons):
    assert (value(text, -5.0, 3.0), value(text, -5.0, 3.0, PYTHON)) == (theirs, pythons)
    reported = [d for d in examined("fll", FORMULA.format(text))[1] if d.code == "FZ609"]
    assert reported
    assert all(d.span.text in text and "pyfuzzylite" in "".join((d.help, *d.facts)) for d in reported)
    assert "FZ609" not in {d.code for d in examined("fll", PYTHON + FORMULA.format(text))[1]}


@pytest.mark.parametrize("name", ["lt", "le", "gt", "ge", "eq", "neq", "floor", "ceil", "fmod"])
def test_functions_of_both_are_written_as_they_are_read(name):
    text = f"{name}(a)" if name in ("floor", "ceil") else f"{name}(a, 2)"
    assert f"term: f Function {text}\n" in FORMATS["fll"].write(read("fll", FORMULA.format(text)))[0]


HIGH = "term: high Ramp 0.0 1.0\nRuleBlock"


def with_formula(text):
    return replaced(SMALL, (HIGH, f"term: high Function {text}\nRuleBlock"))


def test_a_formula_of_x_is_a_set_of_the_output_and_written_so():
    system = read("fll", with_formula("1 - abs(x - 0.75) * pi"))
    assert "high = function(1 - abs(y - 0.75) * pi)" in lines("fll", with_formula("1 - abs(x - 0.75) * pi"))
    written, losses = FORMATS["fll"].write(system)
    assert "term: high Function (1 - (abs((x - 0.75)) * pi))" in written
    assert not [loss for loss in losses if not loss.exact]
    assert read("fll", written).outputs[0].terms == system.outputs[0].terms


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
    text = replaced(with_formula(formula), ("aggregation: Maximum", f"aggregation: {aggregation}"))
    assert [d.message for d in examined("fll", text)[1] if d.code == "FZ609"] == reported


@pytest.mark.parametrize(
    ("formula", "defuzzifier", "message"),
    [
        ("x * a", "Centroid 100", "names 'x', its place, beside"),
        ("x", "WeightedAverage TakagiSugeno", "'inverse_tsukamoto' takes"),
    ],
)
def test_what_is_no_set_of_one_place_is_refused(formula, defuzzifier, message):
    found = errors("fll", replaced(with_formula(formula), ("Centroid 100", defuzzifier)))
    assert any(message in d.message for d in found), found


@pytest.mark.parametrize(
    ("formula", "fuzzylites", "pythons"),
    [
        ("mod(x, 2)", None, "(x % 2)"),
        ("round(x)", None, "round(x)"),
        # Exponents have no place there: a minus in one is taken for a difference.
        ("min(x, -1.5, p)", *["min(min(x, (0 - 1.5)), 0.00000025)"] * 2),
        ("1e300 * x", *[f"(1{'0' * 300} * x)"] * 2),
        ("sign(x)", *["(gt(x, 0) - gt(0, x))"] * 2),
    ],
)
def test_formulas_are_written_in_the_words_of_the_engine(formula, fuzzylites, pythons):
    text = "system s\nsemantics {}\nparam p = 2.5e-7\ndefuzzifier weighted_average\ninput x in [-9, 9] extrapolate\n"
    text += f"  a = ramp(0, 1)\noutput y in [0, 1] else nan\n  f = function({formula})\nif x is a then y is f\n"
    for engine, expected in (("fuzzylite", fuzzylites), ("pyfuzzylite", pythons)):
        if expected is None:
            with pytest.raises(DiagnosticError, match="a formula with a function that fuzzylite does not have"):
                FORMATS["fll"].write(loads(text.format(engine)))
        else:
            assert f"Function {expected}\n" in FORMATS["fll"].write(loads(text.format(engine)))[0]
