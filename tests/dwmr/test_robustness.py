"""Odd input, odd surroundings and interruptions: an answer, no traceback, and nothing half-written."""

import json
import os
import re
import runpy
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from dwmr.cli.main import main
from dwmr.control.fuzzy_gains import Rules
from dwmr.control.laws import python_law
from dwmr.core import jit
from dwmr.scenario.file import find, read
from dwmr.simulation import simulate
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.support.shipped import rules_folder
from tests.dwmr.process import LONG, dwmr, here

PAPER = find("paper")
NAMES = ("summary.json", "trajectory.npz", "path.png", "errors.png")
FILES = sorted(NAMES)


class TestOddValues:
    @pytest.mark.parametrize(
        ("value", "status", "words"),
        [
            ("run.horizon=" + "1" * 5000, 2, "too many digits"),
            ("run.horizon=0x" + "f" * 5000, 1, "thousands of digits"),
            ("run.horizon=" + "[" * 5000, 2, "nested too deeply"),
            (".".join(["a"] * 3000) + "=1", 2, "3000 parts"),
            ("run.horizon=2\nrun.dt=1", 2, "line break"),
            ("robot=5", 1, "robot must be a table, got 5"),
            (
                "rules.ais_raction.k_s=0.5",
                1,
                "--set rules.ais_raction.k_s=0.5: error[FZ902]: unknown key",
            ),
            ("rules.ais_reaction.f_max=0.1", 1, "set k_h_min, G_min, k_s instead"),
            ("rules.ais_reaction.file=" + "a" * 5000, 1, "does not exist"),
            ("avoidance.largest_radius=0.4", 1, "no robot would ever avoid it"),
            ("run.dt=1e-300", 1, "run.dt must be >= 1e-06 s"),
        ],
    )
    def test_are_answered(self, tmp_path, value, status, words):
        done = here("run", "paper", "--set", value, "-o", tmp_path / "out", status=status)
        assert words in done.stderr
        assert list(tmp_path.iterdir()) == []

    def test_given_twice_are_refused(self):
        done = here("run", "paper", "--set", "run.horizon=1", "--set", "run.horizon=2", status=2)
        assert "run.horizon is given twice" in done.stderr

    def test_a_whole_number_of_5000_digits_in_the_file(self, tmp_path):
        path = tmp_path / "x.toml"
        path.write_text("x = " + "1" * 5000, encoding="utf-8")
        with pytest.raises(DiagnosticError, match="too many digits"):
            read(path)

    def test_what_every_robot_lacks_shows_once(self, tmp_path):
        path = tmp_path / "x.toml"
        path.write_text(PAPER.read_text(encoding="utf-8").replace("mass = 120.0 ", "#"), encoding="utf-8")
        with pytest.raises(DiagnosticError) as caught:
            read(path)
        (one,) = caught.value.diagnostics
        assert one.message == "robot.mass is missing"
        assert "[robot]" in one.span.source.line_text(one.span.line)

    def test_a_horizon_between_two_periods_is_said(self):
        (one,) = read(PAPER, ["run.horizon=1.003"]).warnings
        assert one.severity == "warning"
        assert "the run ends at 1.005 s" in one.message
        assert read(PAPER, ["run.horizon=60"]).warnings == ()

    @pytest.mark.parametrize("name", ["a" * 5000, "/".join(["a" * 200] * 40)])
    def test_long_scenario_names_and_folders(self, name):
        here("run", name, status=2)
        done = here("run", "paper", "--set", "run.horizon=1", "-o", name, status=1)
        assert "cannot be written" in done.stderr

    def test_endless_and_silent_files_are_refused_at_once(self, tmp_path):
        os.mkfifo(tmp_path / "pipe")
        for path in ("/dev/zero", tmp_path / "pipe"):
            done = dwmr("run", path, status=1)
            assert "not a regular file" in done.stderr

    @pytest.mark.parametrize(
        "key",
        ["robots.leader.x_0", "robots.follower1.theta_0", "obstacles.0.y", "robot.noise.v", "reference.amplitude_x",
         "obstacles.1.radius", "robots.follower1.formation.separation"],
    )  # fmt: skip
    def test_places_and_lengths_beyond_all_maps_are_refused(self, key):
        with pytest.raises(DiagnosticError) as caught:
            read(PAPER, [f"{key}=1.1e9"])
        assert any(f"{key} must be <= 1e+09" in d.message for d in caught.value.diagnostics)

    @pytest.mark.parametrize(
        ("value", "stops"),
        [("robots.leader.x_0=1e9", True), ("robot.radius=1e308", False), ("reference.amplitude_x=1e9", False)],
    )
    def test_huge_numbers_cost_a_picture_at_most(self, tmp_path, value, stops):
        done = here("run", "paper", "--set", "run.horizon=0.1", "--set", value, "-o", tmp_path, status=int(stops))
        stopped = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["controllers"]["aifqsmc"][
            "stopped"
        ]
        assert (stopped is not None) == stops
        assert (tmp_path / "trajectory.npz").exists()
        missing = set(FILES) - {p.name for p in tmp_path.iterdir()}
        assert all(f"{name} could not be drawn" in done.stderr for name in missing)


