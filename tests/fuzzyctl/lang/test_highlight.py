"""The colours of editors are held to the grammar that reads the files.

After a change of the language: FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest tests/fuzzyctl/lang/test_highlight.py
"""

import json
import os
import re
from pathlib import Path

import pytest
from pygments.lexers import get_lexer_by_name
from pygments.token import Error, Keyword, Name, Number, String, Whitespace

from fuzzyctl.lang import highlight
from fuzzyctl.testing import check_text
from tests.fuzzyctl.lang.test_formatter import PAIRS
from tests.shipped import LAWS, SYSTEMS

ROOT = Path(__file__).parents[3]
TEXTMATE = ROOT / "docs" / "editors" / "fz.tmLanguage.json"
GRAMMAR = (ROOT / "fuzzyctl" / "lang" / "grammar.lark").read_text(encoding="utf-8")
#: The words that terminals of the grammar stand for.
WORDS = set(re.findall(r"^[A-Z_]+(?:\.\d+)?: /([a-z]+)(?:\\b|\(\?=)", GRAMMAR, flags=re.MULTILINE)) - {"x"}
WITHIN = {*highlight.CLAUSES, *highlight.CONSEQUENTS, *highlight.FALLBACKS}
TEXTS = {p.name: p.read_text() for p in (*SYSTEMS, *LAWS)} | {"blocks": PAIRS[1][1]}


def tokens(text):
    lexer = get_lexer_by_name("fz", stripnl=False, ensurenl=False)
    return [(kind, value) for kind, value in lexer.get_tokens(text) if value]


class TestWords:
    def test_there_are_those_of_the_grammar(self):
        assert len(WORDS) > 30
        assert WITHIN < WORDS

    @pytest.mark.parametrize("word", sorted(WORDS - WITHIN))
    def test_of_statements_begin_a_line_and_are_names_in_terms_and_rows(self, word):
        assert tokens(f"  {word} something")[1] == (Keyword, word)
        assert tokens(f"  {word} = triangle(0, 1, 2)")[1] == (Name.Variable, word)
        assert tokens(f"  {word} | N")[1] == (Name, word)

    @pytest.mark.parametrize("word", highlight.CLAUSES)
    def test_of_clauses_stand_within_a_line(self, word):
        assert (Keyword, word) in tokens(f"output u in [0, 1] {word} N")

    @pytest.mark.parametrize(
        "text",
        [
            "controller c\ninput e\noutput y = no_function(e)\n",
            "plant p = tf(num=[1], den=[1, 1])\nloop l\nblock b = p(1)\nrun 1 s\nlet a = no_function(1)\n",
        ],
    )
    def test_of_functions_are_builtins(self, text):
        (found,) = (d for d in check_text(text)[1] if d.severity == "error")
        names = found.facts[0].removeprefix("functions: ").split(", ")
        assert len(names) > 25
        for name in (*names, "tf", "zpk", "ss", "python", "fmu"):
            assert (Name.Builtin, name) in tokens(f"plant a = {name}(x)"), name


class TestLexer:
    def test_a_declaration(self):
        found = {v.strip(): k for k, v in tokens('input table "σ*" in [-0.5e-3, inf] unit "1/s"  # why') if v.strip()}
        assert found["input"] is found["in"] is found["unit"] is Keyword
        assert found["table"] is Name.Variable
        assert found['"σ*"'] is String.Double
        assert found["0.5e-3"] is Number
        assert found["inf"] is Name.Constant
        assert "Comment" in str(found["# why"])

    def test_the_sign_between_two_inputs_is_a_keyword_and_a_name_x_is_a_name(self):
        assert [kind for kind, value in tokens("table u, v = x x y") if value == "x"] == [Name, Keyword]
        assert (Name, "x") in tokens("if x is N then u is P")

    def test_membership_functions_are_builtins_where_they_are_called(self):
        assert (Name.Builtin, "triangle") in tokens("  N = triangle(0, 1, 2)")
        assert (Name, "triangle") in tokens("if x is triangle then u is P")

    def test_codes_and_characters_without_a_place(self):
        assert (Name.Constant, " FZ208 FZ216 ") in tokens('allow FZ208 FZ216 "later"')
        assert (Error, "−") in tokens("  N = triangle(−1, 0, 1)")

    def test_no_character_of_a_text_is_lost_and_none_of_a_sound_one_is_an_error(self):
        for path in sorted((ROOT / "tests" / "golden" / "diagnostics").glob("*.fz")):
            assert "".join(value for _, value in tokens(path.read_text())) == path.read_text(), path
        for text in TEXTS.values():
            assert "".join(value for _, value in tokens(text)) == text
            assert [value for kind, value in tokens(text) if kind is Error] == []


class TestTextMate:
    def test_the_file_is_made_of_the_same_patterns(self):
        text = json.dumps(highlight.textmate(), ensure_ascii=False, indent=2) + "\n"
        if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
            TEXTMATE.write_text(text, encoding="utf-8")
        assert text == TEXTMATE.read_text(encoding="utf-8")

    @pytest.mark.parametrize("name", TEXTS)
    def test_an_editor_and_pygments_colour_a_file_alike(self, name):
        of_pygments = [(kind, value) for kind, value in tokens(TEXTS[name]) if kind is not Whitespace]
        patterns = json.loads(TEXTMATE.read_text(encoding="utf-8"))["patterns"]
        of_editor = [piece for line in TEXTS[name].split("\n") for piece in _coloured(line, patterns)]
        assert of_editor == [(kind, value) for kind, value in of_pygments if value.strip()]

    def test_every_scope_has_a_token_and_is_used(self):
        used = {s for _, scopes in highlight.PATTERNS for s in ((scopes,) if isinstance(scopes, str) else scopes)}
        assert used == set(highlight.TOKENS)


def _coloured(line, patterns):
    """Yield what a TextMate grammar marks in a line: at each place the earliest match, of equal ones the first."""
    at = 0
    while at <= len(line):
        found = [(m.start(), i, m) for i, p in enumerate(patterns) if (m := re.compile(p["match"]).search(line, at))]
        if not found:
            return
        _, i, match = min(found, key=lambda f: f[:2])
        if "name" in patterns[i]:
            yield highlight.TOKENS[patterns[i]["name"]], match[0]
        else:
            for k, scope in patterns[i]["captures"].items():
                if match[int(k)]:
                    yield highlight.TOKENS[scope["name"]], match[int(k)]
        at = max(match.end(), at + 1) if match.end() == at else match.end()
