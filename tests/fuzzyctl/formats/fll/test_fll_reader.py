"""`.fll` files as fuzzylite and pyfuzzylite write them. Mistakes are in tests/golden/foreign_mistakes.txt."""

import pytest

from tests.fuzzyctl.formats.files import SAMPLES, SMALL, errors, head, lines, read, replaced, rules, said

TIPPER, ALL_TERMS = SAMPLES["tipper.fll"], SAMPLES["all_terms.fll"]
SETS = "lock-previous: false\n  term: low Ramp 1.0 0.0\n  term: high Ramp 0.0 1.0"


def changed(old, new):
    return replaced(SMALL, (old, new))


def blocks(text):
    """Return the names of rule blocks with what they say themselves, and the number of rules before the first."""
    system = read("fll", text)
    own = [
        (b.name, b.conjunction, b.implication, b.activation and b.activation.kind, b.disjunction)
        for b in system.rule_blocks
    ]
    return [tuple(x for x in block if x is not None) for block in own], [m.block for m in system.rule_methods]


class TestEngines:
    def test_a_file_is_what_fuzzylite_makes_of_it(self):
        assert head("fll", TIPPER) == {
            "semantics": "fuzzylite",
            "and": "product",
            "or": "probabilistic_sum",
            "defuzzifier": "centroid(resolution=200)",
        }
        found = lines("fll", TIPPER)
        assert [line for line in found if line.startswith(("system", "input", "output"))] == [
            'system tipper "(service and food) -> (tip)"',
            'input service "quality of service" in [0, 10]',
            "input food in [0, 10] extrapolate",
            "output mTip in [0, 30] else hold(nan)",
            "output tsTip in [0, 30] else 15 aggregation sum defuzzifier weighted_average clamp",
        ]
        assert len(rules("fll", TIPPER)) == 6

    def test_old_spellings_have_the_numerics_of_old_versions(self):
        settings = {"semantics": "fuzzylite_6", "implication": "product", "aggregation": "sum"}
        assert head("fll", SAMPLES["old.fll"]) == settings | {"defuzzifier": "tsukamoto"}
        assert "output Y in [0, 1] else hold(0.5)" in lines("fll", SAMPLES["old.fll"])

    def test_lines_may_be_separated_by_semicolons(self):
        assert head("fll", SAMPLES["one_line.fll"])["defuzzifier"] == "som(resolution=100)"
        assert rules("fll", SAMPLES["one_line.fll"]) == ["if a is lo then b is hi", "if a is hi then b is lo"]

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
            ("conjunction: Minimum", "conjunction: none"),  # no rule needs it
        ],
    )
    def test_the_same_file_is_written_in_many_ways(self, old, new):
        assert read("fll", changed(old, new)) == read("fll", SMALL)
        assert [c for c, *_ in said("fll", changed(old, new))] == [c for c, *_ in said("fll", SMALL)]

    @pytest.mark.parametrize(
        ("old", "new", "setting", "expected"),
        [
            ("Centroid 100", "Centroid", "defuzzifier", None),
            ("Centroid 100", "Bisector 50", "defuzzifier", "bisector(resolution=50)"),
            ("Centroid 100", "SmallestOfMaximum", "defuzzifier", "som"),
            ("Centroid 100", "LargestOfMaximum", "defuzzifier", "lom"),
            ("Centroid 100", "MeanOfMaximum", "defuzzifier", "mom"),
            ("General", "First", "activation", "first(count=1, threshold=0)"),
            ("General", "Last 2 0.25", "activation", "last(count=2, threshold=0.25)"),
            ("General", "Highest 3", "activation", "highest(count=3)"),
            ("General", "Lowest", "activation", "lowest(count=1)"),
            ("General", "Proportional", "activation", "proportional"),
            ("General", "Threshold >= 0.5", "activation", "threshold(>= 0.5)"),
        ],
    )
    def test_defuzzifiers_and_activation_methods_have_their_parameters(self, old, new, setting, expected):
        assert head("fll", changed(old, new)).get(setting) == expected

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
        before, tail = changed("Centroid 100", defuzzifier).split("OutputVariable")
        tail = replaced(tail, *zip(("Ramp 1.0 0.0", "Ramp 0.0 1.0"), terms, strict=True))
        assert head("fll", before + "OutputVariable" + tail)["defuzzifier"] == kind

    def test_infinite_ranges_are_as_wide_as_the_terms(self):
        text = changed("InputVariable: b\n  range: 0.0 1.0", "InputVariable: b\n  range: -inf inf\n  lock-range: true")
        assert "input b in [0, 1] extrapolate" in lines("fll", text)
        assert "FZ603" in [c for c, *_ in said("fll", text)]


