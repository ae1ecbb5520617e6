"""FCL as people write it: the standard's, jFuzzyLogic's and fuzzylite's.

Mistakes are in tests/golden/foreign_mistakes.txt.
"""

import math

import pytest

from fuzzyctl import DiagnosticError, dumps, loads
from tests.fuzzyctl.formats.files import errors, examined, head, lines, read, replaced, rules, said

RULES = """AND : MIN; ACCU : MAX;
RULE 1 : IF x IS low THEN u IS no;
RULE 2 : IF x IS high AND y IS high THEN u IS yes;"""

VARIABLES = """VAR_INPUT
 x : REAL; RANGE := (0 .. 10);
 y : REAL; RANGE := (0 .. 10);
END_VAR
VAR_OUTPUT u : REAL; END_VAR"""


def block(
    terms="TERM low := (0, 1) (10, 0); TERM high := (0, 0) (10, 1);",
    consequents="TERM no := 0; TERM yes := 1; METHOD : COGS; DEFAULT := 0.5; RANGE := (0 .. 1);",
    rules=RULES,
    variables=VARIABLES,
    name="demo",
):
    return (
        f"FUNCTION_BLOCK {name}\n{variables}\nFUZZIFY x\n{terms}\nEND_FUZZIFY\nFUZZIFY y\n{terms}\nEND_FUZZIFY\n"
        f"DEFUZZIFY u\n{consequents}\nEND_DEFUZZIFY\nRULEBLOCK first\n{rules}\nEND_RULEBLOCK\nEND_FUNCTION_BLOCK\n"
    )


def sound(text):
    return read("fcl", text)


def found(text):
    return said("fcl", text)


def output(text):
    return next(line for line in lines("fcl", text) if line.startswith("output"))


def blocks(text):
    return [(b.name, b.conjunction, b.implication) for b in sound(text).rule_blocks]


class TestForm:
    def test_a_file_of_the_standard_has_the_numerics_of_its_definitions(self):
        assert dumps(sound(block())).split("\n\n")[1:] == [
            "semantics   exact(merge=places)\ndefuzzifier weighted_average",
            "input x in [0, 10] extrapolate\n  low  = piecewise(0, 1, 10, 0)\n  high = piecewise(0, 0, 10, 1)",
            "input y in [0, 10] extrapolate\n  low  = piecewise(0, 1, 10, 0)\n  high = piecewise(0, 0, 10, 1)",
            "output u in [0, 1] else 0.5\n  no  = singleton(0)\n  yes = singleton(1)",
            "if x is low then u is no\nif x is high and y is high then u is yes\n",
        ]
        # The first rule fires with 0.75, the second with min(0.25, 0.5).
        assert sound(block())(x=2.5, y=5) == pytest.approx(0.25 / (0.75 + 0.25), abs=1e-15)

    def test_comments_of_every_kind_byte_order_mark_and_capitals(self):
        text = "\ufeff(* one *) # two\n/* three\n */ function_block Demo // four\n" + block().split("\n", 1)[1].lower()
        system = sound(text.replace("end_fuzzify", "End_Fuzzify { pragma }", 1))
        assert (system.name, system.rules) == ("Demo", sound(block()).rules)

    @pytest.mark.parametrize(
        ("old", "new"),
        [
            ("\n", "\r\n"),
            ("THEN u IS no;", "THEN u IS no"),
            ("AND y IS high", "\n AND y IS high"),
            ("END_FUNCTION_BLOCK", "END_FUNCTION_BLOCK;"),
            ("END_FUNCTION_BLOCK", "end_function_block ;"),
            ("\n", " "),
            ("\n", "\t \t"),
        ],
    )
    def test_the_same_file_is_written_in_many_ways(self, old, new):
        assert sound(replaced(block(), (old, new))) == sound(block())
        assert found(replaced(block(), (old, new))) == []

    def test_the_name_of_a_block_is_the_rest_of_its_line(self):
        assert lines("fcl", block(name="approximation of sin(x)/x // this"))[0] == (
            'system approximation_of_sin_x_x "approximation of sin(x)/x"'
        )

    def test_several_function_blocks_are_several_systems(self):
        two = block(name="a") + block(name="b")
        with pytest.raises(DiagnosticError, match="several systems"):
            loads(two, "x.fcl")
        assert [loads(two, "x.fcl", block=name).name for name in "ab"] == ["a", "b"]
        (error,) = errors("fcl", block() + block(name="other") + block())
        assert (error.code, error.message) == ("FZ201", "function block 'demo' is declared twice")
        assert error.span.line > error.notes[0].span.line == 1

    @pytest.mark.parametrize("word", ["OPTION", "OPTIONS"])
    def test_options_have_no_effect_and_that_is_said(self, word):
        text = block().replace("RULEBLOCK first", f"{word}\n foo = 3;\nEND_{word}\nRULEBLOCK first")
        assert [f[0] for f in found(text)] == ["FZ603"]
        assert sound(text) == sound(block())

    def test_names_that_differ_in_capitals_only_are_taken_for_each_other_with_a_warning(self):
        text = block(rules="RULE 1 : IF X IS Low THEN u IS no;")
        assert rules("fcl", text) == ["if x is low then u is no"]
        assert [f for f in found(text) if f[0] == "FZ604"] == [("FZ604", 17, 13), ("FZ604", 17, 18)]

    def test_a_second_term_of_one_name_gets_another(self):
        text = block(terms="TERM low := 1;\nTERM low := 2;\nTERM high := 3;")
        assert [t.name for t in sound(text).input("x").terms] == ["low", "low_2", "high"]
        assert ("FZ604", 9, 6) in found(text)


