"""CSV files of a reference path: what is read, and each mistake at its line and column."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from dwmr import read
from tests.dwmr.scenarios import mistakes

#: Texts of CSV files, the place of the only mistake, and words of its message.
MISTAKES = [
    ("t,x,y\n0,0,0\n1,nan,0\n", ":3:3", "column x: nan is not a finite number"),
    ("t,x,y\n0,0,0\n1,0,-inf\n", ":3:5", "column y: -inf is not a finite number"),
    ("t,x,y\n0,0,0\n1,2e9,0\n", ":3:3", "column x: 2e9 is beyond 1e+09"),
    ("t,x,y\n0,0,zero\n", ":2:5", "column y: zero is not a number"),
    ("t,x,y\n0,1_0,0\n", ":2:3", "column x: 1_0 is not a number"),
    ("t,x,y\n0,,0\n", ":2:3", "column x is empty"),
    ("x,t,y\n0,1,0\n1,1,0\n", ":3:3", "1 comes after 1; times must increase"),
    ("t,x,y\n0,0,0\n5,1,0\n4,2,0\n", ":4:1", "4 comes after 5; times must increase"),
    ("t,x,y\n0,0,0\n1,1\n", ":3:1", "the row has 2 cells for 3 columns"),
    ("0,0,0\n1,1,1\n", ":1:1", "the first line names no column t, x, y"),
    ("t,x,x,y\n0,0,0,0\n", ":1:1", "names column x twice"),
    ("t,x,y\n0,0,0\n", "", "has 1 row; a path needs at least 2"),
    ("t,x,y\n", "", "has 0 rows"),
    ("\n# nothing\n", "", "is empty"),
    ("t,x,y\n0,0,0\n5,5,0\n9,5,0\n12,8,0\n", ":3:1", "stands still: its speed is "),
    ("t,x,y\n" + "#" * 4_194_304, "", "at most 4,194,304 are read"),
]


class TestScenario:
    def scenario(self, folder, rows, more=""):
        (folder / "way.csv").write_text(rows, encoding="utf-8")
        path = folder / "mine.toml"
        path.write_text(
            f'extends = "paper"\nreference = {{ kind = "csv", file = "way.csv"{more} }}\n', encoding="utf-8"
        )
        return path

    @pytest.mark.parametrize(("text", "place", "words"), MISTAKES)
    def test_names_file_line_and_column_of_a_mistake(self, tmp_path, text, place, words):
        (one,) = mistakes(self.scenario(tmp_path, text))
        assert one.place.endswith(f"way.csv{place}") or not place
        assert words in one.message

    def test_gives_all_mistakes_up_to_a_number(self, tmp_path):
        assert len(mistakes(self.scenario(tmp_path, "t,x,y\n0,a,b\n1,2\n"))) == 3
        assert len(mistakes(self.scenario(tmp_path, "t,x,y\n" + "0,a,0\n" * 1000))) == 20

    def test_takes_columns_in_any_order_and_passes_over_the_rest(self, tmp_path):
        text = "\ufeff# a way\r\ny, t ,note,x\r\n2,0,a,1\r\n\r\n# on\r\n4,5.5,,-3e0\r\n"
        shape = read(self.scenario(tmp_path, text)).shape
        assert [(shape.at(t).x, shape.at(t).y) for t in (0.0, 5.5)] == [pytest.approx(p) for p in ((1, 2), (-3, 4))]

    def test_that_is_no_text_is_refused(self, tmp_path):
        path = self.scenario(tmp_path, "")
        (tmp_path / "way.csv").write_bytes(b"t,x,y\n\xff")
        assert mistakes(path)[0].code == "FZ002"

    @given(st.integers(0, 10_000), st.integers(4, 40), st.booleans())
    def test_goes_along_the_spline_of_scipy(self, tmp_path_factory, seed, n, closed):
        rng = np.random.default_rng(seed)
        t, points = np.cumsum(rng.uniform(0.1, 2.0, n)), rng.normal(size=(n, 2))
        if closed:
            points[-1] = points[0]
        rows = "".join(f"{a!r},{x!r},{y!r}\n" for a, (x, y) in zip(t.tolist(), points.tolist(), strict=True))
        path = self.scenario(tmp_path_factory.mktemp("path"), f"t,x,y\n{rows}", ", closed = true" if closed else "")
        shape = read(path).shape
        wanted = CubicSpline(t, points, bc_type="periodic" if closed else "natural")
        for one in np.linspace(t[0], t[-1], 50)[:-1]:
            there, speed = shape.at(one), wanted(one, 1)
            assert (there.x, there.y) == pytest.approx(tuple(wanted(one)), rel=1e-6, abs=1e-6)
            assert there.v == pytest.approx(np.hypot(*speed), rel=1e-6, abs=1e-6)

    def test_goes_on_straight_before_and_after_its_rows(self, tmp_path):
        shape = read(self.scenario(tmp_path, "t,x,y\n1,0,0\n4,2,1\n6,3,-1\n9,7,0\n")).shape
        before, first = shape.at(0.0), shape.at(1.0)
        assert (before.theta, before.v) == pytest.approx((first.theta, first.v))
        assert shape.at(11.0).x - shape.at(10.0).x == pytest.approx(shape.at(9.0).v * np.cos(shape.at(9.0).theta))

    def test_may_come_back_to_its_first_row(self, tmp_path):
        rows = "t,x,y\n0,0,0\n4,2,1\n6,3,-1\n9,0,0\n"
        shape = read(self.scenario(tmp_path, rows, ", closed = true")).shape
        assert shape.at(9.0 + 3.3) == pytest.approx(shape.at(3.3))
        (one,) = mistakes(self.scenario(tmp_path, rows.replace("9,0,0", "9,0,1"), ", closed = true"))
        assert "begins at (0, 0) and ends at (0, 1)" in one.message

    def test_is_part_of_the_checksum(self, tmp_path):
        first = read(self.scenario(tmp_path, "t,x,y\n0,0,0\n5,5,0\n")).sha256
        assert read(self.scenario(tmp_path, "t,x,y\n0,0,0\n5,5,1\n")).sha256 != first

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
