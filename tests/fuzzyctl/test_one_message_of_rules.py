"""Rules and terms as beginners write them: one message, with what to write."""

import pytest

from tests.fuzzyctl.messages import only, said, said_of


@pytest.mark.parametrize(
    ("line", "place", "words"),
    [
        ("if e < 3 then u is a", "11 FZ102", "LIMIT = rectangle(-inf, 3), and write: INPUT is LIMIT"),
        ("if e is N and e >= -0.5 then u is a", "11 FZ102", "LIMIT = rectangle(-0.5, inf)"),
        (
            "or if e is N then u is a",
            "11 FZ102",
            "the form is: if (INPUT is TERM or INPUT is TERM) then OUTPUT is TERM",
        ),
        ("and not e is N then u is a", "11 FZ102", "'and' continues no rule"),
        ("if e is N, e is P then u is a", "11 FZ102", "write: if e is N and e is P then u is a"),
        ("if e is P and not N then u is a", "11 FZ102", "write: if e is (P and not N) then u is a"),
        ("if e is between N and Z then u is a", "11 FZ102", "write: if e is (N or Z) then u is a"),
        ("if e is N or if e is P then u is a", "11 FZ102", "write: if e is N or e is P then u is a"),
        ("if e is N the u is a\nelse u is b", "11 FZ102", "'then'"),
    ],
)
def test_a_rule_is_shown_as_it_is_written(line, place, words):
    where, text = said(after=f"{line}\n")[0][:2], said(after=f"{line}\n")[0][2]
    assert f"{where[0]} {where[1]}" == place
    assert words in text


def test_an_else_below_a_rule_that_cannot_be_read_is_repaired():
    (_, _, first), (line, code, words) = said(after="if e is N x e is P the u is a\nelse u is b\n")
    assert "'then'" in first
    assert (line, code) == (12, "FZ101")
    assert words.endswith("write: otherwise u is b")


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("a = constant", "very a = constant", "6 FZ101", "write: very_a = constant(1)"),
        ("[-5, 5]", "[-5, 5], else 0", "5 FZ102", "write: output u in [-5, 5] else 0"),
        ("[-5, 5]", '[-5, 5], unit "V", else 0', "5 FZ102", 'write: output u in [-5, 5] unit "V" else 0'),
        ("terms N Z P", "N = triangle(1, 0, -1)", "4 FZ301", "from left to right it is: triangle(-1, 0, 1)"),
    ],
)
def test_a_declaration_is_shown_as_it_is_written(old, new, place, words):
    found = [d for d in said((old, new)) if d[1] != "FZ203"]
    assert f"{found[0][0]} {found[0][1]}" == place
    assert words in found[0][2]


def test_an_implication_without_effect_names_the_defuzzifier():
    where, words = only(said(("input e", "implication product\ninput e")))
    assert where == "3 FZ214"
    assert words.endswith("the defuzzifier is given here")


def test_long_lines_that_cannot_be_read_are_reported():
    for line in (f"if {'a' * 50_000} <", f"if e is N and {'x<' * 20_000}", f"or {'(' * 90}{'a' * 50_000}"):
        assert said_of(f"system s\n{line}\n")