class TestBlocks:
    @pytest.mark.parametrize(
        ("line", "other", "value"),
        [
            ("conjunction: Minimum", "conjunction: AlgebraicProduct", "product"),
            ("implication: Minimum", "implication: AlgebraicProduct", "product"),
            ("activation: General", "activation: Proportional", "proportional"),
        ],
    )
    def test_they_keep_their_names_and_say_in_what_they_differ(self, line, other, value):
        joined = changed("if a is low then", "if a is low and b is low then")
        second = "RuleBlock: all" + joined.split("RuleBlock: all")[1].replace(line, other)
        found = joined + second + second.replace("RuleBlock: all", "RuleBlock:")
        assert head("fll", found) == head("fll", SMALL)
        assert blocks(found) == ([("all",), ("all_2", value), ("block3", value)], [0, 0, 1, 1, 2, 2])

    def test_without_names_those_that_differ_in_nothing_are_one(self):
        nameless = changed("RuleBlock: all", "RuleBlock:")
        twice = nameless + "RuleBlock:" + nameless.split("RuleBlock:")[1]
        assert blocks(twice)[0] == []
        assert rules("fll", twice) == rules("fll", SMALL) * 2

    def test_without_names_they_leave_implications_to_the_outputs_that_they_set(self):
        more = "OutputVariable: z\n  range: 0 2\n  aggregation: AlgebraicSum\n  defuzzifier: Centroid 100\n"
        more = changed("RuleBlock: all", f"{more}  term: low Ramp 2 0\nRuleBlock:")
        more += "RuleBlock:\n  implication: AlgebraicProduct\n  rule: if b is low then z is low\n"
        outputs = [line for line in lines("fll", more) if line.startswith("output")]
        assert outputs == [
            "output y in [0, 1]",
            "output z in [0, 2] implication product aggregation probabilistic_sum",
        ]
        assert blocks(more)[0] == []

    @pytest.mark.parametrize("activation", ["First 1 0.0", "Highest 2", "Proportional"])
    def test_a_choice_is_made_within_each_of_several(self, activation):
        text = replaced(SMALL, ("General", activation), ("RuleBlock: all", "RuleBlock:"))
        twice = text + "RuleBlock:" + text.split("RuleBlock:")[1]
        assert blocks(twice) == ([("block2",)], [-1, -1, 0, 0])
        assert head("fll", twice) == head("fll", text)

    def test_an_implication_that_no_output_heeds_makes_none_differ(self):
        numbers = "lock-previous: false\n  term: low Constant 1\n  term: high Constant 2"
        text = replaced(SMALL, ("Centroid 100", "WeightedAverage TakagiSugeno"), (SETS, numbers))
        more = text + "RuleBlock: b\n  implication: AlgebraicProduct\n  rule: if b is low then y is low\n"
        assert blocks(more)[0] == [("all",), ("b",)]


class TestTerms:
    def test_all_terms_have_their_parameters_and_heights(self):
        found = lines("fll", ALL_TERMS)
        first = found.index("input x in [0, 6.5] extrapolate")
        assert found[first + 1 : first + 22] == [
            "A = sigmoid(0.5, -20)",
            "B = z_shape(0, 1)",
            "C = ramp(1, 0)",
            "D = triangle(0.5, 1, 1.5)",
            "E = trapezoid(-inf, 1.25, 1.75, 2, height=0.5)",
            "F = concave(0.85, 0.25)",
            "G = rectangle(1.75, 2.25)",
            "H = piecewise(2, 0, 2.25, 1, 2.5, 0.5, 2.75, 1, 3, 0, height=0.9)",
            "I = gaussian(3, 0.2)",
            "J = cosine(3.25, 0.65)",
            "K = gaussian2(3.5, 0.1, 3.3, 0.3)",
            "L = spike(3.64, 1.04)",
            "M = bell(4, 0.25, 3)",
            "N = pi_shape(4, 4.5, 4.5, 5)",
            "O = arc(5.65, 6.25)",
            "P = sigmoid_difference(4.75, 10, 30, 5.25)",
            "Q = sigmoid_product(5.25, 20, -10, 5.75)",
            "R = semi_ellipse(5.5, 6.5)",
            "S = s_shape(5.5, 6.5)",
            "T = rectangle(6, inf)",
            "U = function(0.5 + x * x / 200)",
        ]

    @pytest.mark.parametrize(
        ("written", "expected"),
        [
            ("Binary 0.5 -inf", "rectangle(-inf, 0.5)"),
            ("Bell 3 -2 3", "bell(3, 2, 3)"),
            ("Spike 3 -2", "spike(3, 2)"),
            ("Gaussian 3 -2", "gaussian(3, 2)"),
        ],
    )
    def test_binary_faces_either_way_and_widths_count_by_their_magnitude(self, written, expected):
        text = SMALL.replace("term: low Ramp 1.0 0.0", f"term: low {written}", 1)
        assert f"low  = {expected}" in lines("fll", text)

    def test_a_constant_of_an_input_is_its_degree_everywhere(self):
        text = SMALL.replace("Ramp 0.0 1.0", "Constant 0.5", 1)
        numbers = "lock-previous: false\n  term: low Constant 1.0\n  term: high Constant 0.0"
        text = replaced(text, ("Centroid 100", "WeightedAverage"), (SETS, numbers))
        # (0.25 * 1 + 0.5 * 0) / (0.25 + 0.5)
        assert read("fll", text)(a=0.75, b=0.0) == pytest.approx(1 / 3)


