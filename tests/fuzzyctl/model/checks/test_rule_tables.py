import pytest

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.loading.load import examine, loads
from fuzzyctl.model.checks.tables import culprit as culprit_of
from tests.shipped import SYSTEMS


class TestCulprit:
    @pytest.mark.parametrize(
        ("ranks", "culprit"),
        [
            ([[0, 0, 1], [0, 1, 2], [1, 2, 2]], None),
            ([[2, 2, 1], [2, 1, 0], [1, 0, 0]], None),
            ([[2, 0, 1], [0, 1, 2], [1, 2, 2]], (0, 0)),
            ([[0, 0, 1], [0, 1, 2], [1, 0, 2]], (2, 1)),
            ([[0, 1, 4, 3, 4]], (0, 2)),
            ([[0, 1, 2, 3, 4]], None),
            ([[0, 2, 0], [2, 0, 2], [0, 2, 0]], None),
        ],
    )
    def test_the_one_odd_cell_is_found(self, ranks, culprit):
        assert culprit_of(ranks) == culprit

    @pytest.mark.parametrize("path", SYSTEMS, ids=lambda p: p.name)
    def test_shipped_tables_do_not_jump(self, path):
        _, diagnostics = examine(SourceText("t", path.read_text(encoding="utf-8")))
        assert diagnostics == []


class TestUncoveredRanges:
    @pytest.mark.parametrize(
        ("terms", "gap"),
        [
            ("N = triangle(-inf, 0, 4)\n  P = triangle(6, 10, inf)", "from 4 to 6"),
            ("N = triangle(2, 3, 4)\n  P = triangle(3, 10, inf)", "from 0 to 2"),
            ("N = triangle(-inf, 3, 4)\n  P = triangle(3, 5, 7)", "from 7 to 10"),
            ("N = triangle(-inf, 0, 5)\n  P = triangle(5, 10, inf)", None),
            ("N = gaussian(0, 1)\n  P = triangle(9, 10, inf)", None),
        ],
    )
    def test_gaps_wider_than_a_point_are_found(self, changed, terms, gap):
        text = changed(("terms N@0 P@10", terms), ("[-2, 2]", "[-2, 2] else 0"))
        _, diagnostics = examine(SourceText("t", text))
        assert [d.code for d in diagnostics] == (["FZ309"] if gap else [])
        assert gap is None or gap in diagnostics[0].message

    def test_without_else_the_proof_of_coverage_speaks(self, changed):
        assert loads(changed(("terms N@0 P@10", "N = triangle(-inf, 0, 4)\n  P = triangle(6, 10, inf)"))) is not None
