"""`fuzzyctl sweep`: what varies, what comes out, interruptions, files that change, mistakes in SPEC and files."""

import csv
import json
import math
import os
import pickle
import zipfile
from types import SimpleNamespace

import pyarrow.parquet
import pytest

import fuzzyctl
from fuzzyctl.experiments import sweep_workers
from fuzzyctl.testing import run_command
from tests.fuzzyctl.codegen.fmu.fmus import changed, write_fmu

FILE = """
controller law
input r
input y
param K in (0, 20] = 1
output u "valve" unit "V" = K * (r - y)
every 0.1 s

plant p
input u
param T in (0, inf) = 1 unit "s"
param begin = 0
state x in [-5, 5] unit "m" = begin
der x = (2 * u - x) / T
output y "level" unit "m" = x

loop small
param height = 1 unit "m"
block law = law(r, p.y + noise(sigma=0.01, seed=1))
block p = p(law.u)
let r = height * steps(0: 1)
measure end_value unit "m" = final(p.y)
measure error unit "m s" = iae(p.y, r)
run 2 s
require error <= 1.2
"""
SPEC = """
scenario = "small.fz"
runs = 3
seed = 2
[grid]
"law.K" = [1.0, 2.0]
[random]
"p.T" = { uniform = [0.8, 1.2], relative = "factor" }
"p.begin" = { normal = [0.0, 0.1] }
"""

PLANT = "plant p\ninput u\nparam T = 1\nstate x = 0\nder x = (u - x) / T\noutput y = x\n"
WORKERS = sweep_workers.compute


@pytest.fixture(autouse=True)
def here(monkeypatch):
    """Compute in this process; `here.left` is the number of runs after which `here.error` comes."""
    own = SimpleNamespace(left=math.inf, error=KeyboardInterrupt, computed=0)

    def compute(setup, runs, jobs):
        for one in runs:
            if own.left == 0:
                raise own.error
            own.left -= 1
            own.computed += 1
            yield sweep_workers.work(setup, one)

    monkeypatch.setattr(sweep_workers, "compute", compute)
    return own


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "small.fz").write_text(FILE, encoding="utf-8")
    return tmp_path


def sweep(folder, text, *options):
    """Run the command and return its result."""
    (folder / "spec.toml").write_text(text, encoding="utf-8")
    given = (folder / "spec.toml", "-o", folder / "out", "--format", "json", *(options or ("--jobs", 1)))
    return run_command("sweep", *given)


def swept(folder, text=SPEC, *options):
    """Return the rows of a sweep, one for each run."""
    for old in ("results.csv", "results.parquet", "sweep.json", "times.csv"):
        (folder / "out" / old).unlink(missing_ok=True)
    found = sweep(folder, text, *options)
    assert found.exit_code == 0, f"{found.output}{found.errors}"
    with (folder / "out" / "results.csv").open(newline="", encoding="utf-8") as source:
        return list(csv.DictReader(source))


def mistakes(folder, text=SPEC, *options):
    found = sweep(folder, text, *options)
    assert found.exit_code in (1, 2)
    return json.loads(found.output)["diagnostics"]


def interrupted(folder, here, after, text=SPEC, words=""):
    """Interrupt a sweep after some runs, and return its journal."""
    here.left = after
    found = sweep(folder, text)
    here.left = math.inf
    assert found.exit_code != 0
    assert (words or f"{after} of ") in f"{found.output}{found.errors}"
    return folder / "out" / "journal.jsonl"


