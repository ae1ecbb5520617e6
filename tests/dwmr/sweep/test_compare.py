import csv
import dataclasses
import io
import json

import numpy as np
import pytest
from rich.console import Console
from scipy import stats

from dwmr import find
from dwmr.cli import repetitions
from dwmr.sweep import comparison
from dwmr.sweep.comparison import _print_ratios, _ratios, entries
from fuzzyctl.experiments import parquet
from fuzzyctl.experiments.sweep_plan import Run
from fuzzyctl.experiments.sweep_workers import Outcome
from tests.dwmr.process import here

SHORT = ("--set", "run.horizon=2")
ALONE = ("--jobs", "1")


def outcome(number, **row):
    columns = {
        "stopped": False, "rmse.a.x_e": 1.0, "rmse.a.y_e": 2.0, "rmse.a.theta_e": 3.0,
        "centre_distance.a": None, "obstacle_gap.a": None, "robot_gap.a": -0.1, "obstacles_hit.a": 0, "robots_hit.a": 1,
        "chattering.a.v": 4.0, "chattering.a.omega": 5.0,
    }  # fmt: skip
    return Outcome(number, columns | row, 0.1)


class TestEntries:
    def found(self, *outcomes):
        runs = [Run(one.number, "here", find("paper"), "smc", 0, {}, ()) for one in outcomes]
        return {one.measure: one for one in entries(runs, {one.number: one for one in outcomes})}

    def test_average_the_runs(self):
        found = self.found(outcome(0, **{"rmse.a.x_e": 1.0}), outcome(1, **{"rmse.a.x_e": 3.0}))
        assert (found["rmse.x_e"].mean, found["rmse.x_e"].n, found["rmse.x_e"].unit) == (2.0, 2, "m")
        assert found["rmse.x_e"].low == pytest.approx(2.0 - stats.t.ppf(0.975, 1))
        assert (found["chattering.omega"].mean, found["chattering.omega"].unit) == (5.0, "rad/s²")

    def test_leave_runs_that_stopped_out_of_means_but_not_of_hits(self):
        bad = outcome(1, stopped=True, **{"rmse.a.x_e": 9.0, "obstacles_hit.a": 2})
        found = self.found(outcome(0), bad)
        assert (found["rmse.x_e"].mean, found["rmse.x_e"].n, found["rmse.x_e"].stopped) == (1.0, 1, 1)
        assert (found["obstacles_hit"].mean, found["obstacles_hit"].n) == (0.5, 2)
        assert (found["robots_hit"].mean, found["robots_hit"].n) == (1.0, 2)

    def test_fake_no_interval(self):
        found = self.found(outcome(0))
        assert {(one.low, one.high) for one in found.values()} == {(None, None)}
        assert found["centre_distance"].mean is None


class TestVariation:
    def test_leaves_out_what_a_scenario_does_not_have(self):
        made = comparison.make(
            comparison.variation(None), find("undisturbed"), ("smc",), 2, 0, None, ["disturbances=[]"]
        )  # fmt: skip
        varied = {key.rpartition(".")[2] for key in made.runs[0].values}
        assert varied == {"mass", "inertia", "x_0", "y_0", "theta_0", "seed"}


