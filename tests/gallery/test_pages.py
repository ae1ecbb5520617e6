"""Every loop of the gallery: it is clean, meets what its page derives, and the page says what comes out."""

import re
import runpy
from decimal import Decimal
from functools import cache

import pytest

from fuzzyctl.simulation.simulate import simulate, warnings
from fuzzyctl.testing import run_command
from gallery import pages
from tests.e2e.pages import follow, without_code
from tests.e2e.pictures import blocks_of

ENTRIES = pages.entries()
#: Numbers below this one are rounding errors, which differ from machine to machine.
ROUNDING = Decimal("1e-11")


@cache
def runs(name):
    return [simulate(loop) for loop in pages.loops_of(ENTRIES[name])]


def text(name):
    return (ENTRIES[name] / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ENTRIES)
class TestEveryEntry:
    def test_its_file_is_clean_and_laid_out(self, name):
        path = ENTRIES[name] / f"{name}.fz"
        found = run_command("check", path)
        assert (found.exit_code, "warning[" in found.errors) == (0, False), found.errors
        assert run_command("fmt", "--check", path).exit_code == 0

    def test_it_names_its_source(self, name):
        assert all(loop.citation for loop in pages.loops_of(ENTRIES[name]))

    def test_its_runs_are_accurate_and_meet_what_is_required(self, name):
        for run in runs(name):
            assert run.stopped is None
            assert warnings(run) == []
            assert [r for r in run.requirements if not r.holds] == []

    def test_its_page_says_what_comes_out(self, name):
        (written,) = pages.BLOCK.findall(text(name))
        assert same(written, pages.table_of(runs(name)))

    def test_its_examples_do_what_the_page_says(self, name, tmp_path, monkeypatch):
        for path in ENTRIES[name].glob("*.fz"):
            (tmp_path / path.name).write_bytes(path.read_bytes())
        monkeypatch.chdir(tmp_path)
        follow(ENTRIES[name] / "README.md", tmp_path)

    def test_its_picture_is_small_and_shown(self, name):
        assert (ENTRIES[name] / f"{name}.png").stat().st_size < 40_000
        assert f"]({name}.png)" in without_code(ENTRIES[name] / "README.md")
        assert f"]({name}/README.md)" in (pages.HERE / "README.md").read_text(encoding="utf-8")

    @pytest.mark.long
    def test_its_picture_is_what_is_drawn(self, name, tmp_path):
        drawn = tmp_path / "drawn.png"
        pages.draw(drawn, runs(name), text(name))
        stored, now = blocks_of(ENTRIES[name] / f"{name}.png"), blocks_of(drawn)
        assert stored.shape == now.shape
        assert abs(stored - now).mean() < 0.005


def same(first, second):
    """Return whether two tables agree: words exactly, numbers but for their last digit, rounding errors at all."""
    number = r"-?\d+\.?\d*(?:e[-+]\d+)?"
    if re.sub(number, "0", first) != re.sub(number, "0", second):
        return False
    pairs = [(Decimal(a), Decimal(b)) for a, b in zip(*(re.findall(number, t) for t in (first, second)), strict=True)]
    return all(abs(a - b) <= max(2 * Decimal(10) ** a.as_tuple().exponent, ROUNDING) for a, b in pairs)


def test_tables_are_compared():
    assert same("| iae | 1.234 (1.2 ± 0.1) |", "| iae | 1.235 (1.2 ± 0.1) |")
    assert not same("| iae | 1.234 (1.2 ± 0.1) |", "| iae | 1.244 (1.2 ± 0.1) |")
    assert not same("| iae | 1.234 |", "| ise | 1.234 |")
    assert same("| error | 2.2e-16 |", "| error | 1e-15 |")
    assert not same("| error | 2.2e-16 |", "| error | 1e-7 |")
    assert not same("| end | 0.7853981639 |", "| end | 0.7853981659 |")


class TestCommand:
    def test_an_unknown_page_is_a_mistake_of_usage(self, monkeypatch, capsys):
        monkeypatch.setattr("sys.argv", ["gallery", "upa_moter"])
        with pytest.raises(SystemExit) as ended:
            runpy.run_module("gallery", run_name="__main__")
        assert ended.value.code == 2
        assert "no such page: upa_moter; there are arch_attitude" in capsys.readouterr().err

    def test_a_page_with_a_mistake_is_reported_and_kept(self, monkeypatch, capsys, tmp_path):
        folder = tmp_path / "own"
        folder.mkdir()
        (folder / "own.fz").write_text("loop own\nblock a = b(1)\nrun 1 s\n", encoding="utf-8")
        (folder / "README.md").write_text("# Own\n", encoding="utf-8")
        monkeypatch.setattr(pages, "HERE", tmp_path)
        monkeypatch.setattr("sys.argv", ["gallery", "own"])
        with pytest.raises(SystemExit) as ended:
            runpy.run_module("gallery", run_name="__main__")
        assert ended.value.code == 1
        assert "own.fz:2:11: error[" in capsys.readouterr().err
        assert (folder / "README.md").read_text(encoding="utf-8") == "# Own\n"
