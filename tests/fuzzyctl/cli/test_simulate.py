"""Files that `fuzzyctl simulate` writes; transcripts/simulate.txt holds what it prints."""

import json
import re

import numpy as np
import pytest

from tests.commands import runner

SMALL = """
controller law
input r
input y
param K in (0, 10] = 1
output u "valve" unit "V" = K * (r - y)
every 0.1 s

plant p
input u
param K = 2
param T = 1
state x in [-5, 5] unit "m" = 0
der x = (K * u - x) / T
output y "level" unit "m" = x

loop small "A step"
block law = law(r, p.y)
block p = p(law.u)
let r = steps(0: 1)
measure final "at the end" unit "m" = final(p.y)
measure iae = iae(p.y, r)
run 5 s
require final <= 1
"""

run = runner("simulate")


@pytest.fixture
def small(tmp_path):
    path = tmp_path / "small.fz"
    path.write_text(SMALL, encoding="utf-8")
    return path


def test_summary_data_and_picture_are_those_of_the_run(small, tmp_path):
    out = tmp_path / "new" / "out"
    run(small, "-o", out)
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    assert summary["measures"]["final"] == pytest.approx(2 / 3, rel=1e-4)
    table = np.genfromtxt(out / "data.csv", delimiter=",", names=True, deletechars="")
    assert table.dtype.names == ("t", "r", "law.r", "law.y", "law.u", "p.u", "p.x", "p.y")
    assert table["p.y"][-1] == summary["measures"]["final"]
    assert (out / "loop.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("form", ["npz", "parquet"])
def test_data_has_other_formats(small, tmp_path, form):
    out = tmp_path / "out"
    run(small, "-o", out, "--data", form, "--picture", "svg")
    if form == "npz":
        found = np.load(out / "data.npz")["p.y"]
    else:
        from pyarrow import parquet

        found = parquet.read_table(out / "data.parquet").column("p.y").to_numpy()
    assert len(found) == 51
    assert (out / "loop.svg").read_text("utf-8").startswith("<?xml")


def test_files_of_an_earlier_run_go_and_the_same_run_gives_the_same_bytes(small, tmp_path):
    for name in ("a", "b"):
        run(small, "-o", tmp_path / name, "--picture", "svg")
    run(small, "-o", tmp_path / "a", "--data", "npz")
    (tmp_path / "a" / "notes.txt").write_text("mine")
    run(small, "-o", tmp_path / "a", "--picture", "svg")
    assert sorted(p.name for p in (tmp_path / "a").iterdir()) == ["data.csv", "loop.svg", "notes.txt", "summary.json"]
    for path in (tmp_path / "b").iterdir():
        assert path.read_bytes() == (tmp_path / "a" / path.name).read_bytes()


def test_the_data_up_to_a_stop_is_kept(small, tmp_path):
    run(small, "--set", "p.K=10", "--set", "p.T=0.1", "--set", "law.K=10", "-o", tmp_path / "out")
    rows = (tmp_path / "out" / "data.csv").read_text("utf-8").splitlines()
    summary = json.loads((tmp_path / "out" / "summary.json").read_text("utf-8"))
    assert len(rows) - 1 == summary["samples"] < 51
    assert summary["stopped"]["code"] == "FZ701"


def test_a_file_in_the_place_of_the_folder_of_one_of_several_runs_is_a_mistake(small, tmp_path):
    other, out = tmp_path / "other.fz", tmp_path / "out"
    other.write_text(SMALL.replace("loop small", "loop other"), encoding="utf-8")
    out.mkdir()
    (out / "small").write_text("")
    result = run(small, "--against", other, "-o", out)
    assert (result.exit_code, "small cannot be written: it is a file" in result.output) == (1, True)
    assert [p.name for p in out.iterdir()] == ["small"]


def test_a_table_of_runs_that_is_wider_than_the_terminal_is_printed_in_parts(small, tmp_path, monkeypatch):
    monkeypatch.setattr("fuzzyctl.cli.simulate.terminal_width", lambda stream: 45)
    labels = ["first", "second", "third", "fourth"]
    blocks, _, loop = SMALL.partition("loop small")
    small.write_text(blocks + "".join(f"\nloop {name}{loop}" for name in labels), encoding="utf-8")
    lines = run(small).output.split("\n")
    heads = [line.split() for line in lines if line.startswith("measure")]
    assert heads == [["measure", "first", "second"], ["measure", "third", "fourth"]]
    assert max(len(line) for line in lines if line.startswith(("measure", "final"))) <= 45


FAMILY = SMALL.replace(
    "run 5 s", "for p.x in [0, 1]\nfor p.K in [1, 2]\ndisturbance w in [0, 0.5] = 0\nrequire always p.x <= 0.9\nrun 5 s"
).replace("p(law.u)", "p(law.u + w)")


@pytest.fixture
def family(tmp_path):
    path = tmp_path / "family.fz"
    path.write_text(FAMILY, encoding="utf-8")
    return path


def test_corners_that_break_a_claim_are_replayed_by_their_line(family):
    found = run(family, "--corners")
    assert found.exit_code == 1
    kept, blank, head, first = found.output.splitlines()[-4:]
    assert kept == "require always p.x <= 0.9: kept by this run"
    assert blank == ""
    assert head == "8 corners of p.x, p.K, w"
    line, facts = "--set p.x=0.0 --set p.K=2.0 --set w=0.5", "(at t = 0.7 s, p.x = 0.904924)"
    assert first == f"require always p.x <= 0.9: broken by 5 of 8, first by {line}  {facts}"
    again = run(family, *line.split())
    assert f"require always p.x <= 0.9: broken  {facts}" in again.output
    assert again.exit_code == 1
    data = json.loads(run(family, "--corners", "--set", "law.K=2", "--format", "json").output)["runs"][0]["corners"]
    assert (data["members"], data["drawn"]) == (8, False)
    assert data["broken"][0]["replay"].startswith("--set law.K=2 --set p.x=")


def test_corners_that_break_no_claim(family):
    family.write_text(FAMILY.replace("p.x <= 0.9", "p.x <= 1"), encoding="utf-8")
    found = run(family, "--corners")
    assert found.output.splitlines()[-1] == "8 corners of p.x, p.K, w: no claim is broken"
    assert found.exit_code == 0


@pytest.mark.parametrize(
    ("arguments", "words"), [((), "no loop has a family"), (("--solver", "Radau"), "the solver RK4")]
)
def test_corners_need_a_family_and_rk4(small, arguments, words):
    found = run(small, "--corners", *arguments)
    assert found.exit_code == 2
    assert words in found.output


def test_too_many_corners_are_drawn_and_stopped_members_named(family):
    lines = "\n".join(f"disturbance d{k} in [0, 9] = 0" for k in range(6))
    family.write_text(FAMILY.replace("for p.x", f"{lines}\nfor p.x").replace("u + w", "u + w + d0"), encoding="utf-8")
    found = run(family, "--corners")
    assert "256 members, a Latin hypercube, since there are too many corners, of p.x, p.K, d0" in found.output
    assert re.search(r"\nstopped: \d+ of 256, first by --set p.x=.*left its range", found.output)
