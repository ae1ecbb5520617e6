"""FCL as people write it: the standard's, jFuzzyLogic's and fuzzylite's."""

import math

import pytest

from fuzzyctl import DiagnosticError, loads
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.expr import Number
from fuzzyctl.formats.fcl import read, read_all
from fuzzyctl.model.method import Defuzzifier
from fuzzyctl.model.rule import And, Is, Not, Or
from fuzzyctl.model.variable import Hold


def source(text):
    return SourceText("x.fcl", text)


def sound(text):
    system, diagnostics = read(source(text))
    assert system is not None, [d.message for d in diagnostics]
    return system


def found(text):
    """Return code, line and column of every diagnostic."""
    _, diagnostics = read(source(text))
    return [(d.code, d.span.line, d.span.column) if d.span else (d.code, 0, 0) for d in diagnostics]


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


def with_rule(rule, **more):
    return sound(block(rules=f"RULE 1 : {rule}", **more))


LOW_X, HIGH_X = Is(variable="x", term="low"), Is(variable="x", term="high")
LOW_Y, HIGH_Y = Is(variable="y", term="low"), Is(variable="y", term="high")


def test_a_file_of_the_standard_has_the_numerics_of_its_definitions():
    system = sound(block())
    assert system.name == "demo"
    assert [v.name for v in (*system.inputs, *system.outputs)] == ["x", "y", "u"]
    assert system.input("x").term("low").membership.kind == "piecewise"
    assert system.output("u").otherwise == Number(0.5)
    assert system.method.semantics.profile == "exact"
    assert system.rules[1].antecedent == And(operands=(HIGH_X, HIGH_Y))
    # The first rule fires with 0.75, the second with min(0.25, 0.5).
    assert system(x=2.5, y=5) == pytest.approx(0.25 / (0.75 + 0.25), abs=1e-15)


def test_comments_of_every_kind_byte_order_mark_and_capitals():
    text = "\ufeff(* one *) # two\n/* three\n */ function_block Demo // four\n" + block().split("\n", 1)[1].lower()
    text = text.replace("end_fuzzify", "End_Fuzzify { pragma }", 1)
    system = sound(text)
    assert system.name == "Demo"
    assert len(system.rules) == 2


def test_windows_line_ends_and_semicolons_left_out_at_line_ends():
    text = block(rules="RULE 1 : IF x IS low THEN u IS no\nRULE 2 : IF x IS high\n AND y IS high THEN u IS yes")
    assert sound(text.replace("\n", "\r\n")).rules[1].antecedent == And(operands=(HIGH_X, HIGH_Y))


def test_the_name_of_a_block_is_the_rest_of_its_line():
    system = sound(block(name="approximation of sin(x)/x // this"))
    assert (system.name, system.title) == ("approximation_of_sin_x_x", "approximation of sin(x)/x")


def test_several_function_blocks_are_several_systems():
    systems, diagnostics = read_all(source(block(name="a") + block(name="b")))
    assert [s.name for s in systems] == ["a", "b"]
    assert diagnostics == []
    with pytest.raises(DiagnosticError, match="several systems"):
        loads(block(name="a") + block(name="b"), "x.fcl")
    assert loads(block(name="a") + block(name="b"), "x.fcl", block="b").name == "b"


@pytest.mark.parametrize(
    ("shape", "kind", "parameters"),
    [
        ("TRIAN 0 1 2", "triangle", (0, 1, 2)),
        ("trian 0, 1, 2", "triangle", (0, 1, 2)),
        ("TRAPE -2 0 1 3", "trapezoid", (-2, 0, 1, 3)),
        ("GAUSS 5 2", "gaussian", (5, 2)),
        ("GAUSS2 2 2 3 1", "gaussian2", (2, 2, 3, 1)),
        ("GBELL 2 4 3", "bell", (3, 2, 4)),
        ("SIGM -4 3", "sigmoid", (3, -4)),
        ("DSIGM 8 3 5 7", "sigmoid_difference", (3, 8, 5, 7)),
        ("COSINE 2 5", "cosine", (5, 4)),
        ("Cosine 2 5", "cosine", (2, 5)),
        ("Triangle 0.000 1.000 2.000", "triangle", (0, 1, 2)),
        ("Ramp 1.000 0.000", "ramp", (1, 0)),
        ("Binary 3 inf", "rectangle", (3, math.inf)),
        ("Binary 3 -inf", "rectangle", (-math.inf, 3)),
        ("Discrete 0 1 4 0", "piecewise", (0, 1, 4, 0)),
        ("(0, 1), (4, 0)", "piecewise", (0, 1, 4, 0)),
        ("(3, 1)", "piecewise", (3, 1, 4, 1)),
        ("SINGLETONS (3, 1)", "singleton", (3,)),
        ("-1.5e-3", "singleton", (-0.0015,)),
    ],
)
def test_shapes(shape, kind, parameters):
    system = sound(block(terms=f"TERM low := {shape}; TERM high := TRIAN 0 5 10;"))
    membership = system.input("x").term("low").membership
    assert (membership.kind, tuple(a.value for a in membership.arguments)) == (kind, parameters)


