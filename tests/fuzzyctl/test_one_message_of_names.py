"""One name that is missing, wrong, given twice or of another language gives one message."""

import re

import pytest

from fuzzyctl.analysis.check import check_source
from fuzzyctl.diagnostics.source import SourceText
from tests.fuzzyctl.messages import BASE, only, places, said, says


class TestGivenTwice:
    @pytest.mark.parametrize(
        "line",
        [
            "activation first(count=2, count=3)",
            "activation threshold(> 0.1, < 0.5)",
            "activation threshold(> 0.1, > 0.5)",
        ],
    )
    def test_an_option_of_an_activation(self, line):
        assert only(said(("defuzzifier", f"{line}\ndefuzzifier")))[0] == "2 FZ215"

    def test_an_option_of_a_defuzzifier(self):
        sets = ("constant(1)", "triangle(0, 1, 2)"), ("constant(2)", "triangle(1, 2, 3)")
        twice = ("weighted_average", "centroid(resolution=10, resolution=200)")
        assert only(said(twice, *sets))[0] == "2 FZ215"

    def test_an_output_of_a_table(self):
        assert only(said(("table u = e", "table u, u = e"), ("a a b", "a/a a/a b/b")))[0] == "8 FZ215"


class TestWordsOfRules:
    RULE = "if e is N and (e is Z or e is P) and not e is Z then u is a"

    @pytest.mark.parametrize(
        ("old", "new"),
        [
            ("N and", "N AND"),
            ("Z or", "Z OR"),
            ("then", "THEN"),
            ("then", "Then"),
            ("not", "NOT"),
            ("e is N", "e IS N"),
        ],
    )
    def test_keywords_are_written_small(self, old, new):
        where, words = only(said(after=self.RULE.replace(old, new)))
        assert where == "11 FZ102"
        assert words.endswith(f"keywords are written in small letters | write: {self.RULE}")

    @pytest.mark.parametrize(
        ("old", "new"), [("if", "IF"), ("table", "Table"), ("input", "INPUT"), ("output", "Output")]
    )
    def test_so_are_those_that_begin_a_line(self, old, new):
        where, words = only(said((old, new)) if old != "if" else said(after=self.RULE.replace(old, new)))
        assert where.endswith("FZ101")
        assert f"| write: {old} " in words

    @pytest.mark.parametrize("word", ["and", "or", "then"])
    def test_a_missing_term_is_missed(self, word):
        rule = {"and": "if e is  and e is N then u is a", "or": "if e is  or e is N then u is a"}
        says("11 FZ102", f"a term is missing before '{word}'", after=rule.get(word, "if e is  then u is a"))

    def test_a_missing_connective_is_missed(self):
        says("11 FZ102", "'and' or 'or' is missing before 'e'", after="if e is N e is Z then u is a")


class TestMisspeltClaims:
    @pytest.mark.parametrize(
        ("claim", "meant"),
        [("increasng(u, e)", "increasing"), ("monotone(u, e)", "increasing"), ("bound(u, 0, 1)", "bounded")],
    )
    def test_they_are_no_question_of_numbers_and_truth_values(self, claim, meant):
        says("11 FZ202", f"did you mean '{meant}'?", after=f"require {claim}\n")


