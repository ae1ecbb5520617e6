"""Reading on after repairs: valid files are left alone, locations are those of the text as it was written."""

import json
import re

import pytest

from fuzzyctl import loads
from fuzzyctl.analysis.check import check_source
from fuzzyctl.cli.reports import as_sarif
from fuzzyctl.diagnostics.diagnostic import render
from fuzzyctl.diagnostics.fixes import fixed
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang import repairs
from fuzzyctl.lang.parser import parse
from fuzzyctl.support.shipped import rules_folder
from tests.fuzzyctl.messages import BASE, said


def diagnostics(text):
    return parse(SourceText("t.fz", text))[1]


class TestValidFiles:
    @pytest.mark.parametrize("path", sorted(rules_folder().glob("*.fz")), ids=lambda p: p.stem)
    def test_are_not_repaired(self, path):
        assert diagnostics(path.read_text(encoding="utf-8")) == []

    @pytest.mark.parametrize("word", ["is", "unless", "else"])
    def test_may_call_a_hedge_like_a_word_that_runs_on(self, word):
        text = BASE.replace("defuzz", f"hedge {word}(x) = x^3\ndefuzz", 1) + f"if e is {word} N then u is a\n"
        assert loads(text).hedges[0].name == word

    def test_are_not_returned_where_a_repair_was_needed(self):
        systems, found = check_source(SourceText("t.fz", BASE.replace("[-1, 1]", "[-1, 1];", 1)))
        assert [d.code for d in found] == ["FZ105"]
        assert not systems


