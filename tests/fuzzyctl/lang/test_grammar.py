"""The tables of the grammar that the package ships."""

import pickle
from collections import Counter

import pytest

from fuzzyctl.lang import grammar
from fuzzyctl.testing import check_text


@pytest.fixture(autouse=True)
def _fresh():
    grammar._machine.cache_clear()
    yield
    grammar._machine.cache_clear()


def content(tables):
    """Rules and terminals, and what each state of the parser accepts; numbers differ from one run to the next."""
    table = tables["data"]["parser"]["parser"]
    memo = sorted(repr(sorted(m.items(), key=str)) for m in tables["memo"].values())
    states = Counter(frozenset(table["tokens"][t] for t in state) for state in table["states"].values())
    return memo, states


def test_the_shipped_tables_are_those_of_the_grammar():
    key, shipped = grammar.shipped_tables().split(b"\n", 1)
    assert key.decode() == grammar.key(), "write them anew: python -m fuzzyctl.lang.grammar"
    computed = grammar.computed_tables().split(b"\n", 1)[1]
    assert content(pickle.loads(shipped)) == content(pickle.loads(computed))


@pytest.mark.parametrize("content", [b"", b"0.0.0 00000000\n\x80\x05", b"\x80", None])
def test_tables_are_computed_only_if_those_that_are_shipped_do_not_fit(content, monkeypatch):
    calls = []
    computed = grammar.computed_tables()
    if content is not None:
        monkeypatch.setattr(grammar, "shipped_tables", lambda: content)
    monkeypatch.setattr(grammar, "computed_tables", lambda: (calls.append(1), computed)[1])
    found = check_text("param k = 2 * (3 + 4)\nparam 1\n")[1]
    assert ([d.code for d in found], len(calls)) == (["FZ102"], content is not None)


def test_tables_of_another_grammar_do_not_fit(monkeypatch):
    monkeypatch.setattr(grammar, "grammar_text", lambda: "start: NAME")
    assert not grammar.shipped_tables().startswith(grammar.key().encode())