def test_fuzzylite_gives_terms_a_height():
    system = sound(block(terms="TERM low := Triangle 0 1 2 0.5; TERM high := Triangle 0 5 10;"))
    assert system.input("x").term("low").membership.height == Number(0.5)


def test_a_constant_of_an_input_is_its_degree_everywhere_as_in_fuzzylite():
    terms = "TERM low := Constant 0.25; TERM high := Ramp 0 10;"
    rules = "RULE 1 : if x is low then u is yes;\nRULE 2 : if x is high then u is no;"
    system = sound(block(terms=terms, rules=rules))
    assert [system(x=x, y=1.0) for x in (2.5, 7.5)] == [0.25 / (0.25 + 0.25), 0.25 / (0.25 + 0.75)]


def test_a_surplus_parameter_is_reported_and_has_no_effect():
    text = block(terms="TERM low := TRIAN 0 1 2 3;\nTERM high := TRIAN 0 5 10;")
    assert ("FZ603", 8, 25) in found(text)
    assert sound(text).input("x").term("low").membership.arguments[2] == Number(2.0)


def test_a_difference_of_sigmoids_is_clamped_as_in_jfuzzylogic():
    assert (
        sound(block(terms="TERM low := DSIGM 8 3 5 7; TERM high := 1;")).method.semantics.sigmoid_difference
        == "clamped"
    )


def test_constants_of_var_are_params():
    variables = "VAR_INPUT x, y : REAL; END_VAR VAR_OUTPUT u : REAL; END_VAR\nVAR top : REAL := 10; END_VAR"
    system = sound(block(variables=variables, terms="TERM low := (0, 1) (top, 0); TERM high := TRIAN 0 5 top;"))
    assert system(x=5, y=5) == system.with_params(top=10)(x=5, y=5) != system.with_params(top=20)(x=5, y=5)


def test_initial_values_and_local_variables_have_no_effect():
    variables = VARIABLES.replace("u : REAL;", "u : REAL := 3;") + "\nVAR k : REAL; END_VAR"
    diagnostics = read(source(block(variables=variables)))[1]
    assert [(d.code, d.span.text) for d in diagnostics] == [("FZ603", "u"), ("FZ603", "k")]


def test_functions_know_pi_and_names_in_other_capitals():
    terms = "TERM no := FUNCTION SIN(Pi * X) + +Y - 2; TERM yes := 1; METHOD : COGF; RANGE := (0 .. 9);"
    system = sound(block(consequents=terms, rules="RULE 1 : IF ((x IS low)) THEN ((u IS no));"))
    assert system(x=2.5, y=5) == pytest.approx(4, rel=1e-15)


def test_parameters_that_are_inputs_are_refused_once_for_each():
    text = block(terms="TERM low := (0, 1) (y, 0);\nTERM high := (0, 0) (y, 1);")
    assert [f for f in found(text) if f[0] == "FZ602"] == [("FZ602", 8, 21)]


