"""Tables with numbers as labels, a factor for all cells, hedged cells, and outputs as rows."""

import pytest

from fuzzyctl.building.fragments import cells
from fuzzyctl.convert.markdown import page
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.formats.fz import dumps
from fuzzyctl.lang.formatter import format_source
from fuzzyctl.loading.load import load, loads
from tests.fuzzyctl.messages import only, said_of

HEAD = """system forms
semantics exact(consequent_hedges=activation)
defuzzifier weighted_average
param g = 0.5
input e, de in [-1, 1]
  terms N Z P
output u in [-1, 1] else 0
  terms low@-1 mid@0 high@1
"""
NAMES = """table u = e x de
       N     Z     P
  N |  low   mid   mid
  Z |  low   mid   high
  P |  mid   mid   high
"""
VALUES = """table u = e x de
       N     Z       P
  N |  -1    0       (g)
  Z |  (-g)  0.5*.2  1
  P |  0     0.25    1
"""
CASCADE = """output v in [-1, 1] else 0
  terms low high
"""


def read(lines):
    """A system that is the same after it has been printed, and after it has been formatted."""
    system = loads(HEAD + lines)
    assert loads(dumps(system)) == system == loads(format_source(SourceText("", HEAD + lines)))
    return system


def said(lines):
    return [d for d in said_of(HEAD + lines) if d[1] not in ("FZ208", "FZ211", "FZ216", "FZ310", "FZ311")]


@pytest.mark.parametrize(
    ("header", "labels"),
    [
        ("-1 0 1", "-1 0 1"),
        ("-1 0 +1", "0 1 2"),
        ("0. 1 2", "7 8 9"),
        ("N Z P", "-1 0 1"),
    ],
)
def test_numbers_count_the_terms(header, labels):
    table = NAMES.replace("N     Z     P\n", f"{header}\n")
    for name, label in zip("NZP", labels.split(), strict=True):
        table = table.replace(f"  {name} |", f"  {label} |")
    assert read(table) == read(NAMES)


def test_numbers_may_fall():
    assert read(NAMES.replace("N     Z     P\n", "1 0 -1\n")) == read(NAMES.replace("N     Z     P\n", "P Z N\n"))


def test_labels_of_a_csv_file_may_be_numbers(tmp_path):
    (tmp_path / "u.csv").write_text(",-1,0,1\n-1,low,mid,mid\n0,low,mid,high\n1,mid,mid,high\n")
    (tmp_path / "s.fz").write_text(HEAD + 'table u = e x de from "u.csv"\n')
    assert load(tmp_path / "s.fz") == read(NAMES)


def test_a_factor_multiplies_the_numbers_of_all_cells():
    long = VALUES.replace("-1 ", "(2*g*-1) ").replace(" 0 ", " (2*g*0) ").replace("(g)", "(2*g*g)")
    long = long.replace("(-g)", "(2*g*-g)").replace("0.5*.2", "(2*g*0.5)*.2").replace(" 1\n", " (2*g*1)\n")
    long = long.replace("0.25", "(2*g*0.25)")
    short = read(VALUES.replace("x de", "x de scale 2*g"))
    assert short == read(long)
    assert short(e=-1, de=-1) == -1.0
    assert short.with_params(g=2)(e=-1, de=-1) == -4.0


def test_a_table_from_a_file_has_a_factor_too(tmp_path):
    (tmp_path / "u.csv").write_text(",N,Z,P\n,1,2,3\n")
    (tmp_path / "s.fz").write_text(HEAD + 'table u = e scale 0.1 from "u.csv"\nif de is N then u is 0\n')
    assert load(tmp_path / "s.fz") == read("table u = e\n  N Z P\n | (0.1*1) (0.1*2) (0.1*3)\nif de is N then u is 0\n")