class TestNamesThatAreMissingOrWrong:
    USES = "param k = q\nif e is N then u is function(q * e)\nrequire u(-e) <= e + q\n"

    @pytest.mark.parametrize(
        ("old", "new", "place"),
        [
            ("input e", "input ", "3 FZ102"),
            ("output u", "output ", "5 FZ102"),
            ("output u", 'output "U"', "5 FZ102"),
            ("output u", "output 0.5", "5 FZ102"),
            ("input e", "input .", "3 FZ102"),
            ("input e", "of e", "3 FZ101"),
            ("output u", "0 u", "5 FZ101"),
        ],
    )
    def test_a_variable(self, old, new, place):
        assert only(said((old, new), after=self.USES.replace("param k = q", "param q = 1")))[0] == place

    @pytest.mark.parametrize(("old", "new", "place"), [("e", "total", "3 FZ201"), ("u", "bounded", "5 FZ201")])
    def test_a_variable_called_like_a_claim(self, old, new, place):
        text = (
            (BASE + "if e is P then u is b\nrequire u <= e\n")
            .replace(f" {old} ", f" {new} ")
            .replace(f"= {old}\n", f"= {new}\n")
        )
        _, diagnostics = check_source(SourceText("t.fz", text))
        assert [f"{d.span.line} {d.code}" for d in diagnostics] == [place]

    @pytest.mark.parametrize(("above", "place"), [("", "11 FZ102"), ("input e", "3 FZ102")])
    def test_a_param(self, above, place):
        line = "param  = 2\n"
        assert only(said(after="param . = 2\n" + self.USES))[0] == "11 FZ102"
        found = said((above, line + above), after=self.USES) if above else said(after=line + self.USES)
        assert places(found) == [place]

    def test_a_hedge(self):
        assert only(said(after="hedge (t) = t^2\nif e is steep N then u is a\n"))[0] == "11 FZ102"

    @pytest.mark.parametrize(
        ("terms", "part"),
        [
            ("terms N@-1 Z0 P@1", "write Z@0"),
            ("terms N=-1 Z0 P=1", "write Z=0"),
            ("terms N N@-1", "mixes peaks"),
            ("terms N", "two terms or more"),
            ("terms N P P", "declared twice"),
        ],
    )
    def test_terms(self, terms, part):
        says(("4 FZ201" if "twice" in part else "4 FZ214"), part, ("terms N Z P", terms))

    @pytest.mark.parametrize("word", ["and", "or", "then", "weight", "inf", "pi", "not"])
    def test_words_of_the_language_name_nothing(self, word):
        if word != "pi":  # only a call of a system has the form pi(...)
            assert only(said(("system s", f"system {word}")))[0] == "1 FZ201"
        assert only(said(("defuzz", f"hedge {word}(x) = x\ndefuzz")))[0] == "2 FZ201"
        assert only(said(("defuzz", f"hedge h({word}) = 1\ndefuzz")))[0] == "2 FZ201"


class TestOtherNotations:
    @pytest.mark.parametrize(
        ("line", "help_text"),
        [
            ("require u = 1", "write: require u == 1"),
            ("require u => 1", "write: require u >= 1"),
            ("require u =< 1", "write: require u <= 1"),
            ("require u ≤ 1", "write: require u <= 1"),
            ("require u <= e**2", "write: require u <= e^2"),
            ("param k = 2**3", "write: param k = 2^3"),
            ("require |u| <= 1", "write: require abs(u) <= 1"),
            ("require u <= |e|", "write: require u <= abs(e)"),
            ("require 0 <= u <= 1", "write: require bounded(u, 0, 1)"),
            ("require 0 < u < 1 within 1", "0 < u and u < 1"),
            ("require u <= 1 when e > 0 within 1", "write 'within' once, and before 'when'"),
            ("require u <= 1 within 1 within 2", "write 'within' once, and before 'when'"),
            ("if e is N then u is 2*e + 3 weight 0.5", "u is function(2*e + 3)"),
            ("if e is N then u = 2 + e", "u is function(2 + e)"),
            ("if e is N then u is e + 2", "u is function(e + 2)"),
            ("if e is N then u = a", "write: if e is N then u is a"),
            ("if e = N then u is a", "write: if e is N then u is a"),
            ("if e is N then u is a else u is a", "rules have no 'else'"),
            ("if e is N then u is a wieght", "did you mean 'weight'"),
            ("if e is N then u is a wieght 0.5", "did you mean 'weight'"),
        ],
    )
    def test_what_to_write_instead_is_said(self, line, help_text):
        where, words = only(said(after=f"{line}\n"))
        assert where.startswith("11 FZ10")
        assert help_text in words

    @pytest.mark.parametrize("cells", ["a - b", "- a b", "a b -", "a – b"])
    def test_a_dash_is_no_empty_cell(self, cells):
        where, words = only(said(("a a b", cells)))
        assert where.startswith("10 FZ10")
        assert words.endswith(f"| write: | {re.sub('[-–]', '.', cells)}")

    def test_an_output_that_an_antecedent_misspells_is_found(self):
        _, words = only(
            said(("output u", "output power"), ("u = e", "power = e"), after="if powr is a then power is a")
        )
        assert "inputs and outputs: e, power" in words
        assert "did you mean 'power'?" in words
