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
from matplotlib.figure import Figure

from dwmr.cli.main import main
from dwmr.core import jit
from dwmr.simulation import simulate
from tests.dwmr.process import LONG, dwmr, here
from tests.dwmr.scenarios import PAPER, edited, edited_rules

NAMES = ("summary.json", "trajectory.npz", "path.png", "errors.png")
FILES = sorted(NAMES)


class TestOddValues:
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
        draw = Figure.savefig

        def fail(figure, path, **options):
            if path.name == "path.png":
                raise np.linalg.LinAlgError("Singular matrix")
            draw(figure, path, **options)

        monkeypatch.setattr(Figure, "savefig", fail)
        with pytest.raises(SystemExit) as stop:
            main(["run", "paper", "--set", "run.horizon=0.1", "-o", str(tmp_path)])
        assert stop.value.code == 0
        assert sorted(p.name for p in tmp_path.iterdir()) == ["errors.png", "summary.json", "trajectory.npz"]
        assert "path.png could not be drawn: Singular matrix" in capsys.readouterr().err

    def test_summary_has_the_checksums_of_all_files_that_the_run_has_read(self, tmp_path):
        edited(PAPER, tmp_path / "mine.toml", ('file = "fcafsmc.fz"', 'file = "nowhere.fz"'))
        warning = ("PM  PS  ZO\n", "PS  PS  ZO\n")
        edited_rules(tmp_path, "ais_reaction.fz", warning)
        edited_rules(tmp_path, "boundary_layer.fz", ("input abs_sigma", 'use "shared.fz"\n\ninput abs_sigma'))

        def rules():
            options = ("--rules", tmp_path, "--set", "run.horizon=0.1", "--format", "json", "-o", tmp_path / "o")
            done = here("run", tmp_path / "mine.toml", *options)
            assert done.stderr.count("warning[FZ208]") == 1
            return json.loads(done.stdout)["rules"]

        (tmp_path / "shared.fz").write_text("param unused = 1\n", encoding="utf-8")
        before = rules()
        (tmp_path / "shared.fz").write_text("param unused = 2\n", encoding="utf-8")
        after = rules()
        assert list(before) == ["ais_reaction", "boundary_layer"]
        assert list(after["boundary_layer"]["files"]) == ["boundary_layer.fz", "shared.fz"]
        changed = [n for n, d in after["boundary_layer"]["files"].items() if d != before["boundary_layer"]["files"][n]]
        assert changed == ["shared.fz"]
        assert after["boundary_layer"]["sha256"] != before["boundary_layer"]["sha256"]
        assert after["ais_reaction"] == before["ais_reaction"]
        (digest,) = after["ais_reaction"]["files"].values()
        assert digest == after["ais_reaction"]["sha256"]


def test_memory_counts_laws_and_signals(tmp_path, monkeypatch):
    needed = 8 * 201 * 3 * ((20 + 14) + (20 + 2))
    options = ("--set", "run.horizon=1", "-o", tmp_path)
    monkeypatch.setattr(simulate, "MOST_MEMORY", needed - 1)
    assert "2 control laws" in here("run", "paper", "--controller", "aifqsmc,smc", *options, status=1).stderr
    here("run", "paper", "--controller", "smc", *options)
    monkeypatch.setattr(simulate, "MOST_MEMORY", needed)
    here("run", "paper", "--controller", "aifqsmc,smc", *options)


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
    @pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
    def test_while_files_are_written_waits(self, tmp_path, monkeypatch, number):
        write = np.savez

        def interrupted(*arguments, **arrays):
            os.kill(os.getpid(), number)
            write(*arguments, **arrays)

        monkeypatch.setattr(np, "savez", interrupted)
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