class TestOutput:
    def test_without_greek_letters_spells_them(self, tmp_path):
        arguments = ["run", "paper", "--set", "run.horizon=0.1", "-o", str(tmp_path)]
        done = CliRunner(charset="ascii").invoke(main, arguments)
        assert "theta_e" in done.stdout

    @pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
    def test_that_is_full_is_said(self, tmp_path, monkeypatch, capsys):
        with open("/dev/full", "w") as full:
            monkeypatch.setattr(sys, "stdout", full)
            with pytest.raises(SystemExit) as stop:
                main(["run", "paper", "--set", "run.horizon=0.1", "-o", str(tmp_path)])
        assert stop.value.code == 1
        assert "No space left on device" in capsys.readouterr().err
        assert sorted(p.name for p in tmp_path.iterdir()) == FILES

    @pytest.mark.long
    @pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
    @pytest.mark.parametrize("style", ["text", "json"])
    def test_of_a_process_that_is_full_is_said(self, tmp_path, style):
        with open("/dev/full", "w") as full:
            done = dwmr(
                "run", "paper", "--set", "run.horizon=0.1", "-o", tmp_path, "--format", style, stdout=full, status=1
            )
        assert "No space left on device" in done.stderr
        assert sorted(p.name for p in tmp_path.iterdir()) == FILES


class TestFolder:
    def test_with_a_folder_in_the_way_is_refused_before_the_run(self, tmp_path):
        (tmp_path / "path.png").mkdir()
        done = here("run", "paper", "-o", tmp_path, status=1)
        assert "path.png cannot be written: it is a folder" in done.stderr
        assert [p.name for p in tmp_path.iterdir()] == ["path.png"]

    def test_a_picture_that_cannot_be_drawn_costs_nothing_else(self, tmp_path, monkeypatch, capsys):
        from dwmr import figures

        def fail(target, trajectories, scenario):
            raise np.linalg.LinAlgError("Singular matrix")

        monkeypatch.setattr(figures, "draw_path", fail)
        with pytest.raises(SystemExit) as stop:
            main(["run", "paper", "--set", "run.horizon=0.1", "-o", str(tmp_path)])
        assert stop.value.code == 0
        assert sorted(p.name for p in tmp_path.iterdir()) == ["errors.png", "summary.json", "trajectory.npz"]
        assert "path.png could not be drawn: Singular matrix" in capsys.readouterr().err

    def test_summary_names_the_rule_files_that_were_used(self, tmp_path):
        edited = PAPER.read_text(encoding="utf-8").replace('file = "fcafsmc.fz"', 'file = "nowhere.fz"')
        (tmp_path / "mine.toml").write_text(edited, encoding="utf-8")
        done = here("run", tmp_path / "mine.toml", "--set", "run.horizon=0.1", "--format", "json", "-o", tmp_path / "o")
        assert list(json.loads(done.stdout)["rules"]) == ["ais_reaction", "boundary_layer"]

    def test_summary_has_the_checksums_of_all_that_a_rule_file_reads(self, tmp_path):
        text = (rules_folder() / "boundary_layer.fz").read_text(encoding="utf-8")
        head, mark, tail = text.partition("input abs_sigma")
        (tmp_path / "boundary_layer.fz").write_text(f'use "shared.fz"\n\n{head}{mark}{tail}', encoding="utf-8")

        def rules():
            options = ("--rules", tmp_path, "--set", "run.horizon=0.1", "--format", "json", "-o", tmp_path / "o")
            done = here("run", "paper", *options)
            return json.loads(done.stdout)["rules"]

        (tmp_path / "shared.fz").write_text("param unused = 1\n", encoding="utf-8")
        before = rules()
        (tmp_path / "shared.fz").write_text("param unused = 2\n", encoding="utf-8")
        after = rules()
        assert list(after["boundary_layer"]["files"]) == ["boundary_layer.fz", "shared.fz"]
        changed = [n for n, d in after["boundary_layer"]["files"].items() if d != before["boundary_layer"]["files"][n]]
        assert changed == ["shared.fz"]
        assert after["boundary_layer"]["sha256"] != before["boundary_layer"]["sha256"]
        assert after["ais_reaction"] == before["ais_reaction"]
        (digest,) = after["ais_reaction"]["files"].values()
        assert digest == after["ais_reaction"]["sha256"]