class TestTerms:
    @pytest.mark.parametrize(
        ("shape", "expected"),
        [
            ("TRIAN 0 1 2", "triangle(0, 1, 2)"),
            ("trian 0, 1, 2", "triangle(0, 1, 2)"),
            ("TRAPE -2 0 1 3", "trapezoid(-2, 0, 1, 3)"),
            ("GAUSS 5 2", "gaussian(5, 2)"),
            ("GAUSS2 2 2 3 1", "gaussian2(2, 2, 3, 1)"),
            ("GBELL 2 4 3", "bell(3, 2, 4)"),
            ("SIGM -4 3", "sigmoid(3, -4)"),
            ("DSIGM 8 3 5 7", "sigmoid_difference(3, 8, 5, 7)"),
            ("COSINE 2 5", "cosine(5, 4)"),
            ("Cosine 2 5", "cosine(2, 5)"),
            ("Triangle 0.000 1.000 2.000", "triangle(0, 1, 2)"),
            ("Triangle 0 1 2 0.5", "triangle(0, 1, 2, height=0.5)"),
            ("Ramp 1.000 0.000", "ramp(1, 0)"),
            ("Binary 3 inf", "rectangle(3, inf)"),
            ("Binary 3 -inf", "rectangle(-inf, 3)"),
            ("Discrete 0 1 4 0", "piecewise(0, 1, 4, 0)"),
            ("(0, 1), (4, 0)", "piecewise(0, 1, 4, 0)"),
            ("(3, 1)", "piecewise(3, 1, 4, 1)"),
            ("SINGLETONS (3, 1)", "singleton(3)"),
            ("-1.5e-3", "singleton(-0.0015)"),
        ],
    )
    def test_shapes(self, shape, expected):
        text = block(terms=f"TERM low := {shape}; TERM high := TRIAN 0 5 10;")
        assert f"low  = {expected}" in lines("fcl", text)

    def test_a_constant_of_an_input_is_its_degree_everywhere_as_in_fuzzylite(self):
        terms = "TERM low := Constant 0.25; TERM high := Ramp 0 10;"
        rules = "RULE 1 : if x is low then u is yes;\nRULE 2 : if x is high then u is no;"
        system = sound(block(terms=terms, rules=rules))
        assert [system(x=x, y=1.0) for x in (2.5, 7.5)] == [0.25 / (0.25 + 0.25), 0.25 / (0.25 + 0.75)]

    def test_a_surplus_parameter_is_reported_and_has_no_effect(self):
        text = block(terms="TERM low := TRIAN 0 1 2 3;\nTERM high := TRIAN 0 5 10;")
        assert ("FZ603", 8, 25) in found(text)
        assert "low  = triangle(0, 1, 2)" in lines("fcl", text)

    def test_a_difference_of_sigmoids_is_clamped_as_in_jfuzzylogic(self):
        text = block(terms="TERM low := DSIGM 8 3 5 7; TERM high := 1;")
        assert sound(text).method.semantics.sigmoid_difference == "clamped"

    def test_constants_of_var_are_params(self):
        variables = "VAR_INPUT x, y : REAL; END_VAR VAR_OUTPUT u : REAL; END_VAR\nVAR top : REAL := 10; END_VAR"
        system = sound(block(variables=variables, terms="TERM low := (0, 1) (top, 0); TERM high := TRIAN 0 5 top;"))
        assert system(x=5, y=5) == system.with_params(top=10)(x=5, y=5) != system.with_params(top=20)(x=5, y=5)

    def test_initial_values_and_local_variables_have_no_effect(self):
        variables = VARIABLES.replace("u : REAL;", "u : REAL := 3;") + "\nVAR k : REAL; END_VAR"
        diagnostics = [d for d in examined("fcl", block(variables=variables))[1] if d.code == "FZ603"]
        assert [d.span.text for d in diagnostics] == ["u", "k"]

    def test_parameters_that_are_inputs_are_refused_once_for_each(self):
        text = block(terms="TERM low := (0, 1) (y, 0);\nTERM high := (0, 0) (y, 1);")
        assert [f for f in found(text) if f[0] == "FZ602"] == [("FZ602", 8, 21)]

    def test_ranges_are_estimated_as_jfuzzylogic_does_and_that_is_said(self):
        text = block(
            variables="VAR_INPUT x, y : REAL; END_VAR\nVAR_OUTPUT u : REAL; END_VAR",
            terms="TERM low := GAUSS 2 1; TERM high := SIGM 3 10;",
            consequents="TERM no := TRIAN 0 5 10; TERM yes := GBELL 1 2 20; METHOD : COG;",
        )
        system = sound(text)
        assert system.range_of(system.inputs[0]) == (-2.0, 13.0)
        assert system.range_of(system.outputs[0]) == pytest.approx((0.0, 20 + 999**0.25), rel=1e-15)
        assert [f[:2] for f in found(text) if f[0] == "FZ610"] == [("FZ610", 2), ("FZ610", 3)]

    def test_the_range_of_a_function_is_said_to_be_estimated(self):
        terms = "TERM no := FUNCTION x * y; TERM yes := FUNCTION (x - 5) * (x - 5); METHOD : COGS;"
        messages = [d.message for d in examined("fcl", block(consequents=terms))[1] if d.code == "FZ610"]
        assert messages == ["'u' has no RANGE; [0, 100] is taken, estimated from a few points of its functions"]