class TestMeaning:
    """No repair changes what a line means without saying so: where the meaning is open, no line is offered."""

    @pytest.mark.parametrize(
        "line",
        [
            "if e is not N or P then u is a",
            "if e is N xor e is P then u is a",
            "if e is N then u is a!",
            "then u is a",
            "and e is N then u is a",
            "Engine: tipper",
            "defuzzifier: Centroid 100",
            "require u(e=1) <= 1",
            "input v in [0, 100] %",
            "param k = -5 % -3",
            "if e is N then u is triangle(0, 1, 2)",
            "if e is N then u is gaussmf(2, 5)",
            "if e is N then u is gaussmf (2)",
            "if e is N then u is q(3)",
            'output "U" in [0, 1]',
            "output v in [0, 1] % else 1",
            "if e is N; de is N then u is a",
            "if e is N and; de is N then u is a",
            "if e is N then u is a; nonsense here",
        ],
    )
    def test_open_lines_are_not_rewritten(self, line):
        assert [d.help for d in diagnostics(f"{line}\n{BASE}") if d.help.startswith("write")] == []

    def test_a_formula_may_call_functions_of_the_file(self):
        text = f"{BASE}function half(a) = a / 2\nif e is N then u is half(e) + max(e, 0)\n"
        assert [d.help for d in diagnostics(text)] == ["write: if e is N then u is function(half(e) + max(e, 0))"]

    def test_an_unknown_function_in_a_formula_is_reported_beside_its_repair(self):
        _, found = check_source(SourceText("t.fz", f"{BASE}if e is N then u is 2*e + flor(e)\n"))
        assert [d.help for d in found if d.severity == "error"] == [
            "write: if e is N then u is function(2*e + flor(e))",
            "did you mean 'floor'?",
        ]

    def test_the_parenthesis_of_a_constant_is_no_weight(self):
        (found,) = diagnostics(f"{BASE}if e = N then u is constant (5)\n")
        assert found.help == "write: if e is N then u is constant(5)"

    def test_else_below_a_rule_that_cannot_be_read_is_no_misspelt_keyword(self):
        found = [d for d in diagnostics(f"{BASE}if e is N, then u is\nelse u is b\n") if d.span.text == "else"]
        assert [(d.message, d.help) for d in found] == [("'else' begins no statement", "")]

    @pytest.mark.parametrize("name", ["height", "wanted"])
    def test_a_name_before_an_equals_sign_lacks_its_keyword(self, name):
        (found,) = diagnostics(f"plant p\ninput u\nstate h = 1\nder h = u\n{name} = 2 * h\noutput y = h\n")
        assert found.message == f"'{name}' begins no statement"
        assert found.help == f"write: let {name} = ... or der {name} = ... or output {name} = ..."
        assert found.fix is None

    @pytest.mark.parametrize("value", ["5 %", "5 % + 3", '5 % unit "V"', "min(5 %, 3)"])
    def test_percent_signs_of_expressions_begin_no_comment(self, value):
        (found,) = diagnostics(f"param k := {value} // 2nd\n{BASE}")
        assert found.help == f"write: param k = {value} # 2nd"

    def test_a_percent_sign_before_a_comment_stays(self):
        (found,) = diagnostics(f"if e is N then u is a weight 5 % // note\n{BASE}")
        assert found.help == "write: if e is N then u is a weight 0.05 # note"

    def test_variables_may_be_called_like_keywords_in_capitals(self):
        text = BASE.replace("input e ", "input X ").replace("input de ", "input Y ") + "TABLE u = X * Y\n"
        assert [d.help for d in diagnostics(text) if "TABLE" in d.message] == ["write: table u = X x Y"]

    @pytest.mark.parametrize("line", ["b = 1", "b: 1", "  b := 1;"])
    def test_a_value_below_an_output_is_its_term_where_rules_read_it(self, line):
        text = f"system t\ninput e in [0, 1]\n  terms N P\noutput u in [0, 1] else 0\n{line}\nif e is N then u is b\n"
        assert [d.help.strip() for d in diagnostics(text)] == ["write: b = constant(1)"]

    def test_a_value_below_an_input_is_no_term(self):
        text = "system t\ninput e in [0, 1]\n  b = 1\nif e is b then u is b\n"
        assert [d.help for d in diagnostics(text) if d.help.startswith("write")] == []

    @pytest.mark.parametrize("cell", ["0.5*N", "2*e"])
    def test_a_product_in_a_csv_file_is_no_param_for_sure(self, tmp_path, cell):
        (tmp_path / "t.csv").write_text(f"x,N,Z,P\n,{cell},a,b\n")
        text = BASE[: BASE.index("table")] + 'table u = e from "t.csv"\n'
        _, (found,) = check_source(SourceText("t.fz", text), folder=tmp_path)
        assert "the weight of a term is written TERM*0.5" in found.help

    def test_rows_without_bars_are_shown_with_them_whatever_separates_their_cells(self):
        table = "table u = e x de\n  N P\n"
        for row in ("N, a, b", "N\ta\tb", "N a b"):
            assert "write 'N | a b'" in [d.help for d in diagnostics(f"{BASE}{table}  {row}\n")], row


class TestDeclaredNames:
    """A line that begins with a declared name begins with no misspelt keyword."""

    SYSTEM = "system s\ndefuzzifier centroid\n" + "".join(
        f"{kind} {name} in [0, 10]\n  terms low high\n"
        for kind, name in (("input", "e"), ("input", "de"), ("output", "u"))
    )

    def _said(self, below):
        _, found = check_source(SourceText("t.fz", self.SYSTEM + below))
        return [(d.code, d.span.line, d.message, d.help) for d in found if d.severity == "error"]

    @pytest.mark.parametrize(
        ("table", "row"),
        [
            ("table u = e\n  low high\n  low high\n", "| low high"),
            ("table u = e x de\n  low high\n  low high low\n  high low high\n", "low | high low"),
            ("table u = e\n  low high\n  low high\nrequire u <= 10\n", "| low high"),
        ],
    )
    def test_may_begin_a_row_without_its_bar(self, table, row):
        assert self._said(table) == [("FZ102", 11, "the row lacks its bar", f"write '{row}'")]

    def test_may_begin_the_second_line_of_a_rule(self):
        first, second = self._said("if e is\n low then u is low\n")
        assert (first[0], first[1]) == ("FZ102", 9)
        assert second[1:] == (
            10,
            "'low' begins no statement",
            "a rule is one line, which goes on in the next only inside parentheses",
        )

    def test_codes_are_known_by_their_form(self):
        rule = "if e is low then u is low\n"
        assert [said[3] for said in self._said(f"{rule}alow FZ208\n")] == ["write: allow FZ208"]
        assert [said[2] for said in self._said(f"{rule}lows many\n")] == ["'lows' begins no statement"]