class TestRuleFolder:
    def test_that_holds_nothing_of_use_is_refused(self, tmp_path):
        done = here("run", "paper", "--rules", tmp_path, "-o", tmp_path / "out", status=1)
        assert "looked for ais_reaction.fz, boundary_layer.fz, fcafsmc.fz" in done.stderr

    def test_warnings_of_its_files_show_once(self, tmp_path):
        text = (rules_folder() / "ais_reaction.fz").read_text(encoding="utf-8")
        (tmp_path / "ais_reaction.fz").write_text(text.replace("PM  PS  ZO\n", "PS  PS  ZO\n"), encoding="utf-8")
        done = here("run", "paper", "--rules", tmp_path, "--set", "run.horizon=0.1", "-o", tmp_path / "out")
        assert done.stderr.count("warning[FZ208]") == 1


class TestMemory:
    def test_counts_laws_and_signals(self, monkeypatch):
        file = read(PAPER, ["run.horizon=1"])
        rules = Rules(file.scenario.rules, (), file.places)
        runs = [simulate.prepare(file, law, rules) for law in ("aifqsmc", "smc")]
        needed = 8 * 201 * 3 * ((20 + 14) + (20 + 2))
        monkeypatch.setattr(simulate, "MOST_MEMORY", needed)
        simulate.require_memory(runs, file.places)
        monkeypatch.setattr(simulate, "MOST_MEMORY", needed - 1)
        simulate.require_memory(runs[:1], file.places)
        with pytest.raises(DiagnosticError, match="2 control laws"):
            simulate.require_memory(runs, file.places)


#: What a law in Python has beside its signals.
PARTS = """from types import SimpleNamespace
Settings = init = step = None
FAULTS = {}
def S(name):
    return SimpleNamespace(name=name)
"""


class TestLawFile:
    @pytest.mark.parametrize(
        ("text", "words"),
        [
            ("x = 1\nraise RuntimeError('no luck')\n", "RuntimeError: no luck"),
            ("def f(:\n", "SyntaxError"),
            ("import nosuchmodule\n", "No module named 'nosuchmodule'"),
            ("SIGNALS = ()\n", "has no Settings, FAULTS, init, step"),
            (f"{PARTS}SIGNALS = (S('x'),)\n", "signal 'x' of the control law broken has the name of another column"),
            (f"{PARTS}SIGNALS = (S('t'),)\n", "rename it, as to t_law"),
            (f"{PARTS}SIGNALS = (S('a'), S('a'))\n", "the control law broken has two signals 'a'"),
            (f"{PARTS}SIGNALS = ('a',)\n", "cannot be checked"),
        ],
    )
    def test_that_cannot_be_imported_is_named(self, tmp_path, text, words):
        (tmp_path / "broken.py").write_text(text, encoding="utf-8")
        with pytest.raises(DiagnosticError, match="broken") as caught:
            python_law.load("broken", tmp_path / "broken.py")
        assert words in str(caught.value)
        assert str(tmp_path / "broken.py") in caught.value.diagnostics[0].place