class TestRules:
    @pytest.mark.parametrize(
        ("condition", "expected"),
        [
            ("NOT x IS low", "not x is low"),
            ("x IS NOT low", "x is not low"),
            ("x IS NOT very low", "x is not very low"),
            ("NOT (x IS low OR y IS low)", "not (x is low or y is low)"),
            ("x IS low OR (y IS low AND x IS high)", "x is low or (y is low and x is high)"),
            ("((x IS low) AND (y IS low))OR(x IS high)", "(x is low and y is low) or x is high"),
            ("(x IS low AND y IS low) AND x IS high", "(x is low and y is low) and x is high"),
            ("x IS any", "x is any low"),
            ("((x IS low))", "x is low"),
        ],
    )
    def test_conditions(self, condition, expected):
        assert rules("fcl", block(rules=f"RULE 1 : IF {condition} THEN ((u IS no));")) == [
            f"if {expected} then u is no"
        ]

    def test_mixed_and_or_bind_as_the_dialect_has_it_with_a_warning_where_it_matters(self):
        mixed = "RULE 1 : IF x IS low OR y IS low AND x IS high THEN u IS no;"
        assert rules("fcl", block(rules=mixed)) == ["if x is low or (y is low and x is high) then u is no"]
        left = block(rules=mixed, terms="TERM low := TRIAN 0 0 9; TERM high := TRIAN 0 9 9;")
        assert rules("fcl", left) == ["if (x is low or y is low) and x is high then u is no"]
        assert "FZ609" in [f[0] for f in found(block(rules=mixed))]
        harmless = "RULE 1 : IF x IS low AND y IS low OR x IS high THEN u IS no;"
        assert found(block(rules=harmless)) == []

    def test_several_conclusions_and_weights(self):
        rule = sound(block(rules="RULE 1 : IF x IS low THEN u IS no, u IS yes WITH 0.25")).rules[0]
        assert ([c.term for c in rule.consequents], rule.weight.value) == (["no", "yes"], 0.25)

    @pytest.mark.parametrize(
        ("norms", "conjunction", "disjunction"),
        [
            ("", "min", "max"),
            ("AND : PROD;", "product", "probabilistic_sum"),
            ("OR : BSUM;", "bounded_difference", "bounded_sum"),
            ("AND : NIPMIN;", "nilpotent_minimum", "nilpotent_maximum"),
            ("OR : EINSTEIN;", "hamacher_product", "einstein_sum"),  # as jFuzzyLogic pairs them
            ("AND : EPROD;", "einstein_product", "max"),  # fuzzylite has no pairs
            ("AND : PROD; OR : MAX;", "product", "max"),
            ("AND : DMIN; OR : MAX;", "min", "max"),  # jFuzzyLogic takes the last line
            ("OR : MAX; AND : DMIN;", "drastic_product", "drastic_sum"),
        ],
    )
    def test_and_and_or_are_a_pair(self, norms, conjunction, disjunction):
        method = sound(block(rules=f"{norms} RULE 1 : IF x IS low AND y IS low THEN u IS no;")).method
        assert (method.conjunction, method.disjunction) == (conjunction, disjunction)

    def test_norms_that_are_no_pair_are_reported_where_both_count(self):
        both = "AND : PROD; OR : MAX; RULE 1 : IF x IS low AND (y IS low OR x IS high) THEN u IS no;"
        assert [f[0] for f in found(block(rules=both))] == ["FZ609"]
        assert found(block(rules="AND : PROD; OR : MAX; RULE 1 : IF x IS low AND y IS low THEN u IS no;")) == []


