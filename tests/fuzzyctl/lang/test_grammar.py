"""The shipped tables of the grammar, and the words that its lexer knows."""

import pickle
import re
from collections import Counter

import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang import grammar
from fuzzyctl.lang.lines import LogicalLine
from fuzzyctl.lang.parser import parse


@pytest.fixture(autouse=True)
def _fresh():
    grammar._machine.cache_clear()
    yield
    grammar._machine.cache_clear()


def test_the_shipped_tables_are_those_of_the_grammar():
    key, shipped = grammar.shipped_tables().split(b"\n", 1)
    assert key.decode() == grammar.key(), "write them anew: python -m fuzzyctl.lang.grammar"
    computed = grammar.computed_tables().split(b"\n", 1)[1]
    assert content(pickle.loads(shipped)) == content(pickle.loads(computed))


def content(tables):
    """Rules and terminals, and what each state of the parser accepts; numbers differ from one run to the next."""
    table = tables["data"]["parser"]["parser"]
    memo = sorted(repr(sorted(m.items(), key=str)) for m in tables["memo"].values())
    states = Counter(frozenset(table["tokens"][t] for t in state) for state in table["states"].values())
    return memo, states


@pytest.mark.parametrize("content", [b"", b"0.0.0 00000000\n\x80\x05", b"\x80"])
def test_tables_that_do_not_fit_are_computed(content, monkeypatch):
    calls = []
    computed = grammar.computed_tables()
    monkeypatch.setattr(grammar, "shipped_tables", lambda: content)
    monkeypatch.setattr(grammar, "computed_tables", lambda: (calls.append(1), computed)[1])
    tree, mistakes = parse(SourceText("t", "param k = 2 * (3 + 4)\nparam 1\n"))
    assert (len(tree.statements), [d.code for d in mistakes], len(calls)) == (1, ["FZ102"], 1)


def test_shipped_tables_are_not_computed(monkeypatch):
    monkeypatch.setattr(grammar, "computed_tables", lambda: pytest.fail("they are"))
    assert len(parse(SourceText("t", "param k = 1\n"))[0].statements) == 1


def test_tables_of_another_grammar_do_not_fit(monkeypatch):
    monkeypatch.setattr(grammar, "grammar_text", lambda: "start: NAME")
    assert not grammar.shipped_tables().startswith(grammar.key().encode())


def test_each_terminal_is_a_token():
    machine, _ = grammar._machine()
    lexer = machine.parser.lexer
    words = {name for rows in lexer.keywords.values() for name, _ in rows}
    signs = {name for names in grammar._SIGNS.values() for name in names}
    others = {"NAME", "MEMBER", "NUMBER", "QUANTITY", "STRING"}
    assert {t.name for t in machine.terminals if not t.name.startswith("__")} == words | signs | others


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("param k = 1..2", "a number is malformed"),
        ("param k = 1e", "a number is malformed or runs into letters"),
        ("param k == 1", "unexpected '='"),
        ("param k = a.b.c", "unexpected '.'"),
        ("param k = 5 ms 3", "unexpected '3'"),
        ("param in = 1\u00a0", "unexpected U+00A0 (NO-BREAK SPACE)"),
        ("require a < b < c", "unexpected '<'"),
        ("param k = \u0663", "'\u0663' (U+0663, ARABIC-INDIC DIGIT THREE) is no digit of a number"),
    ],
)
def test_what_is_no_token_of_its_place_is_refused(line, found):
    whole = LogicalLine(0, len(line), "", "statement", line.split()[0])
    node, (mistake,) = grammar.parse_line(SourceText("t", line), whole, "statement")
    assert node is None
    assert found in mistake.message


@pytest.mark.parametrize("word", ["in", "unit", "is", "then", "x", "linear", "function", "hold", "unless", "else"])
def test_keywords_are_names_where_a_name_stands(word):
    text = f"input {word} in [0, 1]\n  terms {word} b\noutput u in [0, 1]\n  terms {word} c\ntable u = {word}\n"
    text += f"  {word} b\n  | {word} c\nif {word} is {word} then u is {word}\n"
    assert parse(SourceText("t", text))[1] == []


def test_a_member_and_a_unit_are_one_token_each():
    text = "controller c\ninput e\nlet a = p.y + 5ms + 3 % + .5\noutput u = a\n"
    tree, mistakes = parse(SourceText("t", text))
    assert not mistakes
    assert re.search(r"'p\.y'.*0\.005.*0\.03.*0\.5", repr(tree.statements[2].value))
