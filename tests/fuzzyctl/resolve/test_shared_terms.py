"""Several variables on a line, and `terms of VARIABLE`."""

import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.fz import dumps
from fuzzyctl.lang.formatter import format_source
from fuzzyctl.loading.load import loads
from tests.fuzzyctl.messages import only, said_of

START = "system s\nand product\ndefuzzifier center_average\n"
SHARED = """input e "error", de in [-1, 1] unit "V"
  terms N@-0.5 Z P@0.5
output u, v in [-2, 2] else 0
  terms A B
"""
APART = """input e "error" in [-1, 1] unit "V"
  terms N@-0.5 Z P@0.5
input de in [-1, 1] unit "V"
  terms N@-0.5 Z P@0.5
output u in [-2, 2] else 0
  terms A B
output v in [-2, 2] else 0
  terms A B
"""
RULES = "if e is N and de is P then u is A, v is B\nif e is Z then u is B\nif de is N then v is A\n"


def read(text):
    """A system that is the same after it has been printed, and after it has been formatted."""
    system = loads(text)
    assert loads(dumps(system)) == system == loads(format_source(SourceText("", text)))
    return system


def variables(lines):
    return START + lines.replace("Z P@", "Z@0 P@") + RULES


def said(lines):
    return [d for d in said_of(variables(lines)) if d[1] not in ("FZ208", "FZ211")]


def test_variables_of_a_line_are_those_of_lines_of_their_own():
    assert read(variables(SHARED)) == read(variables(APART))


@pytest.mark.parametrize(
    ("own", "taken"),
    [
        ('input de in [-1, 1] unit "V"\n  terms N@-0.5 Z P@0.5\n', 'input de in [-1, 1] unit "V" terms of e\n'),
        ("output v in [-2, 2] else 0\n  terms A B\n", "output v in [-2, 2] terms of u else 0\n"),
    ],
)
def test_terms_of_another_variable_are_its_term_lines(own, taken):
    assert own in APART
    assert read(variables(APART.replace(own, taken))) == read(variables(APART))


def test_the_other_variable_may_be_declared_below():
    above = 'input de in [-1, 1] unit "V" terms of e\n'
    first = read(variables(above + SHARED.replace(", de", "")))
    assert first.input("de").terms == first.input("e").terms


def test_names_alone_follow_the_range():
    lines = "input e in [-1, 1]\n  terms N Z P\ninput de in [0, 10] terms of e\n"
    lines += "output u, v in [-1, 1] else 0\n  terms A B\n"
    own = lines.replace(" terms of e", "\n  terms N Z P")
    assert read(variables(lines)) == read(variables(own))


def test_terms_are_called_of_where_they_are_listed():
    lines = SHARED.replace("terms A B", "terms of A B")
    assert [t.name for t in read(variables(lines)).output("u").terms] == ["of", "A", "B"]


def test_a_term_that_one_of_the_variables_uses_is_not_reported():
    assert [d for d in said_of(variables(SHARED)) if d[1] == "FZ208"] == []


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        (" unit", ", e in [-1, 1] unit", "4 FZ102", "unexpected ','"),
        ("u, v in", "u, u in", "6 FZ201", "'u' is declared twice"),
        ("Z P@0.5", "Z@1 P@0.5", "5 FZ301", "out of order"),
        ("N@-0.5", "N@(k)", "5 FZ202", "no param 'k'"),
        ("  terms A B", "  terms A A B", "7 FZ201", "term 'A' is declared twice"),
        ('"V"\n  terms N@-0.5 Z P@0.5', '"V" terms of x', "4 FZ202", "no input or output 'x'"),
        ('"V"\n  terms N@-0.5 Z P@0.5', '"V" terms of e', "4 FZ214", "no terms of its own | write its terms"),
        ('unit "V"', "terms of u", "4 FZ215", "the terms are those of 'u', and terms are given below"),
        ("else 0\n  terms A B", "terms of e else 0", "6 FZ214", "another range | 'u' is in [-2, 2], 'e' is in [-1, 1]"),
        ("in [-1, 1]", "[-1, 1]", "4 FZ102", 'write: input e "error", de in [-1, 1] unit "V"'),
    ],
)
def test_a_mistake_is_reported_once(old, new, place, words):
    assert old in SHARED
    where, text = only(said(SHARED.replace(old, new, 1)))
    assert where == place
    assert words in text


def test_terms_are_not_taken_from_a_variable_that_takes_them_itself():
    lines = SHARED.replace('e "error", de', "e") + "input de in [-1, 1] terms of e\ninput w in [-1, 1] terms of de\n"
    where, text = only(said(lines + "if w is N then u is A\n"))
    assert where.endswith("FZ214")
    assert "write: terms of e" in text


def test_the_terms_that_variables_share_are_limited():
    names = ", ".join(f"x{k}" for k in range(60))
    lines = f"input {names} in [0, 1]\n  terms {' '.join(f't{k}' for k in range(500))}\n{SHARED}"
    assert "14 FZ112" not in said(lines)
    assert [d[1] for d in said(lines) if d[1] != "FZ203"] == ["FZ112"]