SETS = "TERM no := (0, 0) (1, 1) (2, 0); TERM yes := (1, 0) (2, 1) (3, 0); RANGE := (0 .. 3);"
LEFT_AND_RIGHT = "TERM no := (0, 1) (1, 0); TERM yes := (0, 0) (1, 1); METHOD : COG; RANGE := (0 .. 1);"


class TestOutputs:
    @pytest.mark.parametrize(
        ("method", "kind"),
        [("COG", None), ("COA", "bisector"), ("LM", "som"), ("RM", "lom"), ("MM", "mom"), ("Centroid", None)],
    )
    def test_methods_for_sets(self, method, kind):
        assert head("fcl", block(consequents=f"{SETS} METHOD : {method};")).get("defuzzifier") == kind

    def test_accumulation_may_stand_in_either_block(self):
        one = "RULE 1 : IF x IS low THEN u IS no;"
        for text in (block(consequents=SETS, rules=f"ACCU : BSUM; {one}"), block(consequents=f"{SETS} ACCU : BSUM;")):
            assert sound(text).method.aggregation == "bounded_sum"

    def test_rules_of_one_singleton_are_accumulated_first(self):
        rules = "ACCU : {};\nRULE 1 : IF x IS low THEN u IS no;\nRULE 2 : IF y IS low THEN u IS no;\n"
        rules += "RULE 3 : IF x IS high THEN u IS yes;"
        # x: low 0.5, high 0.5; y: low 0.75.
        for norm, expected in (("MAX", 0.5 / (0.75 + 0.5)), ("SUM", 0.5 / (0.5 + 0.75 + 0.5))):
            assert sound(block(rules=rules.format(norm)))(x=5, y=2.5) == pytest.approx(expected, rel=1e-15)

    @pytest.mark.parametrize(
        ("default", "otherwise"),
        [
            ("DEFAULT := -2.5;", "else -2.5"),
            ("DEFAULT := NC;", "else hold(nan)"),
            ("DEFAULT := nan;", ""),
            ("DEFAULT := 3 | NC;", "else hold(3)"),
            ("DEFAULT := nan | NC;", "else hold(nan)"),
            ("LOCK : PREVIOUS;", "else hold(nan)"),
            ("", "else nan"),
        ],
    )
    def test_an_output_where_no_rule_fires(self, default, otherwise):
        assert output(block(consequents=f"{SETS} METHOD : COG; {default}")) == f"output u in [0, 3] {otherwise}".strip()

    def test_jfuzzylogic_takes_its_samples_and_keeps_the_previous_value_without_a_default(self):
        system = sound("// of jFuzzyLogic\n" + block(consequents=f"{SETS} METHOD : COG;"))
        defuzzifier = system.method.defuzzifier
        assert system.output("u").otherwise.start == "nan"
        assert (defuzzifier.kind, defuzzifier.resolution, defuzzifier.grid) == ("centroid", 1000, "left")

    def test_functions_of_takagi_and_sugeno(self):
        functions = "TERM no := FUNCTION (x * 0.5) + 2; TERM yes := FUNCTION LN(x) - LOG(100) ^ 2 / y; METHOD : COGF;"
        # Rule 1 has 0.2, rule 2 min(0.8, 0.5).
        expected = (0.2 * 6 + 0.5 * (math.log(8) - 4 / 5)) / 0.7
        assert sound(block(consequents=functions))(x=8, y=5) == pytest.approx(expected, rel=1e-14)

    def test_functions_know_pi_and_names_in_other_capitals(self):
        terms = "TERM no := FUNCTION SIN(Pi * X) + +Y - 2; TERM yes := 1; METHOD : COGF; RANGE := (0 .. 9);"
        system = sound(block(consequents=terms, rules="RULE 1 : IF x IS low THEN u IS no;"))
        assert system(x=2.5, y=5) == pytest.approx(4, rel=1e-15)

    def test_functions_of_inputs_themselves_and_of_outputs_declared_before(self):
        second = (
            "DEFUZZIFY v\nTERM twice := FUNCTION 2 * u; METHOD : COGF; RANGE := (0 .. 2);\nEND_DEFUZZIFY\nRULEBLOCK"
        )
        text = block(variables=VARIABLES.replace("u : REAL;", "u, v : REAL;"))
        text = text.replace("TERM low := (0, 1) (10, 0);", "TERM low := FUNCTION 1 - x / 10;", 1)
        text = replaced(text, ("RULEBLOCK first", f"{second} first"), ("THEN u IS no", "THEN u IS no, v IS twice"))
        assert "low  = function(1 - x / 10)" in lines("fcl", text)
        values = sound(text)(x=4, y=5)
        assert values["v"] == 2 * values["u"] == pytest.approx(2 * 0.4 / (0.6 + 0.4), rel=1e-15)

    def test_a_sum_over_all_inputs_in_order_is_linear(self):
        text = block(consequents="TERM no := FUNCTION 2 * x + -3 * y + 1; TERM yes := 1; METHOD : COGF;")
        assert "no  = linear(2, -3, 1)" in lines("fcl", text)

    def test_a_method_for_sets_with_numbers_takes_their_average_and_says_so(self):
        text = block(consequents="TERM no := 0; TERM yes := 1;\nMETHOD : COG; RANGE := (0 .. 1);")
        assert [f for f in found(text) if f[0] == "FZ603"] == [("FZ603", 15, 1)]
        assert sound(text)(x=2.5, y=5) == pytest.approx(0.25, abs=1e-15)

    def test_monotone_sets_and_points_with_cogs_are_tsukamotos(self):
        ramps = "TERM no := Ramp 1 0; TERM yes := Ramp 0 1; METHOD : COGS; RANGE := (0 .. 1);"
        assert head("fcl", block(consequents=ramps))["defuzzifier"] == "tsukamoto"
        points = "TERM no := (0, 1) (1, 0.8) (3, 0); TERM yes := (1, 0) (2, 0.5) (3, 1);"
        system = sound(block(consequents=f"{points} METHOD : COGS; RANGE := (0 .. 3);"))
        # At x = 1 and y = 10 'no' has 0.9 and 'yes' 0.1, which lie at 0.5 and at 1.2.
        assert system(x=1, y=10) == pytest.approx(0.9 * 0.5 + 0.1 * 1.2, rel=1e-14)

    @pytest.mark.parametrize(
        ("comment", "aggregation", "said"), [("", "sum", "plain sum"), ("// jFuzzyLogic\n", "bounded_sum", "BSUM")]
    )
    def test_the_normalized_sum_is_that_of_the_dialect_and_that_is_said(self, comment, aggregation, said):
        text = comment + block(consequents=LEFT_AND_RIGHT, rules=RULES.replace("ACCU : MAX", "ACCU : NSUM"))
        system, diagnostics = examined("fcl", text)
        assert system.method.aggregation == aggregation
        (warning,) = [d for d in diagnostics if d.code == "FZ609"]
        assert said in warning.message
        assert (warning.span.line, warning.span.text) == (17 + bool(comment), "ACCU : NSUM")

    def test_fuzzylites_word_for_the_normalized_sum_needs_no_warning(self):
        rules = RULES.replace("ACCU : MAX", "ACCU : NormalizedSum")
        sets = "TERM no := Ramp 1 0; TERM yes := Ramp 0 1; METHOD : Centroid; RANGE := (0 .. 1);"
        assert sound(block(consequents=sets, rules=rules)).method.aggregation == "bounded_sum"
        assert found(block(consequents=sets, rules=rules)) == []


