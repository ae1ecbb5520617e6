"""Sweeps of tanks: journal, resumption, interruption, workers, and comparison of what comes out."""

import csv
import dataclasses
import json
import math
from functools import partial

import pytest

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.experiments import parquet, sweep_journal, sweep_plan, sweep_run, sweep_spec, sweep_workers
from fuzzyctl.experiments.estimates import entries
from fuzzyctl.experiments.sweep_run import InterruptedSweepError, Workers
from fuzzyctl.experiments.sweep_workers import SweepError, setup_of, work
from tests.fuzzyctl.experiments.tanks import Tanks

SPEC = """
scenario = "{scenario}"
controllers = ["open", "shut"]
runs = 3
seed = 5
measures = ["level"]

[grid]
"tank.area" = [4.0, 8.0]

[random]
"tank.level" = {{ uniform = [0.9, 1.1], relative = "factor" }}
"""
ALONE = Workers(jobs=1)


@pytest.fixture
def tank(tmp_path):
    """A tank that extends a shipped one."""
    (tmp_path / "shipped").mkdir()
    (tmp_path / "shipped" / "small.toml").write_text(
        "[tank]\narea = 2.0\nlevel = 1.0\nsteps = 3\nseed = 0\n", encoding="utf-8"
    )
    path = tmp_path / "mine.toml"
    path.write_text('extends = "small"\n[tank]\nlevel = 2.0\n', encoding="utf-8")
    return path


def spec(tank, text=SPEC):
    path = tank.parent / "spec.toml"
    path.write_text(text.format(scenario=tank.name), encoding="utf-8")
    return sweep_spec.read(path)


def made(tank, text=SPEC, overrides=(), **tanks):
    return sweep_plan.make(Tanks(tank.parent / "shipped", **tanks), spec(tank, text), overrides)


def swept(found, folder, resume=False, workers=ALONE, formats=("csv",), **options):
    about = sweep_journal.describe(spec(found.scenario.path), found, ())
    return sweep_run.run(found, ("level",), about, folder, formats, workers, resume, **options).summary


