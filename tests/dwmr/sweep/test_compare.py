"""`dwmr compare`: tables, intervals, and what becomes of runs that stop."""

import csv
import dataclasses
import json
from types import SimpleNamespace

import numpy as np
import pyarrow.parquet
import pytest
from scipy import stats

from dwmr import find
from tests.dwmr.process import here
from tests.dwmr.scenarios import by_hand

SHORT = ("--set", "run.horizon=2")
ALONE = ("--jobs", "1")


@pytest.fixture
def entries(recorded):
    """A function (*trajectories) -> the measures of a comparison in whose repetitions these run, by their names."""

    def compare(*trajectories):
        recorded(*trajectories)
        options = ("--controller", "smc", "--runs", len(trajectories), *SHORT, *ALONE, "--set", "obstacles=[]")
        stops = any(one.stop is not None for one in trajectories)
        done = here("compare", "undisturbed", *options, "--format", "json", status=int(stops))
        found = json.loads(done.stdout)["entries"]
        return {one["measure"]: one for one in found if one["robot"] == "follower1"}

    return compare


#: Robots far from each other.
APART = {"x": [0.0, 50.0, 100.0]}
STOP = SimpleNamespace(t=0.01, robot="leader", reason="it fell over", mistake=None)


class TestEntries:
    def test_average_the_runs(self, entries):
        found = entries(by_hand(x_e=1.0, v_c=0.0, **APART), by_hand(x_e=3.0, **APART))
        one = found["rmse.x_e"]
        assert (one["mean"], one["n"], one["unit"]) == (2.0, 2, "m")
        assert one["low"] == pytest.approx(2.0 - stats.t.ppf(0.975, 1))
        assert found["chattering.omega"]["unit"] == "rad/s²"

    def test_leave_runs_that_stopped_out_of_means_but_not_of_hits(self, entries):
        found = entries(by_hand(x_e=1.0, **APART), by_hand(x_e=9.0, stop=STOP))
        assert [found["rmse.x_e"][key] for key in ("mean", "n", "stopped")] == [1.0, 1, 1]
        assert [found["robots_hit"][key] for key in ("mean", "n")] == [0.5, 2]

    @pytest.mark.parametrize(("hits", "n"), [(0, 3), (1, 3), (2, 2)])
    def test_have_the_interval_of_a_share_by_wilson(self, entries, hits, n):
        one = entries(*(by_hand(**({} if k < hits else APART)) for k in range(n)))["robots_hit"]
        expected = stats.binomtest(hits, n).proportion_ci(0.95, method="wilson")
        assert (one["mean"], one["n"]) == (pytest.approx(hits / n), n)
        assert (one["low"], one["high"]) == pytest.approx((expected.low, expected.high), abs=1e-12)

    def test_fake_no_interval(self, entries):
        found = entries(by_hand(**APART))
        assert {(one["low"], one["high"]) for one in found.values()} == {(None, None)}
        assert found["centre_distance"]["mean"] is None


class TestCommand:
    def test_leaves_out_what_a_scenario_does_not_have(self):
        options = ("--controller", "smc", "--runs", "2", *SHORT, *ALONE, "--format", "json")
        found = json.loads(here("compare", "undisturbed", *options, "--set", "disturbances=[]").stdout)["entries"]
        (one,) = [one for one in found if (one["robot"], one["measure"]) == ("leader", "rmse.x_e")]
        assert one["low"] < one["mean"] < one["high"]

    def test_has_a_table_of_the_filter_where_there_is_one(self):
        scenarios = ("moving-obstacles", "undisturbed")
        done = here("compare", *scenarios, "--controller", "smc", "--set", "run.horizon=1", *ALONE)
        assert "moving-obstacles: safety filter" in done.stdout
        assert "undisturbed: safety filter" not in done.stdout
        assert "infeasible: moments at which no command kept a barrier" in " ".join(done.stdout.split())

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
        assert len(rows) == 3 * 3 * 13
        row = rows[0]
        assert (row["controller"], row["robot"], row["measure"], row["n"]) == ("aifqsmc", "leader", "rmse.x_e", "3")
        assert float(row["low"]) < float(row["mean"]) < float(row["high"])
        here(*arguments, "-o", tmp_path / "table.parquet")
        columns = pyarrow.parquet.read_table(tmp_path / "table.parquet").to_pydict()
        assert ["" if v is None else repr(v) for v in columns["mean"]] == [r["mean"] for r in rows]

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


def test_a_mean_beyond_all_bounds_is_null(recorded):
    recorded(by_hand(x_e=[0.0, np.inf, 0.0], **APART))
    text = here("compare", "paper", "--controller", "smc", *SHORT, *ALONE, "--format", "json").stdout
    means = {one["robot"]: one["mean"] for one in json.loads(text)["entries"] if one["measure"] == "rmse.x_e"}
    assert means == {"leader": 0.0, "follower1": None, "follower2": 0.0}


def test_ratios_to_a_table_of_the_paper_are_counted(recorded, run_paper):
    run = run_paper("aifqsmc")[1]
    recorded(run, dataclasses.replace(run, controller="aifqsmc_without_layer"))
    laws = "aifqsmc,aifqsmc_without_layer"
    text = here("compare", "paper", "--controller", laws, *ALONE).stdout
    assert "paper: RMSE over those of Table 12 of the paper" in text
    near = "aifqsmc: 9 of 9 errors within 10 % of Table 12, 9 within 12 %, ratios 0.90 to 1.09"
    assert near in " ".join(text.split())
    assert text.count("% of Table 12") == 1
