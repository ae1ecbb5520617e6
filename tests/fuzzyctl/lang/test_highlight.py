"""The colours of editors are held to the grammar that reads the files.

After a change of the language: FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest tests/fuzzyctl/lang/test_highlight.py
"""

import json
import os
import re
from pathlib import Path

import pytest
from pygments.token import Error, Keyword, Name, Number, String, Whitespace

from fuzzyctl.cli.new import starter
from fuzzyctl.lang import highlight, syntax
from fuzzyctl.lang.highlight import (
    CLAUSES,
    CONSEQUENTS,
    CONTROLLER_FUNCTIONS,
    FALLBACKS,
    OPERATORS,
    TOKENS,
    FuzzyLexer,
    textmate,
)
from fuzzyctl.model import stateful_operators
from fuzzyctl.resolve.block_names import FUNCTIONS
from fuzzyctl.support.shipped import rules_folder

ROOT = Path(__file__).parents[1].parent.parent
GRAMMAR = (ROOT / "fuzzyctl" / "lang" / "grammar.lark").read_text(encoding="utf-8")
TEXTMATE = ROOT / "docs" / "editors" / "fz.tmLanguage.json"
GOLDEN = sorted((ROOT / "tests" / "golden" / "diagnostics").glob("*.fz"))
TEXTS = {"starter": starter("a")} | {p.name: p.read_text() for p in sorted(rules_folder().glob("*.fz"))}


def keywords_of_the_grammar():
    """The words that terminals of grammar.lark stand for."""
    terminals = re.findall(r"^[A-Z_]+(?:\.\d+)?: /([a-z]+)(?:\\b|\(\?=)", GRAMMAR, flags=re.MULTILINE)
    return set(terminals)


def tokens(text):
    return [(kind, value) for kind, value in FuzzyLexer(stripnl=False, ensurenl=False).get_tokens(text) if value]


def kinds(text):
    return {value.strip(): kind for kind, value in tokens(text) if value.strip()}


class TestKeywords:
    def test_they_are_those_of_the_grammar(self):
        words = keywords_of_the_grammar()
        assert len(words) > 30
        assert words == {*syntax.STATEMENT_KEYWORDS, *syntax.BLOCK_KEYWORDS, *CLAUSES, *CONSEQUENTS, *FALLBACKS, "x"}

    @pytest.mark.parametrize("word", sorted({*syntax.STATEMENT_KEYWORDS, *syntax.BLOCK_KEYWORDS}))
    def test_a_statement_begins_with_one(self, word):
        assert tokens(f"  {word} something")[1] == (Keyword, word)

    @pytest.mark.parametrize("word", syntax.STATEMENT_KEYWORDS)
    def test_a_term_or_a_row_may_be_called_like_one(self, word):
        assert tokens(f"  {word} = triangle(0, 1, 2)")[1] == (Name.Variable, word)
        assert tokens(f"  {word} | N")[1] == (Name, word)

    @pytest.mark.parametrize("word", CLAUSES)
    def test_clauses_stand_within_a_line(self, word):
        assert (Keyword, word) in tokens(f"output u in [0, 1] {word} N")

    def test_operators_are_those_of_the_model(self):
        assert set(OPERATORS) == set(stateful_operators.OPERATORS)
        assert set(CONTROLLER_FUNCTIONS) == set(FUNCTIONS)


class TestLexer:
    def test_a_declaration(self):
        found = kinds('input table "σ*" in [-0.5e-3, inf] unit "1/s"  # why')
        assert found["input"] is Keyword
        assert found["table"] is Name.Variable
        assert found['"σ*"'] is String.Double
        assert found["0.5e-3"] is Number
        assert found["inf"] is Name.Constant
        assert found["in"] is found["unit"] is Keyword
        assert found["# why"] is FuzzyLexer.tokens["root"][0][1]

    def test_the_sign_between_two_inputs_is_a_keyword_and_a_name_x_is_none(self):
        found = [kind for kind, value in tokens("table u, v = x x y") if value == "x"]
        assert found == [Name, Keyword]
        assert (Name, "x") in tokens("if x is N then u is P")

    def test_membership_functions_are_builtins_where_they_are_called(self):
        assert (Name.Builtin, "triangle") in tokens("  N = triangle(0, 1, 2)")
        assert (Name, "triangle") in tokens("if x is triangle then u is P")

    def test_codes_of_allow(self):
        assert (Name.Constant, " FZ208 FZ216 ") in tokens('allow FZ208 FZ216 "later"')

    @pytest.mark.parametrize("name", TEXTS)
    def test_nothing_of_a_right_file_is_an_error_or_lost(self, name):
        found = tokens(TEXTS[name])
        assert "".join(value for _, value in found) == TEXTS[name]
        assert [value for kind, value in found if kind is Error] == []

    @pytest.mark.parametrize("path", GOLDEN, ids=lambda p: p.stem)
    def test_nothing_of_a_wrong_file_is_lost(self, path):
        text = path.read_text()
        assert "".join(value for _, value in tokens(text)) == text

    def test_a_character_without_a_place_is_an_error(self):
        assert (Error, "−") in tokens("  N = triangle(−1, 0, 1)")

    def test_pygments_can_find_it_by_file_name(self):
        assert FuzzyLexer.filenames == ("*.fz",)
        assert "fz" in FuzzyLexer.aliases


class TestTextMate:
    def test_the_file_is_made_of_the_same_patterns(self):
        text = json.dumps(textmate(), ensure_ascii=False, indent=2) + "\n"
        if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
            TEXTMATE.write_text(text, encoding="utf-8")
        assert text == TEXTMATE.read_text(encoding="utf-8")

    def test_it_has_what_an_editor_needs(self):
        grammar = json.loads(TEXTMATE.read_text(encoding="utf-8"))
        assert grammar["scopeName"] == "source.fz"
        for pattern in grammar["patterns"]:
            groups = re.compile(pattern["match"]).groups
            assert ("name" in pattern) == (groups == 0)
            assert all(1 <= int(k) <= groups for k in pattern.get("captures", {}))

    @pytest.mark.parametrize("name", TEXTS)
    def test_an_editor_and_pygments_colour_a_file_alike(self, name):
        of_pygments = [(kind, value) for kind, value in tokens(TEXTS[name]) if kind is not Whitespace]
        patterns = json.loads(TEXTMATE.read_text(encoding="utf-8"))["patterns"]
        of_editor = [piece for line in TEXTS[name].split("\n") for piece in _coloured(line, patterns)]
        assert of_editor == [(kind, value) for kind, value in of_pygments if value.strip()]


def _coloured(line, patterns):
    """Yield what a TextMate grammar marks in a line: at each place the earliest match, of equal ones the first."""
    at = 0
    while at <= len(line):
        found = [(m.start(), i, m) for i, p in enumerate(patterns) if (m := re.compile(p["match"]).search(line, at))]
        if not found:
            return
        _, i, match = min(found, key=lambda f: f[:2])
        if "name" in patterns[i]:
            yield TOKENS[patterns[i]["name"]], match[0]
        else:
            for k, scope in patterns[i]["captures"].items():
                if match[int(k)]:
                    yield TOKENS[scope["name"]], match[int(k)]
        at = max(match.end(), at + 1) if match.end() == at else match.end()


def test_every_scope_has_a_token_and_is_used():
    used = {s for _, scopes in highlight.PATTERNS for s in ((scopes,) if isinstance(scopes, str) else scopes)}
    assert used == set(TOKENS)
