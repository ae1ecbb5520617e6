"""CSV files of a reference path: what is read, and each mistake at its line and column."""

import numpy as np
import pytest

from dwmr import find, read
from dwmr.reference.path_files import LARGEST_PATH, read_rows
from fuzzyctl import DiagnosticError


def mistakes(text):
    with pytest.raises(DiagnosticError) as caught:
        read_rows("way.csv", text.encode())
    return caught.value.diagnostics


class TestReadRows:
    def test_takes_columns_in_any_order_and_passes_over_the_rest(self):
        rows = read_rows("way.csv", b"\xef\xbb\xbf# a way\r\ny, t ,note,x\r\n2,0,a,1\r\n\r\n# on\r\n4,5.5,,-3e0\r\n")
        assert rows.t.tolist() == [0.0, 5.5]
        assert rows.points.tolist() == [[1.0, 2.0], [-3.0, 4.0]]
        assert rows.lines == (3, 6)

    @pytest.mark.parametrize(
        ("text", "place", "words"),
        [
            ("t,x,y\n0,0,0\n1,nan,0\n", "way.csv:3:3", "column x: nan is no finite number"),
            ("t,x,y\n0,0,0\n1,0,-inf\n", "way.csv:3:5", "column y: -inf is no finite number"),
            ("t,x,y\n0,0,0\n1,2e9,0\n", "way.csv:3:3", "column x: 2e9 is beyond 1e+09"),
            ("t,x,y\n0,0,zero\n", "way.csv:2:5", "column y: zero is no number"),
            ("t,x,y\n0,1_0,0\n", "way.csv:2:3", "column x: 1_0 is no number"),
            ("t,x,y\n0,,0\n", "way.csv:2:3", "column x is empty"),
            ("x,t,y\n0,1,0\n1,1,0\n", "way.csv:3:3", "1 comes after 1; times must increase"),
            ("t,x,y\n0,0,0\n5,1,0\n4,2,0\n", "way.csv:4:1", "4 comes after 5; times must increase"),
            ("t,x,y\n0,0,0\n1,1\n", "way.csv:3:1", "the row has 2 cells for 3 columns"),
            ("t,x,z\n0,0,0\n", "way.csv:1:1", "the first line names no column y"),
            ("0,0,0\n1,1,1\n", "way.csv:1:1", "the first line names no column t, x, y"),
            ("t,x,x,y\n0,0,0,0\n", "way.csv:1:1", "names column x twice"),
            ("t,x,y\n0,0,0\n", "way.csv", "has 1 row; a path needs at least 2"),
            ("t,x,y\n", "way.csv", "has 0 rows"),
            ("\n# nothing\n", "way.csv", "is empty"),
        ],
    )  # fmt: skip
    def test_names_file_line_and_column_of_a_mistake(self, text, place, words):
        (one,) = mistakes(text)
        assert (one.code, one.place) == ("FZ910", place)
        assert words in one.message

    def test_gives_all_mistakes_up_to_a_number(self):
        assert len(mistakes("t,x,y\n0,a,b\n1,2\n")) == 3
        assert len(mistakes("t,x,y\n" + "0,a,0\n" * 1000)) == 20

    def test_refuses_what_is_no_text(self):
        with pytest.raises(DiagnosticError, match="not UTF-8") as caught:
            read_rows("way.csv", b"t,x,y\n\xff")
        assert caught.value.diagnostics[0].code == "FZ002"


class TestScenario:
    def scenario(self, folder, rows, more=""):
        (folder / "way.csv").write_text(rows, encoding="utf-8")
        path = folder / "mine.toml"
        path.write_text(
            f'extends = "paper"\nreference = {{ kind = "csv", file = "way.csv"{more} }}\n', encoding="utf-8"
        )
        return path

    def test_goes_through_the_rows_at_their_times(self, tmp_path):
        shape = read(self.scenario(tmp_path, "t,x,y\n1,0,0\n4,2,1\n6,3,-1\n9,7,0\n")).shape
        for t, x, y in ((1, 0, 0), (4, 2, 1), (6, 3, -1), (9, 7, 0)):
            assert (shape.at(t).x, shape.at(t).y) == pytest.approx((x, y), abs=1e-12)
        before, first = shape.at(0.0), shape.at(1.0)
        assert (before.theta, before.v) == pytest.approx((first.theta, first.v))
        assert shape.at(11.0).x - shape.at(10.0).x == pytest.approx(shape.at(9.0).v * np.cos(shape.at(9.0).theta))

    def test_may_come_back_to_its_first_row(self, tmp_path):
        rows = "t,x,y\n0,0,0\n4,2,1\n6,3,-1\n9,0,0\n"
        shape = read(self.scenario(tmp_path, rows, ", closed = true")).shape
        assert shape.at(9.0 + 3.3) == pytest.approx(shape.at(3.3))
        with pytest.raises(DiagnosticError, match=r"begins at \(0, 0\) and ends at \(0, 1\)"):
            read(self.scenario(tmp_path, rows.replace("9,0,0", "9,0,1"), ", closed = true"))

    def test_that_stands_still_is_refused_at_its_row(self, tmp_path):
        with pytest.raises(DiagnosticError, match=r"stands still: its speed is .* m/s at t = 7") as caught:
            read(self.scenario(tmp_path, "t,x,y\n0,0,0\n5,5,0\n9,5,0\n12,8,0\n"))
        (one,) = caught.value.diagnostics
        assert one.place == f"{tmp_path / 'way.csv'}:3:1"

    def test_is_part_of_the_checksum(self, tmp_path):
        first = read(self.scenario(tmp_path, "t,x,y\n0,0,0\n5,5,0\n")).sha256
        assert read(self.scenario(tmp_path, "t,x,y\n0,0,0\n5,5,1\n")).sha256 != first

    def test_that_is_too_large_is_refused_before_it_is_read(self, tmp_path):
        path = self.scenario(tmp_path, "t,x,y\n" + "#" * LARGEST_PATH)
        with pytest.raises(DiagnosticError, match="at most 4,194,304 are read"):
            read(path)

    def test_of_many_rows_is_read_at_once(self, tmp_path):
        t = np.arange(0.0, 5_000.0, 0.05)
        rows = "\n".join(f"{a:.2f},{10 * np.cos(a / 20):.5f},{10 * np.sin(a / 20):.5f}" for a in t)
        shape = read(self.scenario(tmp_path, f"t,x,y\n{rows}\n")).shape
        assert shape.at(2_000.025).v == pytest.approx(0.5, abs=1e-3)

    def test_beside_the_scenario_that_is_extended_is_found(self, tmp_path):
        (tmp_path / "below").mkdir()
        self.scenario(tmp_path / "below", "t,x,y\n0,0,0\n5,5,0\n")
        (tmp_path / "top.toml").write_text('extends = "below/mine.toml"\n', encoding="utf-8")
        assert read(tmp_path / "top.toml").shape.end == 5.0


def test_the_paper_itself_has_no_file():
    assert read(find("paper")).folders == (find("paper").parent,)
