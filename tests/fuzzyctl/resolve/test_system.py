import pytest

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import examine, loads


def errors(text):
    with pytest.raises(DiagnosticError) as error:
        loads(text)
    return [d.code for d in error.value.diagnostics]


class TestMethod:
    def test_the_defaults_are_those_of_the_exact_profile(self, base):
        method = loads(base).method
        assert (method.conjunction, method.disjunction, method.implication, method.aggregation) == (
            "min",
            "max",
            "min",
            "max",
        )
        assert (method.defuzzifier.kind, method.defuzzifier.resolution) == ("centroid", None)

    def test_settings_are_read(self, changed):
        text = "and product\nor probabilistic_sum\nimplication product\naggregation sum\n"
        text += "defuzzifier centroid(resolution=50)\n"
        method = loads(changed(("\ninput x", f"\n{text}input x"))).method
        assert (method.conjunction, method.aggregation, method.defuzzifier.resolution) == ("product", "sum", 50)

    @pytest.mark.parametrize(
        ("setting", "code"),
        [
            ("and prod", "FZ213"),
            ("and min(resolution=3)", "FZ213"),
            ("defuzzifier centroid(resolution=1)", "FZ302"),
            ("defuzzifier centroid(resolution=5000000)", "FZ302"),
            ("defuzzifier centroid(resolution=10, grid=right)", "FZ213"),
            ("defuzzifier centroid(grid=midpoint)", "FZ214"),
            ("defuzzifier centroid(samples=10)", "FZ213"),
            ("defuzzifier center_average(resolution=10)", "FZ213"),
        ],
    )
    def test_bad_settings_are_diagnosed(self, changed, setting, code):
        assert errors(changed(("\ninput x", f"\n{setting}\ninput x"))) == [code]

    def test_implication_beside_an_average_is_a_warning(self, changed):
        text = changed(("\ninput x", "\nimplication product\ndefuzzifier center_average\ninput x"))
        _, diagnostics = examine(SourceText("t", text))
        assert [(d.code, d.severity) for d in diagnostics] == [("FZ214", "warning")]


class TestWhole:
    def test_one_of_several_systems_must_be_named(self, base):
        text = base + base.replace("system base", "system other")
        with pytest.raises(DiagnosticError, match="systems: base, other"):
            loads(text)
        assert loads(text, block="other").name == "other"
        with pytest.raises(DiagnosticError, match="did you mean 'other'"):
            loads(text, block="othr")

    def test_a_file_without_rules_says_so(self):
        assert errors("system s\ninput x in [0, 1]\n  terms A B\noutput u in [0, 1]\n  terms A B\n") == ["FZ212"]

    def test_version_one_is_read(self, base):
        assert loads("fz 1\n" + base) == loads(base)

    def test_citations_join(self, changed):
        assert loads(changed(("\ninput x", '\nsource "a"\nsource "b"\ninput x'))).citation == "a; b"

    def test_20_000_rules_are_the_most(self, changed):
        text = changed(after="if x is N then u is N\n" * 20_000)
        assert errors(text) == ["FZ112"]