class TestRuleBlocks:
    def test_several_keep_their_names_and_say_in_what_they_differ(self):
        second = "END_RULEBLOCK\nRULEBLOCK second\nAND : {};\nRULE 1 : IF x IS high {} y IS low THEN u IS yes;"
        first = "AND : MIN;\nRULE 1 : IF x IS low AND y IS low THEN u IS no;\n"
        for norm, word, own in (("MIN", "AND", None), ("PROD", "OR", None), ("PROD", "AND", "product")):
            text = block(rules=first + second.format(norm, word))
            assert blocks(text) == [("first", None, None), ("second", own, None)]
            assert [m.block for m in sound(text).rule_methods] == [0, 1]
        methods = sound(block(rules=first + second.format("PROD", "OR"))).rule_methods
        assert methods[1].disjunction == "probabilistic_sum"

    def test_one_that_is_switched_off_has_no_effect_and_that_is_said(self):
        second = "END_RULEBLOCK\nRULEBLOCK second\nENABLED : FALSE;\nRULE 1 : IF x IS high THEN u IS yes;"
        first = "RULE 1 : IF x IS low THEN u IS no;\n"
        assert sound(block(rules=first + second)).rules == sound(block(rules=first)).rules
        assert blocks(block(rules=first + second)) == []
        assert [f[0] for f in found(block(rules=first + second))] == ["FZ611"]
        assert {f[0] for f in found(block(rules="ENABLED : FALSE;\n" + first))} == {"FZ611", "FZ212"}

    def test_implications_count_where_they_set_a_set_and_accumulations_must_agree(self):
        second = "END_RULEBLOCK\nRULEBLOCK second\nACT : PROD; {}\nRULE 1 : IF x IS high THEN u IS yes;"
        first = "ACT : MIN; ACCU : MAX;\nRULE 1 : IF x IS low THEN u IS no;\n"
        made = block(rules=first + second.format("ACCU : MAX;"), consequents=LEFT_AND_RIGHT)
        assert blocks(made) == [("first", None, None), ("second", None, "product")]
        assert blocks(block(rules=first + second.format(""))) == [("first", None, None), ("second", None, None)]
        refused = block(rules=first + second.format("ACCU : BSUM;"), consequents=LEFT_AND_RIGHT)
        assert [d.code for d in errors("fcl", refused)] == ["FZ602"]


