import re
from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest

from fuzzyctl import (
    ArgumentError,
    DiagnosticError,
    ValueOutOfBoundsError,
    build,
    compile,
    dumps,
    load,
    loads,
)
from fuzzyctl.expr import span_of, walk


def tipper(**changes):
    service = build.input_variable("service", 0, 10, build.partition("poor good excellent"), label="Service")
    food = build.input_variable(
        "food", 0, 10, {"bad": ("trapezoid", -inf, 0, 1, 3), "fine": ("trapezoid", 1, 3, 10, inf)}
    )
    tip = build.output_variable("tip", 0, 30, {"low": 0, "fair": 15, "high": 30}, unit="%")
    table = build.rule_table(
        "tip",
        "service",
        {"poor": "low fair", "good": ["fair", "high"], "excellent": "fair 30"},
        "food",
        headers="bad fine",
    )
    given = {"defuzzifier": "weighted_average", "conjunction": "product"} | changes
    return build.system("tipper", [service, food, tip], [table], **given)


class TestBuild:
    def test_a_system_built_in_python_is_the_one_written_as_text(self):
        text = """\
system tipper
and product
defuzzifier weighted_average
input service "Service" in [0, 10]
  poor = triangle(-inf, 0, 5)
  good = triangle(0, 5, 10)
  excellent = triangle(5, 10, inf)
input food in [0, 10]
  bad = trapezoid(-inf, 0, 1, 3)
  fine = trapezoid(1, 3, 10, inf)
output tip in [0, 30] unit "%"
  low = constant(0)
  fair = constant(15)
  high = constant(30)
table tip = service x food
              bad   fine
  poor      | low   fair
  good      | fair  high
  excellent | fair  30
"""
        assert tipper()(service=7, food=2) == loads(text)(service=7, food=2)
        once = loads(dumps(tipper()))
        assert once(service=7, food=2) == loads(text)(service=7, food=2)
        assert loads(dumps(once)) == once

    def test_the_paper_s_function_can_be_built(self):
        peaks = {"NB": -1, "NM": -0.66, "NS": -0.33, "ZO": 0, "PS": 0.09, "PM": "f_max"}
        cells = {
            "NB": "NB NM NM NS NS",
            "NS": "NM NS ZO PS ZO",
            "ZO": "ZO PS PM PS ZO",
            "PS": "ZO PS ZO NS NM",
            "PB": "NS NS NM NM NB",
        }
        names = "NB NS ZO PS PB"
        system = build.system(
            "ais",
            [
                build.input_variable("sigma", -0.06, 0.06, build.partition(names, [-0.03, -0.015, 0, 0.015, 0.03])),
                build.input_variable("dsigma", -1, 1, build.partition(names, [-0.5, -0.25, 0, 0.25, 0.5])),
                build.output_variable("f", -1, "f_max", {n: ("singleton", p) for n, p in peaks.items()}),
            ],
            [build.rule_table("f", "sigma", cells, "dsigma", headers=names)],
            params={"k_s": 0.55, "f_max": "(0.1 - 0.001) / k_s"},
            conjunction="product",
            defuzzifier="center_average",
        )
        shipped = load("ais_reaction")
        for point in ((0.01, -0.2), (0.0, 0.0), (-0.02, 0.4)):
            values = dict(zip(("sigma", "dsigma"), point, strict=True))
            assert system(**values) == pytest.approx(shipped(**values), abs=1e-15)

    def test_rules_may_be_texts(self):
        x = build.input_variable("x", 0, 1, build.partition("L H"))
        u = build.output_variable("u", 0, 1, {"A": 0, "B": 1}, otherwise=0.5)
        system = build.system(
            "s", [x, u], ["if not x is very L then u is B weight 0.5"], defuzzifier="weighted_average"
        )
        assert system(x=1.0) == 1.0
        assert system(x=0.0) == 0.5


class TestMistakes:
    def test_the_checks_are_those_of_a_file(self):
        with pytest.raises(DiagnosticError, match="FZ214"):
            tipper(defuzzifier="centroid")

    def test_unknown_names_are_found(self):
        x = build.input_variable("x", 0, 1, build.partition("L H"))
        u = build.output_variable("u", 0, 1, {"A": 0, "B": 1})
        with pytest.raises(DiagnosticError) as error:
            build.system(
                "s", [x, u], ["if y is L then u is A", "if x is rarely Q then u is C"], defuzzifier="weighted_average"
            )
        assert [d.code for d in error.value.diagnostics] == ["FZ202", "FZ202", "FZ203", "FZ203"]

    def test_texts_that_are_no_rules_or_expressions_are_refused(self):
        with pytest.raises(DiagnosticError, match="FZ102"):
            build.rule("if x is then y")
        with pytest.raises(ArgumentError, match="is not a rule"):
            build.rule("param a = 1")
        with pytest.raises(DiagnosticError):
            build.expression("1 +")

    def test_rows_and_cells_of_the_wrong_length_are_refused(self):
        with pytest.raises(ArgumentError, match="2 cells for 1 columns"):
            build.rule_table("u", "x", {"L": "A B"}, "y", headers="L")
        with pytest.raises(ArgumentError, match="2 terms for 1 outputs"):
            build.rule_table("u", "x", {"L": "A/B"})
        with pytest.raises(ArgumentError, match="partition"):
            build.partition("L H", [1])


