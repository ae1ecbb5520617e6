"""`fuzzyctl sweep`: what it prints, its exit codes, a SPEC with mistakes."""

import csv
import itertools
import json
import math

import pytest

from tests.commands import runner
from tests.fuzzyctl.cli.test_simulate import FAMILY
from tests.shipped import SYSTEMS

SPEC = """
scenario = "water_tank.fz"
runs = 2
seed = 1
measures = ["iae", "settling"]
[grid]
"law.GU" = [4.0, 8.0]
"""

run = runner("sweep")


@pytest.fixture
def spec(tmp_path):
    tank = (SYSTEMS[0].parent / "loops" / "water_tank.fz").read_text(encoding="utf-8")
    (tmp_path / "water_tank.fz").write_text(tank.replace("run 60 s step 10 ms", "run 60 s"), encoding="utf-8")

    def write(text=SPEC):
        path = tmp_path / "spec.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_it_prints_a_table_with_means_over_the_repetitions(spec, tmp_path):
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


def test_it_prints_json(spec, tmp_path):
    found = run(spec(SPEC.replace("[4.0, 8.0]", "[4.0]")), "-o", tmp_path / "out", "--jobs", 1, "--format", "json")
    data = json.loads(found.output)
    assert (data["runs"], data["stopped"], data["files"]) == (2, 0, ["results.csv", "sweep.json", "times.csv"])


@pytest.mark.parametrize(
    ("text", "arguments", "code", "words"),
    [
        (SPEC.replace("law.GU", "law.GX"), [], 1, "spec.toml:7:1: error[FZ902]: run 0: unknown param law.GX"),
        (None, ["none.toml"], 2, "there is no such file"),
        (SPEC, ["--set", "GU"], 2, "expected key=value"),
        ('scenario = "water_tank.fz"\n', ["--set", "law.GU=3", "--set", "GU=4"], 2, "law.GU is given"),
        (SPEC, ["--jobs", "2", "--dask", "local:2"], 2, "give one of them"),
        (SPEC.replace("runs", 'against = ["water_tank.fz"]\nruns'), [], 2, "name the file once"),
        (SPEC.replace("runs", 'against = ["copy/water_tank.fz"]\nruns'), [], 2, "rename a loop or a file"),
    ],
)
def test_mistakes_are_reported_before_the_first_run(spec, tmp_path, text, arguments, code, words):
    path = [spec(text)] if text else []
    (tmp_path / "copy").mkdir()
    (tmp_path / "copy" / "water_tank.fz").write_bytes((tmp_path / "water_tank.fz").read_bytes())
    found = run(*path, *arguments, "-o", tmp_path / "out")
    assert (found.exit_code, words in found.output) == (code, True), found.output
    assert not (tmp_path / "out").exists()


@pytest.fixture
def family(tmp_path):
    path = tmp_path / "family.fz"
    path.write_text(FAMILY + "measure least = minimum(p.y)\nrequire least >= 0.1\n", encoding="utf-8")
    return path


def test_members_of_a_family_are_run_and_the_worst_are_named(family, tmp_path):
    found = run(family, "--for", 12, "-o", tmp_path / "out", "--jobs", 1)
    assert found.exit_code == 0, found.output
    lines = found.output.splitlines()
    assert lines[0] == "12 runs, all to the end"
    assert lines[-5] == "worst final: 1 m  run 7: --set p.x=1.0 --set p.K=2.0 --set w=0.5"
    assert lines[-3] == "worst least: 0  run 0: --set p.x=0.0 --set p.K=1.0 --set w=0.0"
    assert [line.partition(":")[0] for line in lines[-2:]] == ["require least >= 0.1", "require always p.x <= 0.9"]
    rows = (tmp_path / "out" / "results.csv").read_text().splitlines()
    assert rows[0].startswith("run,scenario,controller,repetition,p.x,p.K,w,t_end,")
    assert len(rows) == 13
    data = json.loads(run(family, "--for", 9, "-o", tmp_path / "two", "--jobs", 1, "--format", "json").output)
    assert data["worst"][0] | {"value": 0} == {
        "loop": "small", "measure": "final", "value": 0, "run": 7, "replay": "--set p.x=1.0 --set p.K=2.0 --set w=0.5",
    }  # fmt: skip


def test_a_stopped_member_breaks_no_claim(tmp_path):
    path = tmp_path / "blow.fz"
    path.write_text(
        "plant p\nstate x = 1\nder x = x * x\noutput y = x\nloop blow\nblock p = p()\nfor p.x in [0.1, 1]\n"
        "run 3 s step 10 ms\nrequire always p.x >= 0\n",
        encoding="utf-8",
    )
    result = run(path, "--for", 2, "-o", tmp_path / "out", "--jobs", 1)
    assert "stopped: 1 of 2, first by run 1: --set p.x=1.0" in result.output
    assert "broken" not in result.output


def test_a_spec_may_vary_more_than_the_family(family, tmp_path):
    spec = tmp_path / "spec.toml"
    spec.write_text('scenario = "family.fz"\nmembers = 3\nseed = 2\n[grid]\n"law.K" = [0.5, 1.0]\n', encoding="utf-8")
    found = run(spec, "-o", tmp_path / "out", "--jobs", 1)
    assert found.output.splitlines()[0] == "6 runs, all to the end"
    assert "--set p.x=" in found.output.splitlines()[-1]
    assert "--set law.K=" in found.output.splitlines()[-1]
    twice = run(spec, "--for", 2, "--set", "p.x=0.5", "-o", tmp_path / "two", "--jobs", 1)
    assert twice.exit_code != 0
    assert "p.x is given twice" in twice.output


def test_a_sweep_of_members_needs_a_family(spec, tmp_path):
    found = run(spec(), "--for", 2, "-o", tmp_path / "out")
    assert found.exit_code == 1
    assert "no loop has a family to draw from" in found.output


def members_of(path, tmp_path, count, *arguments):
    """Return the values of some columns of the members that a sweep runs, by name."""
    out = tmp_path / f"out{count}"
    found = run(path, "--for", count, "-o", out, "--jobs", 1, *arguments)
    assert found.exit_code == 0, found.output
    names, *rows = csv.reader((out / "results.csv").read_text().splitlines())
    return {name: [float(row[names.index(name)]) for row in rows] for name in ("p.x", "p.K", "w")}


def test_corners_come_before_a_latin_hypercube(family, tmp_path):
    columns = members_of(family, tmp_path, 16)
    assert list(zip(*(c[:8] for c in columns.values()), strict=True)) == [
        *itertools.product((0.0, 1.0), (1.0, 2.0), (0.0, 0.5))
    ]
    assert sorted(int(8 * x) for x in columns["p.x"][8:]) == list(range(8))  # one in each eighth of the range
    assert not {*members_of(family, tmp_path, 7)["p.x"]} & {0.0, 1.0}  # fewer than there are corners


def test_ends_outside_of_a_range_are_missed_by_a_hair(family, tmp_path):
    text = FAMILY.replace("p.K in [1, 2]", "p.K in (1, 2)").replace("w in [0, 0.5]", "w in [0, p_most]")
    family.write_text(text.replace("block law", "param p_most = 0.25\nblock law"), encoding="utf-8")
    columns = members_of(family, tmp_path, 8, "--set", "p_most=0.125")
    assert {*columns["p.K"]} == {math.nextafter(1.0, 2.0), math.nextafter(2.0, 1.0)}
    assert {*columns["w"]} == {0.0, 0.125}
