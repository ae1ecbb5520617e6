"""Sweeps over loops: what varies, what comes out, files that change, mistakes in SPEC and files."""

import csv
import dataclasses
import json
import math
import pickle
import zipfile
from functools import partial
from types import SimpleNamespace

import pytest

import fuzzyctl
from fuzzyctl.codegen.fmu.archive import compiler, fmu, sources
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.experiments import sweep_journal, sweep_plan, sweep_run, sweep_workers
from fuzzyctl.experiments.scenario_keys import OverrideError
from fuzzyctl.experiments.sweep_run import InterruptedSweepError
from fuzzyctl.experiments.sweep_workers import SweepError, work
from fuzzyctl.sweep.loop_files import against, read
from fuzzyctl.sweep.loops import Loops
from tests.fuzzyctl.codegen.fmu.fmus import plant_fmu

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


class Here:
    """Computes in this process.

    Args:
        ended_after: Number of runs after which Ctrl-C comes.
    """

    def __init__(self, ended_after=math.inf):
        self.left = ended_after

    def compute(self, setup, runs):
        for one in runs:
            if self.left == 0:
                raise KeyboardInterrupt
            self.left -= 1
            yield work(setup, one)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "small.fz").write_text(FILE, encoding="utf-8")
    return tmp_path


def swept(folder, text=SPEC, overrides=(), resume=False, workers=None):
    """Return the rows of a sweep, one for each run."""
    (folder / "spec.toml").write_text(text, encoding="utf-8")
    file = read(folder / "spec.toml")
    made = sweep_plan.make(Loops(against(file)), file, overrides)
    about = sweep_journal.describe(file, made, overrides)
    sweep_run.run(made, file.spec.measures, about, folder / "out", workers=workers or Here(), resume=resume)
    with (folder / "out" / "results.csv").open(newline="", encoding="utf-8") as source:
        return list(csv.DictReader(source))


def planned(folder, text=SPEC, overrides=()):
    (folder / "spec.toml").write_text(text, encoding="utf-8")
    file = read(folder / "spec.toml")
    return sweep_plan.make(Loops(against(file)), file, overrides)


def mistakes(folder, text=SPEC, overrides=()):
    with pytest.raises(DiagnosticError) as caught:
        planned(folder, text, overrides)
    return caught.value.diagnostics


class TestRuns:
    def test_are_those_of_simulate_with_the_same_values(self, folder):
        rows = swept(folder)
        assert [(row["law.K"], row["repetition"]) for row in rows] == [(k, r) for k in ("1.0", "2.0") for r in "012"]
        loop = fuzzyctl.load(folder / "small.fz", block=fuzzyctl.Loop)
        row = rows[4]
        given = {name: float(row[name]) for name in ("law.K", "p.T", "p.begin")}
        once = fuzzyctl.simulation.loop_params.with_settings(loop, given)
        found = fuzzyctl.Experiment(once).run(seed=int(row["noise.seed"]))
        assert float(row["error"]) == pytest.approx(found.measures["error"], rel=1e-13)
        assert row["require error <= 1.2"] == str(found.passed).lower()

    def test_all_points_of_the_grid_meet_the_same_draws(self, folder):
        rows = swept(folder)
        for name in ("p.T", "p.begin", "noise.seed"):
            assert [r[name] for r in rows[:3]] == [r[name] for r in rows[3:]]
            assert len({r[name] for r in rows}) == 3

    def test_one_run_has_the_noise_of_the_file(self, folder):
        (row,) = swept(folder, 'scenario = "small.fz"\n')
        found = fuzzyctl.simulate(fuzzyctl.load(folder / "small.fz", block=fuzzyctl.Loop), backend="numba")
        assert float(row["error"]) == found.measures["error"]
        (other,) = swept(folder, 'scenario = "small.fz"\n[set]\n"noise.seed" = 7\n')
        assert other["error"] != row["error"]

    def test_a_compiled_loop_serves_all_values_of_free_params(self, folder):
        made = planned(folder)
        loops = made.runnable
        ready = []
        for one in made.runs:
            scenario = loops.read(one.path, one.overrides)
            loops.prepare(scenario, one.controller, ())
            ready.append(loops.known.experiments["small"][1])
        # the start of a state is a constant of what is compiled
        assert ready[0].nominal.keys() == {"law.K", "p.T"}

    def test_results_name_units_and_sources(self, folder):
        swept(folder)
        about = json.loads((folder / "out" / "sweep.json").read_text(encoding="utf-8"))
        columns = {name: one["unit"] for name, one in about["columns"].items() if one["unit"]}
        assert columns == {"p.T": "s", "t_end": "s", "end_value": "m", "error": "m s"}
        assert about["scenario"]["text"][0] == {"file": "small.fz", "text": FILE}

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

    def test_the_journal_keeps_what_is_done(self, folder):
        whole = swept(folder)
        (folder / "out" / "results.csv").rename(folder / "whole.csv")
        (folder / "out" / "sweep.json").unlink()
        (folder / "out" / "times.csv").unlink()
        with pytest.raises(InterruptedSweepError, match="4 of 6 runs are kept"):
            swept(folder, workers=Here(4))
        assert swept(folder, resume=True, workers=Here(2)) == whole
        assert (folder / "out" / "results.csv").read_bytes() == (folder / "whole.csv").read_bytes()

    def test_workers_get_a_copy_without_what_this_process_knows(self, folder):
        made = planned(folder)
        copy = pickle.loads(pickle.dumps(made.runnable))
        assert copy == made.runnable
        assert made.runnable.known.files
        assert not copy.known.files

    def test_a_process_of_its_own_computes_the_same(self, folder):
        whole = swept(folder)
        assert swept(folder, workers=sweep_run.Workers(jobs=1)) == whole

    def test_params_of_controllers_inside_controllers_vary(self, folder):
        outer = "controller outer\ninput r\ninput y\nblock a = law(r, y, K=3)\nblock b = law(r, y)\n"
        text = FILE.replace("\nplant p", f"{outer}output u = a.u + b.u\nevery 0.1 s\n\nplant p")
        (folder / "small.fz").write_text(text.replace("block law = law(", "block law = outer("), encoding="utf-8")
        spec = 'scenario = "small.fz"\n[set]\nlaw.b.K = 2\n[grid]\nlaw.a.K = [1.0, 4.0]\n'
        errors = [row["error"] for row in swept(folder, spec)]
        loop = fuzzyctl.load(folder / "small.fz", block=fuzzyctl.Loop)
        runs = [fuzzyctl.simulate(loop, **{"law.a.K": k, "law.b.K": 2}) for k in (1, 4)]
        assert [float(e) for e in errors] == pytest.approx([run.measures["error"] for run in runs], rel=1e-13)
        (folder / "out" / "results.csv").unlink()
        drawn = 'scenario = "small.fz"\n[random]\n"law.*.K" = { uniform = [1.0, 2.0], relative = "factor" }\n'
        (row,) = swept(folder, drawn)
        assert 3 <= float(row["law.a.K"]) <= 6
        assert 1 <= float(row["law.b.K"]) <= 2
        (found,) = mistakes(folder, spec.replace("4.0", "40"))
        assert found.message == "run 1: param 'law.a.K' is 40, outside of (0, 20]"