class TestRuns:
    def test_are_those_of_simulate_with_the_same_values(self, folder):
        rows = swept(folder)
        assert [(row["law.K"], row["repetition"]) for row in rows] == [(k, r) for k in ("1.0", "2.0") for r in "012"]
        loop = fuzzyctl.load(folder / "small.fz", block=fuzzyctl.Loop)
        row = rows[4]
        found = fuzzyctl.Experiment(loop, free=["law.K", "p.T"]).run(
            [float(row["law.K"]), float(row["p.T"])], seed=int(row["noise.seed"])
        )
        free = swept(folder, SPEC.replace('"p.begin" = { normal = [0.0, 0.1] }', ""))[4]
        assert float(free["error"]) == pytest.approx(found.measures["error"], rel=1e-13)
        assert free["require error <= 1.2"] == str(found.passed).lower()
        for name in ("p.T", "p.begin", "noise.seed"):
            assert [r[name] for r in rows[:3]] == [r[name] for r in rows[3:]]
            assert len({r[name] for r in rows}) == 3

    def test_one_run_has_the_noise_of_the_file(self, folder):
        (row,) = swept(folder, 'scenario = "small.fz"\n')
        found = fuzzyctl.simulate(fuzzyctl.load(folder / "small.fz", block=fuzzyctl.Loop), backend="numba")
        assert float(row["error"]) == found.measures["error"]
        (other,) = swept(folder, 'scenario = "small.fz"\n[set]\n"noise.seed" = 7\n')
        assert other["error"] != row["error"]

    def test_files_name_units_and_sources_and_hold_the_same_numbers(self, folder):
        rows = swept(folder, SPEC, "--data", "csv,parquet")
        about = json.loads((folder / "out" / "sweep.json").read_text(encoding="utf-8"))
        columns = {name: one["unit"] for name, one in about["columns"].items() if one["unit"]}
        assert columns == {"p.T": "s", "t_end": "s", "end_value": "m", "error": "m s"}
        assert about["scenario"]["text"][0] == {"file": "small.fz", "text": FILE}
        table = pyarrow.parquet.read_table(folder / "out" / "results.parquet")
        assert table["error"].to_pylist() == [float(row["error"]) for row in rows]

    def test_a_run_that_leaves_its_range_is_a_row_with_its_reason(self, folder):
        rows = swept(folder, 'scenario = "small.fz"\n[grid]\nheight = [1.0, 9.0]\n')
        assert [row["stopped"] for row in rows] == ["false", "true"]
        assert rows[1]["stop_reason"] == "state 'p.x' left its range"
        assert rows[1]["error"] == ""
        assert rows[1]["require error <= 1.2"] == "false"
        assert 0.0 < float(rows[1]["t_end"]) < 2.0

    def test_loops_of_further_files_are_run_side_by_side(self, folder):
        (folder / "other.fz").write_text(FILE.replace("K * (r - y)", "2 * K * (r - y)"), encoding="utf-8")
        rows = swept(folder, 'scenario = "small.fz"\nagainst = ["other.fz"]\n[grid]\nK = [1.0, 2.0]\n')
        assert [row["controller"] for row in rows] == ["small.small", "other.small"] * 2
        assert rows[1]["error"] == rows[2]["error"]
        (row,) = swept(folder, 'scenario = "small.fz"\nagainst = ["other.fz"]\ncontrollers = ["other.small"]\n')
        assert row["error"] == rows[1]["error"]

    def test_processes_and_a_cluster_give_the_same_bytes(self, folder, monkeypatch):
        swept(folder)
        first = (folder / "out" / "results.csv").read_bytes()
        monkeypatch.setattr(sweep_workers, "compute", WORKERS)
        swept(folder, SPEC, "--jobs", 2)
        assert (folder / "out" / "results.csv").read_bytes() == first
        pytest.importorskip("distributed")
        (folder / "out" / "results.csv").unlink()
        (folder / "out" / "times.csv").unlink()
        (folder / "out" / "sweep.json").unlink()
        options = ("sweep", folder / "spec.toml", "-o", folder / "out", "--dask")
        assert run_command(*options, "local:1").exit_code == 0
        assert (folder / "out" / "results.csv").read_bytes() == first
        found = run_command(*options[:3], folder / "other", "--dask", "nonsense://x")
        assert "no dask scheduler answers at nonsense://x" in found.errors

    def test_params_of_controllers_inside_controllers_vary(self, folder):
        outer = "controller outer\ninput r\ninput y\nblock a = law(r, y, K=3)\nblock b = law(r, y)\n"
        text = FILE.replace("\nplant p", f"{outer}output u = a.u + b.u\nevery 0.1 s\n\nplant p")
        (folder / "small.fz").write_text(text.replace("block law = law(", "block law = outer("), encoding="utf-8")
        spec = 'scenario = "small.fz"\n[set]\nlaw.b.K = 2\n[grid]\nlaw.a.K = [1.0, 4.0]\n'
        errors = [row["error"] for row in swept(folder, spec)]
        loop = fuzzyctl.load(folder / "small.fz", block=fuzzyctl.Loop)
        runs = [fuzzyctl.simulate(loop, **{"law.a.K": k, "law.b.K": 2}) for k in (1, 4)]
        assert [float(e) for e in errors] == pytest.approx([run.measures["error"] for run in runs], rel=1e-13)
        drawn = 'scenario = "small.fz"\n[random]\n"law.*.K" = { uniform = [1.0, 2.0], relative = "factor" }\n'
        (row,) = swept(folder, drawn)
        assert 3 <= float(row["law.a.K"]) <= 6
        assert 1 <= float(row["law.b.K"]) <= 2
        (folder / "out" / "results.csv").unlink()
        (found,) = mistakes(folder, spec.replace("4.0", "40"))
        assert found["message"] == "run 1: param 'law.a.K' is 40, outside of (0, 20]"


