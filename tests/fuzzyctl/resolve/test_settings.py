import pytest

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import Name, Number
from fuzzyctl.formats.fz import dumps
from fuzzyctl.loading.load import examine, loads
from fuzzyctl.model.method import Activation, Defuzzifier
from fuzzyctl.model.profiles import PROFILES
from fuzzyctl.model.variable import Hold


def errors(text):
    with pytest.raises(DiagnosticError) as error:
        loads(text)
    return [d.code for d in error.value.diagnostics]


def with_settings(changed, *lines):
    return changed(("\ninput x", "\n" + "\n".join(lines) + "\ninput x"))


class TestActivation:
    @pytest.mark.parametrize(
        ("line", "activation"),
        [
            ("activation general", Activation()),
            ("activation first(count=2, threshold=0.1)", Activation(kind="first", count=2, threshold=Number(0.1))),
            ("activation highest(count=1)", Activation(kind="highest", count=1)),
            ("activation proportional", Activation(kind="proportional")),
            ("activation threshold(>= 0.5)", Activation(kind="threshold", comparison=">=", threshold=Number(0.5))),
        ],
    )
    def test_methods_are_read(self, changed, line, activation):
        text = with_settings(changed, line).replace("[-2, 2]", "[-2, 2] else 0")
        assert loads(text).method.activation == activation

    @pytest.mark.parametrize(
        ("line", "code"),
        [
            ("activation hihgest(count=1)", "FZ213"),
            ("activation highest", "FZ303"),
            ("activation highest(threshold=1)", "FZ213"),
            ("activation highest(count=0)", "FZ302"),
            ("activation highest(count=1.5)", "FZ302"),
            ("activation threshold(0.5)", "FZ102"),
            ("activation threshold(>= q)", "FZ102"),
            ("activation general\nactivation general", "FZ215"),
        ],
    )
    def test_mistakes_are_found(self, changed, line, code):
        assert code in errors(with_settings(changed, line))


class TestSemantics:
    def test_exact_changes_nothing(self, changed):
        assert loads(with_settings(changed, "semantics exact")) == loads(changed())

    def test_a_profile_sets_the_knobs_and_what_a_defuzzifier_is_without_options(self, changed):
        method = loads(with_settings(changed, "semantics fuzzylite\ndefuzzifier centroid")).method
        assert method.semantics == PROFILES["fuzzylite"].semantics
        assert method.defuzzifier == Defuzzifier(kind="centroid", resolution=1000, grid="midpoint", rule="plain")

    def test_what_is_said_overrides_the_profile(self, changed):
        text = "semantics matlab(weight=after, least=1e-6)\ndefuzzifier centroid(resolution=201)"
        method = loads(with_settings(changed, text)).method
        assert (method.semantics.weight, method.semantics.least, method.semantics.merge) == ("after", 1e-6, "rules")
        assert (method.defuzzifier.resolution, method.defuzzifier.grid) == (201, "endpoints")
        own = loads(with_settings(changed, "semantics matlab\ndefuzzifier centroid(resolution=exact)")).method
        assert own.defuzzifier == Defuzzifier()

    def test_it_says_what_an_output_is_where_no_rule_fires(self, changed):
        assert loads(with_settings(changed, "semantics matlab")).outputs[0].otherwise == "midpoint"
        assert loads(with_settings(changed, "semantics jfuzzylogic")).outputs[0].otherwise == Hold(start="nan")
        assert loads(with_settings(changed, "semantics jfuzzylogic")).method.aggregation == "sum"

    @pytest.mark.parametrize(
        ("text", "code"),
        [
            ("matlap", "FZ213"),
            ("matlab(wieght=after)", "FZ213"),
            ("matlab(weight=afer)", "FZ213"),
            ("matlab(weight=1)", "FZ213"),
            ("matlab(least=2)", "FZ302"),
            ("matlab(least=nan)", "FZ302"),
            ("matlab(equal=none)", "FZ302"),
            ("matlab(least=0, least=0)", "FZ215"),
            ("matlab\nsemantics exact", "FZ215"),
        ],
    )
    def test_what_no_profile_and_no_knob_is(self, changed, text, code):
        assert errors(with_settings(changed, f"semantics {text}")) == [code]

    def test_an_aggregation_that_joins_rules_has_an_effect(self, changed):
        for semantics, idle in (("exact", 1), ("pyfuzzylite", 0)):
            text = with_settings(changed, f"semantics {semantics}", "aggregation sum", "defuzzifier center_average")
            _, found = examine(SourceText("a", text))
            assert sum("'aggregation' has no effect" in d.message for d in found) == idle

    @pytest.mark.parametrize("name", PROFILES)
    def test_every_profile_prints_and_reads_back(self, changed, name):
        own = "fuzzylite(least=none, equal=0.25, total=strengths)" if name == "fuzzylite" else name
        text = f"semantics {own}\ndefuzzifier centroid(resolution=77, grid=endpoints)"
        for form in (text, f"semantics {own}", f"semantics {own}\ndefuzzifier centroid(resolution=exact)"):
            system = loads(with_settings(changed, form))
            assert loads(dumps(system)) == system


