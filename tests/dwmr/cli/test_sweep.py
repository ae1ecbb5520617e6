import contextlib
import csv
import json
import os
import select
import signal
import socket
import subprocess
import sys
from textwrap import dedent

import pyarrow.parquet
import pytest

from dwmr import load
from fuzzyctl.experiments import sweep_workers
from tests.dwmr.process import LONG, dwmr, here, in_short, interrupted_by_a_worker_that_starts

SPEC = """
scenario = "paper"
runs = {runs}
seed = 1
measures = ["rmse", "centre_distance", "robot_gap", "obstacles_hit", "robots_hit", "lyapunov", "drift", "g_ais_min"]

[set]
"run.horizon" = {horizon}

[random]
"robots.*.mass" = {{ uniform = [100, 140] }}
"disturbances.*.v" = {{ uniform = [0.8, 1.2], relative = "factor" }}
"""

#: What a sweep leaves that is the same bytes each time.
SAME = ("results.csv", "results.parquet", "sweep.json")


def spec(folder, runs=6, horizon=1.0, text=SPEC):
    path = folder / "spec.toml"
    path.write_text(text.format(runs=runs, horizon=horizon), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def one(tmp_path_factory):
    """A sweep of six short runs by one process: its SPEC and its folder."""
    folder = tmp_path_factory.mktemp("one")
    path = spec(folder)
    done = in_short("sweep", path, "-o", folder / "out", "--jobs", "1", "--data", "csv,parquet")
    assert done.stderr == ""
    assert "6 runs, all to the end" in done.stdout
    return path, folder / "out"


@pytest.fixture
def dask_port():
    """The port at which dask's scheduler shows its state by default, in use."""
    with socket.socket() as listener:
        with contextlib.suppress(OSError):  # another process may use it already
            listener.bind(("127.0.0.1", 8787))
            listener.listen()
        yield


def require_same(first, second):
    for name in SAME:
        assert (first / name).read_bytes() == (second / name).read_bytes(), name


class TestSweep:
    def test_leaves_results_and_no_journal(self, one):
        assert sorted(p.name for p in one[1].iterdir()) == ["results.csv", "results.parquet", "sweep.json", "times.csv"]

    def test_has_the_same_numbers_in_both_formats(self, one):
        table = pyarrow.parquet.read_table(one[1] / "results.parquet")
        columns, about = table.to_pydict(), json.loads(table.schema.metadata[b"dwmr"])
        with (one[1] / "results.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        assert [float(row["rmse.leader.x_e"]) for row in rows] == columns["rmse.leader.x_e"]
        assert about == json.loads((one[1] / "sweep.json").read_text(encoding="utf-8"))
        assert about["columns"]["rmse.leader.theta_e"] == {"unit": "rad"}
        assert list(columns) == list(rows[0])

    def test_repeats_what_a_run_gives(self, one, tmp_path):
        with (one[1] / "results.csv").open(newline="") as file:
            row = list(csv.DictReader(file))[3]
        values = [f"--set={key}={row[key]}" for key in row if key.startswith(("robots.", "disturbances.", "run.seed"))]
        here("run", "paper", "--set", "run.horizon=1.0", *values, "-o", tmp_path)
        found = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["controllers"]["aifqsmc"]
        assert found["rmse"]["follower2"]["x_e"] == float(row["rmse.follower2.x_e"])
        assert found["drift"]["leader"]["k_h_v"]["growth"] == float(row["drift.leader.k_h_v.growth"])

    @pytest.mark.long
    def test_does_not_depend_on_the_number_of_processes(self, one, tmp_path):
        (tmp_path / "sweep.json").write_bytes((one[1] / "sweep.json").read_bytes())
        (tmp_path / "results.csv").write_text("of an earlier sweep", encoding="utf-8")
        dwmr("sweep", one[0], "-o", tmp_path, "--jobs", "2", "--data", "csv,parquet")
        require_same(one[1], tmp_path)

    @pytest.mark.long
    def test_is_the_same_on_a_cluster_beside_another_one(self, one, tmp_path, dask_port):
        done = dwmr("sweep", one[0], "-o", tmp_path, "--dask", "local:2", "--data", "csv,parquet")
        assert done.stderr == ""
        require_same(one[1], tmp_path)

    @pytest.mark.parametrize(("options", "beside"), [((), None), (("--resume",), "[]"), ((), '{"columns": {}}')])
    def test_refuses_to_replace_files_that_no_sweep_wrote(self, one, tmp_path, beside, options):
        (tmp_path / "results.csv").write_text("mine", encoding="utf-8")
        if beside is not None:
            (tmp_path / "sweep.json").write_text(beside, encoding="utf-8")
        done = here("sweep", one[0], "-o", tmp_path, *options, status=1)
        assert "error[FZ909]" in done.stderr
        assert "results.csv" in done.stderr
        assert "no sweep wrote that" in done.stderr
        assert (tmp_path / "results.csv").read_text(encoding="utf-8") == "mine"
        assert len(list(tmp_path.iterdir())) == (1 if beside is None else 2)

    def test_prints_json(self, one, tmp_path):
        options = ("--jobs", "1", "--format", "json", "--set", "robot.radius=0.5")
        found = json.loads(here("sweep", one[0], "-o", tmp_path, *options).stdout)
        assert (found["runs"], found["stopped"], found["files"]) == (6, 0, ["results.csv", "sweep.json", "times.csv"])


#: The command, which prints "held" and waits for a line before it looks for outcomes for the (argument 1 + 1)th time.
HELD = """
import sys
from dwmr.cli.main import main
from fuzzyctl.experiments import sweep_workers
left, wait = int(sys.argv[1]), sweep_workers.wait
def hold(*futures, **options):
    global left
    if left == 0:
        print("held", flush=True)
        sys.stdin.readline()
    left -= 1
    return wait(*futures, **options)
sweep_workers.wait = hold
main(sys.argv[2:])
"""


def held(path, out, looks=3):
    """Begin a sweep by two processes, and hold it where each look has found at least one outcome, and six at most."""
    process = subprocess.Popen(
        [sys.executable, "-W", "error", "-c", HELD, str(looks), "sweep", path, "-o", out, "--jobs", "2",
         "--data", "csv,parquet"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    if process.stdout.readline() != "held\n":
        raise AssertionError(f"ended before it was held: {process.communicate()}")
    return process


def workers_of(process):
    found = subprocess.run(
        ["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True, text=True, check=False
    )
    return [int(pid) for pid in found.stdout.split()]


@pytest.fixture(scope="module")
def long(tmp_path_factory):
    """A sweep of more runs than are done when it is held: its SPEC, and the folder of one that was not interrupted."""
    folder = tmp_path_factory.mktemp("long")
    path = spec(folder, runs=30)
    here("sweep", path, "-o", folder / "whole", "--data", "csv,parquet", "--jobs", "1")
    return path, folder / "whole"


@pytest.mark.skipif(not hasattr(os, "pidfd_open"), reason="waits for processes of others to end, as Linux can")
class TestResume:
    def test_a_killed_sweep_goes_on_to_the_same_bytes(self, long, tmp_path):
        process, journal = held(long[0], tmp_path / "out"), tmp_path / "out" / "journal.jsonl"
        workers = [os.pidfd_open(pid) for pid in workers_of(process)]
        assert len(workers) >= 2
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=LONG)
        with journal.open("r+b") as file:  # as if it had been killed while writing
            file.truncate(journal.stat().st_size - 7)
        for worker in workers:
            assert select.select([worker], [], [], LONG)[0], "a worker goes on without its parent"
            os.close(worker)
        assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["journal.jsonl"]
        options = ("--data", "csv,parquet", "--jobs", "1", "--resume", "--format", "json")
        found = json.loads(here("sweep", long[0], "-o", tmp_path / "out", *options).stdout)
        assert 0 < found["computed"] < 30
        require_same(long[1], tmp_path / "out")

    def test_an_interrupted_sweep_says_how_to_go_on(self, long, tmp_path, monkeypatch):
        looks, wait = iter(range(3)), sweep_workers.wait

        def interrupted(*futures, **options):
            if next(looks, None) is None:
                signal.raise_signal(signal.SIGINT)
            return wait(*futures, **options)

        options = ("-o", tmp_path / "out", "--data", "csv,parquet")
        with monkeypatch.context() as patched:
            patched.setattr(sweep_workers, "wait", interrupted)
            done = here("sweep", long[0], *options, "--jobs", "2", status=130)
        assert done.stdout == ""
        assert "of 30 runs are kept" in done.stderr
        assert "--resume" in done.stderr
        here("sweep", long[0], *options, "--jobs", "1", "--resume")
        require_same(long[1], tmp_path / "out")

    @pytest.mark.long
    def test_an_interrupted_group_of_processes_says_how_to_go_on(self, long, tmp_path):
        process = held(long[0], tmp_path / "out")
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=LONG)
        assert process.returncode == 130
        assert out == ""
        assert "Traceback" not in err
        assert "of 30 runs are kept" in err
        assert "--resume" in err
        here("sweep", long[0], "-o", tmp_path / "out", "--data", "csv,parquet", "--jobs", "1", "--resume")
        require_same(long[1], tmp_path / "out")

    def test_an_interrupt_while_workers_start_is_a_single_line(self, long, tmp_path):
        done = interrupted_by_a_worker_that_starts(tmp_path, "sweep", long[0], "-o", tmp_path / "out", "--jobs", "2")
        assert (done.stdout, done.stderr) == ("", "interrupted\n")

    @pytest.mark.long
    def test_a_worker_that_dies_is_a_message(self, long, tmp_path):
        process = held(long[0], tmp_path / "out")
        for pid in workers_of(process):
            with open(f"/proc/{pid}/cmdline", encoding="utf-8") as file:
                if "spawn_main" in file.read():
                    os.kill(pid, signal.SIGKILL)
        _, err = process.communicate("go on\n", timeout=LONG)
        assert process.returncode == 1
        assert "Traceback" not in err
        assert "a worker process ended" in err
        assert "--resume" in err


class TestBadInput:
    def test_a_changed_spec_is_not_resumed(self, tmp_path, one):
        path = spec(tmp_path)
        out = tmp_path / "out"
        out.mkdir()
        for file in one[1].iterdir():
            (out / file.name).write_bytes(file.read_bytes())
        spec(tmp_path, runs=7)
        err = here("sweep", path, "-o", out, "--resume", status=1).stderr
        assert "changed: runs of the SPEC, number of runs" in err
        spec(tmp_path)
        err = here("sweep", path, "-o", out, "--resume", "--set", "robot.radius=0.6", status=1).stderr
        assert "changed: values of --set" in err
        about = json.loads((out / "sweep.json").read_text(encoding="utf-8"))
        assert {len(digest) for digest in (*about["rules"].values(), about["versions"]["sources"])} == {64}
        assert 'name = "paper"' in about["scenario"]["text"][0]["text"]
        assert "is finished" in here("sweep", path, "-o", out, "--resume", status=1).stderr

    @pytest.mark.parametrize(
        ("arguments", "status", "words"),
        [
            (["nowhere.toml"], 2, "no SPEC 'nowhere.toml'"),
            (["{spec}", "--data", "xlsx"], 2, "'xlsx' is not one of csv, parquet"),
            (["{spec}", "--jobs", "0"], 2, "0 is not in the range"),
            (["{spec}", "--jobs", "2", "--dask", "local:2"], 2, "give one of them"),
            (["{spec}", "--dask", "local:many"], 2, "needs a number of processes"),
            (["{spec}", "--dask", "nonsense://x"], 1, "no dask scheduler answers at nonsense://x"),
            (["{spec}", "--resume"], 1, "holds no sweep to go on with"),
            (["{spec}", "--set", "run.horizon=-1"], 1, "set.run.horizon is given by --set already"),
            (["{spec}", "-o", "{spec}"], 1, "cannot be written"),
        ],
    )
    def test_gets_a_clear_answer(self, tmp_path, monkeypatch, arguments, status, words):
        path = spec(tmp_path)
        monkeypatch.chdir(tmp_path)
        done = here("sweep", *[a.format(spec=path) for a in arguments], status=status)
        assert words in done.stderr
        assert [p.name for p in tmp_path.iterdir()] == ["spec.toml"]

    def test_parquet_without_pyarrow_names_what_to_install(self, tmp_path, monkeypatch):
        monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
        done = here("sweep", spec(tmp_path), "--data", "parquet", status=1)
        assert "Parquet needs pyarrow, which is not installed" in done.stderr

    def test_the_spec_of_its_help_runs_in_an_empty_folder(self, tmp_path):
        text = here("sweep", "--help").stdout.partition('  scenario = "')
        spec_text = dedent(f"{text[1]}{text[2].partition(chr(10) * 2)[0]}")
        (tmp_path / "spec.toml").write_text(spec_text, encoding="utf-8")
        assert "3 runs, all to the end" in here("sweep", "spec.toml", "--jobs", "1", cwd=tmp_path).stdout


class TestRunData:
    def test_run_writes_the_formats_that_are_asked_for(self, tmp_path):
        here("run", "paper", "--set", "run.horizon=1", "-o", tmp_path, "--data", "npz,csv")
        first = load(tmp_path / "trajectory.npz")
        assert (load(tmp_path / "trajectory.csv").runs["aifqsmc"]["x"] == first.runs["aifqsmc"]["x"]).all()
        assert first.metadata["scenario"]["text"][0]["file"] == "paper.toml"
        assert first.metadata["scenario"]["overrides"] == ["run.horizon=1"]
        assert len(first.metadata["rules"]["ais_reaction"]["sha256"]) == 64
        here("run", "paper", "--set", "run.horizon=1", "-o", tmp_path, "--data", "mat")
        assert sorted(p.name for p in tmp_path.glob("trajectory.*")) == ["trajectory.mat"]