class TestTexts:
    """What is written as text reads as it does in a file."""

    def system(self, rules, variables=(), **rest):
        x = build.input_variable("x", 0, 1, build.partition("L H"))
        mode = build.input_variable("mode", 0, 1, {"slow": "triangle(-inf, 0, 1)", "fast": ("triangle", 0, 1, inf)})
        u = build.output_variable("u", 0, 4, {"A": 0, "B": "k * 2", "C": "k"}, otherwise=0)
        given = {"params": {"k": (1.5, "m")}, "defuzzifier": "weighted_average"} | rest
        return build.system("s", [x, mode, u, *variables], rules, **given)

    def test_terms_may_be_texts(self):
        system = self.system(["if x is H and mode is fast then u is B", "if x is L then u is C"])
        assert (system(x=1, mode=1), system(x=0, mode=1)) == (3.0, 1.5)
        assert system.with_params(k=1)(x=1, mode=1) == 2.0
        assert system.params[0].unit == "m"

    def test_tables_may_be_slices_with_weights_and_functions(self):
        slow = build.rule_table("u", "x", {"L": "A", "H": "B*0.5"}, condition="mode is slow")
        fast = build.rule_table("u", "x", {"L": "linear(1, 2, 0.5)", "H": "(k + 1)"}, condition="not mode is slow")
        system = self.system([slow, fast])
        assert system(x=1, mode=0) == 3.0
        assert system(x=0, mode=1) == 2.5
        assert system(x=1, mode=1) == 2.5
        assert system(x=1, mode=0.5) == pytest.approx((0.5 * 0.5 * 3 + 0.5 * 2.5) / (0.25 + 0.5))

    def test_hedges_and_guarantees_may_be_texts(self):
        rules = ["if x is sharply H then u is B", "if x is not sharply H then u is A"]
        system = self.system(rules, hedges={"sharply": "x ^ 4"}, guarantees=["u >= 0 within 1e-9"])
        assert system(x=0.5, mode=0) == pytest.approx(3 * 0.5**4)
        assert len(system.guarantees) == 1
        assert loads(dumps(system)) == system

    def test_an_output_may_have_a_method_of_its_own_and_hold(self):
        terms = {"A": "triangle(0, 0.2, 0.4)", "B": ("triangle", 0.5, 0.7, 0.9)}
        v = build.output_variable("v", 0, 1, terms, otherwise="hold", defuzzifier="centroid", implication="product")
        system = self.system(["if x is H and mode is fast then v is B, u is B"], [v])
        assert system(x=0.5, mode=0.5)["v"] == pytest.approx(0.7)
        assert system(x=0, mode=0)["v"] == 0.5
        assert "output v in [0, 1] else hold implication product defuzzifier centroid" in dumps(system)


X = build.input_variable("x", 0, 1, build.partition("L H"))
Y = build.input_variable("y", 0, 1, build.partition("L H"))
U = build.output_variable("u", 0, 1, {"A": 0, "B": 1}, otherwise=0)


