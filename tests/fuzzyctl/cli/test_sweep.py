"""`fuzzyctl sweep`: what it prints, its exit codes, a SPEC with mistakes."""

import json

import pytest

from fuzzyctl.experiments import sweep_workers
from fuzzyctl.experiments.sweep_workers import work
from fuzzyctl.support.shipped import rules_folder
from tests.commands import runner

SPEC = """
scenario = "water_tank.fz"
runs = 2
seed = 1
measures = ["iae", "settling"]
[grid]
"law.GU" = [4.0, 8.0]
"""

run = runner("sweep")


@pytest.fixture(autouse=True)
def here(monkeypatch):
    """Compute in this process."""
    monkeypatch.setattr(sweep_workers, "compute", lambda setup, runs, jobs: (work(setup, one) for one in runs))


@pytest.fixture
def spec(tmp_path):
    tank = (rules_folder() / "loops" / "water_tank.fz").read_text(encoding="utf-8")
    (tmp_path / "water_tank.fz").write_text(tank.replace("run 60 s step 10 ms", "run 60 s"), encoding="utf-8")

    def write(text=SPEC):
        path = tmp_path / "spec.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_prints_a_table_with_means_over_the_repetitions(spec, tmp_path):
    found = run(spec(), "-o", tmp_path / "out", "--jobs", 1)
    assert found.exit_code == 0, found.output
    lines = found.output.splitlines()
    assert lines[0] == "4 runs, all to the end"
    assert lines[3].split() == ["loop", "law.GU", "iae", "settling", "met"]
    assert lines[4].split() == ["m", "s", "s", "%"]
    assert [line.split()[:2] for line in lines[5:7]] == [["fill", "4"], ["fill", "8"]]
    assert all("±" in line for line in lines[5:7])
    again = run(spec(), "-o", tmp_path / "out", "--resume")
    assert again.exit_code == 1
    assert "belongs to a sweep that is finished" in again.output


def test_prints_json(spec, tmp_path):
    found = run(spec(SPEC.replace("[4.0, 8.0]", "[4.0]")), "-o", tmp_path / "out", "--jobs", 1, "--format", "json")
    data = json.loads(found.output)
    assert (data["runs"], data["stopped"], data["files"]) == (2, 0, ["results.csv", "sweep.json", "times.csv"])


def test_a_mistake_in_the_spec_is_a_diagnostic(spec, tmp_path):
    found = run(spec(SPEC.replace("law.GU", "law.GX")), "-o", tmp_path / "out")
    assert found.exit_code == 1
    assert "spec.toml:7:1: error[FZ902]: run 0: unknown param law.GX" in found.output
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.toml"], "there is no such file"),
        (["--set", "GU"], "expected key=value"),
        (["--set", "law.GU=3", "--set", "GU=4"], "law.GU is given"),
        (["--jobs", "2", "--dask", "local:2"], "give one of them"),
    ],
)
def test_wrong_usage_exits_with_2(spec, arguments, words):
    text = 'scenario = "water_tank.fz"\n'
    given = arguments if arguments[0].endswith(".toml") else [spec(text), *arguments]
    found = run(*given)
    assert found.exit_code == 2, found.output
    assert words in found.output


@pytest.mark.parametrize(
    ("other", "repair"), [("water_tank.fz", "name the file once"), ("copy/water_tank.fz", "rename a loop or a file")]
)
def test_loops_of_the_same_name_in_files_of_the_same_name_are_reported(spec, tmp_path, other, repair):
    path = spec(SPEC.replace("runs = 2", f'runs = 2\nagainst = ["{other}"]'))
    (tmp_path / "copy").mkdir()
    (tmp_path / "copy" / "water_tank.fz").write_bytes((tmp_path / "water_tank.fz").read_bytes())
    found = run(path, "-o", tmp_path / "out", "--jobs", 1)
    assert found.exit_code == 2
    assert "loop 'fill' is there 2 times" in found.output
    assert repair in found.output
    assert not (tmp_path / "out").exists()
