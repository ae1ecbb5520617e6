import shutil

import pytest

from fuzzyctl.cli import check as module
from fuzzyctl.support.shipped import rules_folder
from tests.commands import runner

run = runner("check", "--watch")


@pytest.fixture
def path(tmp_path):
    return shutil.copy(rules_folder() / "tipper.fz", tmp_path / "tip.fz")


@pytest.fixture
def saves(monkeypatch):
    """Give a function that says what happens while the command waits, one step after the other, then Ctrl-C."""

    def happen(*steps):
        rest = iter(steps)

        def wait(_seconds):
            step = next(rest, None)
            if step is None:
                raise KeyboardInterrupt
            step()

        monkeypatch.setattr(module.time, "sleep", wait)

    return happen


def test_each_save_is_checked_evaluated_and_drawn(path, saves, tmp_path):
    picture = tmp_path / "tip.png"
    text = path.read_text()
    sizes = []

    def break_it():
        sizes.append(picture.stat().st_size)
        path.write_text(text.replace("excellent", "excelent", 1))

    def mend_it():
        assert picture.stat().st_size == sizes[0]
        path.write_text(text.replace("[0, 30]", "[0, 40]"))

    saves(lambda: None, break_it, lambda: None, mend_it)
    result = run(path, "service=7", "food=8", "-o", picture)
    assert result.exit_code == 0
    assert result.stdout.count("tip = ") == 2
    assert result.stdout.count("tip.fz: tipper: 3 rules, no errors") == 2
    assert result.stderr.count("has no term") == 1


def test_a_file_that_it_uses_counts(saves, tmp_path):
    used, path = tmp_path / "shared.fz", tmp_path / "a.fz"
    used.write_text("input x in [0, 1]\n  terms N P\n")
    path.write_text('system t\nuse "shared.fz"\noutput y in [0, 1] else 0\n  terms a b\nif x is N then y is a\n')
    saves(lambda: used.write_text("input x in [0, 2]\n  terms N P Q\n"), lambda: None)
    assert run(path).stdout.count("t: 1 rule, no errors") == 2


def test_a_file_that_vanishes_and_comes_back(path, saves):
    text = path.read_text()
    saves(path.unlink, lambda: path.write_text(text))
    result = run(path)
    assert result.exit_code == 0
    assert result.stdout.count("no errors") == 2
    assert "tip.fz" in result.stderr


def test_loops_are_run(saves, tmp_path):
    path = shutil.copy(rules_folder() / "loops" / "water_tank.fz", tmp_path / "tank.fz")
    saves()
    result = run(path, "--block", "fill", "-o", tmp_path / "out")
    assert "overshoot" in result.stdout
    assert (tmp_path / "out" / "summary.json").is_file()


def test_wrong_usage(saves, path, tmp_path):
    assert run(tmp_path / "none.fz").exit_code == 1
    saves()
    tank = rules_folder() / "loops" / "water_tank.fz"
    assert run(tank, "service=1", "--block", "fill").exit_code == 2


def test_a_guarantee_that_does_not_hold_stops_no_picture(path, saves, tmp_path):
    picture = tmp_path / "tip.png"
    path.write_text(path.read_text().replace("bounded(tip, 0, 30)", "bounded(tip, 0, 20)"))
    saves(lambda: None)
    result = run(path, "service=7", "food=8", "-o", picture)
    assert "tip = 20.3" in result.stdout
    assert result.stderr.count("the guarantee 'bounded(tip, 0, 20)' does not hold") == 1
    assert picture.is_file()
