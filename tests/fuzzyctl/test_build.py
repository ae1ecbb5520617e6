from math import inf

import pytest

from fuzzyctl import build
from fuzzyctl.errors import ArgumentError, DiagnosticError
from fuzzyctl.formats.fz import dumps
from fuzzyctl.loading import load, loads
from fuzzyctl.shipped import rules_folder


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
        assert loads(dumps(tipper()))(service=7, food=2) == loads(text)(service=7, food=2)

    def test_it_prints_as_a_rule_file_that_reads_back(self):
        once = loads(dumps(tipper()))
        assert loads(dumps(once)) == once
        assert [t.name for t in once.inputs[0].terms] == ["poor", "good", "excellent"]

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
        shipped = load(rules_folder() / "ais_reaction.fz")
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
        with pytest.raises(ArgumentError, match="is no rule"):
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
