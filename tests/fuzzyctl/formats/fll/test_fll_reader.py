"""`.fll` files as fuzzylite and pyfuzzylite write them, and as people break them."""

import math
from pathlib import Path

import pytest

from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.expr import ONE, Number, evaluate
from fuzzyctl.formats.common.report import ParseError
from fuzzyctl.formats.fll import read
from fuzzyctl.formats.fll.formulas import read_formula
from fuzzyctl.loading.load import load
from fuzzyctl.model.method import Activation, Defuzzifier
from fuzzyctl.model.profiles import profile
from fuzzyctl.model.rule import And, Is, Or
from fuzzyctl.model.variable import Hold
from tests.fuzzyctl.formats.fll.small import SMALL, changed, rule, said, system

#: What a rule block may say itself.
OF_BLOCKS = ("conjunction", "disjunction", "implication", "activation")

SAMPLES = Path(__file__).parent.parent / "samples"
TIPPER = (SAMPLES / "tipper.fll").read_text(encoding="utf-8")
ALL_TERMS = (SAMPLES / "all_terms.fll").read_text(encoding="utf-8")

OF_NUMBERS = "term: low Constant 1.0\n  term: high Constant 0.0\n"


class TestEngines:
    def test_a_file_is_what_fuzzylite_makes_of_it(self):
        found = system(TIPPER)
        assert (found.name, found.title) == ("tipper", "(service and food) -> (tip)")
        assert [(v.name, v.label, v.extrapolate) for v in found.inputs] == [
            ("service", "quality of service", False),
            ("food", "", True),
        ]
        assert found.method.semantics == profile("fuzzylite").semantics
        assert (found.method.conjunction, found.method.disjunction) == ("product", "probabilistic_sum")
        first, second = found.outputs
        assert found.method.defuzzifier == Defuzzifier(resolution=200, rule="plain")
        assert (first.otherwise, first.clamped) == (Hold(start="nan"), False)
        assert (second.otherwise, second.clamped, second.aggregation) == (Number(15.0), True, "sum")
        assert second.defuzzifier.kind == "weighted_average"
        assert len(found.rules) == 6

    def test_old_spellings_have_the_numerics_of_old_versions(self):
        found = system((SAMPLES / "old.fll").read_text(encoding="utf-8"))
        assert found.method.semantics == profile("fuzzylite_6").semantics
        assert found.method.implication == "product"
        assert found.method.defuzzifier.kind == "tsukamoto"
        assert found.outputs[0].otherwise == Hold(start=Number(0.5))

    def test_lines_may_be_separated_by_semicolons(self):
        found = system((SAMPLES / "one_line.fll").read_text(encoding="utf-8"))
        assert [v.name for v in (*found.inputs, *found.outputs)] == ["a", "b"]
        assert len(found.rules) == 2
        assert found.method.defuzzifier.kind == "som"

    @pytest.mark.parametrize(
        ("old", "new"),
        [
            ("Engine: small", "# numbers\n\nEngine:small # the engine"),
            ("Engine: small", "ENGINE : small"),
            ("  range: 0.0 1.0", "\trange:0 1"),
            ("  conjunction", "  enabled: true\n  conjunction"),
            ("  term: low Ramp 1.0 0.0", "  Term:low  Ramp\t1 0.0"),
            ("if a is low then y is low", "if a is low then y is low with 1.0"),
            ("if a is low then y is low", "if ((a is low)) then y is low"),
            ("\n", "\r\n"),
            ("  activation: General\n", ""),
        ],
    )
    def test_the_same_file_is_written_in_many_ways(self, old, new):
        assert system(changed(old, new)) == system(SMALL)
        assert said(changed(old, new)) == []

    def test_defuzzifiers_take_the_samples_of_fuzzylite_unless_they_say(self):
        assert system(changed("Centroid 100", "Centroid")).method.defuzzifier.resolution == 1000
        assert system(changed("Centroid 100", "Bisector 50")).method.defuzzifier.resolution == 50
        for word, kind in (("SmallestOfMaximum", "som"), ("LargestOfMaximum", "lom"), ("MeanOfMaximum", "mom")):
            assert system(changed("Centroid 100", word)).method.defuzzifier == profile("fuzzylite").defuzzifier(kind)

    @pytest.mark.parametrize(
        ("defuzzifier", "terms", "kind"),
        [
            ("WeightedAverage", ("Constant 1", "Linear 1 2"), "weighted_average"),
            ("WeightedAverage Automatic", ("Ramp 1 0", "Sigmoid 0.5 9"), "tsukamoto"),
            ("WeightedAverage Automatic", ("Triangle 0 1 2", "Gaussian 0 1"), "inverse_tsukamoto"),
            ("WeightedAverage TakagiSugeno", ("Ramp 1 0", "Ramp 0 1"), "inverse_tsukamoto"),
            ("WeightedSum", ("Constant 1", "Constant 2"), "weighted_sum"),
            ("WeightedSum Tsukamoto", ("Ramp 1 0", "Ramp 0 1"), "tsukamoto_sum"),
            ("WeightedSum TakagiSugeno", ("Ramp 1 0", "Ramp 0 1"), "inverse_tsukamoto_sum"),
        ],
    )
    def test_weighted_defuzzifiers_depend_on_the_terms(self, defuzzifier, terms, kind):
        text = changed("Centroid 100", defuzzifier)
        head, tail = text.split("OutputVariable")
        for old, new in zip(("Ramp 1.0 0.0", "Ramp 0.0 1.0"), terms, strict=True):
            tail = tail.replace(old, new)
        assert system(head + "OutputVariable" + tail).method.defuzzifier.kind == kind

    @pytest.mark.parametrize(
        ("text", "activation"),
        [
            ("First", Activation(kind="first", count=1, threshold=Number(0.0))),
            ("Last 2 0.25", Activation(kind="last", count=2, threshold=Number(0.25))),
            ("Highest 3", Activation(kind="highest", count=3)),
            ("Lowest", Activation(kind="lowest", count=1)),
            ("Proportional", Activation(kind="proportional")),
            ("Threshold >= 0.5", Activation(kind="threshold", comparison=">=", threshold=Number(0.5))),
        ],
    )
    def test_activation_methods_have_their_parameters(self, text, activation):
        assert system(changed("General", text)).method.activation == activation

    @pytest.mark.parametrize(
        ("line", "other", "field", "value"),
        [
            ("conjunction: Minimum", "conjunction: AlgebraicProduct", "conjunction", "product"),
            ("implication: Minimum", "implication: AlgebraicProduct", "implication", "product"),
            ("activation: General", "activation: Proportional", "activation", Activation(kind="proportional")),
        ],
    )
    def test_rule_blocks_keep_their_names_and_say_in_what_they_differ(self, line, other, field, value):
        joined = SMALL.replace("if a is low then", "if a is low and b is low then")
        second = "RuleBlock: all" + joined.split("RuleBlock: all")[1].replace(line, other)
        found = system(joined + second + second.replace("RuleBlock: all", "RuleBlock:"))
        assert found.method == system(SMALL).method
        assert [b.name for b in found.rule_blocks] == ["all", "all_2", "block3"]
        assert [getattr(b, field) for b in found.rule_blocks] == [None, value, value]
        assert sum(getattr(b, f) is not None for b in found.rule_blocks for f in OF_BLOCKS) == 2
        assert [r.block for r in found.rule_methods] == sorted([0, 1, 2] * (len(found.rules) // 3))

    def test_rule_blocks_without_names_that_differ_in_nothing_are_one(self):
        nameless = SMALL.replace("RuleBlock: all", "RuleBlock:")
        twice = system(nameless + "RuleBlock:" + nameless.split("RuleBlock:")[1])
        assert not twice.rule_blocks
        assert twice.rules == system(SMALL).rules * 2

    def test_rule_blocks_without_names_leave_implications_to_the_outputs_that_they_set(self):
        more = SMALL.replace(
            "RuleBlock: all",
            "OutputVariable: z\n  range: 0 2\n  aggregation: AlgebraicSum\n"
            "  defuzzifier: Centroid 100\n  term: low Ramp 2 0\nRuleBlock:",
        )
        more += "RuleBlock:\n  implication: AlgebraicProduct\n  rule: if b is low then z is low\n"
        first, second = system(more).outputs
        assert (first.implication, second.implication, second.aggregation) == (None, "product", "probabilistic_sum")
        assert not system(more).rule_blocks

    @pytest.mark.parametrize("activation", ["First 1 0.0", "Highest 2", "Proportional"])
    def test_a_choice_is_made_within_each_of_several_blocks(self, activation):
        text = SMALL.replace("General", activation).replace("RuleBlock: all", "RuleBlock:")
        found = system(text + "RuleBlock:" + text.split("RuleBlock:")[1])
        assert [b.name for b in found.rule_blocks] == ["block2"]
        assert [m.block for m in found.rule_methods] == [-1, -1, 0, 0]
        assert found.method.activation == system(text).method.activation

    def test_an_implication_that_no_output_heeds_makes_no_block_differ(self):
        sets = "lock-previous: false\n  term: low Ramp 1.0 0.0\n  term: high Ramp 0.0 1.0"
        numbers = "lock-previous: false\n  term: low Constant 1\n  term: high Constant 2"
        text = SMALL.replace("Centroid 100", "WeightedAverage TakagiSugeno").replace(sets, numbers)
        found = system(text + "RuleBlock: b\n  implication: AlgebraicProduct\n  rule: if b is low then y is low\n")
        assert [b.implication for b in found.rule_blocks] == [None, None]

    def test_infinite_ranges_are_as_wide_as_the_terms(self):
        text = changed("InputVariable: b\n  range: 0.0 1.0", "InputVariable: b\n  range: -inf inf\n  lock-range: true")
        found = system(text).inputs[1]
        assert (found.lower.value, found.upper.value, found.extrapolate) == (0.0, 1.0, True)
        assert [c[0] for c in said(text)] == ["FZ603"]


class TestTerms:
    def test_all_terms_have_their_parameters(self):
        found = {t.name: t.membership for t in system(ALL_TERMS).inputs[0].terms}
        shapes = {name: (m.kind, tuple(a.value for a in m.arguments)) for name, m in found.items() if name != "U"}
        assert shapes == {
            "A": ("sigmoid", (0.5, -20.0)),
            "B": ("z_shape", (0.0, 1.0)),
            "C": ("ramp", (1.0, 0.0)),
            "D": ("triangle", (0.5, 1.0, 1.5)),
            "E": ("trapezoid", (-math.inf, 1.25, 1.75, 2.0)),
            "F": ("concave", (0.85, 0.25)),
            "G": ("rectangle", (1.75, 2.25)),
            "H": ("piecewise", (2.0, 0.0, 2.25, 1.0, 2.5, 0.5, 2.75, 1.0, 3.0, 0.0)),
            "I": ("gaussian", (3.0, 0.2)),
            "J": ("cosine", (3.25, 0.65)),
            "K": ("gaussian2", (3.5, 0.1, 3.3, 0.3)),
            "L": ("spike", (3.64, 1.04)),
            "M": ("bell", (4.0, 0.25, 3.0)),
            "N": ("pi_shape", (4.0, 4.5, 4.5, 5.0)),
            "O": ("arc", (5.65, 6.25)),
            "P": ("sigmoid_difference", (4.75, 10.0, 30.0, 5.25)),
            "Q": ("sigmoid_product", (5.25, 20.0, -10.0, 5.75)),
            "R": ("semi_ellipse", (5.5, 6.5)),
            "S": ("s_shape", (5.5, 6.5)),
            "T": ("rectangle", (6.0, math.inf)),
        }

    def test_a_number_behind_the_parameters_is_the_height(self):
        found = {t.name: t.membership.height for t in system(ALL_TERMS).inputs[0].terms}
        assert (found["E"], found["H"], found["A"]) == (Number(0.5), Number(0.9), ONE)

    def test_binary_faces_either_way(self):
        found = system(
            changed("a\n  range: 0.0 1.0\n  term: low Ramp 1.0 0.0", "a\n  range: 0 1\n  term: low Binary 0.5 -inf")
        )
        assert [a.value for a in found.inputs[0].terms[0].membership.arguments] == [-math.inf, 0.5]

    def test_a_formula_names_the_variable_itself_as_x(self):
        formula = next(t.membership.arguments[0] for t in system(ALL_TERMS).inputs[0].terms if t.name == "U")
        assert evaluate(formula, {"x": 6.0}) == 0.5 + 36 / 200

    @pytest.mark.parametrize(
        ("text", "value"),
        [
            ("1 + 2 * 3", 7),
            ("-a ^ 2", -9),
            ("2 ^ -1", 0.5),
            ("2 ** 3 ^ 2", 512),
            ("(1 + 2) * a - 4 / 2", 7),
            ("1 - 2 - 3", -4),
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
        ],
    )
    def test_formulas_are_read_as_fuzzylite_does(self, text, value):
        source = SourceText("t", text)
        formula = read_formula(Span(source, 0, len(text)), {"a", "b"})
        assert evaluate(formula, {"a": 3.0, "b": 4.0}) == pytest.approx(value, abs=1e-12)

    @pytest.mark.parametrize(
        ("text", "code"),
        [
            ("", "FZ601"),
            ("1 +", "FZ601"),
            ("1 2", "FZ601"),
            ("a $ b", "FZ601"),
            ("(a", "FZ103"),
            ("sin(a", "FZ103"),
            ("sin(a, b)", "FZ601"),
            ("expm1(a)", "FZ602"),
            ("ne(a, b)", "FZ602"),
            ("mod(a, b)", "FZ602"),
            ("a %", "FZ601"),
            ("a and", "FZ601"),
            ("or a", "FZ601"),
            ("a ! b", "FZ601"),
            ("asinh(" * 12 + "a" + ")" * 12, "FZ601"),
            ("c + 1", "FZ202"),
            ("(" * 60 + "a" + ")" * 60, "FZ601"),
            ("-" * 60 + "a", "FZ601"),
            ("+".join("a" * 1500), "FZ601"),
        ],
    )
    def test_what_is_no_formula_is_reported(self, text, code):
        with pytest.raises(ParseError) as caught:
            read_formula(Span(SourceText("t", text), 0, len(text)), {"a", "b"})
        assert caught.value.diagnostic.code == code


class TestRules:
    LOW, HIGH = Is(variable="a", term="low"), Is(variable="a", term="high")
    B = Is(variable="b", term="low")

    @pytest.mark.parametrize(
        ("text", "antecedent"),
        [
            ("a is low or a is high and b is low", Or(operands=(LOW, And(operands=(HIGH, B))))),
            ("a is low and a is high or b is low", Or(operands=(And(operands=(LOW, HIGH)), B))),
            ("(a is low or a is high) and b is low", And(operands=(Or(operands=(LOW, HIGH)), B))),
            ("a is low and a is high and b is low", And(operands=(LOW, HIGH, B))),
            ("a is not very low", Is(variable="a", term="low", hedges=("not", "very"))),
            ("a is any low", Is(variable="a", term="low", hedges=("any",))),
            ("a is any and b is low", And(operands=(Is(variable="a", term="low", hedges=("any",)), B))),
        ],
    )
    def test_and_binds_before_or_and_hedges_stand_before_the_term(self, text, antecedent):
        assert rule(f"if {text} then y is low").antecedent == antecedent

    def test_consequents_may_be_several_and_hedged(self):
        found = rule("if a is low then y is very low and y is somewhat high with 0.5")
        assert [(c.term, c.hedges) for c in found.consequents] == [("low", ("very",)), ("high", ("somewhat",))]
        assert found.weight == Number(0.5)

    def test_an_output_may_be_read_by_rules_behind_those_that_set_it(self):
        assert rule("if y is low then y is high").antecedent == Is(variable="y", term="low")

    def test_the_propositions_of_a_disabled_input_are_false(self):
        text = changed("InputVariable: b\n", "InputVariable: b\n  enabled: false\n").replace("a is low", "b is low", 1)
        assert system(text).rules[0].antecedent == Is(variable="b", term="low", hedges=("not", "any"))
        assert [c[0] for c in said(text)] == ["FZ611"]

    def test_disabled_outputs_and_blocks_are_left_out(self):
        more = SMALL.replace(
            "RuleBlock: all",
            "OutputVariable: z\n  enabled: false\n  range: 0 2\n  term: low Ramp 2 0\n"
            "RuleBlock: off\n  enabled: false\n  rule: if b is low then y is high\nRuleBlock: all",
        )
        found = system(more.replace("if a is low then y is low", "if a is low then y is low and z is low"))
        assert [o.name for o in found.outputs] == ["y"]
        assert len(found.rules) == 2
        assert [c[0] for c in said(more)] == ["FZ611", "FZ611"]


class TestMistakes:
    """Each is one message, in the place where it is."""

    @pytest.mark.parametrize(
        ("old", "new", "expected"),
        [
            ("Engine: small\n", "Engine small\n", ("FZ601", "error", 1, 1)),
            ("Engine: small\n", "Engine: small\nEngine: again\n", ("FZ215", "error", 2, 1)),
            ("Engine: small\n", "name: small\n", ("FZ601", "error", 1, 1)),
            ("RuleBlock: all", "RuleBlok: all", None),
            ("  activation: General", "  colour: red", ("FZ601", "error", 22, 3)),
            ("  activation: General", "  activation: Some", ("FZ602", "error", 22, 15)),
            ("if a is low then", "if a is very and b is low then", ("FZ601", "error", 23, 22)),
            ("if a is low then", "if (a is) and b is low then", ("FZ601", "error", 23, 17)),
            ("  activation: General", "  activation: First 0 0.5", ("FZ601", "error", 22, 21)),
            ("  activation: General", "  activation: Threshold ~ 0.5", ("FZ601", "error", 22, 25)),
            ("  activation: General", "  activation: Proportional 3", ("FZ303", "error", 22, 28)),
            ("conjunction: Minimum", "conjunction: Function", ("FZ602", "error", 19, 16)),
            ("conjunction: Minimum", "conjunction: Maximum", ("FZ602", "error", 19, 16)),
            ("implication: Minimum", "implication: none", ("FZ212", "error", 18, 1)),
            ("aggregation: Maximum", "aggregation: none", ("FZ212", "error", 10, 17)),
            ("defuzzifier: Centroid 100", "defuzzifier: none", ("FZ212", "error", 10, 17)),
            ("Centroid 100", "Centroid 0", ("FZ601", "error", 13, 25)),
            ("Centroid 100", "Middle", ("FZ602", "error", 13, 16)),
            ("Centroid 100", "WeightedAverage Custom", ("FZ602", "error", 13, 32)),
            ("lock-previous: false", "lock-previous: maybe", ("FZ601", "error", 15, 18)),
            ("default: nan", "default: none", ("FZ601", "error", 14, 12)),
            ("default: nan", "default: nan\n  default: nan", ("FZ215", "error", 15, 3)),
            ("OutputVariable: y\n  range: 0.0 1.0", "OutputVariable: y\n  range: 0.0", ("FZ601", "error", 11, 10)),
            ("OutputVariable: y\n  range: 0.0 1.0", "OutputVariable: y\n  range: 0.0 inf", ("FZ302", "error", 11, 10)),
            ("OutputVariable: y", "OutputVariable: a", None),
            ("OutputVariable: y", "OutputVariable:", None),
            ("InputVariable: b", "InputVariable: b c", ("FZ604", "warning", 6, 16)),
            ("  term: high Ramp 0.0 1.0\nRule", "  term: high Rampe 0.0 1.0\nRule", ("FZ602", "error", 17, 14)),
            ("  term: high Ramp 0.0 1.0\nRule", "  term: high Ramp 0.0\nRule", ("FZ303", "error", 17, 9)),
            ("  term: high Ramp 0.0 1.0\nRule", "  term: high Ramp 0.0 x\nRule", ("FZ601", "error", 17, 23)),
            ("  term: high Ramp 0.0 1.0\nRule", "  term: high Ramp 0 1 0.5 7\nRule", ("FZ603", "warning", 17, 27)),
            ("  term: high Ramp 0.0 1.0\nRule", "  term: high\nRule", None),
            ("  term: high Ramp 0.0 1.0\nRule", "  term: high Function a + z\nRule", ("FZ202", "error", 17, 27)),
            ("  term: high Ramp 0.0 1.0\nRule", "  term: high Function x + a\nRule", ("FZ602", "error", 17, 23)),
            ("  term: high Ramp 0.0 1.0\nRule", "  term: high Linear 1\nRule", ("FZ303", "error", 17, 9)),
            (
                "  term: high Ramp 0.0 1.0\nRule",
                "  term: low Ramp 0 1\n  term: high Ramp 0 1\nRule",
                ("FZ604", "warning", 17, 9),
            ),
            ("if a is low then", "if c is low then", ("FZ202", "error", 23, 12)),
            ("if a is low then", "if a is lou then", ("FZ203", "error", 23, 17)),
            ("if a is low then", "if a low then", ("FZ601", "error", 23, 14)),
            ("if a is low then", "a is low then", ("FZ601", "error", 23, 9)),
            ("if a is low then", "if (a is low then", ("FZ103", "error", 23, 12)),
            ("if a is low then", "if a is low and then", ("FZ202", "error", 23, 25)),
            ("if a is low then y is low", "if a is low", ("FZ601", "error", 23, 19)),
            ("if a is low then y is low", "if a is low then b is low", ("FZ214", "error", 23, 26)),
            ("if a is low then y is low", "if a is low then y is low with 2", ("FZ302", "error", 23, 40)),
            ("if a is low then y is low", "if a is low then y is low with x", ("FZ601", "error", 23, 40)),
            ("if a is low then y is low", "if a is low then y is low or y is high", ("FZ601", "error", 23, 35)),
            (
                "if a is low then y is low",
                "if " + "(" * 60 + "a is low" + ")" * 60 + " then y is low",
                ("FZ106", "error", 23, 62),
            ),
        ],
    )
    def test_one_mistake_has_one_message(self, old, new, expected):
        text = changed(old, new)
        found = said(text)
        errors = [f for f in found if f[1] == "error"]
        if expected is not None:
            assert found == [expected]
        else:
            assert errors
        assert (read(SourceText("t.fll", text))[0] is None) == bool(errors)

    def test_norms_that_no_rule_needs_may_lack(self):
        text = SMALL.replace("conjunction: Minimum", "conjunction: none").replace(
            "disjunction: Maximum", "disjunction: none"
        )
        assert system(text) == system(SMALL)
        joined = text.replace("if a is low then", "if a is low and b is low then")
        assert said(joined) == [("FZ212", "error", 23, 9)]

    @pytest.mark.parametrize(
        ("text", "code"),
        [
            ("", "FZ004"),
            ("# nothing\n", "FZ004"),
            ("<html>not found</html>", "FZ601"),
            ("Engine: a\n", "FZ212"),
            (SMALL.split("RuleBlock")[0], "FZ212"),
            (SMALL.split("OutputVariable")[0], "FZ212"),
        ],
    )
    def test_what_is_no_such_file_is_reported(self, text, code):
        assert code in [c for c, severity, *_ in said(text) if severity == "error"]


def test_a_kept_output_keeps_its_default_until_a_rule_fires(tmp_path):
    path = tmp_path / "hold.fll"
    text = SMALL.replace("if a is low then y is low", "if a is low and b is high then y is low")
    text = text.replace("if a is high", "if b is high").replace("lock-previous: false", "lock-previous: true")
    path.write_text(text.replace("default: nan", "default: 0.75"), encoding="utf-8")
    assert load(path)(a=0.5, b=0.0) == 0.75


def test_a_constant_of_an_input_is_its_degree_everywhere():
    text = SMALL.replace("defuzzifier: Centroid 100", "defuzzifier: WeightedAverage").replace(
        "  term: high Ramp 0.0 1.0\nInputVariable: b", "  term: high Constant 0.5\nInputVariable: b"
    )
    found = system(text.replace("term: low Ramp 1.0 0.0\n  term: high Ramp 0.0 1.0\nRule", OF_NUMBERS + "Rule"))
    # (0.25 * 1 + 0.5 * 0) / (0.25 + 0.5)
    assert found(a=0.75, b=0.0) == pytest.approx(1 / 3)


def test_the_largest_number_of_samples_is_reported():
    _, diagnostics = read(SourceText("t.fll", SMALL.replace("Centroid 100", "Centroid 1000000000")))
    (found,) = diagnostics
    assert found.message == "expected a whole number from 1 to 1000000, found '1000000000'"


class TestNoRule:
    @pytest.mark.parametrize(
        ("old", "new", "line", "message"),
        [
            ("  rule: if a is low then y is low\n  rule: if a is high then y is high\n", "", 18, "has no rule"),
            ("RuleBlock: all\n", "RuleBlock: all\n  enabled: false\n", 18, "the only rule block is disabled"),
            (SMALL[SMALL.index("RuleBlock") :], "", 1, "the file has no RuleBlock"),
            ("OutputVariable: y\n", "OutputVariable: y\n  enabled: false\n", 10, "all outputs are disabled"),
        ],
    )
    def test_why_no_rule_acts_is_reported_with_its_place(self, old, new, line, message):
        _, diagnostics = read(SourceText("t.fll", changed(old, new)))
        (error,) = [d for d in diagnostics if d.severity == "error"]
        assert (error.code, error.span.line) == ("FZ212", line)
        assert message in error.message

    def test_rules_of_disabled_outputs_alone_are_none(self):
        other = "OutputVariable: z\n  enabled: false\n  term: t Ramp 0 1\n"
        text = changed("RuleBlock: all", other + "RuleBlock: all").replace("then y is low", "then z is t")
        _, diagnostics = read(SourceText("t.fll", text.replace("then y is high", "then z is t")))
        (error,) = [d for d in diagnostics if d.severity == "error"]
        assert (error.message, error.span.line) == ("no rule sets an output that is enabled", 21)


@pytest.mark.parametrize(
    ("written", "parameters"),
    [("Bell 3 -2 3", (3, 2, 3)), ("Spike 3 -2", (3, 2)), ("Gaussian 3 -2", (3, 2))],
)
def test_formulas_take_the_magnitude_of_a_width(written, parameters):
    membership = (
        system(
            changed(
                "term: low Ramp 1.0 0.0\n  term: high Ramp 0.0 1.0\nInputVariable: b",
                f"term: low {written}\n  term: high Ramp 0.0 1.0\nInputVariable: b",
            )
        )
        .inputs[0]
        .terms[0]
        .membership
    )
    assert tuple(a.value for a in membership.arguments) == parameters