@pytest.mark.parametrize(
    ("condition", "antecedent"),
    [
        ("NOT x IS low", Not(operand=LOW_X)),
        ("x IS NOT low", Is(variable="x", term="low", hedges=("not",))),
        ("x IS NOT very low", Is(variable="x", term="low", hedges=("not", "very"))),
        ("NOT (x IS low OR y IS low)", Not(operand=Or(operands=(LOW_X, LOW_Y)))),
        ("x IS low OR (y IS low AND x IS high)", Or(operands=(LOW_X, And(operands=(LOW_Y, HIGH_X))))),
        ("((x IS low) AND (y IS low))OR(x IS high)", Or(operands=(And(operands=(LOW_X, LOW_Y)), HIGH_X))),
        ("(x IS low AND y IS low) AND x IS high", And(operands=(And(operands=(LOW_X, LOW_Y)), HIGH_X))),
        ("x IS any", Is(variable="x", term="low", hedges=("any",))),
    ],
)
def test_conditions(condition, antecedent):
    assert with_rule(f"IF {condition} THEN u IS no;").rules[0].antecedent == antecedent


def test_mixed_and_or_bind_as_the_dialect_has_it_with_a_warning_where_it_matters():
    rule = "IF x IS low OR y IS low AND x IS high THEN u IS no;"
    assert with_rule(rule).rules[0].antecedent == Or(operands=(LOW_X, And(operands=(LOW_Y, HIGH_X))))
    left = with_rule(rule, terms="TERM low := TRIAN 0 0 9; TERM high := TRIAN 0 9 9;").rules[0].antecedent
    assert left == And(operands=(Or(operands=(LOW_X, LOW_Y)), HIGH_X))
    assert "FZ609" in [f[0] for f in found(block(rules=f"RULE 1 : {rule}"))]
    harmless = "RULE 1 : IF x IS low AND y IS low OR x IS high THEN u IS no;"
    assert found(block(rules=harmless)) == []


def test_several_conclusions_and_weights():
    rule = with_rule("IF x IS low THEN u IS no, u IS yes WITH 0.25").rules[0]
    assert [c.term for c in rule.consequents] == ["no", "yes"]
    assert rule.weight == Number(0.25)


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
def test_and_and_or_are_a_pair(norms, conjunction, disjunction):
    method = sound(block(rules=f"{norms} RULE 1 : IF x IS low AND y IS low THEN u IS no;")).method
    assert (method.conjunction, method.disjunction) == (conjunction, disjunction)


def test_norms_that_are_no_pair_are_reported_where_both_count():
    both = "AND : PROD; OR : MAX; RULE 1 : IF x IS low AND (y IS low OR x IS high) THEN u IS no;"
    assert [f[0] for f in found(block(rules=both))] == ["FZ609"]
    assert found(block(rules="AND : PROD; OR : MAX; RULE 1 : IF x IS low AND y IS low THEN u IS no;")) == []


SETS = "TERM no := (0, 0) (1, 1) (2, 0); TERM yes := (1, 0) (2, 1) (3, 0); RANGE := (0 .. 3);"


@pytest.mark.parametrize(
    ("method", "kind"),
    [("COG", "centroid"), ("COA", "bisector"), ("LM", "som"), ("RM", "lom"), ("MM", "mom"), ("Centroid", "centroid")],
)
def test_methods_for_sets(method, kind):
    assert sound(block(consequents=f"{SETS} METHOD : {method};")).method.defuzzifier == Defuzzifier(kind=kind)


def test_accumulation_may_stand_in_either_block():
    in_rules = sound(block(consequents=SETS, rules="ACCU : BSUM; RULE 1 : IF x IS low THEN u IS no;"))
    in_output = sound(block(consequents=f"{SETS} ACCU : BSUM;", rules="RULE 1 : IF x IS low THEN u IS no;"))
    assert in_rules.method.aggregation == in_output.method.aggregation == "bounded_sum"


def test_rules_of_one_singleton_are_accumulated_first():
    rules = "ACCU : {};\nRULE 1 : IF x IS low THEN u IS no;\nRULE 2 : IF y IS low THEN u IS no;\n"
    rules += "RULE 3 : IF x IS high THEN u IS yes;"
    most = sound(block(rules=rules.format("MAX")))
    total = sound(block(rules=rules.format("SUM")))
    # x: low 0.5, high 0.5; y: low 0.75.
    assert most(x=5, y=2.5) == pytest.approx(0.5 / (0.75 + 0.5), rel=1e-15)
    assert total(x=5, y=2.5) == pytest.approx(0.5 / (0.5 + 0.75 + 0.5), rel=1e-15)


