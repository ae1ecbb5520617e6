"""Mistakes in lets and in outputs that are formulas: each has its message at its place."""

import pytest

import fuzzyctl
from fuzzyctl import DiagnosticError

HEAD = "system s\ndefuzzifier center_average\ninput e in [-1, 1]\n  terms N P\n"
OUTPUT = "output u in [-1, 1]\n  terms N P\n"
TABLE = "table u = e\n    N P\n  | N P\n"

MISTAKES = {
    "let z = e + q\n": ("FZ202", "no param, input or let 'q'", "q"),
    "let z = e + u\n": ("FZ202", "no param, input or let 'u'", "u"),
    "let z = e\n  terms A B\n": ("FZ212", "let 'z' has terms and no range", "z"),
    "let z = z + 1\n": ("FZ217", "lets depend on each other in a circle: z → z", "z"),
    "let a = b\nlet b = a\n": ("FZ217", "lets depend on each other in a circle: a → b → a", "b"),
    "let z in [1, 0] = e\n": ("FZ304", "the range of 'z' is empty: [1, 0]", "1, 0"),
    "let z in [-inf, 1] = e\n": ("FZ302", "the range of 'z' is infinite", "-inf, 1"),
    "let e = 2 * e\n": ("FZ201", "'e' is declared twice", "e"),
    "let z = e\nif e is N then z is N\n": ("FZ214", "'z' is a let; a consequent sets an output", "z"),
    "let z in [0, 1] = e\n  A = triangle(0, 1, 2)\nif z is B then u is N\n": ("FZ203", "let 'z' has no term 'B'", "B"),
    "let z in [0, 1] = e\n  A = linear(0, 1)\n": (
        "FZ214",
        "'linear' is a consequent, for terms of an output",
        "linear",
    ),
    "let z = 2 * e\nlet w in [-z, 1] = e\n": ("FZ202", "no param 'z'", "z"),
    "let z e\n": ("FZ101", "expected a name, then '='", "let"),
    "output v in [0, 1] else 0 = e\n": ("FZ214", "output 'v' is a formula, and 'else' needs rules", "else 0"),
    "output v in [0, 1] = q\n": ("FZ202", "no param, input or output 'q'", "q"),
    "output v in [0, 1] = w\noutput w in [0, 1] = v\n": (
        "FZ217",
        "outputs depend on each other in a circle: v → w → v",
        "w",
    ),
    "output v in [0, 1] = e\nif e is N then v is function(e)\n": (
        "FZ214",
        "output 'v' is a formula, and a rule sets it",
        "v is function(e",
    ),
}


@pytest.mark.parametrize("text", MISTAKES)
def test_each_mistake_has_its_message_and_nothing_else_is_reported(text):
    with pytest.raises(DiagnosticError) as caught:
        fuzzyctl.loads(HEAD + text + OUTPUT + TABLE)
    (found,) = caught.value.diagnostics
    assert (found.code, found.message, found.span.text) == MISTAKES[text]
    assert found.help or found.facts


def test_a_let_that_nothing_reads_is_warned_of(tmp_path):
    path = tmp_path / "s.fz"
    path.write_text(HEAD + "let z = e\n" + OUTPUT + TABLE)
    (found,) = fuzzyctl.check(path)[1]
    assert (found.code, found.message, found.severity) == ("FZ216", "nothing uses let 'z'", "warning")


def test_a_table_may_cross_lets():
    text = (
        HEAD + "let z in [-2, 2] = 2 * e\n  terms A B\n" + OUTPUT + "table u = z x e\n    N P\n  A | N P\n  B | P P\n"
    )
    assert fuzzyctl.loads(text)(e=-1.0) == -1.0


def test_a_number_is_named_by_a_param_as_before():
    with pytest.raises(DiagnosticError) as caught:
        fuzzyctl.loads(HEAD + "let z = 2e-3\n" + OUTPUT + TABLE)
    (found,) = caught.value.diagnostics
    assert (found.code, found.message) == (
        "FZ101",
        "unexpected 'let': a statement begins with its keyword and goes on with its value",
    )
    assert found.help == "write: param z = 2e-3"