class TestHedgedCells:
    TABLE = "table u = e\n  N Z P\n  | [not low] mid [very not high]*0.5\n"
    RULES = "if e is N then u is not low\nif e is Z then u is mid\nif e is P then u is very not high weight 0.5\n"

    def test_they_are_rules_with_hedged_consequents(self):
        assert read(self.TABLE).rules == read(self.RULES).rules

    def test_of_several_outputs_each_has_its_own(self):
        both = "table u, v = e\n  N Z P\n  | [not low]/high mid/low high/[very low]\n"
        rules = read(CASCADE + both).rules
        assert [tuple(c.hedges for c in r.consequents) for r in rules] == [(("not",), ()), ((), ()), ((), ("very",))]

    def test_they_are_printed_in_all_forms(self):
        assert "[not low]" in dumps(read(self.TABLE))
        assert "very not high" in page(read(self.TABLE), {})

    def test_python_takes_them_as_texts(self):
        assert cells("[not low] mid") == tuple(
            c.model_copy(update={"span": None}) for c in read(self.TABLE).blocks[0].cells[0][:2]
        )


def test_rows_may_be_those_of_an_output():
    lines = f"{CASCADE}table v = e\n  N Z P\n  | high low high\n"
    table = "table u = v x e\n        N    Z    P\n  low | mid low high\n  high | low mid mid\n"
    rules = "".join(
        f"if v is {row} and e is {column} then u is {cell}\n"
        for row, cells in (("low", "mid low high"), ("high", "low mid mid"))
        for column, cell in zip("NZP", cells.split(), strict=True)
    )
    assert read(lines + table).rules == read(lines + rules).rules
    assert read(lines + table)(e=0.3, de=0) == read(lines + rules)(e=0.3, de=0)


def test_conditions_in_cells_are_formatted_with_blanks_between_words():
    text = HEAD + VALUES.replace("0.25", "function(e > 0 and not de > 0)")
    assert loads(format_source(SourceText("", text))) == loads(text)


@pytest.mark.parametrize(
    ("table", "old", "new", "place", "words"),
    [
        (NAMES, "N     Z     P\n", "-1 0 2\n", "10 FZ203", "do not count the 3 terms of 'de'"),
        (NAMES, "N     Z     P\n", "-1 0\n", "10 FZ203", "write each of -1 0 1 once"),
        (NAMES, "N     Z     P\n", "-0.5 0.5 1.5\n", "10 FZ203", "do not count the 3 terms of 'de'"),
        (NAMES, "N     Z     P\n", "N 0 P\n", "10 FZ203", "input 'de' has no term '0'"),
        (NAMES, "  N |", "  1 |", "11 FZ203", "input 'e' has no term '1'"),
        (NAMES, "x de", "x de scale 2", "11 FZ214", "'scale' multiplies numbers, and 'low' is none"),
        (NAMES, "x de", "x de scale", "9 FZ102", "the line ends too early"),
        (VALUES, "x de", "x de scale k", "9 FZ202", "no param 'k'"),
        (NAMES, "low", "[vry low]", "11 FZ202", "did you mean 'very'?"),
        (NAMES, "low", "[very lo]", "11 FZ203", "did you mean 'low'?"),
        (NAMES, "low", "[not]", "11 FZ102", "'not' needs a term behind it"),
        (NAMES, "e x de", "u x de", "9 FZ214", "the table sets 'u' and reads it"),
        (NAMES, "e x de", "e x de x u", "9 FZ102", "put 'with VARIABLE is TERM' above a table"),
        (NAMES, "low", "not low", "11 FZ207", "in brackets: [not TERM]"),
        (NAMES, "low", "very(low)", "11 FZ207", "in brackets: [very TERM]"),
        (NAMES, "x de", "x de scale", "9 FZ102", "expected '(', + or -, a name or a number"),
    ],
)
def test_a_mistake_is_reported_once(table, old, new, place, words):
    assert old in table
    where, text = only(said(table.replace(old, new, 1)))
    assert where == place
    assert words in text