class TestFiles:
    def test_a_used_file_that_changed_is_refused(self, folder):
        laws, rest = FILE.split("plant p")
        (folder / "laws.fz").write_text(laws, encoding="utf-8")
        (folder / "small.fz").write_text(f'use "laws.fz"\n\nplant p{rest}', encoding="utf-8")
        with pytest.raises(InterruptedSweepError):
            swept(folder, workers=Here(4))
        (folder / "laws.fz").write_text(laws.replace("K * (r", "1.5 * K * (r"), encoding="utf-8")
        with pytest.raises(DiagnosticError) as caught:
            swept(folder, resume=True)
        (found,) = caught.value.diagnostics
        assert found.code == "FZ909"
        assert "file laws.fz" in found.facts[0]
        assert (folder / "out" / "journal.jsonl").exists()

    def test_a_table_that_changes_while_the_sweep_runs_ends_it(self, folder):
        (folder / "r.csv").write_text("t,r\n0,1\n2,1\n", encoding="utf-8")
        text = FILE.replace("height * steps(0: 1)", 'csv("r.csv", column="r")')
        (folder / "small.fz").write_text(text, encoding="utf-8")
        made = planned(folder)
        assert set(made.used) == {"r.csv"}
        (folder / "r.csv").write_text("t,r\n0,2\n2,1\n", encoding="utf-8")
        with pytest.raises(SweepError, match=r"r\.csv changed while the sweep ran"):
            sweep_run.run(made, (), {}, folder / "out", workers=Here())

    def test_a_plant_in_python_that_raises_is_a_row(self, folder):
        code = 'inputs = ("u",)\nstates = {"x": 0.0}\noutputs = ("y",)\n\ndef derivative(t, x, u):\n'
        code += "    return (1 / (t - 1.05) * 0 + u[0],) if t < 1 else 1 / 0\n\ndef output(t, x):\n    return x\n"
        (folder / "p.py").write_text(code, encoding="utf-8")
        head, tail = FILE.split("plant p")
        (folder / "small.fz").write_text(f'{head}plant p = python("p.py")\n\nloop {tail.split("loop ")[1]}')
        (row,) = swept(folder, 'scenario = "small.fz"\n')
        assert row["stop_reason"] == "'derivative' of plant 'p' raised ZeroDivisionError"

    def test_an_fmu_has_its_own_params_in_each_run_and_is_not_changed(self, folder):
        pytest.importorskip("fmpy")
        if compiler() is None:
            pytest.skip("there is no C compiler")
        plant = plant_fmu("plant p\ninput u\nparam T = 1\nstate x = 0\nder x = (u - x) / T\noutput y = x\n")
        (folder / "p.fmu").write_bytes(fmu(plant, 3).data)
        loop = "loop l\nblock p = p(1)\nmeasure end_value = final(p.y)\nrun 1 s step 0.1 s\n"
        (folder / "small.fz").write_text(f'plant p = fmu("p.fmu")\nparam T = 3\n\n{loop}', encoding="utf-8")
        text = 'scenario = "small.fz"\n[grid]\n"p.T" = [1.0, 2.0]\n'
        rows = swept(folder, text)
        assert [float(row["end_value"]) for row in rows] == pytest.approx([1 - math.exp(-1 / T) for T in (1, 2)])
        (folder / "out" / "sweep.json").unlink()
        for one in ("results.csv", "times.csv"):
            (folder / "out" / one).unlink()
        with pytest.raises(InterruptedSweepError):
            swept(folder, text, workers=Here(1))
        with zipfile.ZipFile(folder / "p.fmu", "a") as changed:
            changed.writestr("extra/note.txt", "another version")
        with pytest.raises(DiagnosticError) as caught:
            swept(folder, text, resume=True)
        assert "file p.fmu" in caught.value.diagnostics[0].facts[0]

    def test_an_fmu_that_crashes_is_a_row_and_the_sweep_goes_on(self, folder, monkeypatch):
        pytest.importorskip("fmpy")
        if compiler() is None:
            pytest.skip("there is no C compiler")

        def crashing(model, version):
            texts, call = sources(model, version), '    static const char call[] = "fmi3DoStep";\n'
            crash = "    static const fmi3ValueReference first[] = {FMU_FIRST_PARAM};\n    double T;\n"
            crash += '    fmu_get(instance, "own", first, 1, &T);\n    if (T == 2.0) { abort(); }\n'
            return texts | {"fmi3.c": texts["fmi3.c"].replace(call, crash + call)}

        monkeypatch.setattr("fuzzyctl.codegen.fmu.archive.sources", crashing)
        plant = plant_fmu("plant p\ninput u\nparam T = 1\nstate x = 0\nder x = (u - x) / T\noutput y = x\n")
        (folder / "p.fmu").write_bytes(fmu(plant, 3).data)
        loop = "loop l\nblock p = p(1)\nmeasure end_value = final(p.y)\nrun 1 s step 0.1 s\n"
        (folder / "small.fz").write_text(f'plant p = fmu("p.fmu")\nparam T = 3\n\n{loop}', encoding="utf-8")
        workers = SimpleNamespace(compute=partial(sweep_workers.compute, jobs=1))
        rows = swept(folder, 'scenario = "small.fz"\n[grid]\n"p.T" = [1.0, 2.0, 0.5]\n', workers=workers)
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
        ],
    )  # fmt: skip
    def test_stand_at_their_line(self, folder, old, new, line, words):
        assert old in SPEC
        found = mistakes(folder, SPEC.replace(old, new))
        lines = [(f"{one.message} {one.help}", one.span.line if one.span else 0) for one in found]
        assert any(words in text and at == line for text, at in lines), lines

    def test_a_param_given_by_two_names_is_refused(self, folder):
        with pytest.raises(OverrideError, match=r"law\.K is given twice"):
            planned(folder, 'scenario = "small.fz"\n', ["K=1", "law.K=2"])

    def test_a_file_without_loops(self, folder):
        (folder / "small.fz").write_text(FILE.split("loop small")[0], encoding="utf-8")
        (found,) = mistakes(folder, 'scenario = "small.fz"\n')
        assert (found.code, found.message) == ("FZ502", "the file holds no loop")

    def test_mistakes_of_the_file_are_its_own(self, folder):
        (folder / "small.fz").write_text(FILE.replace("der x", "dre x"), encoding="utf-8")
        assert all(one.span.source.name.endswith("small.fz") for one in mistakes(folder))

    def test_a_measure_with_the_name_of_a_column(self, folder):
        (folder / "small.fz").write_text(FILE.replace("error", "stopped"), encoding="utf-8")
        (found,) = mistakes(folder, 'scenario = "small.fz"\n')
        assert found.message == "'stopped' is taken"

    def test_values_that_do_not_fit_together_are_found_before_the_first_run(self, folder):
        text = FILE.replace("every 0.1 s", "param dT = 0.1\nevery dT").replace("run 2 s", "run 2 s step 50 ms")
        (folder / "small.fz").write_text(text, encoding="utf-8")
        found = mistakes(folder, 'scenario = "small.fz"\n[grid]\n"law.dT" = [0.1, 0.12]\n')
        assert [(one.code, one.message[:6]) for one in found] == [("FZ702", "run 1:")]

    def test_what_varies_in_vain_is_a_warning(self, folder):
        (folder / "small.fz").write_text(FILE.replace("noise(sigma=0.01, seed=1)", "0"), encoding="utf-8")
        (found,) = planned(folder, 'scenario = "small.fz"\n[grid]\n"noise.seed" = [1, 2]\n').warnings
        assert "no run reads a seed of noise" in found.message


def test_a_loop_that_differs_between_files_has_no_common_value(folder):
    (folder / "other.fz").write_text(FILE.replace("= 1 unit", "= 3 unit"), encoding="utf-8")
    loops = Loops((folder / "other.fz",))
    settings = loops.read(folder / "small.fz", ()).settings
    assert settings["law"] == {"K": 1.0}
    assert settings["p"] == {"begin": 0.0}
    assert dataclasses.replace(loops) == loops