class TestOwnSettings:
    def test_an_output_may_have_its_own_method(self, changed):
        output = loads(changed(("[-2, 2]", "[-2, 2] aggregation sum defuzzifier centroid(resolution=50)"))).outputs[0]
        assert output.aggregation == "sum"
        assert output.defuzzifier == Defuzzifier(kind="centroid", resolution=50)

    def test_only_an_output(self, changed):
        assert errors(changed(('unit "m"', "implication min"))) == ["FZ214"]
        assert errors(changed(("[-2, 2]", "[-2, 2] aggregation max aggregation sum"))) == ["FZ215"]
        assert errors(changed(("[-2, 2]", "[-2, 2] defuzzifier centriod"))) == ["FZ213"]

    def test_exact_maxima_need_norms_that_have_them(self, changed):
        assert errors(changed(("[-2, 2]", "[-2, 2] aggregation probabilistic_sum defuzzifier mom"))) == ["FZ214"]
        sampled = "[-2, 2] aggregation probabilistic_sum defuzzifier mom(resolution=50)"
        assert loads(changed(("[-2, 2]", sampled))) is not None
        assert loads(changed(("[-2, 2]", "[-2, 2] aggregation probabilistic_sum"))) is not None

    @pytest.mark.parametrize(
        ("text", "defuzzifier"),
        [
            ("bisector", Defuzzifier(kind="bisector")),
            (
                "bisector(resolution=101, grid=endpoints, rule=first)",
                Defuzzifier(kind="bisector", resolution=101, grid="endpoints", rule="first"),
            ),
            ("centroid(resolution=9, rule=trapezoid)", Defuzzifier(resolution=9, rule="trapezoid")),
            ("som(by=magnitude)", Defuzzifier(kind="som", by="magnitude")),
            (
                "mom(resolution=7, grid=left, tolerance=1e-9)",
                Defuzzifier(kind="mom", resolution=7, grid="left", tolerance=1e-9),
            ),
            (
                "som(resolution=9, rule=running, tolerance=1e-6)",
                Defuzzifier(kind="som", resolution=9, rule="running", tolerance=1e-6),
            ),
            (
                "bisector(resolution=9, rule=between, tolerance=1e-6)",
                Defuzzifier(kind="bisector", resolution=9, rule="between", tolerance=1e-6),
            ),
            ("inverse_tsukamoto_sum", Defuzzifier(kind="inverse_tsukamoto_sum")),
        ],
    )
    def test_options_of_defuzzifiers_are_read_and_written(self, changed, text, defuzzifier):
        system = loads(with_settings(changed, f"defuzzifier {text}"))
        assert system.method.defuzzifier == defuzzifier
        assert loads(dumps(system)).method.defuzzifier == defuzzifier

    @pytest.mark.parametrize(
        ("text", "code"),
        [
            ("bisector(rule=first)", "FZ214"),
            ("bisector(grid=left)", "FZ214"),
            ("bisector(resolution=10, rule=plain)", "FZ213"),
            ("centroid(resolution=10, by=value)", "FZ213"),
            ("mom(resolution=10, by=value)", "FZ213"),
            ("som(by=size)", "FZ213"),
            ("mom(rule=running)", "FZ214"),
            ("som(resolution=9, rule=running, by=magnitude)", "FZ214"),
            ("bisector(resolution=9, tolerance=0.1)", "FZ214"),
            ("som(resolution=9, rule=first)", "FZ213"),
            ("mom(tolerance=1)", "FZ302"),
            ("mom(tolerance=much)", "FZ302"),
            ("mom(resolution=1)", "FZ302"),
            ("mom(resolution=10, resolution=11)", "FZ215"),
            ("tsukamoto_sum(resolution=10)", "FZ213"),
        ],
    )
    def test_mistakes_in_options_are_found(self, changed, text, code):
        assert code in errors(with_settings(changed, f"defuzzifier {text}"))


class TestHedges:
    def test_a_hedge_of_ones_own_changes_a_degree(self, changed):
        text = with_settings(changed, "defuzzifier center_average", "param p = 3", "hedge cubed(z) = z^p")
        text += "if x is cubed Z then u is P\nif x is not very Z then u is N\n"
        system = loads(text)
        rule = system.rules[-1]
        assert rule.antecedent.hedges == ("not", "very")
        assert system.hedges[0].expression.right == Name("p")

    @pytest.mark.parametrize(
        ("lines", "after", "code"),
        [
            (["hedge very(x) = x^2"], "", "FZ201"),
            (["hedge h(z) = z", "hedge h(z) = z"], "if x is h Z then u is P\n", "FZ201"),
            (["hedge h(z) = z + q"], "if x is h Z then u is P\n", "FZ202"),
            ([], "if x is vry Z then u is P\n", "FZ202"),
            ([], "if x is very not then u is P\n", "FZ102"),
        ],
    )
    def test_mistakes_are_found(self, changed, lines, after, code):
        assert code in errors(with_settings(changed, *lines, "and min") + after)


