"""Texts that are read: names like keywords, locations, limits. Mistakes are in tests/golden/mistakes."""

import json
import re

import pytest

from fuzzyctl import load, loads
from fuzzyctl.testing import check_text, run_command
from tests.fuzzyctl.lang.test_highlight import WORDS

SYSTEM = """\
system s
defuzzifier weighted_average
input e in [-1, 1]
  terms N Z P
output u in [-5, 5]
  a = constant(1)
  b = constant(2)
table u = e
    N Z P
  | a a b
"""


def mistakes(text):
    return [(d.code, d.span.line) for d in check_text(text)[1]]


class TestNames:
    @pytest.mark.parametrize("word", sorted(WORDS - {"and", "or", "not", "then", "weight"}))
    def test_terms_of_any_keyword_are_read(self, word):
        text = SYSTEM.replace("  a = constant(1)", f"  {word}  =  constant(1)").replace("a a b", f"0.5 {word} b*0.5")
        assert [t.name for t in loads(text).outputs[0].terms] == [word, "b"]

    @pytest.mark.parametrize("word", ["error", "in", "unit", "is", "x", "linear", "hold", "unless", "else", "rules"])
    def test_keywords_name_whatever_has_a_name(self, word):
        text = f"system s\ninput {word} in [0, 1]\n  terms {word} b\noutput u in [0, 1]\n  terms {word} c\n"
        text += f"table u = {word}\n  {word} b\n  | {word} c\nif {word} is {word} then u is {word}\n"
        assert [v.name for v in loads(text).inputs] == [word]

    @pytest.mark.parametrize("word", ["is", "unless", "else"])
    def test_a_hedge_may_have_the_name_of_a_word_within_a_rule(self, word):
        text = SYSTEM.replace("defuzz", f"hedge {word}(x) = x^3\ndefuzz", 1) + f"if e is {word} N then u is a\n"
        assert loads(text).hedges[0].name == word

    def test_they_are_normalised(self):
        assert loads(SYSTEM.replace("system s", "system e\u0301")).name == "\u00e9"

    def test_a_word_of_the_grammar_without_more_is_a_mistake(self):
        for word in WORDS:
            assert mistakes(f"{word} ?\n"), word


class TestBrokenLines:
    def test_of_500_lines_with_91_broken_exactly_those_are_reported(self):
        lines = [f"param p{i} = {i}" for i in range(500)]
        broken = list(range(3, 500, 5))[:91]
        for i in broken:
            slips = ("param p = ", f"parm p{i} = {i}", f"param p{i} == {i}", f"param {i} = (", "param q = 3 'm'")
            lines[i] = slips[i % 5]
        found = check_text("\n".join(lines))[1]
        assert [d.span.line - 1 for d in found if d.code in ("FZ101", "FZ102", "FZ103", "FZ105")] == broken

    def test_500_are_reported_and_that_reading_stops(self):
        found = check_text(SYSTEM + "param k = (1]\n" * 900)[1]
        assert [d.code for d in found] == ["FZ103"] * 500 + ["FZ112"]
        assert "too many errors (500)" in found[-1].message

    def test_a_text_that_is_repaired_to_report_more_is_not_returned(self):
        blocks, found = check_text(SYSTEM.replace("[-1, 1]", "[-1, 1];", 1))
        assert (blocks, [d.code for d in found]) == ((), ["FZ105"])

    def test_lines_of_a_repair_follow_each_other_in_text_and_report(self):
        text = run_command("check", "-", stdin="param a = 1; param b = 2\n").errors
        assert "  = help: write 2 lines:\n      param a = 1\n      param b = 2\n" in text
        report = run_command("check", "-", "--format", "sarif", stdin="param a = 1; param b = 2\n").output
        results = json.loads(report)["runs"][0]["results"]
        assert any("help: write 2 lines:\nparam a = 1\n" in r["message"]["text"] for r in results)

    def test_long_and_very_many_lines_are_reported_without_a_repair(self):
        (long, *_) = check_text(f"{SYSTEM}{'IF e IS N AND ' * 30}e IS N THEN u IS a")[1]
        assert "write: if" not in long.help
        found = check_text("IF e IS N THEN u IS a;\n" * 3000)[1]
        assert sum(d.help.startswith("write: if e is N") for d in found) < 3000
        for line in (f"if {'a' * 50_000} <", f"if e is N and {'x<' * 20_000}", f"or {'(' * 90}{'a' * 50_000}"):
            assert mistakes(f"system s\n{line}\n")


class TestLimits:
    @pytest.mark.parametrize(
        ("head", "line", "at"),
        [
            ("system s\n", "let a = x + 1\n", 22),
            ("controller c\n", "let a = x + 1\n", 21),
            ("plant p\n", "der a = 1\n", 21),
        ],
    )
    def test_lines_of_equations_are_counted(self, head, line, at, monkeypatch):
        monkeypatch.setattr("fuzzyctl.lang.parser.MAX_EQUATIONS", 20)
        assert "FZ112" not in dict(mistakes(head + 19 * line))
        assert dict(mistakes(head + 40 * line))["FZ112"] == at

    def test_words_are_counted(self, monkeypatch):
        monkeypatch.setattr("fuzzyctl.lang.parser.MAX_WORDS", 24)
        rule = "if x is (a or b) then y is c\n"  # of ten words and a parenthesis
        assert "FZ112" not in dict(mistakes("system s\n" + 2 * rule))
        assert dict(mistakes("system s\n" + 20 * rule))["FZ112"] == 4

    def test_operators_are_counted_before_a_line_is_read(self):
        text = "param p = 1" + " + 1" * 80_001
        (found,) = check_text(text)[1]
        assert (found.code, found.message) == ("FZ112", "the file has 80,001 operators, more than 80,000")
        assert found.span.start == text.rindex("+")

    def test_signs_of_numbers_texts_and_comments_are_no_operators(self, monkeypatch):
        monkeypatch.setattr("fuzzyctl.lang.parser.MAX_OPERATORS", 1000)
        line = 'a = piecewise(-1, -2e-3, - 3, [-4) # 1 - 2 "\nsource "1 - 2"\n'
        assert not [d for d in check_text(line * 500)[1] if "operators" in d.message]

    @pytest.mark.parametrize("value", ["(1 + " * 90 + "1" + ")" * 90, "-" * 90 + "1", "1^" * 90 + "1"])
    def test_expressions_as_deep_as_allowed_are_read(self, value):
        assert not [code for code, _ in mistakes(f"{SYSTEM}param p = {value}\n") if code != "FZ216"]


def test_members_units_and_numbers_are_told_apart(tmp_path):
    path = tmp_path / "c.fz"
    path.write_text("controller p\ninput e\noutput y = e\ncontroller c\ninput e\nblock p = p(e)\n", encoding="utf-8")
    path.write_text(path.read_text() + "output u = p.y + 5ms + 3 % + .5\nevery 1 s\n", encoding="utf-8")
    numbers = re.findall(r"\d\.\d+", repr(load(path, block="c").results[0].value))
    assert sorted(map(float, numbers)) == [0.005, 0.03, 0.5]
