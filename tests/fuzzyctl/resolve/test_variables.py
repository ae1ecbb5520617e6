import math

import pytest

import fuzzyctl
from fuzzyctl.analysis.check import check_source
from fuzzyctl.diagnostics.diagnostic import DiagnosticError, ValueOutOfBoundsError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.fz import dumps
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.loading.load import loads


def errors(text):
    with pytest.raises(DiagnosticError) as error:
        loads(text)
    return [(d.code, d.span.line) for d in error.value.diagnostics]


def parameters(system, variable, term):
    return tuple(system.number(a) for a in variable.term(term).membership.arguments)


class TestTerms:
    def test_peaks_make_triangles_that_meet_at_each_other_with_shoulders_at_the_ends(self, changed):
        rows = [("       N  P\n", "       N  Z  P\n"), ("N |  N  Z", "N |  N  Z  Z"), ("Z |  N  P", "Z |  N  P  P")]
        system = loads(changed(("terms N@0 P@10", "terms N@0 Z@2 P@10"), *rows, ("P |  Z  P", "P |  Z  P  P")))
        y = system.input("y")
        assert [parameters(system, y, t) for t in "NZP"] == [(-math.inf, 0, 2), (0, 2, 10), (2, 10, math.inf)]

    def test_bare_names_are_spread_over_the_range(self, changed):
        system = loads(changed(("terms N@0 P@10", "terms N P")))
        assert parameters(system, system.input("y"), "P") == (0, 10, math.inf)

    def test_a_uniform_partition_of_a_symmetric_range_has_exactly_zero_in_the_middle(self):
        system = loads(
            "system s\ninput x in [-0.4, 0.4]\n  terms A B C D E F G\n"
            "output u in [0, 1]\n  terms A=0 B=0 C=0 D=0 E=0 F=0 G=0\n"
            "defuzzifier weighted_average\ntable u = x\n  A B C D E F G\n | A B C D E F G\n"
        )
        x = system.input("x")
        peaks = [parameters(system, x, t)[1] for t in "ABCDEFG"]
        assert peaks[3] == 0
        assert peaks == [-p for p in reversed(peaks)]
        assert peaks[0] == -0.4

    def test_parameters_may_be_named_and_computed_from_params(self, changed):
        text = changed(
            ("Z = triangle(-1, 0, 1)", "Z = triangle(right=k, left=-k, peak=0)"),
            ("\ninput x", "\nparam k = 2 / 2\ninput x"),
        )
        system = loads(text)
        assert parameters(system, system.input("x"), "Z") == (-1, 0, 1)

    @pytest.mark.parametrize(
        ("old", "new", "code", "line"),
        [
            ("Z = triangle(-1, 0, 1)", "Z = trinagle(-1, 0, 1)", "FZ202", 5),
            ("Z = triangle(-1, 0, 1)", "Z = triangle(-1, 0, 1, 2)", "FZ303", 5),
            ("Z = triangle(-1, 0, 1)", "Z = triangle(-1, 0, top=1)", "FZ303", 5),
            ("Z = triangle(-1, 0, 1)", "Z = triangle(left=-1, 0, 1)", "FZ303", 5),
            ("Z = triangle(-1, 0, 1)", "Z = triangle(-1, 0, left=1)", "FZ303", 5),
            ("Z = triangle(-1, 0, 1)", "Z = triangle(-1, 0, k)", "FZ202", 5),
            ("Z = triangle(-1, 0, 1)", "Z = triangle(-1, 0, sine(1))", "FZ202", 5),
            ("Z = triangle(-1, 0, 1)", "Z = triangle(-1, 0, atan2(1))", "FZ303", 5),
            ("Z = triangle(-1, 0, 1)", "Z = triangle(-1, inf, inf)", "FZ302", 5),
            ("Z = triangle(-1, 0, 1)", "N = triangle(-1, 0, 1)", "FZ201", 5),
            ("Z = triangle(-1, 0, 1)", "not = triangle(-1, 0, 1)", "FZ201", 5),
            ("terms N@0 P@10", "terms N@0 P", "FZ214", 9),
            ("terms N@0 P@10", "terms N@10 P@0", "FZ301", 9),
            ("input y in [0, 10]", "input min in [0, 10]", "FZ201", 8),
        ],
    )
    def test_mistakes_are_found_at_their_line(self, changed, old, new, code, line):
        assert (code, line) in errors(changed((old, new)))