def rows(folder):
    with (folder / "results.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def mistakes(tank, text=SPEC, overrides=()):
    with pytest.raises(DiagnosticError) as caught:
        made(tank, text, overrides)
    return caught.value.diagnostics


class Here:
    """Computes in this process.

    Args:
        ended_after: Number of runs after which `error` comes.
        error: What ends the sweep.
    """

    def __init__(self, ended_after=math.inf, error=KeyboardInterrupt):
        self.left, self.error, self.computed = ended_after, error, 0

    def compute(self, setup, runs):
        for one in runs:
            if self.left == 0:
                raise self.error
            self.left -= 1
            self.computed += 1
            yield work(setup, one)


class TestPlan:
    def test_has_a_run_for_each_point_repetition_and_controller(self, tank):
        runs = made(tank).runs
        assert [one.number for one in runs] == list(range(12))
        assert {(one.controller, one.repetition, one.values["tank.area"]) for one in runs} == {
            (law, k, area) for law in ("open", "shut") for k in range(3) for area in (4.0, 8.0)
        }
        assert len({one.values["tank.level"] for one in runs}) == 3
        assert all(1.8 <= one.values["tank.level"] <= 2.2 for one in runs)
        assert len({one.values["tank.seed"] for one in runs}) == 3

    @pytest.mark.parametrize(
        ("old", "new", "line", "words"),
        [
            ('"tank.area" = [4.0, 8.0]', '"tank.aera" = [4.0]', 9, "did you mean 'area'?"),
            ('"tank.area" = [', '"tank.*" = [', 9, "in [random] alone name one key, or draw tank.* in"),
            ("[4.0, 8.0]", "[4.0, -8.0]", 9, "run 6: tank.area must be > 0, got -8.0"),
            ('"shut"]', '"shot"]', 3, "there is no valve 'shot'"),
            ('["level"]', '["levle"]', 6, "there is no measure 'levle' did you mean 'level'?"),
            ('"tank.level"', '"tank.depth"', 12, "no number in the scenario that a factor could change"),
            ('"tank.level"', '"tank.levle"', 12, "that a factor could change did you mean 'level'?"),
            ('"{scenario}"', '"nothing.toml"', 2, "there is no such file"),
        ],
    )  # fmt: skip
    def test_answers_a_mistake_at_its_line(self, tank, old, new, line, words):
        assert old in SPEC
        found = mistakes(tank, SPEC.replace(old, new))
        assert any(words in f"{one.message} {one.help}" and one.span.line == line for one in found), found

    def test_answers_broken_toml_at_its_place(self, tank):
        with pytest.raises(DiagnosticError) as caught:
            spec(tank, 'scenario = "a"\nruns = = 2\n')
        (one,) = caught.value.diagnostics
        assert (one.code, one.span.line, one.message) == ("FZ901", 2, "not valid TOML: Invalid value")

    def test_warns_of_what_varies_without_effect(self, tank):
        (found,) = made(tank, SPEC.replace('"open", "shut"', '"shut"')).warnings
        assert found.message == "grid.tank.area varies in vain: no run reads the area"
        assert (found.severity, found.span.line) == ("warning", 9)


class TestRun:
    def test_leaves_a_row_for_each_run(self, tank, tmp_path):
        found = made(tank)
        summary = swept(found, tmp_path / "out", formats=("csv", "parquet"), workers=Here())
        assert (summary["runs"], summary["computed"], summary["stopped"]) == (12, 12, 0)
        assert summary["files"] == ["results.csv", "results.parquet", "sweep.json", "times.csv"]
        for row, one in zip(rows(tmp_path / "out"), found.runs, strict=True):
            left = (1 - 1 / one.values["tank.area"]) ** 3 if one.controller == "open" else 1
            assert float(row["measures.level"]) == pytest.approx(one.values["tank.level"] * left)
        columns, about = parquet.read_table(tmp_path / "out" / "results.parquet", "fuzzyctl")
        assert columns["measures.level"] == [float(row["measures.level"]) for row in rows(tmp_path / "out")]
        assert about["columns"]["measures.level"] == {"unit": "m"}
        assert [one["file"] for one in about["scenario"]["text"]] == ["mine.toml", "small.toml"]

    def test_a_run_that_stops_is_a_row_with_its_reason(self, tank, tmp_path):
        tank.write_text(tank.read_text().replace("2.0", "200.0"), encoding="utf-8")
        summary = swept(made(tank), tmp_path / "out", workers=Here())
        assert summary["reasons"] == {"it flows over": 9}
        assert [row["stopped"] for row in rows(tmp_path / "out")[:2]] == ["false", "true"]

    def test_processes_give_the_same_bytes(self, tank, tmp_path):
        for name, workers in (("here", Here()), ("one", ALONE), ("two", Workers(jobs=2))):
            swept(made(tank), tmp_path / name, workers=workers)
        for name in ("results.csv", "sweep.json"):
            first, *others = ((tmp_path / one / name).read_bytes() for one in ("here", "one", "two"))
            assert others == [first, first]

    def test_a_cluster_gives_the_same_bytes(self, tank, tmp_path):
        for name, workers in (("here", Here()), ("dask", Workers(cluster="local:1"))):
            swept(made(tank), tmp_path / name, workers=workers)
        assert (tmp_path / "here" / "results.csv").read_bytes() == (tmp_path / "dask" / "results.csv").read_bytes()

    @pytest.mark.parametrize("error", [KeyboardInterrupt, sweep_workers.WorkerLostError("a worker ended")])
    def test_goes_on_where_it_was_ended(self, tank, tmp_path, error):
        kind = InterruptedSweepError if error is KeyboardInterrupt else SweepError
        with pytest.raises(kind, match=r"5 of 12 runs are kept in .*; go on with --resume"):
            swept(made(tank), tmp_path / "out", workers=Here(5, error))
        assert [one.name for one in (tmp_path / "out").iterdir()] == ["journal.jsonl"]
        with pytest.raises(DiagnosticError, match="5 of 12 runs of a sweep that is not finished"):
            swept(made(tank), tmp_path / "out")
        rest = Here()
        summary = swept(made(tank), tmp_path / "out", resume=True, workers=rest)
        assert (summary["computed"], rest.computed) == (7, 7)
        swept(made(tank), tmp_path / "whole", workers=Here())
        assert (tmp_path / "out" / "results.csv").read_bytes() == (tmp_path / "whole" / "results.csv").read_bytes()
        with pytest.raises(DiagnosticError, match="belongs to a sweep that is finished"):
            swept(made(tank), tmp_path / "out", resume=True)

    def test_what_is_ended_before_its_first_run_leaves_nothing(self, tank, tmp_path):
        with pytest.raises(InterruptedSweepError, match=r"^interrupted$"):
            swept(made(tank), tmp_path / "out", workers=Here(0))
        assert not (tmp_path / "out").exists()

    def test_does_not_go_on_after_the_scenario_changed(self, tank, tmp_path):
        with pytest.raises(InterruptedSweepError):
            swept(made(tank), tmp_path / "out", workers=Here(5))
        tank.write_text(tank.read_text().replace("2.0", "3.0"), encoding="utf-8")
        with pytest.raises(DiagnosticError, match=r"changed: text of the scenario"):
            swept(made(tank), tmp_path / "out", resume=True)
        assert [one.name for one in (tmp_path / "out").iterdir()] == ["journal.jsonl"]

    def test_a_worker_that_dies_is_reported(self, tank, tmp_path):
        level = made(tank).runs[0].values["tank.level"]
        with pytest.raises(SweepError, match="a worker process ended in the middle of a run"):
            swept(made(tank, dies_at=level), tmp_path / "out", workers=ALONE)

    def test_a_run_that_cannot_be_computed_ends_the_sweep(self, tank, tmp_path):
        level = made(tank).runs[4].values["tank.level"]
        with pytest.raises(SweepError, match=r"run 4 of .* cannot be computed:\n.*the valve broke(?s:.*)4 of 12 runs"):
            swept(made(tank, raises_at=level), tmp_path / "out", workers=Here())

    def test_shows_how_far_it_is_and_shields_the_writing(self, tank, tmp_path):
        seen = []

        class Shown:
            def __init__(self, *total):
                seen.append(total)

            def __enter__(self):
                return seen.append

            def __exit__(self, *error):
                seen.append("end")

        swept(made(tank), tmp_path / "out", workers=Here(), shown=Shown, shielded=Shown)
        assert seen == [(12,), *range(1, 13), "end", (), "end"]


class TestWork:
    def test_a_scenario_that_changes_is_noticed(self, tank):
        found = made(tank)
        tank.write_text(tank.read_text() + "# changed\n", encoding="utf-8")
        outcome = work(setup_of(found, measures=()), found.runs[0])
        assert outcome.problem == f"{tank} changed while the sweep ran"

    def test_a_file_that_a_scenario_names_and_that_changes_is_noticed(self, tank):
        law = tank.parent / "law.fz"
        law.write_text("1", encoding="utf-8")
        found = made(tank, SPEC + "[set]\n'tank.law' = 'law.fz'\n")
        assert list(found.used) == ["law.fz"]
        assert work(setup_of(found, measures=()), found.runs[0]).problem == ""
        law.write_text("2", encoding="utf-8")
        outcome = work(setup_of(found, measures=()), found.runs[0])
        assert outcome.problem == f"{law} changed while the sweep ran"

    def test_a_scenario_that_breaks_is_reported(self, tank):
        found = made(tank)
        tank.write_text('extends = "smal"\n', encoding="utf-8")
        assert "was checked, but cannot be prepared" in work(setup_of(found, measures=()), found.runs[0]).problem


class TestComparison:
    def test_of_two_scenarios_has_means_with_intervals(self, tank):
        other = tank.with_name("other.toml")
        other.write_text('extends = "mine.toml"\n[tank]\nlevel = 4.0\n', encoding="utf-8")
        plans = [made(tank), made(other)]
        runs = sweep_plan.joined(plans)
        assert [one.number for one in runs] == list(range(24))
        done = {one.number: work(setup_of(*plans, measures=("level",)), one) for one in runs}
        found = list(entries(runs, done, ["measures.level"], partial(plans[0].runnable.unit, plans[0].scenario)))
        assert [(one.scenario, one.controller) for one in found] == [
            ("mine", "open"), ("mine", "shut"), ("other", "open"), ("other", "shut")
        ]  # fmt: skip
        for one in found:
            assert (one.unit, one.estimate.n, one.stopped) == ("m", 6, 0)
            assert one.estimate.low < one.estimate.mean < one.estimate.high
        assert found[3].estimate.mean == pytest.approx(2 * found[1].estimate.mean)

    def test_leaves_out_runs_that_stopped(self, tank):
        found = made(tank)
        outcomes = {one.number: work(setup_of(found, measures=("level",)), one) for one in found.runs}
        outcomes[0] = dataclasses.replace(outcomes[0], row={"stopped": True, "measures.level": 999.0})
        (one, _) = entries(found.runs, outcomes, ["measures.level"], partial(found.runnable.unit, found.scenario))
        assert (one.estimate.n, one.stopped) == (5, 1)
        assert one.estimate.mean < 3


def test_the_description_is_plain_data(tank):
    about = sweep_journal.describe(spec(tank), made(tank), ["tank.level=1"])
    assert json.loads(json.dumps(about)) == about
    assert about["overrides"] == ["tank.level=1"]