@pytest.mark.parametrize(
    ("default", "otherwise"),
    [
        ("DEFAULT := -2.5;", Number(-2.5)),
        ("DEFAULT := NC;", Hold(start="nan")),
        ("DEFAULT := nan;", "nan"),
        ("DEFAULT := 3 | NC;", Hold(start=Number(3.0))),
        ("DEFAULT := nan | NC;", Hold(start="nan")),
        ("LOCK : PREVIOUS;", Hold(start="nan")),
        ("", "nan"),
    ],
)
def test_what_an_output_is_where_no_rule_fires(default, otherwise):
    system = sound(block(consequents=f"{SETS} METHOD : COG; {default}"))
    assert system.output("u").otherwise == otherwise


def test_jfuzzylogic_keeps_the_previous_value_where_no_default_is_given():
    system = sound(block(consequents=f"{SETS.replace('RANGE', '// of jFuzzyLogic' + chr(10) + 'RANGE')} METHOD : COG;"))
    assert system.output("u").otherwise == Hold(start="nan")
    assert system.method.defuzzifier == Defuzzifier(kind="centroid", resolution=1000, grid="left", rule="plain")


def test_functions_of_takagi_and_sugeno():
    text = block(
        consequents="TERM no := FUNCTION (x * 0.5) + 2; TERM yes := FUNCTION LN(x) - LOG(100) ^ 2 / y; METHOD : COGF;"
    )
    system = sound(text)
    assert system.output("u").term("no").membership.kind == "function"
    rule_1_only = sound(text.replace("RULE 2", "(*").replace("yes;\nEND", "yes;*)\nEND"))
    assert rule_1_only(x=4, y=5) == pytest.approx(4.0, rel=1e-15)
    # Rule 1 has 0.2, rule 2 min(0.8, 0.5).
    expected = (0.2 * 6 + 0.5 * (math.log(8) - 4 / 5)) / 0.7
    assert system(x=8, y=5) == pytest.approx(expected, rel=1e-14)


def test_functions_of_inputs_themselves_and_of_outputs_declared_before():
    text = block(variables=VARIABLES.replace("u : REAL;", "u, v : REAL;"))
    text = text.replace("TERM low := (0, 1) (10, 0);", "TERM low := FUNCTION 1 - x / 10;", 1)
    second = "DEFUZZIFY v\nTERM twice := FUNCTION 2 * u; METHOD : COGF; RANGE := (0 .. 2);\nEND_DEFUZZIFY\nRULEBLOCK"
    text = text.replace("RULEBLOCK", second, 1).replace("THEN u IS no", "THEN u IS no, v IS twice")
    system = sound(text)
    assert system.input("x").term("low").membership.kind == "function"
    values = system(x=4, y=5)
    assert values["v"] == 2 * values["u"] == pytest.approx(2 * 0.4 / (0.6 + 0.4), rel=1e-15)


def test_a_sum_over_all_inputs_in_order_is_linear():
    system = sound(block(consequents="TERM no := FUNCTION 2 * x + -3 * y + 1; TERM yes := 1; METHOD : COGF;"))
    membership = system.output("u").term("no").membership
    assert (membership.kind, [a.value for a in membership.arguments]) == ("linear", [2, -3, 1])


def test_a_method_for_sets_with_numbers_takes_their_average_and_says_so():
    text = block(consequents="TERM no := 0; TERM yes := 1;\nMETHOD : COG; RANGE := (0 .. 1);")
    assert [f for f in found(text) if f[0] == "FZ603"] == [("FZ603", 15, 1)]
    assert sound(text)(x=2.5, y=5) == pytest.approx(0.25, abs=1e-15)


def test_monotone_sets_with_cogs_are_tsukamotos():
    system = sound(block(consequents="TERM no := Ramp 1 0; TERM yes := Ramp 0 1; METHOD : COGS; RANGE := (0 .. 1);"))
    assert system.method.defuzzifier.kind == "tsukamoto"


