"""What is written as `.fll` computes the same numbers when it is read back, or the losses say so."""

import pytest

from fuzzyctl import DiagnosticError, as_profile, loads
from fuzzyctl.convert.convert import convert
from tests.fuzzyctl.formats.files import FORMATS, errors, read

write = FORMATS["fll"].write

TWO = """\
system two
and product
defuzzifier {method}
input x in [0, 10]
  a = {a}
  b = {b}
output y in [0, 4] else 2
  p = {p}
  q = {q}
if x is a then y is p
if x is b then y is q
"""


def two(
    a="gaussian(0, 0.5)", b="gaussian(10, 0.5)", p="constant(1)", q="constant(3)", method="weighted_average", weight=""
):
    text = TWO.format(a=a, b=b, p=p, q=q, method=method)
    return loads(text.replace("then y is p\n", f"then y is p {weight}\n"))


def head(system):
    return write(system)[0].splitlines()[0]


class TestTails:
    def test_far_tails_still_decide_in_the_file(self):
        system = two()
        found = convert(system, "fll")
        assert found.lossy == ()
        assert [loss.what for loss in found.losses] == ["least 0.0"]
        assert system(x=4.9) == pytest.approx(1.036, abs=1e-3)
        assert found.read_back(x=4.9) == pytest.approx(system(x=4.9), rel=1e-12)

    @pytest.mark.parametrize(
        ("changes", "said"),
        [
            ({}, True),
            ({"a": "sigmoid(0, -5)"}, True),
            ({"a": "triangle(-inf, 0, 10)", "b": "bell(10, 0.1, 5)"}, True),
            ({"a": "triangle(-inf, 0, 10)", "b": "triangle(0, 10, inf)"}, False),
            ({"a": "z_shape(0, 10)", "b": "cosine(10, 20)"}, False),
            ({"a": "triangle(-inf, 0, 10)", "b": "triangle(0, 10, inf)", "weight": "weight 1e-6"}, True),
            ({"a": "triangle(-inf, 0, 10, height=1e-5)", "b": "triangle(0, 10, inf)"}, True),
        ],
    )
    def test_the_file_is_for_pyfuzzylite_only_where_small_activations_decide(self, changes, said):
        assert head(two(**changes)) == ("# numerics of pyfuzzylite" if said else "Engine: two")

    def test_a_system_of_fuzzylite_stays_one(self):
        text = write(two())[0].partition("\n")[2]
        assert head(read("fll", text)) == "Engine: two"


class TestPlaces:
    @pytest.mark.parametrize(
        ("changes", "lost"),
        [
            ({"p": "ramp(2, 0)", "q": "ramp(2, 4)"}, []),
            ({"p": "ramp(2, 0)", "q": "ramp(2, 5)"}, ["places clamped"]),
            ({"p": "ramp(2, 0)", "q": "sigmoid(2, 5)"}, ["places clamped"]),
            ({"p": "ramp(2, 0, height=0.5)", "q": "ramp(2, 4)"}, ["places clamped"]),
        ],
    )
    def test_free_places_are_a_loss_only_where_one_may_leave_the_range(self, changes, lost):
        flat = {"a": "triangle(-inf, 0, 10)", "b": "triangle(0, 10, inf)"}
        _, losses = write(two(method="tsukamoto", **flat, **changes))
        assert [loss.what for loss in losses if not loss.exact] == lost

    def test_degrees_of_points_are_no_places(self):
        text = TWO.format(
            a="triangle(-inf, 0, 10)",
            b="triangle(0, 10, inf)",
            p="ramp(2, 1)",
            q="piecewise(2, 0, 4, 1)",
            method="tsukamoto",
        )
        _, losses = write(loads(text.replace("[0, 4]", "[1, 4]")))
        assert losses == []


def test_an_input_that_equals_a_number_is_a_triangle_without_sides():
    system = two(a="singleton(3)", b="ramp(0, 10)")
    text, losses = write(system)
    assert "  term: a Triangle 3 3 3\n" in text
    assert losses == []
    back = read("fll", text)
    for x in (2.9, 3.0, 3.1):
        assert back(x=x) == system(x=x)