class TestCombinations:
    """All repairs of a line at once, those of single tokens among them."""

    @pytest.mark.parametrize(
        ("line", "right"),
        [
            ("if e iz N then u is a;", "if e is N then u is a"),
            ("if e iz N then u iz a;  % note", "if e is N then u is a  # note"),
            ("IF e iz N THEN u is a", "if e is N then u is a"),
            ("param k = = 0,5;", "param k = 0.5"),
            ("param k in 0 .. 1 := 1;", "param k in [0, 1] = 1"),
            ("nd min;,", "and min"),
            ("(0,5) IF e IS N THEN u IS a;", "if e is N then u is a weight 0.5"),
            ("weight 0.5 if e is N then u is a", "if e is N then u is a weight 0.5"),
            ("if e is N && de is N || e is P then u is a;", "if (e is N and de is N) or e is P then u is a"),
            (
                "if (e is N || e is P && de is N) && de is P then u is a",
                "if (e is N or (e is P and de is N)) and de is P then u is a",
            ),
        ],
    )
    def test_is_the_fix_of_the_line(self, line, right):
        source = SourceText("t.fz", f"{BASE}{line}\n")
        (found,) = parse(source)[1]
        assert fixed(source, [found.fix]).split("\n")[-2] == right

    @pytest.mark.parametrize("line", ["9, 1 (1) : 1", "1 1, 1 (1) : 1", "1, 1 (1) : 3", "default 5", "if e f g h"])
    def test_is_none_where_it_is_open_what_was_meant(self, line):
        (found,) = diagnostics(f"{BASE}{line}\n")
        assert found.fix is None

    def test_has_a_part_in_an_edit_that_was_made_before(self):
        # The rule is moved as a whole, then its capitals are replaced.
        (found,) = diagnostics(f"{BASE}0.5: IF e IS N THEN u IS a\n")
        assert [r.text for r in found.fix.replacements] == ["if e is N then u is a weight 0.5"]


class TestElseBelowAnOutput:
    OUTPUT = "system t\ninput e in [0, 1]\n  terms N P\noutput u in [0, 1]  # here\n  terms a b\n"

    @pytest.mark.parametrize(
        ("line", "value", "rest"),
        [
            ("else 5,5", "5.5", ""),
            ("  default := 0;", "0", ""),
            ("DEFAULT := NC;  // as in FCL", "hold", ""),
            ("default midpoint  # why", "midpoint", "  # why\n"),
        ],
    )
    def test_is_moved_to_it(self, line, value, rest):
        source = SourceText("t.fz", f"{self.OUTPUT}{line}\n")
        (found,) = parse(source)[1]
        right = self.OUTPUT.replace("1]  # here", f"1] else {value}  # here") + rest
        assert (found.fix.applicability, fixed(source, [found.fix])) == ("sure", right)

    def test_is_not_where_it_has_one(self):
        (found,) = diagnostics(self.OUTPUT.replace("1]  #", "1] else 0  #") + "else 1\n")
        assert found.fix is None