def test_rising_and_falling_points_with_cogs_are_tsukamotos():
    points = "TERM no := (0, 1) (1, 0.8) (3, 0); TERM yes := (1, 0) (2, 0.5) (3, 1);"
    system = sound(block(consequents=f"{points} METHOD : COGS; RANGE := (0 .. 3);"))
    assert system.method.defuzzifier.kind == "tsukamoto"
    # At x = 1 and y = 10 'no' has 0.9 and 'yes' 0.1, which lie at 0.5 and at 1.2.
    assert system(x=1, y=10) == pytest.approx(0.9 * 0.5 + 0.1 * 1.2, rel=1e-14)


def test_the_range_of_a_function_is_said_to_be_estimated():
    terms = "TERM no := FUNCTION x * y; TERM yes := (x - 5) * (x - 5);".replace(":= (x", ":= FUNCTION (x")
    _, diagnostics = read(source(block(consequents=f"{terms} METHOD : COGS;")))
    message = next(d.message for d in diagnostics if d.code == "FZ610")
    assert message == "'u' has no RANGE; [0, 100] is taken, estimated from a few points of its functions"


@pytest.mark.parametrize("end", ["END_FUNCTION_BLOCK;", "end_function_block ;"])
def test_a_semicolon_behind_the_end_is_harmless(end):
    assert sound(block().replace("END_FUNCTION_BLOCK", end)) == sound(block())


def test_ranges_are_estimated_as_jfuzzylogic_does_and_that_is_said():
    text = block(
        variables="VAR_INPUT x, y : REAL; END_VAR\nVAR_OUTPUT u : REAL; END_VAR",
        terms="TERM low := GAUSS 2 1; TERM high := SIGM 3 10;",
        consequents="TERM no := TRIAN 0 5 10; TERM yes := GBELL 1 2 20; METHOD : COG;",
    )
    system = sound(text)
    assert (system.input("x").lower, system.input("x").upper) == (Number(-2.0), Number(13.0))
    assert system.output("u").lower == Number(0.0)
    assert system.output("u").upper.value == pytest.approx(20 + 999**0.25, rel=1e-15)
    assert [f[:2] for f in found(text) if f[0] == "FZ610"] == [("FZ610", 2), ("FZ610", 3)]


def test_several_rule_blocks_keep_their_names_and_say_in_what_they_differ():
    second = "END_RULEBLOCK\nRULEBLOCK second\nAND : {};\nRULE 1 : IF x IS high {} y IS low THEN u IS yes;"
    first = "AND : MIN;\nRULE 1 : IF x IS low AND y IS low THEN u IS no;\n"
    for norm, word, own in (("MIN", "AND", None), ("PROD", "OR", None), ("PROD", "AND", "product")):
        system = sound(block(rules=first + second.format(norm, word)))
        assert [b.name for b in system.rule_blocks] == ["first", "second"]
        assert [b.conjunction for b in system.rule_blocks] == [None, own]
        assert [m.block for m in system.rule_methods] == [0, 1]
    assert [m.disjunction for m in sound(block(rules=first + second.format("PROD", "OR"))).rule_methods][1] == (
        "probabilistic_sum"
    )


def test_a_rule_block_that_is_switched_off_has_no_effect_and_that_is_said():
    second = "END_RULEBLOCK\nRULEBLOCK second\nENABLED : FALSE;\nRULE 1 : IF x IS high THEN u IS yes;"
    first = "RULE 1 : IF x IS low THEN u IS no;\n"
    text = block(rules=first + second)
    assert sound(text).rules == sound(block(rules=first)).rules
    assert not sound(text).rule_blocks
    assert [f[0] for f in found(text)] == ["FZ611"]
    off = block(rules="ENABLED : FALSE;\n" + first)
    assert [f[0] for f in found(off)] == ["FZ611", "FZ212"]


def test_implications_of_rule_blocks_count_where_they_set_a_set_and_accumulations_must_agree():
    sets = "TERM no := (0, 1) (1, 0); TERM yes := (0, 0) (1, 1); METHOD : COG; RANGE := (0 .. 1);"
    second = "END_RULEBLOCK\nRULEBLOCK second\nACT : PROD; {}\nRULE 1 : IF x IS high THEN u IS yes;"
    first = "ACT : MIN; ACCU : MAX;\nRULE 1 : IF x IS low THEN u IS no;\n"
    made = sound(block(rules=first + second.format("ACCU : MAX;"), consequents=sets))
    assert [b.implication for b in made.rule_blocks] == [None, "product"]
    assert [b.implication for b in sound(block(rules=first + second.format(""))).rule_blocks] == [None, None]
    refused = found(block(rules=first + second.format("ACCU : BSUM;"), consequents=sets))
    assert [f[0] for f in refused] == ["FZ602"]