class TestTheSameChecksAsAFile:
    def codes(self, name="s", variables=(X, U), rules=("if x is L then u is A", "if x is H then u is B"), **rest):
        with pytest.raises(DiagnosticError) as error:
            build.system(name, variables, rules, **{"defuzzifier": "weighted_average"} | rest)
        assert all(d.span is None and not d.notes and "line" not in str(d.facts) for d in error.value.diagnostics)
        return [d.code for d in error.value.diagnostics]

    @pytest.mark.parametrize("name", ["a b", "", "x\ny", "1a", "a-b"])
    def test_what_is_no_name_names_nothing(self, name):
        assert self.codes(name) == ["FZ102"]
        assert self.codes(params={name: 1}) == ["FZ102"]
        assert self.codes(variables=[X, build.output_variable("u", 0, 1, {"A": 0, "B": 1, name: 2})]) == ["FZ102"]

    def test_words_of_the_language_name_no_variables(self):
        assert self.codes(variables=[X, U, build.input_variable("inf", 0, 1, build.partition("N P"))]) == ["FZ201"]

    @pytest.mark.parametrize(
        ("rows", "headers", "code"),
        [
            ({"L": "A A"}, "L H", "FZ204"),
            ({"L": "A", "H": "A"}, "L", "FZ205"),
            ({"L": "A A", "H": "A A"}, "L L", "FZ206"),
        ],
    )
    def test_tables_are_whole(self, rows, headers, code):
        assert self.codes(variables=[X, Y, U], rules=[build.rule_table("u", "x", rows, "y", headers=headers)]) == [code]

    def test_a_table_crosses_two_inputs(self):
        table = build.rule_table("u", "x", {"L": "A A", "H": "A A"}, "x", headers="L H")
        assert self.codes(rules=[table]) == ["FZ214"]

    @pytest.mark.parametrize(("spec", "code"), [(("trimf", 0, 1, 2), "FZ202"), (("triangle", 0, 1, 2, 3), "FZ303")])
    def test_membership_functions_are_those_there_are(self, spec, code):
        assert self.codes(variables=[build.input_variable("x", 0, 1, {"L": spec, "H": 0}), U])[0] == code

    def test_a_near_name_is_suggested(self):
        with pytest.raises(DiagnosticError, match=r"did you mean 'A'"):
            build.system("s", [X, U], ["if x is L then u is AA"], defuzzifier="weighted_average")

    def test_a_rule_made_by_hand_cannot_smuggle_statements_in(self):
        rule = build.rule("if x is L then u is A")
        for term in ("A weight 0.5", "A\nparam q = 1"):
            smuggler = replace(rule, consequents=(replace(rule.consequents[0], term=term),))
            assert self.codes(rules=[smuggler]) == ["FZ102"]


class TestArguments:
    def test_of_the_wrong_type_are_named(self):
        with pytest.raises(ArgumentError, match="'activation' must be the text of an activation method"):
            build.system("s", [X, U], ["if x is L then u is A"], activation=3)
        with pytest.raises(ArgumentError, match="'lower' must be a number or the text of an expression, got list"):
            build.input_variable("x", [], 1, {})
        with pytest.raises(ValueOutOfBoundsError, match="not NaN"):
            build.input_variable("x", nan, 1, {})
        with pytest.raises(ArgumentError, match="'label' must be a text, got int"):
            build.input_variable("x", 0, 1, {}, label=3)

    def test_texts_hold_one_statement(self):
        for text in ("1\nparam q = 2", '1 unit "m"'):
            with pytest.raises((ArgumentError, DiagnosticError)):
                build.expression(text)
        with pytest.raises((ArgumentError, DiagnosticError)):
            build.rule("if x is L then u is A\nif x is H then u is B")


