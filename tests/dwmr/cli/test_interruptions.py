"""Interrupted commands exit with 130 and leave whole results, or those that were there before."""

import json
import signal
from pathlib import Path

import pytest

from dwmr.simulation import simulate
from tests.dwmr.process import here

SHORT = ("--set", "run.horizon=0.1")
FILES = ["errors.png", "path.png", "summary.json", "trajectory.npz"]


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture
def interrupted(monkeypatch):
    """Interrupt the run of a law as soon as it has computed its last period."""
    finish = simulate.run

    def interrupt(law):
        def run(simulation, report=None):
            def heard(done):
                if simulation.name == law and done == simulation.scenario.run.steps + 1:
                    signal.raise_signal(signal.SIGINT)

            return finish(simulation, heard)

        monkeypatch.setattr(simulate, "run", run)

    return interrupt


@pytest.fixture
def interrupted_while_moved(monkeypatch):
    """Interrupt a command, by both signals, when it moves its first finished file into its place."""
    move, left = Path.replace, [signal.SIGINT, signal.SIGTERM]

    def replace(path, target):
        if ".results-" in str(path):
            while left:
                signal.raise_signal(left.pop())
        return move(path, target)

    monkeypatch.setattr(Path, "replace", replace)


def test_the_last_period_of_a_law_ends_the_run_and_names_the_results(tmp_path, interrupted):
    interrupted("fcafsmc")
    done = here("run", "paper", "--controller", "all", *SHORT, "-o", tmp_path, status=130)
    assert f"interrupted: the results of aifqsmc, fcafsmc until then are in {tmp_path}\n" in done.stderr
    assert "smc was not run: interrupted" in done.stderr
    assert f"results in {tmp_path}" in done.stdout.replace("\n", " ")
    laws = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["controllers"]
    assert [law["stopped"] and law["stopped"]["reason"] for law in laws.values()] == [None, "interrupted"]
    assert names(tmp_path) == FILES
    interrupted("smc")
    done = here("run", "paper", "--controller", "smc", *SHORT, "-o", tmp_path, "--format", "json", status=130)
    assert json.loads(done.stdout)["controllers"]["smc"]["stopped"]["reason"] == "interrupted"


def test_a_run_that_is_interrupted_before_anything_is_done_leaves_nothing(tmp_path, monkeypatch):
    def run(simulation, report=None):
        raise KeyboardInterrupt

    monkeypatch.setattr(simulate, "run", run)
    assert here("run", "paper", "-o", tmp_path / "out", status=130).stderr == "interrupted\n"
    assert names(tmp_path) == []


@pytest.mark.usefixtures("interrupted_while_moved")
@pytest.mark.parametrize(
    "command", [("run", "paper", "--controller", "smc"), ("figures", "paper", "--only", "8-9"), ("report", "paper")]
)
def test_files_on_their_way_arrive(tmp_path, command):
    out = tmp_path / ("report.html" if command[0] == "report" else "out")
    done = here(*command, *SHORT, "-o", out, status=130)
    assert "interrupted while the results were written; they are whole\n" in done.stderr
    kept = {"run": FILES, "figures": ["fig08.png", "fig09.png", "index.md"]}
    assert names(tmp_path) == [out.name]
    assert out.is_file() or names(out) == kept[command[0]]


@pytest.mark.parametrize(
    ("command", "name"),
    [
        (("figures", "paper", "--only", "8"), "index.md"),
        (("animate", "paper", "--controller", "smc"), "a.png"),
        (("report", "paper", "--controller", "smc"), "a.html"),
    ],
)
def test_what_was_there_before_stays(tmp_path, interrupted, command, name):
    interrupted("smc")
    (tmp_path / name).write_text("before", encoding="utf-8")
    out = tmp_path if command[0] == "figures" else tmp_path / name
    assert here(*command, *SHORT, "-o", out, status=130).stderr == "interrupted\n"
    assert names(tmp_path) == [name]
    assert (tmp_path / name).read_text(encoding="utf-8") == "before"


def test_a_comparison_leaves_nothing(tmp_path, monkeypatch):
    collected = []

    def collect(*_):
        collected.append(True)
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr("fuzzyctl.experiments.sweep_run.collect", collect)
    done = here("compare", "paper", "--controller", "smc", *SHORT, "-o", tmp_path / "a.csv", status=130)
    assert (done.stdout, done.stderr, collected, names(tmp_path)) == ("", "interrupted\n", [True], [])
