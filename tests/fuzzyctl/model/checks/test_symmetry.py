"""One cell that breaks the symmetry of a table."""

import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import examine

HEAD = """system s
and product
defuzzifier weighted_average
input a in [-1, 1]
  terms NB NS Z PS PB
input b in [-2, 2]
  terms NB NS Z PS PB
output u in [-1, 1]
  terms NB NS ZO PS PB
"""
#: Turned by 180 degrees each is its opposite; the second is not symmetric in any other way.
PD = ["NB NB NS NS ZO", "NB NS NS ZO PS", "NS NS ZO PS PS", "NS ZO PS PS PB", "ZO PS PS PB PB"]
ODD = ["NB ZO NS PS ZO", "NB NS PB ZO NS", "PS NS ZO PS NS", "PS ZO NB PS PB", "ZO NS PS ZO PB"]


def found(rows, code="FZ311", head=HEAD):
    labels = ["NB", "NS", "Z", "PS", "PB"]
    table = "table u = a x b\n  NB NS Z PS PB\n" + "".join(f"{k} | {r}\n" for k, r in zip(labels, rows, strict=True))
    _, diagnostics = examine(SourceText("s.fz", head + table))
    return [d for d in diagnostics if d.code == code]


def changed(rows, row, column, cell):
    cells = [r.split() for r in rows]
    cells[row][column] = cell
    return [" ".join(r) for r in cells]


class TestOddCells:
    @pytest.mark.parametrize("rows", [PD, ODD])
    def test_a_symmetric_table_is_fine(self, rows):
        assert found(rows) == []

    def test_the_pair_that_breaks_it_is_shown(self):
        (d,) = found(changed(ODD, 1, 4, "PS"))
        assert d.severity == "warning"
        places = {(d.span.line, d.span.text), (d.notes[0].span.line, d.notes[0].span.text)}
        assert places == {(13, "PS"), (15, "PS")}
        assert "turned by 180 degrees" in d.facts[0]

    def test_several_symmetries_point_at_the_cell_itself(self):
        (d,) = found(changed(PD, 4, 1, "ZO"))
        assert (d.span.line, d.span.column) == (16, 9)

    def test_two_odd_pairs_are_meant(self):
        assert found(changed(changed(ODD, 1, 4, "PS"), 0, 1, "PB")) == []

    def test_a_table_that_is_the_same_nearly_everywhere_may_have_one_other_cell(self):
        plain = ["ZO ZO ZO ZO ZO"] * 5
        assert found(changed(plain, 0, 4, "PB")) == []

    def test_a_table_without_symmetry_is_none_but_for_one_cell(self):
        assert found(["NB NS ZO PS PB", "PS ZO NB NB ZO", "ZO PB PB NS NS", "NB PS ZO PB PS", "NS NS PB ZO NB"]) == []

    def test_a_cell_that_jumps_has_one_message(self):
        rows = changed(PD, 1, 1, "PB")
        assert len(found(rows, "FZ310")) == 1
        assert found(rows) == []
