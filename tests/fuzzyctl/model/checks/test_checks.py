import pytest

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import examine, loads
from fuzzyctl.model.checks.checks import CHECKS, HINTS, check_model
from fuzzyctl.model.checks.parameters import VALUE_CHECKS
from fuzzyctl.model.checks.terms import SHAPE_CHECKS, SHAPE_HINTS
from tests.shipped import SYSTEMS


def found(text):
    return [(d.code, d.severity) for d in examine(SourceText("t", text))[1]]


class TestChecks:
    def test_the_base_text_is_clean(self, base):
        assert check_model(loads(base)) == []

    @pytest.mark.parametrize("path", SYSTEMS, ids=lambda p: p.name)
    def test_shipped_files_are_clean(self, path):
        assert found(path.read_text(encoding="utf-8")) == []

    def test_every_check_is_named_once(self):
        checks = (*CHECKS, *HINTS, *VALUE_CHECKS, *SHAPE_CHECKS, *SHAPE_HINTS)
        assert len({c.__name__ for c in checks}) == len(checks)

    def test_hints_are_warnings_and_loading_does_without_them(self, changed):
        text = changed(("\ninput x", "\nparam k = 1\ninput x"), after="if x is N and y is N then u is P\n")
        system = loads(text)
        hints = [d for check in HINTS for d in check(system)]
        assert sorted({d.code for d in hints}) == ["FZ209", "FZ216"]
        assert {d.severity for d in hints} == {"warning"}
        with pytest.raises(DiagnosticError, match="FZ216"):
            loads(text + "deny FZ216\n")

    def test_hints_about_shapes_are_looked_for_where_they_are_asked_for(self, changed):
        text = changed(("Z = triangle(-2, 0, 2)", "Z = triangle(-2, 9, 12)"))
        assert {d.severity for d in check_model(loads(text))} == {"warning"}
        assert check_model(loads(text), hints=False) == []
        with pytest.raises(DiagnosticError, match="FZ306"):
            loads(text + "deny FZ306\n")

    def test_maxima_of_curved_terms_may_have_no_closed_form(self, changed):
        curved = ("Z = triangle(-2, 0, 2)", "Z = sigmoid_product(-1, 2, -2, 1)")
        for kind in ("som", "lom", "mom"):
            assert found(changed(curved, ("\ninput x", f"\ndefuzzifier {kind}\ninput x"))) == [("FZ214", "error")]
            sampled = ("\ninput x", f"\ndefuzzifier {kind}(resolution=100)\ninput x")
            assert found(changed(curved, sampled)) == []
        for kind in ("centroid", "bisector"):
            assert found(changed(curved, ("\ninput x", f"\ndefuzzifier {kind}\ninput x"))) == []
        assert found(changed(curved, ("\ninput x", "\ndefuzzifier center_average\ninput x"))) == []

    @pytest.mark.parametrize(
        ("defuzzifier", "term", "reason"),
        [
            ("tsukamoto", "function(u * u)", "is a formula whose inverse 'tsukamoto' does not know"),
            ("tsukamoto", "function(x)", "is no set, and 'tsukamoto' inverts sets"),
            ("tsukamoto", "linear(1, 1, 1)", "is no set, and 'tsukamoto' inverts sets"),
            ("tsukamoto", "triangle(-2, 0, 2)", "is not monotone, so 'tsukamoto' cannot invert it"),
            ("inverse_tsukamoto", "function(u)", "is a formula, and 'inverse_tsukamoto' takes its degrees"),
        ],
    )
    def test_why_tsukamoto_does_not_take_a_term(self, changed, defuzzifier, term, reason):
        text = changed(
            ("\ninput x", f"\ndefuzzifier {defuzzifier}\ninput x"),
            ("N = triangle(-3, -2, 0)", "N = ramp(0, -2)"),
            ("Z = triangle(-2, 0, 2)", f"Z = {term}"),
            ("P = triangle(0, 2, 3)", "P = ramp(0, 2)"),
        )
        (only,) = examine(SourceText("t", text))[1]
        assert only.message == f"term 'Z' of 'u' {reason}"

    def test_a_singleton_has_no_centroid(self, changed):
        assert found(changed(("Z = triangle(-2, 0, 2)", "Z = singleton(0)"))) == [("FZ214", "error")]

    def test_an_adaptive_output_needs_an_average(self, changed):
        adaptive = ("[-2, 2]", "[-2, 2] adaptive rate x")
        assert found(changed(adaptive)) == [("FZ214", "error")]
        assert found(changed(adaptive, ("Z = triangle(-2, 0, 2)", "Z = singleton(0)"))) == [("FZ214", "error")]
        average = ("\ninput x", "\ndefuzzifier weighted_average\ninput x")
        assert found(changed(adaptive, average)) == []
        other = ("table u", "output v in [0, 1] else 0\n  A = singleton(0)\n\ntable u")
        assert found(changed(adaptive, average, other, after="if x is N then v is A\n")) == []

    def test_initial_consequents_lie_in_the_range(self, changed):
        text = changed(("[-2, 2]", "[-1, 2] adaptive rate x"), ("\ninput x", "\ndefuzzifier weighted_average\ninput x"))
        assert found(text) == [("FZ302", "error")]

    def test_the_order_of_operands_does_not_hide_a_second_rule(self, changed):
        assert found(changed(after="if y is N and x is N then u is N\n")) == [("FZ209", "warning")]

    def test_terms_from_high_to_low_are_no_slip(self, changed):
        text = changed(
            (
                "  N = triangle(-inf, -1, 0)\n  Z = triangle(-1, 0, 1)\n  P = triangle(0, 1, inf)\n",
                "  P = triangle(0, 1, inf)\n  Z = triangle(-1, 0, 1)\n  N = triangle(-inf, -1, 0)\n",
            )
        )
        assert found(text) == []

    def test_a_sigmoid_has_no_peak_to_average(self, changed):
        sigmoid = ("Z = triangle(-2, 0, 2)", "Z = sigmoid(0, 2)")
        assert found(changed(sigmoid, ("\ninput x", "\ndefuzzifier center_average\ninput x"))) == [("FZ214", "error")]
        assert found(changed(("Z = triangle(-1, 0, 1)", "Z = sigmoid(0, 2)"))) == []

    def test_one_bad_number_gives_one_diagnostic(self, changed):
        assert found(changed(("Z = triangle(-2, 0, 2)", "Z = triangle(-2, 1 / 0, 2)"))) == [("FZ307", "error")]

    @pytest.mark.parametrize(
        ("old", "new", "code"),
        [
            ("terms N@0 P@10", "terms N@10 P@0", "FZ301"),
            ('[0, 10] unit "m"\n  terms N@0 P@10', "[0, inf]\n  terms N P", "FZ302"),
            ("[-2, 2]", "[2, -2]", "FZ304"),
            ("[-2, 2]", "[-1.7e308, 1.7e308]", "FZ304"),
            ('[0, 10] unit "m"\n  terms N@0 P@10', "[9, 1]\n  terms N P", "FZ304"),
        ],
    )
    def test_one_slip_in_a_partition_gives_one_diagnostic(self, changed, old, new, code):
        assert found(changed((old, new))) == [(code, "error")]

    @pytest.mark.parametrize("peaks", ["triangle(-inf, -inf, 0)", "trapezoid(-1, 0, inf, inf)", "triangle(inf, 0, 1)"])
    def test_infinite_peaks_are_refused(self, changed, peaks):
        codes = [c for c, _ in found(changed(("Z = triangle(-1, 0, 1)", f"Z = {peaks}")))]
        assert len(codes) == 1
        assert codes[0] in ("FZ301", "FZ302")