class TestLookAlikes:
    def test_a_letter_of_another_alphabet_is_named(self, changed):
        with pytest.raises(DiagnosticError, match=r"U\+0420 \(CYRILLIC CAPITAL LETTER ER\)"):
            loads(changed(("Z |  N  P", "Z |  N  Р")))
        with pytest.raises(DiagnosticError, match=r"U\+0430"):
            loads(changed(("\ninput x", "\npаram k = 1\ninput x")))


class TestClauses:
    @pytest.mark.parametrize(
        ("clause", "value"),
        [("else 0.5", 0.5), ("else (1 / 4)", 0.25), ("else midpoint", "midpoint"), ("else nan", "nan")],
    )
    def test_an_output_says_what_it_is_where_no_rule_fires(self, changed, clause, value):
        output = loads(changed(("[-2, 2]", f"[-2, 2] {clause}"))).outputs[0]
        system = loads(changed(("[-2, 2]", f"[-2, 2] {clause}")))
        found = output.otherwise if isinstance(value, str) else system.number(output.otherwise)
        assert found == value

    @pytest.mark.parametrize(
        ("old", "new", "code"),
        [
            ('unit "m"', "else 3", "FZ214"),
            ('unit "m"', "adaptive rate x", "FZ214"),
            ("[-2, 2]", "[-2, 2] extrapolate", "FZ214"),
            ("[-2, 2]", "[-2, 2] else holt", "FZ213"),
            ("[-2, 2]", "[-2, 2] else hold(z)", "FZ202"),
            ("[-2, 2]", "[-2, 2] else hold(inf)", "FZ302"),
            ("[-2, 2]", "[-2, 2] else hold()", "FZ102"),
            ("[-2, 2]", "[-2, 2] else k", "FZ213"),
            ("[-2, 2]", "[-2, 2] else 1 else 2", "FZ215"),
            ("[-2, 2]", "[2, -2]", "FZ304"),
            ("[-2, 2]", "[-inf, 2]", "FZ302"),
            ("[-2, 2]", "[-2, z]", "FZ202"),
        ],
    )
    def test_misplaced_clauses_are_found(self, changed, old, new, code):
        assert [c for c, _ in errors(changed((old, new)))] == [code]


BARE = """system s
defuzzifier weighted_average
input x in [0, 1]
  all = trapezoid(-1, 0, 1, 2)
input k in [0, 9]
output y in [0, 9]
  f = {f}
if x is all then y is f
"""


class TestBareInputs:
    def test_an_input_that_only_a_function_reads_needs_no_terms(self):
        assert loads(BARE.format(f="linear(1, 2, 3)"))(x=0.5, k=2) == 7.5
        system = loads(BARE.format(f="function(x * k)"))
        assert system(x=0.5, k=2) == 1.0
        assert loads(dumps(system)) == system

    def test_an_input_that_nothing_can_read_has_its_terms_missing(self):
        with pytest.raises(DiagnosticError, match="input 'k' has no terms"):
            loads(BARE.format(f="constant(1)"))