class TestJournal:
    def test_keeps_what_is_done_whatever_ends_the_sweep(self, folder, here):
        whole = swept(folder)
        first = (folder / "out" / "results.csv").read_bytes()
        for name in ("results.csv", "sweep.json", "times.csv"):
            (folder / "out" / name).unlink()
        for error in (KeyboardInterrupt, sweep_workers.WorkerLostError("a worker ended")):
            here.error = error
            journal = interrupted(folder, here, 4, words="4 of 6 runs are kept in ")
            assert [p.name for p in journal.parent.iterdir()] == ["journal.jsonl"]
            assert "4 of 6 runs of a sweep that is not finished" in sweep(folder, SPEC).output
            here.computed = 0
            assert swept(folder, SPEC, "--resume") == whole
            assert here.computed == 2
            assert (folder / "out" / "results.csv").read_bytes() == first
            assert "belongs to a sweep that is finished" in sweep(folder, SPEC, "--resume").output
            for name in ("results.csv", "sweep.json", "times.csv"):
                (folder / "out" / name).unlink()

    def test_of_no_run_is_removed(self, folder, here):
        interrupted(folder, here, 0, words="interrupted")
        assert not (folder / "out").exists()

    def test_a_record_that_is_cut_or_damaged_is_computed_again(self, folder, here):
        whole = swept(folder)
        for name in ("results.csv", "sweep.json", "times.csv"):
            (folder / "out" / name).unlink()
        journal = interrupted(folder, here, 3)
        data = journal.read_bytes()
        last = data.rindex(b"\n", 0, len(data) - 1) + 1
        damaged = data[:last] + data[last:].replace(b'"error": ', b'"error": 1')
        assert damaged != data
        cuts = [(data[:k], 4) for k in (last, last + 1, (last + len(data)) // 2, len(data) - 1)]
        for content, left in [*cuts, (damaged, 4), (data, 3), (data[:40], 6)]:
            journal.parent.mkdir(exist_ok=True)
            journal.write_bytes(content)
            here.computed = 0
            assert swept(folder, SPEC, *(["--resume"] if left < 6 else [])) == whole
            assert here.computed == left
            for name in ("results.csv", "sweep.json", "times.csv"):
                (folder / "out" / name).unlink()

    def test_a_sweep_that_changed_does_not_go_on(self, folder, here):
        laws, rest = FILE.split("plant p")
        (folder / "laws.fz").write_text(laws, encoding="utf-8")
        (folder / "small.fz").write_text(f'use "laws.fz"\n\nplant p{rest}', encoding="utf-8")
        journal = interrupted(folder, here, 4)
        (folder / "laws.fz").write_text(laws.replace("K * (r", "1.5 * K * (r"), encoding="utf-8")
        (found,) = mistakes(folder, SPEC, "--resume")
        assert found["code"] == "FZ909"
        assert "file laws.fz" in found["facts"][0]
        assert journal.exists()

    def test_a_folder_that_cannot_be_used_is_named(self, folder, here):
        fcntl = pytest.importorskip("fcntl")
        journal = interrupted(folder, here, 3)
        with journal.open("rb") as other:
            fcntl.flock(other, fcntl.LOCK_EX)
            assert "is in use by another sweep" in sweep(folder, SPEC, "--resume").output
        journal.unlink()
        os.mkfifo(journal)
        assert "is not a regular file" in sweep(folder, SPEC).output
        journal.unlink()
        os.mkfifo(folder / "out" / "sweep.json")
        assert "no sweep wrote that" in sweep(folder, SPEC).output

    def test_a_full_disk_is_reported_with_the_file(self, folder):
        resource = pytest.importorskip("resource")
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        (folder / "spec.toml").write_text(SPEC, encoding="utf-8")
        resource.setrlimit(resource.RLIMIT_FSIZE, (200, limits[1]))
        try:
            found = run_command("sweep", folder / "spec.toml", "-o", folder / "out", "--jobs", 1)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert found.exit_code == 1
        assert "journal.jsonl cannot be written: File too large" in found.errors


class TestFiles:
    @pytest.mark.parametrize(
        ("name", "old", "new", "words"),
        [
            ("r.csv", "0,1", "0,2", "r.csv changed while the sweep ran"),
            ("small.fz", "run 2 s", "run 3 s", "small.fz changed while the sweep ran"),
            ("small.fz", "run 2 s", "rum 2 s", "was checked, but cannot be prepared"),
        ],
    )
    def test_a_file_that_changes_while_the_sweep_runs_ends_it(self, folder, monkeypatch, name, old, new, words):
        (folder / "r.csv").write_text("t,r\n0,1\n2,1\n", encoding="utf-8")
        text = FILE.replace("height * steps(0: 1)", 'csv("r.csv", column="r")')
        (folder / "small.fz").write_text(text, encoding="utf-8")
        compute = sweep_workers.compute

        def changing(setup, runs, jobs):
            path = folder / name
            path.write_text(path.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
            fresh = pickle.loads(pickle.dumps(setup)) if name == "small.fz" else setup
            return compute(fresh, runs, jobs)

        monkeypatch.setattr(sweep_workers, "compute", changing)
        found = sweep(folder, 'scenario = "small.fz"\n')
        assert found.exit_code == 1
        assert words in f"{found.output}{found.errors}"

    @pytest.mark.parametrize(
        ("code", "reason"),
        [
            ("1 / 0", "'derivative' of plant 'p' raised ZeroDivisionError"),
            ("__import__('os').kill(__import__('os').getpid(), 9)", ""),
        ],
    )
    def test_a_plant_in_python_that_fails_is_a_row_or_ends_the_worker(self, folder, monkeypatch, code, reason):
        text = 'inputs = ("u",)\nstates = {"x": 0.0}\noutputs = ("y",)\n\ndef derivative(t, x, u):\n'
        text += f"    return (u[0],) if t < 1 else {code}\n\ndef output(t, x):\n    return x\n"
        (folder / "p.py").write_text(text, encoding="utf-8")
        head, tail = FILE.split("plant p")
        (folder / "small.fz").write_text(f'{head}plant p = python("p.py")\n\nloop {tail.split("loop ")[1]}')
        if reason:
            (row,) = swept(folder, 'scenario = "small.fz"\n')
            assert row["stop_reason"] == reason
            return
        monkeypatch.setattr(sweep_workers, "compute", WORKERS)
        found = sweep(folder, 'scenario = "small.fz"\n')
        assert "a worker process ended in the middle of a run" in f"{found.output}{found.errors}"

    def test_an_fmu_has_its_own_params_in_each_run_and_is_not_changed(self, folder, here):
        pytest.importorskip("fmpy")
        write_fmu(PLANT, folder / "p.fmu")
        loop = "loop l\nblock p = p(1)\nmeasure end_value = final(p.y)\nrun 1 s step 0.1 s\n"
        (folder / "small.fz").write_text(f'plant p = fmu("p.fmu")\nparam T = 3\n\n{loop}', encoding="utf-8")
        text = 'scenario = "small.fz"\n[grid]\n"p.T" = [1.0, 2.0]\n'
        rows = swept(folder, text)
        assert [float(row["end_value"]) for row in rows] == pytest.approx([1 - math.exp(-1 / T) for T in (1, 2)])
        for one in ("results.csv", "times.csv", "sweep.json"):
            (folder / "out" / one).unlink()
        interrupted(folder, here, 1, text)
        with zipfile.ZipFile(folder / "p.fmu", "a") as archive:
            archive.writestr("extra/note.txt", "another version")
        (found,) = mistakes(folder, text, "--resume")
        assert "file p.fmu" in found["facts"][0]

    def test_an_fmu_that_crashes_is_a_row_and_the_sweep_goes_on(self, folder):
        pytest.importorskip("fmpy")

        def crashing(name, content):
            call = b'    static const char call[] = "fmi3DoStep";\n'
            crash = b"    static const fmi3ValueReference first[] = {FMU_FIRST_PARAM};\n    double T;\n"
            crash += b'    fmu_get(instance, "own", first, 1, &T);\n    if (T == 2.0) { abort(); }\n'
            head = b"#include <stdlib.h>\n" if name == "sources/fmi3.c" else b""
            return head + content.replace(call, crash + call)

        changed(write_fmu(PLANT, folder / "p.fmu"), crashing, compile_again=True)
        loop = "loop l\nblock p = p(1)\nmeasure end_value = final(p.y)\nrun 1 s step 0.1 s\n"
        (folder / "small.fz").write_text(f'plant p = fmu("p.fmu")\nparam T = 3\n\n{loop}', encoding="utf-8")
        rows = swept(folder, 'scenario = "small.fz"\n[grid]\n"p.T" = [1.0, 2.0, 0.5]\n')
        assert [row["stop_reason"] for row in rows] == ["", "FMU 'p' crashed when it had to make a step", ""]
        assert [row["end_value"] != "" for row in rows] == [True, False, True]


class TestMistakes:
    @pytest.mark.parametrize(
        ("old", "new", "line", "words"),
        [
            ('"law.K"', '"law.k"', 6, "unknown param law.k did you mean 'law.K'?"),
            ('"law.K"', '"*.K"', 6, "grid.*.K: a star stands for several keys in [random] alone name one key"),
            ("[1.0, 2.0]", "[1.0, 22.0]", 6, "run 3: param 'law.K' is 22, outside of (0, 20]"),
            ("[1.0, 2.0]", '[1.0, "two"]', 6, "run 3: law.K must be a finite number, got 'two'"),
            ("[1.0, 2.0]", "[1.0, true]", 6, "run 3: law.K must be a finite number, got true"),
            ('"p.T"', '"p.D"', 8, "no number in the scenario that a factor could change"),
            ("runs = 3", 'controllers = ["big"]', 3, "there is no loop 'big'"),
            ("runs = 3", 'measures = ["errors"]', 3, "there is no measure 'errors' did you mean 'error'?"),
            ("runs = 3", 'against = ["none.fz"]', 3, "against: no file 'none.fz'"),
            ("runs = 3", 'against = ["smal.fz"]', 3, "there is no such file did you mean 'small.fz'?"),
            ("runs = 3", "loop = 3", 3, "unknown key loop"),
            ("small.fz", "big.fz", 2, "there is no such file"),
            ("seed = 2", "[set]\n'noise.seed' = -1", 5, "noise.seed must be a whole number >= 0, got -1"),
            ("runs = 3", "runs = = 3", 3, "not valid TOML: Invalid value"),
        ],
    )  # fmt: skip
    def test_stand_at_their_line(self, folder, old, new, line, words):
        assert old in SPEC
        found = mistakes(folder, SPEC.replace(old, new))
        lines = [(f"{one['message']} {one['help'] or ''}", one["line"] or 0) for one in found]
        assert any(words in text and at == line for text, at in lines), lines

    def test_a_param_given_by_two_names_is_refused(self, folder):
        found = sweep(folder, 'scenario = "small.fz"\n', "--set", "K=1", "--set", "law.K=2")
        assert "law.K is given twice" in f"{found.output}{found.errors}"

    @pytest.mark.parametrize(
        ("old", "new", "spec", "words"),
        [
            ("loop small", "loop_small", "", "the file holds no loop"),
            ("der x", "dre x", "", "small.fz"),
            ("error", "stopped", "", "'stopped' is taken"),
            ("every 0.1 s", "param dT = 0.1\nevery dT", '[grid]\n"law.dT" = [0.1, 0.15]\n', "run 1:"),
        ],
    )
    def test_of_the_file_are_found_before_the_first_run(self, folder, old, new, spec, words):
        text = FILE.split(old)[0] if old == "loop small" else FILE.replace(old, new)
        (folder / "small.fz").write_text(text.replace("run 2 s", "run 2 s step 50 ms"), encoding="utf-8")
        found = mistakes(folder, f'scenario = "small.fz"\n{spec}'.replace("0.15", "0.12"))
        assert any(words in f"{one['message']} {one['file']}" for one in found), found
        assert not (folder / "out").exists()

    def test_what_varies_in_vain_is_a_warning(self, folder):
        (folder / "small.fz").write_text(FILE.replace("noise(sigma=0.01, seed=1)", "0"), encoding="utf-8")
        found = sweep(folder, 'scenario = "small.fz"\n[grid]\n"noise.seed" = [1, 2]\n')
        assert "no run reads a seed of noise" in found.errors
