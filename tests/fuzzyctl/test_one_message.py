"""One mistake gives one message, in the words of the one who made it."""

import pytest

from fuzzyctl.checking import check_source
from fuzzyctl.source import SourceText

BASE = """\
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


def said(*pairs, after="", folder=None):
    """Return what is said of the base text with replacements, each of which must apply: place, code, words."""
    text = BASE
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new, 1)
    _, diagnostics = check_source(SourceText("t.fz", text + after), folder=folder)
    return [
        (d.span.line if d.span else 0, d.code, " | ".join([d.message, *d.facts, d.help, *(n.message for n in d.notes)]))
        for d in diagnostics
    ]


def only(found):
    """Return the only message as `line code`, and its words."""
    assert len(found) == 1, found
    line, code, words = found[0]
    return f"{line} {code}", words


class TestTheBase:
    def test_it_is_sound(self):
        assert said() == []


class TestNumbers:
    @pytest.mark.parametrize(
        ("old", "new", "place", "point"),
        [("[-5, 5]", "[-５, 5]", "5 FZ105", "U+FF15"), ("constant(1)", "constant(1٢.5)", "6 FZ105", "U+0662")],
    )
    def test_digits_of_other_scripts_are_refused_by_their_code_point(self, old, new, place, point):
        where, words = only(said((old, new)))
        assert where == place
        assert point in words


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


class TestIllFormedTerms:
    @pytest.mark.parametrize("otherwise", ["", " else 0"])
    def test_hints_do_not_stumble_over_them(self, otherwise):
        terms = "  N = piecewise(1, 2, 3)\n  Z = triangle(-1, 0, 1)\n  P = triangle(0, 1, 1)"
        assert only(said(("  terms N Z P", terms), ("[-5, 5]", f"[-5, 5]{otherwise}")))[0] == "4 FZ302"


CROSSED = (
    ("input e in [-1, 1]\n  terms N Z P", "input e in [-1, 1]\n  terms N Z P\ninput d in [0, 1]\n  terms N Z P"),
    ("table u = e\n    N Z P\n  | a a b\n", 'table u = e x d from "t.csv"\n'),
    ("[-5, 5]", "[-5, 5] else 0"),
)


class TestCsvFields:
    def read(self, tmp_path, csv):
        (tmp_path / "t.csv").write_text(csv)
        return said(*CROSSED, folder=tmp_path)

    @pytest.mark.parametrize(
        "csv",
        [
            ',N,Z,P\n"N",a,"a", b\nZ,a,a,"linear(1, 2, 3)"\nP,a,0.5,b*(1/2)\n',
            "e\\d;N;Z;P\nN;a;a;b\nZ;a;a;b\nP;a;0.5;.\n",
            '"e, d",N,Z,P\r\n\r\nN,a,a,b\r\nZ,a,a,b\r\n,,,\r\nP,a,a,b',
        ],
    )
    def test_quotes_semicolons_and_a_corner_are_read(self, tmp_path, csv):
        assert self.read(tmp_path, csv) == []

    @pytest.mark.parametrize(
        ("csv", "place", "part"),
        [
            (",N,Z,P\nN,,a,b,b\nZ,a,a,b\nP,a,a,b\n", "2 FZ207", "the field of cell 1 is empty | write '.'"),
            (",N,,P\nN,a,a,b\nZ,a,a,b\nP,a,a,b\n", "1 FZ207", "the field of column 2 is empty"),
            (",N,Z,P\nN,a,a,b,\nZ,a,a,b\nP,a,a,b\n", "2 FZ207", "the field of cell 4 is empty"),
            (",N,Z,P\nN,a a,b,b\nZ,a,a,b\nP,a,a,b\n", "2 FZ102", "unexpected 'a'"),
            (",N,Z,P\nN,linear(1, 2, 3),b,b\nZ,a,a,b\nP,a,a,b\n", "2 FZ103", "in double quotes"),
            (',N,Z,P\nN,"a,b,b\nZ,a,a,b\nP,a,a,b\n', "2 FZ104", "quoted field"),
            ("N,Z,P\nN,a,a,b\nZ,a,a,b\nP,a,a,b\n", "1 FZ207", "begin it with an empty field"),
            (",N,Z,P\nN,a,a,b\n,a,a,b\nP,a,a,b\n", "3 FZ207", "in its first field"),
            (",N Z,P\nN,a,b\n", "1 FZ102", "parted by commas"),
            ("", "10 FZ212", "the form of the file is: the first line"),
        ],
    )
    def test_a_field_that_is_no_cell_is_named(self, tmp_path, csv, place, part):
        where, words = only(self.read(tmp_path, csv))
        assert where == place
        assert part in words


class TestTheFormOfATable:
    @pytest.mark.parametrize("rows", ["  N | a\n  Z | a\n  P | b", "  | N Z P\n  | a a b"])
    def test_a_table_without_header_is_shown_its_own_form(self, rows):
        where, words = only(said(("    N Z P\n  | a a b", rows)))
        assert where == "8 FZ212"
        assert "the form is: a line 'N Z P', below it a line '| CELL CELL CELL'" in words