class TestTablesWithBars:
    VARIABLES = "".join(
        f"{kind} {name} in [0, 10]\n  terms {terms}\n"
        for kind, name, terms in (
            ("input", "e", "low high"),
            ("input", "de", "small large"),
            ("output", "u", "low high"),
        )
    )

    def _helps(self, *lines):
        return [d.help for d in diagnostics("\n".join((self.VARIABLES, *lines)))]

    @pytest.mark.parametrize("corner", ["", "e", "e \\ de", "| e", "|"])
    def test_become_rows_of_one_bar(self, corner):
        found = self._helps("table u = e x de", f"  {corner} | small | large |", "|---|:---:|---|", "low | low | high")
        assert found == ["write: small large", "remove the line", "write: low | low high"]

    def test_a_header_of_terms_only_has_no_corner(self):
        assert self._helps("table u = e", "  | low | high |", "  | low | high |") == [
            "write: low high",
            "write: | low high",
        ]

    def test_a_first_row_is_no_header(self):
        assert self._helps("table u = e x de", "low | low | high")[0] == "write: low | low high"
        assert self._helps("table u = de x e", "small | low | high")[0] == "write: small | low high"


class TestSeveralLines:
    def test_are_shown_below_each_other(self):
        (found,) = diagnostics("param a = 1; param b = 2")
        assert found.help == "write 2 lines:\nparam a = 1\nparam b = 2"
        assert render(found).split("\n")[-3:] == [
            "  = help: write 2 lines:",
            "      param a = 1",
            "      param b = 2",
        ]

    def test_are_lines_of_a_report(self):
        _, found = check_source(SourceText("t.fz", "param a = 1; param b = 2"))
        results = json.loads(as_sarif(found))["runs"][0]["results"]
        assert any("help: write 2 lines:\nparam a = 1\n" in r["message"]["text"] for r in results)


@pytest.mark.parametrize(
    "line", ["hedge h(x) := x^2", "function f(a, b) : a + b", "controller c\nlet a := 2", "controller c\nnext a <- 2"]
)
def test_a_value_is_assigned_with_the_equals_sign(line):
    (found,) = diagnostics(line)
    assert found.help == "write: " + re.sub(r" (:=|:|<-)", " =", line.split("\n")[-1])


def test_a_term_may_have_the_name_that_ends_other_rules():
    text = "input e in [0, 1]\n  terms low end_if\nIF e IS low THEN u IS very end_if\n"
    assert [d.help for d in diagnostics(text)] == ["write: if e is low then u is very end_if"]


def test_an_assignment_above_a_setting_is_no_table():
    assert [d.message for d in diagnostics("engine = mamdani\nand min\n")] == [
        "unexpected term outside of an input or output"
    ]


class TestLocations:
    def test_of_codes_are_in_the_text_as_it_was_written(self):
        source = SourceText("t.fz", BASE + "alow FZ999\n")
        _, found = check_source(source)
        assert [(d.code, d.span.source is source, d.span.text) for d in found] == [
            ("FZ213", True, "FZ999"),
            ("FZ101", True, "alow"),
        ]

    def test_are_those_of_the_text_as_it_was_written(self):
        text = BASE + "IF e IS N && e IS Q THEN u IS a;\n/* note */\nif e is Q then u is q\n"
        _, found = check_source(SourceText("t.fz", text))
        places = [(d.code, d.span.line, d.span.column, d.span.text) for d in found]
        assert places == [
            ("FZ101", 11, 1, "IF"),
            ("FZ203", 11, 19, "Q"),
            ("FZ102", 12, 1, "/* note */"),
            ("FZ203", 13, 9, "Q"),
            ("FZ203", 13, 21, "q"),
        ]

    def test_what_cannot_be_repaired_is_a_fact_of_the_line(self):
        (found,) = diagnostics("param k = 3 4 'm'")
        assert found.facts == ("column 13: unexpected '4'",)


def test_the_table_of_repairs_has_at_most_forty_rows():
    assert len(repairs.CHARACTERS) + len(repairs.ROWS) <= 40


class TestLimits:
    def test_long_lines_and_long_gaps_are_left_alone(self):
        for line in ("IF e IS N THEN u IS a" + " " * 50 + "x", "IF e IS N AND " * 30 + "e IS N THEN u IS a"):
            assert "write: if" not in said(after=line)[0][2]

    def test_of_very_many_lines_not_all_are_repaired(self):
        found = diagnostics("IF e IS N THEN u IS a;\n" * 3000)
        assert sum(d.help.startswith("write: if e is N") for d in found) < 3000