def test_without_a_home_functions_are_compiled_for_one_process(monkeypatch):
    def none():
        raise RuntimeError("Could not determine home directory.")

    for name in ("FUZZYCTL_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(jit.Path, "home", none)
    jit._cache_folder.cache_clear()
    try:
        assert jit.compiled(lambda x: 2.0 * x)(21.0) == 42.0
    finally:
        jit._cache_folder.cache_clear()


@pytest.mark.skipif(not jit.COMPILED, reason="needs numba")
@pytest.mark.parametrize(
    ("suffix", "length"),
    [*(pytest.param(*one, marks=pytest.mark.long) for one in (("nbi", 0), ("nbc", 40))), ("nbc", -1)],
)
def test_a_damaged_cache_is_compiled_anew(tmp_path, monkeypatch, suffix, length):
    code = "from dwmr.core.jit import compiled\n@compiled\ndef f(x):\n    return 2.0 * x\n"
    (tmp_path / "m.py").write_text(code, encoding="utf-8")
    monkeypatch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(jit, "_cache_folder", jit._cache_folder.__wrapped__)

    def hits():
        f = runpy.run_path(str(tmp_path / "m.py"))["f"]
        assert f(21.0) == 42.0
        return sum(f.stats.cache_hits.values())

    assert [hits(), hits()] == [0, 1]
    damaged = list((tmp_path / "cache").rglob(f"*.{suffix}"))
    assert damaged
    for path in damaged:
        path.write_bytes(path.read_bytes()[:length] + (b"?" if length < 0 else b""))
    assert [hits(), hits()] == [0, 1]


class TestInterruption:
    def test_in_a_later_law_keeps_the_finished_ones(self, tmp_path, monkeypatch, capsys):
        finish = simulate.run

        def run(simulation, report=None):
            if simulation.name == "fcafsmc":
                raise KeyboardInterrupt
            return finish(simulation, report)

        monkeypatch.setattr(simulate, "run", run)
        arguments = ["run", "paper", "--controller", "all", "--set", "run.horizon=0.1", "-o", str(tmp_path)]
        with pytest.raises(SystemExit) as stop:
            main(arguments)
        assert stop.value.code == 130
        assert list(json.loads((tmp_path / "summary.json").read_text())["controllers"]) == ["aifqsmc"]
        assert "fcafsmc was not run: interrupted" in capsys.readouterr().err

    def test_before_anything_is_done_leaves_nothing(self, tmp_path, monkeypatch):
        def run(simulation, report=None):
            raise KeyboardInterrupt

        monkeypatch.setattr(simulate, "run", run)
        with pytest.raises(SystemExit) as stop:
            main(["run", "paper", "-o", str(tmp_path / "out")])
        assert stop.value.code == 130
        assert list(tmp_path.iterdir()) == []

    @pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
    def test_while_files_are_written_waits(self, tmp_path, monkeypatch, number):
        from dwmr.output import data

        write = data.write_trajectories

        def interrupted(*arguments):
            os.kill(os.getpid(), number)
            write(*arguments)

        monkeypatch.setattr(data, "write_trajectories", interrupted)
        with pytest.raises(SystemExit) as stop:
            main(["run", "paper", "--set", "run.horizon=0.1", "-o", str(tmp_path)])
        assert stop.value.code == 130
        assert sorted(p.name for p in tmp_path.iterdir()) == FILES

    @pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.long)])
    def test_keeps_what_is_done_even_without_the_compiler(self, tmp_path, number):
        code = (
            "import os, sys; sys.modules['numba'] = None\n"
            "from dwmr.cli.main import main\nfrom dwmr.simulation import periods\n"
            "plain = periods.run_periods\n"
            "def run_periods(first, last, *rest):\n"
            "    if first > 4:\n"
            "        print('interrupted at', first, flush=True)\n"
            f"        os.kill(os.getpid(), {number:d})\n"
            "    return plain(first, last, *rest)\n"
            "periods.run_periods = run_periods\n"
            "main(sys.argv[1:])\n"
        )
        arguments = ["run", "paper", "--controller", "smc", "-o", str(tmp_path)]
        done = subprocess.run(
            [sys.executable, "-c", code, *arguments], capture_output=True, text=True, timeout=LONG, check=False
        )
        assert done.returncode == 130, done.stderr
        assert "Traceback" not in done.stderr
        # A single line: not another period is computed after the signal.
        (reached,) = re.findall(r"^interrupted at (\d+)$", done.stdout, flags=re.MULTILINE)
        stopped = json.loads((tmp_path / "summary.json").read_text())["controllers"]["smc"]["stopped"]
        assert stopped == {"t": (int(reached) - 1) * 0.005, "robot": None, "reason": "interrupted"}
        assert sorted(p.name for p in tmp_path.iterdir()) == FILES