def test_names_that_differ_in_capitals_only_are_taken_for_each_other_with_a_warning():
    text = block(rules="RULE 1 : IF X IS Low THEN u IS no;")
    assert sound(text).rules[0].antecedent == LOW_X
    assert [f for f in found(text) if f[0] == "FZ604"] == [("FZ604", 17, 13), ("FZ604", 17, 18)]


def test_a_second_term_of_one_name_gets_another():
    text = block(terms="TERM low := 1;\nTERM low := 2;\nTERM high := 3;")
    system = sound(text)
    assert [t.name for t in system.input("x").terms] == ["low", "low_2", "high"]
    assert ("FZ604", 9, 6) in found(text)


GOOD_RULE = "\nRULE 9 : IF x IS low THEN u IS no;"

#: A part of the block, its text, and what is found: code and column.
MISTAKES = [
    ("rules", "RULE 1 : IF z IS low THEN u IS no;", "FZ202", 13, "no input or output 'z'"),
    ("rules", "RULE 1 : IF x IS lwo THEN u IS no;", "FZ203", 18, "'x' has no term 'lwo'"),
    ("rules", "RULE 1 : IF x IS low THEN u IS maybe;", "FZ203", 32, "'u' has no term 'maybe'"),
    ("rules", "RULE 1 : IF x IS low THEN w IS no;", "FZ202", 27, "no output 'w'"),
    ("rules", "RULE 1 : IF x IS low THEN x IS low;", "FZ214", 27, "'x' is an input"),
    ("rules", "RULE 1 : IF x IS vrey low THEN u IS no;", "FZ202", 18, "no hedge 'vrey'"),
    ("rules", "RULE 1 : IF x low THEN u IS no;", "FZ601", 15, "expected IS, found 'low'"),
    ("rules", "RULE 1 : IF (x IS low THEN u IS no;", "FZ601", 23, "expected AND, OR or ')', found 'THEN'"),
    ("rules", "RULE 1 : IF x IS low u IS no;", "FZ601", 22, "expected AND, OR or THEN, found 'u'"),
    ("rules", "RULE 1 : IF x IS low THEN u IS no WITH;", "FZ601", 39, "expected a weight, found ';'"),
    ("rules", "AND : MAX;" + GOOD_RULE, "FZ213", 7, "there is no AND 'MAX'"),
    ("rules", "ACCU : NOSUCH;" + GOOD_RULE, "FZ213", 8, "there is no ACCU 'NOSUCH'"),
    ("rules", "ACTIVATION : First;" + GOOD_RULE, "FZ602", 1, "an activation method other than General"),
    ("rules", "", "FZ212", 1, "the rule block has no rule"),
    ("rules", "FOO : 3;" + GOOD_RULE, "FZ601", 1, "expected a statement, found 'FOO'"),
    ("terms", "TERM low := TRIAN 0 1; TERM high := 1;", "FZ303", 13, "'TRIAN' has 2 parameters instead of 3"),
    ("terms", "TERM low := TRAIN 0 1 2; TERM high := 1;", "FZ601", 13, "no shape 'TRAIN'"),
    ("terms", "TERM low := (0, 1) (2; TERM high := 1;", "FZ601", 22, "expected ',', found ';'"),
    ("terms", "TERM low := width; TERM high := 1;", "FZ202", 13, "'width' is neither a number nor declared"),
    ("terms", "TERM low := SINGLETONS (1, 1) (2, 0.5); TERM high := 1;", "FZ602", 13, "several singletons"),
    ("terms", "TERM low := FUNCTION y; TERM high := 1;", "FZ202", 22, "no variable 'y'"),
    ("terms", "TERM low := 1; TERM high := 1; METHOD : COG;", "FZ214", 32, "METHOD belongs to DEFUZZIFY"),
    ("terms", "TERM low := 1; TERM high := 1; ENABLED : FALSE;", "FZ602", 32, "switched off"),
    ("terms", "TERM low := 1; TERM high := 1; RANGE := (0 .. );", "FZ601", 32, "a range has two ends"),
    ("terms", "TERM low := 1e999; TERM high := 1;", "FZ108", 13, "a double cannot hold this number"),
    ("terms", "TERM low := 1; TERM high := 1; @@@", "FZ601", 32, "the character '@' (U+0040)"),
    ("consequents", f"{SETS} METHOD : COGS;", "FZ214", 87, "'COGS' is for numbers"),
    ("consequents", "METHOD : COG;", "FZ212", 11, "output 'u' has no terms"),
    ("consequents", "TERM no := 0; TERM yes := 1; DEFAULT := never;", "FZ213", 41, "DEFAULT is a number or NC"),
    ("consequents", "TERM no := FUNCTION u; TERM yes := 1;", "FZ602", 21, "a function of the output 'u'"),
    ("consequents", "TERM no := FUNCTION trunc(x); TERM yes := 1;", "FZ602", 21, "the function 'trunc'"),
    ("consequents", "TERM no := FUNCTION x % 2; TERM yes := 1;", "FZ602", 23, "the remainder '%'"),
    ("consequents", "TERM no := FUNCTION x ^ 2 ^ 3; TERM yes := 1;", "FZ601", 27, "'a ^ b ^ c' is read from the left"),
    ("consequents", "TERM no := FUNCTION inf * x; TERM yes := 1;", "FZ602", 21, "a number of a function is not finite"),
    ("consequents", "TERM no := FUNCTION sin(x, y); TERM yes := 1;", "FZ303", 21, "'sin' does not take 2 arguments"),
    ("consequents", "TERM no := nan; TERM yes := 1;", "FZ302", 12, "parameter 1 of 'no' is not a number"),
    ("consequents", "TERM no := Constant 0 1; TERM yes := 1;", "FZ303", 12, "'Constant' takes 1 number, got 2"),
    ("terms", "TERM low := 0 1; TERM high := 1;", "FZ601", 13, "2 numbers without the word of a shape"),
    ("terms", "TERM low := TRIAN 0 1 -; TERM high := 1;", "FZ601", 24, "expected a number, found ';'"),
    ("consequents", "TERM no := FUNCTION (x; TERM yes := 1;", "FZ601", 23, "expected ')', found ';'"),
    ("consequents", "TERM no := 0; TERM yes := 1; METHOD : COGS; METHOD : COG;", "FZ215", 45, "METHOD is given twice"),
]