class TestUnknownMembershipFunctions:
    """The form is printed, and how the order of another tool differs: its numbers would read as others here."""

    @pytest.mark.parametrize(
        ("term", "kind", "order"),
        [
            ("gaussmf(2)", "gaussian", "MATLAB writes gaussmf(sigma, mean)"),
            ("gaussmf(2, 5, 7)", "gaussian", "MATLAB writes gaussmf(sigma, mean)"),
            ("gausmf(2, 5)", "gaussian", "MATLAB writes gaussmf(sigma, mean)"),
            ("guassmf(2, 5)", "gaussian", "MATLAB writes gaussmf(sigma, mean)"),
            ("gaussianmf(2, 5)", "gaussian", "MATLAB writes gaussmf(sigma, mean)"),
            ("gauss2(1, 2, 1, 5)", "gaussian2", "MATLAB writes gauss2mf(sigma_left, mean_left, "),
            ("gaussian2mf(1, 2, 1, 5)", "gaussian2", "MATLAB writes gauss2mf(sigma_left, mean_left, "),
            ("sigmoidmf(5, 2)", "sigmoid", "MATLAB writes sigmf(slope, inflection)"),
            ("sigmoid_mf(5, 2)", "sigmoid", "MATLAB writes sigmf(slope, inflection)"),
            ("sig(5, 2)", "sigmoid", "FCL writes sigm(slope, inflection)"),
            ("gbelmf(2, 4, 6)", "bell", "MATLAB writes gbellmf(width, slope, center)"),
            ("bellmf(2, 4, 6)", "bell", "MATLAB writes gbellmf(width, slope, center)"),
            ("dsigmf(5, 2, 5)", "sigmoid_difference", "MATLAB writes dsigmf(rising, left, falling, right)"),
            ("dsigm(5, 2, 5, 7)", "sigmoid_difference", "MATLAB writes dsigmf(rising, left, falling, right)"),
            ("psigm(5, 2, 5, 7)", "sigmoid_product", "MATLAB writes psigmf(rising, left, falling, right)"),
            ("linzm(5, 2)", "ramp", "MATLAB writes linzmf(end, start)"),
        ],
    )
    def test_of_another_order_say_so(self, term, kind, order):
        found = unknown_kind(term)
        form = f"{kind}({', '.join(MEMBERSHIP[kind].parameters)})"
        assert found.help == f"did you mean '{kind}'? the form is: {form}"
        assert found.facts[1].startswith(order)
        assert found.facts[1].endswith(f", here it is {form}: the order differs")

    @pytest.mark.parametrize(
        ("term", "form"),
        [
            ("trinagle(0, 5, 10)", "triangle(left, peak, right)"),
            ("trimf(1, 2)", "triangle(left, peak, right)"),
            ("linsm(1, 2)", "ramp(start, end)"),
            ("pisewise(0, 0, 1, 1)", "piecewise(x1, y1, ...)"),
        ],
    )
    def test_of_the_same_order_have_their_form_only(self, term, form):
        found = unknown_kind(term)
        assert found.help == f"did you mean '{form.partition('(')[0]}'? the form is: {form}"
        assert len(found.facts) == 1


def unknown_kind(term):
    """What is reported of a term."""
    text = f"system t\ninput x in [0, 10]\n  a = {term}\noutput y in [0, 1] else 0\n  b = triangle(0, 1, 1)\n"
    found = check_source(SourceText("t.fz", text))[1]
    return next(d for d in found if d.message.startswith("no membership function"))


class TestRangesOfParams:
    TEXT = (
        "system s\nand product\ndefuzzifier center_average\nparam top = 2\nparam k in [0.1, top] = {value}\n"
        "input x in [-1, 1]\n  terms N P\noutput u in [-1, 1]\n  N = constant(-k)\n  P = constant(k)\n"
        "table u = x\n   N P\n | N P\n"
    )

    @pytest.mark.parametrize(
        ("value", "message"), [("0", "0, outside of [0.1, 2]"), ("2 * top", "4, outside of [0.1, 2]")]
    )
    def test_a_value_outside_is_a_mistake(self, value, message):
        with pytest.raises(DiagnosticError) as caught:
            fuzzyctl.loads(self.TEXT.format(value=value))
        (error,) = caught.value.diagnostics
        assert (error.code, error.span.text) == ("FZ302", value)
        assert error.message == f"param 'k' is {message}"

    def test_a_value_given_later_is_checked_too(self):
        system = fuzzyctl.loads(self.TEXT.format(value="1"))
        assert fuzzyctl.loads(fuzzyctl.dumps(system)) == system
        assert system.with_params(k=2).values["k"] == 2.0
        with pytest.raises(DiagnosticError, match="outside of"):
            system.with_params(k=3)
        with pytest.raises(ValueOutOfBoundsError, match=r"in \[0.1, 2\]"):
            fuzzyctl.compile(system, "python", free=["k"]).batch([[0.0]], [3.0])

    def test_an_empty_range_is_a_mistake(self):
        with pytest.raises(DiagnosticError, match="the range of 'k' is empty"):
            fuzzyctl.loads(self.TEXT.format(value="1").replace("[0.1, top]", "[top, 0.1]"))