FLAT = {"a": "triangle(-inf, 0, 10)", "b": "triangle(0, 10, inf)"}


class TestInvertedTerms:
    """fuzzylite inverts some kinds only, whatever their parameters; of others it takes the degree, or stops."""

    @pytest.mark.parametrize("method", ["tsukamoto", "tsukamoto_sum"])
    @pytest.mark.parametrize(
        ("term", "written"),
        [
            ("triangle(0, 4, inf)", "Ramp 0 4"),
            ("triangle(-inf, 0, 4)", "Ramp 4 0"),
            ("trapezoid(0, 3, 4, inf)", "Ramp 0 3"),
            ("trapezoid(-inf, 0, 1, 4)", "Ramp 4 1"),
            ("piecewise(0, 0, 4, 1)", "Ramp 0 4"),
            ("piecewise(0, 1, 4, 0)", "Ramp 4 0"),
            ("pi_shape(0, 3, 4, inf)", "SShape 0 3"),
            ("pi_shape(-inf, 0, 1, 4)", "ZShape 1 4"),
            ("triangle(0, 4, inf, height=0.5)", "Ramp 0 4 0.5"),
            ("concave(3, 4)", "Concave 3 4"),
        ],
    )
    def test_sides_that_rise_or_fall_once_are_kinds_that_it_inverts(self, term, written, method):
        system = as_profile(two(method=method, p=term, q="ramp(0, 4)", **FLAT), "pyfuzzylite")
        text, losses = write(system)
        assert [x for x in losses if not x.exact] == []
        assert f"  term: p {written}\n" in text
        back = read("fll", text)
        assert back.method.defuzzifier.kind == method
        for x in (1.0, 4.0, 5.0, 7.5, 9.0):
            assert back(x=x) == pytest.approx(system(x=x), rel=1e-14), x

    @pytest.mark.parametrize(
        "term",
        [
            "piecewise(0, 0, 2, 0.2, 4, 1)",
            "piecewise(0, 0.1, 4, 1)",
            "gaussian2(-inf, 1, 1, 1)",
            "gaussian2(3, 1, inf, 1)",
            "triangle(2, 2, inf)",
        ],
    )
    @pytest.mark.parametrize("format", ["fll", "fis", "fcl"])
    def test_others_are_refused_with_the_term(self, term, format):
        system = two(method="tsukamoto", p=term, q="ramp(0, 4)", **FLAT)
        if format == "fis":
            system = as_profile(system, "pyfuzzylite")
        with pytest.raises(DiagnosticError) as caught:
            convert(system, format)
        (found,) = caught.value.diagnostics
        assert found.code == "FZ608"
        kind = term.partition("(")[0]
        why = f"term 'p' of 'y' is of the kind '{kind}', which fuzzylite cannot invert as it can "
        assert found.facts[0] == f"{why}arc, concave, ramp, s_shape, sigmoid, z_shape"

    @pytest.mark.parametrize("format", ["fis", "fcl"])
    def test_degrees_of_monotone_terms_are_refused_where_the_terms_say_the_method(self, format):
        system = two(method="inverse_tsukamoto", p="ramp(4, 0)", q="ramp(0, 4)", **FLAT)
        with pytest.raises(DiagnosticError) as caught:
            convert(as_profile(system, "pyfuzzylite"), format)
        (found,) = caught.value.diagnostics
        why = "output 'y' has the defuzzifier 'inverse_tsukamoto', but fuzzylite inverts its terms"
        assert found.facts == (why,)
        assert convert(as_profile(system, "pyfuzzylite"), "fll").lossy == ()

    def test_tsukamoto_said_of_what_fuzzylite_cannot_invert_is_an_error_at_the_term(self):
        text = write(two(method="tsukamoto", p="ramp(4, 0)", q="ramp(0, 4)", **FLAT))[0]
        text = text.replace("term: p Ramp 4 0", "term: p Discrete 0 1 4 0")
        ((code, message, line),) = [(d.code, d.message, d.span.line) for d in errors("fll", text)]
        assert (code, text.splitlines()[line - 1].strip()) == ("FZ214", "term: p Discrete 0 1 4 0")
        assert message == "'WeightedAverage Tsukamoto' inverts terms, and fuzzylite cannot invert 'p'"