@pytest.mark.parametrize(("part", "text", "code", "column", "message"), MISTAKES, ids=[m[1] for m in MISTAKES])
def test_a_mistake_is_reported_with_its_place(part, text, code, column, message):
    system, diagnostics = read(source(block(**{part: text})))
    assert system is None
    errors = [d for d in diagnostics if d.severity == "error"]
    assert (errors[0].code, errors[0].span.column) == (code, column)
    assert message in errors[0].message


def test_all_mistakes_are_reported_at_once():
    rules = "RULE 1 : IF x IS lwo THEN u IS no;\nRULE 2 : IF y IS low u IS no;\nRULE 3 : IF z IS low THEN u IS no;"
    assert sorted(f[:2] for f in found(block(rules=rules))) == [("FZ202", 19), ("FZ203", 17), ("FZ601", 18)]


def test_what_a_broken_statement_declares_is_not_missed():
    text = block(terms="TERM low := TRIAN 0 1 two%;\nTERM high := 1;")
    assert {f[0] for f in found(text)} == {"FZ601"}


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "FZ004"),
        ("(* nothing", "FZ601"),
        ("FUNCTION_BLOCK x", "FZ601"),
        ("FUNCTION_BLOCK x END_FUNCTION_BLOCK", "FZ212"),
        ("VAR_INPUT x : REAL; END_VAR", "FZ601"),
        (block().replace("END_FUZZIFY", ""), "FZ601"),
        (block().replace("END_FUNCTION_BLOCK", ""), "FZ601"),
        (block().replace("FUZZIFY y", "FUZZIFY z"), "FZ202"),
        (block().replace("VAR_OUTPUT u", "VAR_OUTPUT v"), "FZ202"),
        (block().replace(" y : REAL;", " x : REAL;"), "FZ201"),
        (block().replace("FUZZIFY y", "FUZZIFY x"), "FZ215"),
        (block().replace("VAR_INPUT", "VAR_IN_OUT"), "FZ602"),
    ],
)
def test_a_broken_file_is_reported(text, code):
    system, diagnostics = read(source(text))
    assert system is None
    assert code in [d.code for d in diagnostics if d.severity == "error"]