class TestMistakes:
    def test_all_are_reported_at_once(self):
        rules = "RULE 1 : IF x IS lwo THEN u IS no;\nRULE 2 : IF y IS low u IS no;\nRULE 3 : IF z IS low THEN u IS no;"
        assert sorted(f[:2] for f in found(block(rules=rules))) == [("FZ202", 19), ("FZ203", 17), ("FZ601", 18)]

    def test_names_that_a_broken_statement_declares_are_known(self):
        text = block(terms="TERM low := TRIAN 0 1 two%;\nTERM high := 1;")
        assert {f[0] for f in found(text)} == {"FZ601"}

    @pytest.mark.parametrize(
        ("old", "new", "code"),
        [
            ("END_FUZZIFY", "", "FZ601"),
            ("END_FUNCTION_BLOCK", "", "FZ601"),
            ("FUZZIFY y", "FUZZIFY z", "FZ202"),
            ("VAR_OUTPUT u", "VAR_OUTPUT v", "FZ202"),
            (" y : REAL;", " x : REAL;", "FZ201"),
            ("FUZZIFY y", "FUZZIFY x", "FZ215"),
            ("VAR_INPUT", "VAR_IN_OUT", "FZ602"),
        ],
    )
    def test_broken_declarations_are_reported(self, old, new, code):
        assert code in [d.code for d in errors("fcl", replaced(block(), (old, new)))]

    @pytest.mark.parametrize("again", ["RANGE := (0 .. 2);", "METHOD : COG;", "DEFAULT := 1;"])
    def test_a_statement_given_twice_on_lines_of_their_own_is_reported_once(self, again):
        text = block(consequents=f"{SETS}\n{again}\n{again}\nTERM more := TRIAN 0 1 2;")
        assert [f[0] for f in found(text) if f[0] == "FZ215"] == ["FZ215"] * (2 if "RANGE" in again else 1)

    def test_deep_nesting_is_refused(self):
        condition = "(" * 5000 + "x IS low" + ")" * 5000
        assert errors("fcl", block(rules=f"RULE 1 : IF {condition} THEN u IS no;"))[0].code == "FZ106"
        for formula in ("(" * 5000 + "x" + ")" * 5000, " + ".join(["x"] * 5000)):
            text = block(consequents=f"TERM no := FUNCTION {formula}; TERM yes := 1;")
            assert "FZ106" in [d.code for d in errors("fcl", text)]