#: Conditions with `any`, behind which fuzzylite takes nothing, and what is written.
ANY = {
    "x is any a": "x is any",
    "x is very any a": "x is very any",
    "x is any very a": "x is any",
    "x is not any a": "x is not any",
    "not (x is any a)": "x is not any",
    "x is any a and x is b": "x is any and x is b",
}


@pytest.mark.parametrize("condition", ANY)
def test_nothing_stands_behind_any(condition):
    text = TWO.format(a="ramp(10, 0)", b="ramp(0, 10)", p="constant(1)", q="constant(3)", method="weighted_average")
    system = loads(text.replace("if x is a then", f"if {condition} then"))
    written = write(system)[0]
    assert f"rule: if {ANY[condition]} then y is p\n" in written
    back = read("fll", written)
    for x in (0.0, 2.5, 7.0, 10.0):
        assert back(x=x) == pytest.approx(system(x=x), rel=1e-12)


def test_the_normalized_sum_is_the_bounded_one():
    written = write(two())[0].replace("disjunction: Maximum", "disjunction: NormalizedSum")
    back = read("fll", written)
    assert back.method.disjunction == "bounded_sum"
    assert "disjunction: BoundedSum" in write(back)[0]


NAMED = """\
system t "a # title; here"
defuzzifier weighted_average
input round in [0, 10]
  round = ramp(10, 0)
  if = ramp(0, 10)
output with "in # per; cent" in [0, 4] else 2
  with = constant(1)
  q = constant(3)
if round is round then with is with
if round is if then with is q
"""


def test_what_rules_of_fuzzylite_take_for_their_own_words_is_no_name():
    text, losses = write(loads(NAMED))
    assert "rule: if round_ is round then with_ is with_\n" in text
    assert "rule: if round_ is if_ then with_ is q\n" in text
    reported = [x.what for x in losses if x.what.startswith("the name")]
    assert reported == ["the name 'round'", "the name 'with'", "the name 'if'", "the name 'with'"]


def test_descriptions_that_lose_a_sign_are_reported():
    text, losses = write(loads(NAMED))
    assert "  description: a title, here\n" in text
    assert "  description: in per, cent\n" in text
    assert {(x.where, x.what) for x in losses if "'#'" in x.why} == {
        ("system 't'", "the title"),
        ("output 'with_'", "the label"),
    }
    assert all(x.exact for x in losses)


FORMULA = """\
system one
defuzzifier weighted_average
input {0} in [0, 10]
  a = function(exp(-{0}^2))
output y in [0, 4] else 2
  p = constant(1)
if {0} is a then y is p
"""


@pytest.mark.parametrize("name", ["heat", "x"])
def test_formulas_of_an_input_call_it_x_since_fuzzylite_6_knows_no_other_name_of_it_there(name):
    text, _ = write(loads(FORMULA.format(name)))
    assert "  term: a Function exp((0 - (x ^ 2)))\n" in text


def test_they_keep_the_name_beside_a_variable_that_is_called_x():
    text = FORMULA.format("heat").replace("output y", "output x").replace("then y", "then x")
    assert "  term: a Function exp((0 - (heat ^ 2)))\n" in write(loads(text))[0]


def test_a_param_that_is_called_x_is_not_the_variable():
    text = FORMULA.format("heat").replace("input", "param x = 2\ninput", 1).replace("exp(-heat^2)", "x^(-heat)")
    assert "  term: a Function (2 ^ (0 - x))\n" in write(loads(text))[0]