@pytest.mark.parametrize("between", [" ", "\t \t"])
def test_a_file_may_stand_in_one_line(between):
    text = between.join(block().split())
    assert found(text) == found(block())[:0]
    assert sound(text).model_copy(update={"span": None}) == sound(block()).model_copy(update={"span": None})


@pytest.mark.parametrize("word", ["OPTION", "OPTIONS"])
def test_options_have_no_effect_and_that_is_said(word):
    text = block().replace("RULEBLOCK first", f"{word}\n foo = 3;\nEND_{word}\nRULEBLOCK first")
    assert [f[0] for f in found(text)] == ["FZ603"]
    assert sound(text) == sound(block())


@pytest.mark.parametrize("again", ["RANGE := (0 .. 2);", "METHOD : COG;", "DEFAULT := 1;"])
def test_a_statement_given_twice_on_lines_of_their_own_is_reported_once(again):
    text = block(consequents=f"{SETS}\n{again}\n{again}\nTERM more := TRIAN 0 1 2;")
    assert [f[0] for f in found(text) if f[0] == "FZ215"] == ["FZ215"] * (2 if "RANGE" in again else 1)


def test_deep_nesting_is_refused():
    condition = "(" * 5000 + "x IS low" + ")" * 5000
    assert next(f[0] for f in found(block(rules=f"RULE 1 : IF {condition} THEN u IS no;"))) == "FZ106"
    formula = "(" * 5000 + "x" + ")" * 5000
    assert "FZ106" in [f[0] for f in found(block(consequents=f"TERM no := FUNCTION {formula}; TERM yes := 1;"))]
    chain = " + ".join(["x"] * 5000)
    assert "FZ106" in [f[0] for f in found(block(consequents=f"TERM no := FUNCTION {chain}; TERM yes := 1;"))]


@pytest.mark.parametrize(
    ("comment", "aggregation", "said"), [("", "sum", "plain sum"), ("// jFuzzyLogic\n", "bounded_sum", "BSUM")]
)
def test_the_normalized_sum_is_that_of_the_dialect_and_that_is_said(comment, aggregation, said):
    sets = "TERM no := (0, 1) (1, 0); TERM yes := (0, 0) (1, 1); METHOD : COG; RANGE := (0 .. 1);"
    text = comment + block(consequents=sets, rules=RULES.replace("ACCU : MAX", "ACCU : NSUM"))
    system, diagnostics = read(source(text))
    assert system.method.aggregation == aggregation
    (warning,) = [d for d in diagnostics if d.code == "FZ609"]
    assert said in warning.message
    assert (warning.span.line, warning.span.text) == (17 + bool(comment), "ACCU : NSUM")


def test_fuzzylites_word_for_the_normalized_sum_needs_no_warning():
    rules = RULES.replace("ACCU : MAX", "ACCU : NormalizedSum")
    sets = "TERM no := Ramp 1 0; TERM yes := Ramp 0 1; METHOD : Centroid; RANGE := (0 .. 1);"
    system, diagnostics = read(source(block(consequents=sets, rules=rules)))
    assert system.method.aggregation == "bounded_sum"
    assert [d.code for d in diagnostics] == []


def test_the_last_rule_of_a_block_in_one_line_may_lack_its_semicolon():
    text = block().replace("THEN u IS yes;\n", "THEN u IS yes ").replace("\n", " ")
    assert len(sound(text).rules) == 2


def test_function_blocks_of_one_name_are_reported_once_at_the_second():
    _, diagnostics = read_all(source(block() + block(name="other") + block()))
    (error,) = [d for d in diagnostics if d.severity == "error"]
    assert (error.code, error.message) == ("FZ201", "function block 'demo' is declared twice")
    assert error.span.line > error.notes[0].span.line == 1