class TestFragments:
    """Texts are written as behind the keyword of a file, and what is wrong with them is said of them alone."""

    def built(self, **rest):
        return build.system("s", [X, U], ["if x is L then u is A"], **{"defuzzifier": "weighted_average"} | rest)

    def output(self, **rest):
        return build.output_variable("u", 0, 1, {"A": 0}, **rest)

    def test_hold_takes_a_number_or_a_text(self):
        assert self.output(otherwise=build.Hold(0.5)) == self.output(otherwise="hold(0.5)")
        assert self.output(otherwise=build.Hold(start="k / 2")) == self.output(otherwise="hold(k / 2)")
        assert self.output(otherwise=build.Hold()) == self.output(otherwise=" hold ")
        assert self.output(otherwise="hold(0.2)").otherwise.start == build.expression(0.2)
        with pytest.raises(ArgumentError, match=r"is not a value for 'otherwise'; the form is: hold\(START\)"):
            self.output(otherwise="hold(0.2) adaptive rate (1)")

    def test_what_is_held_goes_on_in_the_order_of_rows(self):
        gap = {"L": "triangle(-inf, 0, 0.1)", "H": "triangle(0.9, 1, inf)"}
        held = build.output_variable("u", 0, 1, {"A": 0, "B": 1}, otherwise=build.Hold(0.5))
        rules = ["if x is L then u is A", "if x is H then u is B"]
        system = build.system("s", [build.input_variable("x", 0, 1, gap), held], rules, defuzzifier="weighted_average")
        points = np.array([0.5, 1.0, 0.5, 0.0, 0.5, 1.0])
        for backend in ("numpy", "python"):
            kernel = compile(system, backend)
            assert kernel.run(points)[0].tolist() == [0.5, 1, 1, 0, 0, 1]
            assert kernel.run(points[::-1])[0].tolist() == [1, 1, 0, 0, 1, 1]
            assert kernel.batch(points).tolist() == [0.5, 1, 0.5, 0, 0.5, 1]

    def test_activation_is_what_a_file_says(self):
        for text in ("highest(count=1)", "threshold(>= 0.1)", "first(count=2, threshold=(k))"):
            system = self.built(activation=text, params={"k": 0.1})
            assert re.search(rf"\nactivation +{re.escape(text)}\n", dumps(system))
            assert loads(dumps(system)) == system
        assert self.built(activation="general") == self.built()

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("highest", "needs a count\n(.*\n)*.*write, for example: highest"),
            ("hihgest(count=1)", "did you mean 'highest'"),
            ("highest(count=1) general", "the form is: general"),
        ],
    )
    def test_an_activation_that_there_is_not_is_refused(self, text, message):
        with pytest.raises(DiagnosticError, match=message):
            self.built(activation=text)

    def test_a_defuzzifier_has_its_options(self):
        y = build.output_variable("u", 0, 1, {"A": "triangle(0, 0.5, 1)"}, otherwise=0)
        system = build.system("s", [X, y], ["if x is L then u is A"], defuzzifier="centroid(resolution=10)")
        assert system.method.defuzzifier.resolution == 10
        with pytest.raises(DiagnosticError, match="resolution = 0 is not a whole number"):
            self.built(defuzzifier="centroid(resolution=0)")

    def test_terms_take_keywords_and_a_height(self):
        terms = build.input_variable("x", 0, 1, {"A": "triangle(0, 1, right=k, height=0.5)"}).terms
        assert terms[0].membership == build.membership("triangle", 0, 1, "k", height=0.5)
        with pytest.raises(DiagnosticError, match=r"<term>:1:1: error\[FZ202\].*'triangel'"):
            build.input_variable("x", 0, 1, {"A": "triangel(0, 1, 2)"})
        assert build.input_variable("x", 0, 1, {"A": "max(k, 2)"}).terms[0].membership.kind == "constant"

    @pytest.mark.parametrize(
        ("call", "place", "form"),
        [
            (lambda: build.expression("1+"), "<expression>:1:2", "(k - 1) / 2"),
            (lambda: build.rule("if x is then u is A"), "<rule>:1:9", "if INPUT is TERM"),
            (lambda: build.rule_table("u", "x", {"L": "A *"}), "<table row>:1:3", "cells separated by blanks"),
            (lambda: build.rule_table("u", "x", {"L": "A"}, condition="x is"), "<condition>:1:4", "INPUT is TERM and"),
            (lambda: build.Hold("(1) 2"), "<expression>:1:5", "(k - 1) / 2"),
            (lambda: TestFragments().output(otherwise="hold(1 +)"), "<value for 'otherwise'>:1:9", "hold(START)"),
            (lambda: TestFragments().built(guarantees=["u <="]), "<guarantee>:1:4", "EXPRESSION >= EXPRESSION"),
        ],
    )
    def test_a_broken_one_shows_its_own_form_and_place(self, call, place, form):
        with pytest.raises(DiagnosticError) as error:
            call()
        shown = str(error.value)
        assert place in shown
        assert f"the form is: {form}" in shown
        assert "param" not in shown
        assert "_" not in shown

    def test_expressions_of_texts_have_no_places(self):
        """They would be those of a statement that was never written."""
        (term,) = build.input_variable("x", 0, 1, {"A": "triangle(0, k, 2 * k)"}).terms
        given = [*term.membership.arguments, build.expression("-k + max(1, k)"), build.Hold("k").start]
        assert all(span_of(part) is None for e in given for part in walk(e))

    def test_a_comment_hides_nothing(self):
        with pytest.raises(ArgumentError, match="is not a condition"):
            build.rule_table("u", "x", {"L": "A"}, condition="x is L then u is A #")

    def test_what_cannot_be_printed_is_refused_in_words_that_can(self):
        with pytest.raises(ArgumentError, match="is not an expression") as error:
            build.expression("k \ud800")
        assert str(error.value).encode()

    def test_names_of_a_method_have_no_blanks(self):
        with pytest.raises(DiagnosticError, match="'min ' cannot be the name of a conjunction"):
            self.built(conjunction="min ")
        with pytest.raises(DiagnosticError, match="'max ' cannot be the name of an aggregation"):
            build.system("s", [X, self.output(aggregation="max ")], ["if x is L then u is A"])


@pytest.mark.parametrize(
    ("call", "repaired"),
    [
        (lambda: build.input_variable("x", 0, 1, {"A": "gaussmf(10, 50)"}), "gaussian(50, 10)"),
        (lambda: TestFragments().built(guarantees=["u = 1"]), "u == 1"),
        (lambda: build.rule_table("u", "x", {"L": "A"}, condition="a IS b && c is d"), "a is b and c is d"),
    ],
)
def test_repairs_show_the_fragment_alone(call, repaired):
    with pytest.raises(DiagnosticError) as caught:
        call()
    assert [d.help for d in caught.value.diagnostics] == [f"write: {repaired}"]