class TestRules:
    @pytest.mark.parametrize(
        ("text", "expected"),
        [
            ("a is low or a is high and b is low", "a is low or (a is high and b is low)"),
            ("a is low and a is high or b is low", "(a is low and a is high) or b is low"),
            ("(a is low or a is high) and b is low", "(a is low or a is high) and b is low"),
            ("a is low and a is high and b is low", "a is low and a is high and b is low"),
            ("a is not very low", "a is not very low"),
            ("a is any and b is low", "a is any low and b is low"),
            ("y is low", "y is low"),  # behind the rules that set it
        ],
    )
    def test_and_binds_before_or_and_hedges_stand_before_the_term(self, text, expected):
        assert rules("fll", changed("if a is low then", f"if {text} then"))[0] == f"if {expected} then y is low"

    def test_consequents_may_be_several_and_hedged(self):
        rule = "if a is low then y is very low and y is somewhat high with 0.5"
        found = read("fll", changed("if a is low then y is low", rule)).rules[0]
        assert [(c.term, c.hedges) for c in found.consequents] == [("low", ("very",)), ("high", ("somewhat",))]
        assert found.weight.value == 0.5

    def test_the_propositions_of_a_disabled_input_are_false(self):
        text = changed("InputVariable: b\n", "InputVariable: b\n  enabled: false\n").replace("a is low", "b is low", 1)
        assert rules("fll", text)[0] == "if b is not any low then y is low"
        assert "FZ611" in [c for c, *_ in said("fll", text)]

    def test_disabled_outputs_and_blocks_are_left_out(self):
        off = "OutputVariable: z\n  enabled: false\n  range: 0 2\n  term: low Ramp 2 0\nRuleBlock: off\n"
        off += "  enabled: false\n  rule: if b is low then y is high\n"
        text = changed("RuleBlock: all", f"{off}RuleBlock: all")
        assert rules("fll", replaced(text, ("then y is low", "then y is low and z is low"))) == rules("fll", SMALL)
        assert [c for c, *_ in said("fll", text)].count("FZ611") == 2

    def test_a_kept_output_keeps_its_default_until_a_rule_fires(self):
        text = replaced(
            SMALL,
            *(
                ("if a is low then y is low", "if a is low and b is high then y is low"),
                ("if a is high", "if b is high"),
            ),
            *(("lock-previous: false", "lock-previous: true"), ("default: nan", "default: 0.75")),
        )
        assert read("fll", text)(a=0.5, b=0.0) == 0.75


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
        (error,) = errors("fll", changed(old, new))
        assert (error.code, error.span.line) == ("FZ212", line)
        assert message in error.message

    def test_rules_of_disabled_outputs_alone_are_none(self):
        other = "OutputVariable: z\n  enabled: false\n  term: t Ramp 0 1\n"
        text = replaced(
            SMALL,
            *(("RuleBlock: all", other + "RuleBlock: all"), ("then y is low", "then z is t")),
            ("then y is high", "then z is t"),
        )
        (error,) = errors("fll", text)
        assert (error.message, error.span.line) == ("no rule sets an output that is enabled", 21)


def test_norms_that_a_rule_needs_must_not_lack():
    text = changed("conjunction: Minimum", "conjunction: none").replace("if a is low", "if a is low and b is low")
    assert [(d.code, d.span.line, d.span.column) for d in errors("fll", text)] == [("FZ212", 23, 9)]


def test_the_largest_number_of_samples_is_reported():
    (error,) = errors("fll", changed("Centroid 100", "Centroid 1000000000"))
    assert error.message == "expected a whole number from 1 to 1000000, found '1000000000'"