class TestTakagiSugeno:
    BASE = (
        "system s\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms L H\ninput y in [0, 10]\n  terms L H\n"
        "output u in [-9, 99]\n  A = linear(1, 2, 3)\n  B = function(x * y - 1)\n  C = constant(5)\n"
    )

    def test_consequents_are_functions_of_the_inputs(self):
        system = loads(
            self.BASE
            + "table u = x x y\n     L  H\n L | A  B\n H | C  0.5\nif x is L and y is L then u is linear(0, 1, 0)\n"
        )
        x, y = 0.25, 4.0
        w = {"LL": 0.75 * 0.6, "LH": 0.75 * 0.4, "HL": 0.25 * 0.6, "HH": 0.25 * 0.4}
        w = {k: min(0.75 if k[0] == "L" else 0.25, 0.6 if k[1] == "L" else 0.4) for k in w}
        values = [(w["LL"], x + 2 * y + 3), (w["LH"], x * y - 1), (w["HL"], 5), (w["HH"], 0.5), (w["LL"], y)]
        expected = sum(a * z for a, z in values) / sum(a for a, _ in values)
        assert system(x=x, y=y) == pytest.approx(expected, rel=1e-14)

    @pytest.mark.parametrize(
        ("old", "new", "code"),
        [
            ("linear(1, 2, 3)", "linear(1, 2)", "FZ303"),
            ("function(x * y - 1)", "function(x * z)", "FZ202"),
            ("function(x * y - 1)", "function(x, y)", "FZ303"),
            ("defuzzifier weighted_average\n", "", "FZ214"),
            ("weighted_average", "tsukamoto", "FZ214"),
        ],
    )
    def test_mistakes_are_found(self, old, new, code):
        text = self.BASE.replace(old, new) + "if x is L then u is A\nif x is H then u is B\nif y is L then u is C\n"
        assert code in errors(text)


class TestOutputsInAntecedents:
    def test_a_later_rule_reads_the_crisp_value(self):
        system = loads(
            "system s\ndefuzzifier weighted_average\ninput x in [0, 1]\n  terms L H\n"
            "output mid in [0, 2]\n  L = triangle(-inf, 0, 2)\n  H = triangle(0, 2, inf)\n"
            "output u in [0, 10]\n  terms A=0 B=10\n"
            "if x is L then mid is L\nif x is H then mid is H\nif mid is L then u is A\nif mid is H then u is B\n"
        )
        result = system(x=0.25)
        assert result == {"mid": 0.5, "u": 2.5}


class TestTsukamoto:
    def test_monotone_consequents_are_inverted(self):
        system = loads(
            "system s\ndefuzzifier tsukamoto\ninput x in [0, 1]\n  terms L H\n"
            "output u in [0, 10]\n  A = ramp(10, 0)\n  B = ramp(0, 10)\nif x is L then u is A\nif x is H then u is B\n"
        )
        # At x = 0.3: A fires with 0.7, inverse 3; B with 0.3, inverse 3.
        assert system(x=0.3) == pytest.approx(3.0, rel=1e-14)


class TestSlicedTables:
    def test_a_condition_joins_each_rule(self):
        system = loads(
            "system s\ndefuzzifier weighted_average\n"
            "input m in [0, 1]\n  terms slow fast\ninput x in [0, 1]\n  terms L H\n"
            "output u in [0, 10]\n  terms A=0 B=10\n"
            "with m is slow\ntable u = x\n  L H\n | A B\nwith m is fast\ntable u = x\n  L H\n | B A\n"
        )
        assert [system(m=0.0, x=1.0), system(m=1.0, x=1.0)] == [10.0, 0.0]


HYBRID = """
system hybrid
{settings}
defuzzifier {defuzzifier}
input e in [-1, 1]
  terms N P
output u in [0, 1] {of_u}
  a = constant(0)
  b = constant(1)
output v in [0, 1] {of_v}
  terms lo hi
table u, v = e
     N     P
  |  a/lo  b/hi
"""


class TestIdleSettings:
    """Settings that no output heeds are warned of, and only those."""

    def idle(self, settings="", defuzzifier="weighted_average", of_u="", of_v="defuzzifier centroid"):
        text = HYBRID.format(settings=settings, defuzzifier=defuzzifier, of_u=of_u, of_v=of_v)
        found = examine(SourceText("t", text))[1]
        assert {d.code for d in found} <= {"FZ214"}
        return [(d.span.line, d.message.split("'")[1]) for d in found]

    def test_one_output_that_heeds_them_is_enough(self):
        assert self.idle("implication product\naggregation sum") == []

    def test_none_that_does(self):
        of_v = ""
        assert self.idle("implication product\naggregation sum", of_v=of_v) == [(3, "implication"), (4, "aggregation")]

    def test_none_that_has_not_its_own(self):
        assert self.idle("implication product", of_v="defuzzifier centroid implication min") == [(3, "implication")]

    def test_those_of_an_output_that_sums_over_rules(self):
        assert self.idle(of_u="implication product aggregation sum") == [(7, "implication"), (7, "aggregation")]