class TestCommand:
    def test_has_a_table_for_each_scenario(self):
        done = here("compare", "paper", "undisturbed", "--controller", "smc,fcafsmc", *SHORT, *ALONE)
        assert done.stderr == ""
        for word in ("paper:", "undisturbed:", "fcafsmc", "smc", "follower2"):
            assert word in done.stdout
        assert "aifqsmc" not in done.stdout
        assert "±" not in done.stdout
        assert max(map(len, done.stdout.splitlines())) <= 80

    def test_agrees_with_a_run(self, measured):
        options = ("--controller", "aifqsmc", *SHORT, *ALONE, "--format", "json")
        found = json.loads(here("compare", "paper", *options).stdout)
        expected = measured("aifqsmc", "run.horizon=2")
        (one,) = [e for e in found["entries"] if (e["robot"], e["measure"]) == ("follower1", "rmse.y_e")]
        assert one["mean"] == expected["rmse"]["follower1"]["y_e"]
        assert one["low"] is None

    def test_shows_intervals_over_repetitions_and_writes_them(self, tmp_path):
        arguments = ("compare", "paper", "--controller", "all", "--runs", "3", "--seed", "5", *SHORT, *ALONE)
        done = here(*arguments, "-o", tmp_path / "table.csv")
        assert "±" in done.stdout
        assert "3 runs each" in done.stdout
        with (tmp_path / "table.csv").open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        assert len(rows) == 3 * 3 * 10
        row = rows[0]
        assert (row["controller"], row["robot"], row["measure"], row["n"]) == ("aifqsmc", "leader", "rmse.x_e", "3")
        assert float(row["low"]) < float(row["mean"]) < float(row["high"])
        here(*arguments, "-o", tmp_path / "table.parquet")
        columns, _ = parquet.read_table(tmp_path / "table.parquet", "dwmr")
        assert [repr(v) for v in columns["mean"]] == [r["mean"] for r in rows]

    def test_takes_what_varies_from_a_spec(self, tmp_path):
        path = tmp_path / "spec.toml"
        path.write_text('scenario = "paper"\n[random]\n"robot.mass" = { uniform = [-2, -1] }\n', encoding="utf-8")
        done = here("compare", "paper", "--vary", path, "--runs", "2", *SHORT, *ALONE, status=1)
        assert f"{path}:3" in done.stderr
        assert "run 0: robot.mass must be > 0 kg" in done.stderr

    def test_a_run_that_stops_is_said(self):
        done = here(
            "compare", "paper", "--controller", "smc", "--set", "disturbances.0.start=1",
            "--set", "disturbances.0.force=1e300",
            *SHORT, *ALONE, status=1,
        )  # fmt: skip
        assert "warning: paper, smc: 1 of 1 stopped" in done.stdout

    @pytest.mark.parametrize(
        ("arguments", "status", "words"),
        [
            (["paper", "--runs", "0"], 2, "0 is not in the range"),
            (["paper", "paper"], 2, "'paper' is given twice"),
            (["paper", str(find("paper"))], 2, "paper.toml is given twice"),
            (["paper", "--controller", "smc,aifqsmc, smc"], 2, "'smc' is given twice"),
            (
                ["paper", "--set", "run.horizon=0.1", *ALONE, "-o", "/dev/null/x.csv"],
                1,
                "name another file with -o FILE",
            ),
            (["paper", "-o", "table.xlsx"], 2, "neither in .csv nor in .parquet"),
            (["paper", "--vary", "nowhere.toml"], 2, "does not exist"),
        ],
    )
    def test_bad_input_gets_a_clear_answer(self, tmp_path, monkeypatch, arguments, status, words):
        monkeypatch.chdir(tmp_path)
        assert words in here("compare", *arguments, status=status).stderr
        assert list(tmp_path.iterdir()) == []

    def test_two_scenarios_of_one_name_are_refused(self, tmp_path):
        (tmp_path / "other.toml").write_text('extends = "paper"\nname = "paper"\n', encoding="utf-8")
        done = here("compare", "paper", tmp_path / "other.toml", *SHORT, status=2)
        assert "two scenarios have the name 'paper'" in done.stderr
        assert "other.toml" in done.stderr


def test_no_terminal_acts_on_the_data(capfdbinary):
    entry = comparison.Entry("here", "own", "a\x9b31m", "rmse.x_e", "m", 1, np.inf, None, None, 0)
    repetitions._print([entry], "json", 1)
    text = capfdbinary.readouterr().out.decode()
    assert "a\\u009b31m" in text
    assert json.loads(text)["entries"][0] == dataclasses.asdict(entry) | {"mean": None}


def test_ratios_to_a_table_of_the_paper_are_counted(measured):
    found = [
        comparison.Entry("paper", "aifqsmc", robot, f"rmse.{name}", "m", 1, value, None, None, 0)
        for robot, row in measured("aifqsmc")["rmse"].items()
        for name, value in row.items()
    ]
    out = Console(width=120, record=True, file=io.StringIO())
    _print_ratios(out, "paper", list(_ratios(found, 12)), 12)
    said = out.export_text()
    assert "paper: RMSE over those of Table 12 of the paper" in said
    assert "aifqsmc: 9 of 9 within 10%, 0.90 to 1.09" in said
    assert list(_ratios([dataclasses.replace(found[0], controller="mine")], 12)) == []
