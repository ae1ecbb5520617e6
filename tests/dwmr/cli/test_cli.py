import io
import json
import subprocess
import sys

import click
import numpy as np
import pytest

from dwmr.cli import run_options
from dwmr.cli.main import COMMANDS, main
from dwmr.scenario.file import find
from fuzzyctl.support.shipped import rules_folder
from tests.commands import commands_of
from tests.dwmr.process import LONG, here, in_short

PAPER = find("paper")
MASS_LINE = PAPER.read_text(encoding="utf-8").split("mass = 120.0")[0].count("\n") + 1


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Results of one short run of all laws."""
    folder = tmp_path_factory.mktemp("run")
    done = in_short("run", "paper", "--controller", "all", "--set", "run.horizon=3", "-o", folder)
    return folder, done


class TestHelp:
    def test_teaches_by_example(self):
        done = here("--help")
        assert "dwmr run paper --controller all" in done.stdout

    def test_no_line_of_the_list_of_commands_is_cut(self):
        lines = here("--help").stdout.partition("Commands:\n")[2].splitlines()
        assert len(lines) == len(commands_of(main)) == 10
        for line in lines:
            assert line.endswith(f"  {COMMANDS[line.split()[0]][2]}")
            assert line.endswith(".")
            assert not line.endswith("..")


class TestRun:
    def test_shows_the_errors_of_all_robots(self, short):
        _, done = short
        for word in ("aifqsmc", "fcafsmc", "smc", "follower2", "G_AIS"):
            assert word in done.stdout
        assert done.stderr == ""

    def test_shows_whether_v_falls_and_whether_the_gains_drift(self, short):
        assert "dV/dt > 0" in short[1].stdout
        runs = json.loads((short[0] / "summary.json").read_text(encoding="utf-8"))["controllers"]
        shown = f"{100 * runs['aifqsmc']['lyapunov']['leader']['V_dot_23_positive']:.1f}"
        row = next(line for line in short[1].stdout.split("Stability")[1].splitlines() if line.startswith("aifqsmc"))
        assert shown in row.split()
        assert f"{runs['aifqsmc']['drift']['leader']['k_h_omega']['final']:.3f}" in row.split()

    def test_all_laws_are_those_of_the_paper(self, short):
        assert list(json.loads((short[0] / "summary.json").read_text(encoding="utf-8"))["controllers"]) == [
            "aifqsmc", "fcafsmc", "smc"
        ]  # fmt: skip

    def test_ablations_run_beside_the_whole_law(self, tmp_path):
        done = here("run", "paper", "--controller", "ablations", "--set", "run.horizon=1", "-o", tmp_path)
        runs = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["controllers"]
        assert list(runs) == ["aifqsmc", *(f"aifqsmc_without_{p}" for p in ("adaptation", "immunity", "layer"))]
        assert runs["aifqsmc_without_adaptation"]["drift"]["leader"]["k_h_v"]["largest"] == 0.1
        assert max(len(line) for line in done.stdout.partition("results in")[0].splitlines()) <= 80

    def test_several_laws_are_separated_by_commas(self):
        task = run_options.read("paper", None, ())
        assert run_options.laws_of(task, "smc, aifqsmc_without_layer") == ("smc", "aifqsmc_without_layer")
        assert run_options.laws_of(task, "smc,all") == ("smc", "aifqsmc", "fcafsmc")
        with pytest.raises(click.BadParameter, match="'pid' is not one of"):
            run_options.laws_of(task, "smc,pid")

    def test_a_short_run_is_not_compared_with_the_paper(self, short):
        assert "Table 12" not in short[1].stdout

    def test_a_whole_run_is_compared_with_the_paper(self, tmp_path):
        done = here("run", "paper", "-o", str(tmp_path))
        for word in ("Table 12", "0.5399", "ratio"):
            assert word in done.stdout

    def test_only_laws_that_reached_the_end_are_compared_with_the_paper(self):
        from rich.console import Console

        from dwmr.output.report import print_report

        values = dict.fromkeys(("x_e", "y_e", "theta_e"), 0.5)
        run = {
            "rmse": {"leader": values}, "avoidance_s": {"leader": 0.0}, "obstacles_hit": [], "robots_hit": [],
            **{name: {"leader": None} for name in ("centre_distance", "obstacle_gap", "robot_gap")},
            "chattering": {"leader": {"v": 0.0, "omega": 0.0}}, "condition_violated": {},
            "saturation": {"leader": dict.fromkeys(("v", "omega", "torque"), 0.0)}, "wall_s": 0.1, "stopped": None,
        }  # fmt: skip
        stopped = {**run, "stopped": {"t": 150.0, "robot": "leader", "reason": "it fell over"}}
        out = Console(width=100, record=True, file=io.StringIO())
        print_report(out, {"controllers": {"aifqsmc": stopped, "fcafsmc": run}}, printed=12)
        text = out.export_text()
        assert "0.5399" not in text
        assert "0.4519" in text

    def test_writes_the_four_files_and_nothing_else(self, short):
        folder, _ = short
        assert sorted(p.name for p in folder.iterdir()) == ["errors.png", "path.png", "summary.json", "trajectory.npz"]

    def test_summary_has_every_promised_entry(self, short):
        summary = json.loads((short[0] / "summary.json").read_text(encoding="utf-8"))
        for law, run in summary["controllers"].items():
            for section in ("rmse", "rmse_body", "rmse_inertial"):
                for robot in ("leader", "follower1", "follower2"):
                    assert {"x_e", "y_e", "theta_e", "theta_e_star", "theta_e_unwrapped"} <= run[section][robot].keys()
            assert run["steps"] == 600
            assert run["centre_distance"].keys() == {"leader", "follower1", "follower2"}
            assert run["chattering"]["leader"].keys() == {"v", "omega"}
            assert ("g_ais_min" in run) == (law == "aifqsmc")
            assert run["wall_s"] > 0.0
        assert len(summary["rules"]["ais_reaction"]["sha256"]) == 64
        assert summary["versions"]["numpy"] == np.__version__

    def test_trajectory_names_its_arrays_and_units(self, short):
        with np.load(short[0] / "trajectory.npz") as data:
            assert data["aifqsmc/x"].shape == (151, 3)
            assert data["smc/t"][1] == pytest.approx(0.02)
            assert data["aifqsmc/g_ais_v"].min() > 0.0
            about = json.loads(str(data["metadata"]))
        assert about["robots"] == ["leader", "follower1", "follower2"]
        assert about["signals"]["v_c"]["unit"] == "m/s"

    def test_two_runs_give_the_same_bytes(self, short, tmp_path):
        here("run", "paper", "--controller", "all", "--set", "run.horizon=3", "-o", tmp_path)
        for name in ("trajectory.npz", "path.png", "errors.png"):
            assert (tmp_path / name).read_bytes() == (short[0] / name).read_bytes()
        first, second = (
            [
                line
                for line in (folder / "summary.json").read_text(encoding="utf-8").splitlines()
                if "wall_s" not in line
            ]
            for folder in (short[0], tmp_path)
        )
        assert first == second

    def test_an_edited_rule_changes_the_numbers(self, short, tmp_path):
        text = (rules_folder() / "ais_reaction.fz").read_text(encoding="utf-8")
        edited = text.replace("ZO |  ZO  PS  PM  PS  ZO", "ZO |  ZO  PS  NS  PS  ZO")
        assert edited != text
        (tmp_path / "ais_reaction.fz").write_text(edited, encoding="utf-8")
        done = here(
            "run", "paper", "--rules", tmp_path, "--set", "run.horizon=3", "-o", tmp_path / "out", "--format", "json"
        )
        changed = json.loads(done.stdout)["controllers"]["aifqsmc"]["rmse"]
        usual = json.loads((short[0] / "summary.json").read_text(encoding="utf-8"))["controllers"]["aifqsmc"]["rmse"]
        assert changed != usual

    def test_a_scenario_beside_its_own_rule_files_needs_no_option(self, tmp_path):
        (tmp_path / "mine.toml").write_text(PAPER.read_text(encoding="utf-8"), encoding="utf-8")
        broken = (
            (rules_folder() / "ais_reaction.fz")
            .read_text(encoding="utf-8")
            .replace("0.09, 0.18, inf)", "0.09, 0.19, inf)")
        )
        (tmp_path / "ais_reaction.fz").write_text(broken, encoding="utf-8")
        done = here("run", tmp_path / "mine.toml", "-o", tmp_path / "out", status=1)
        assert str(tmp_path / "ais_reaction.fz") in done.stderr

    def test_a_run_that_diverges_says_so_and_keeps_its_data(self, tmp_path):
        done = here(
            "run",
            "paper",
            "--controller",
            "smc",
            "--set",
            "disturbances.0.start=1",
            "--set",
            "disturbances.0.force=1e300",
            "-o",
            tmp_path,
            status=1,
        )
        stopped = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["controllers"]["smc"]["stopped"]
        assert stopped["robot"] == "leader"
        assert "stopped at t =" in done.stdout
        assert (tmp_path / "trajectory.npz").exists()


def cases(tmp_path):
    (tmp_path / "empty.toml").write_bytes(b"")
    (tmp_path / "binary.toml").write_bytes(bytes(range(256)))
    (tmp_path / "large.toml").write_bytes(b"# garbage\n" * 1_000_000)
    (tmp_path / "broken.toml").write_text("[run\ndt = 1", encoding="utf-8")
    paper = PAPER.read_text(encoding="utf-8")
    (tmp_path / "negative.toml").write_text(paper.replace("mass = 120.0", "mass = -120.0"), encoding="utf-8")
    (tmp_path / "misspelt.toml").write_text(paper.replace("torque_limit", "torqe_limit"), encoding="utf-8")
    (tmp_path / "wordy.toml").write_text(paper.replace("mass = 120.0", 'mass = "heavy"'), encoding="utf-8")
    (tmp_path / "file").write_text("x", encoding="utf-8")
    peak = tmp_path / "peak"
    peak.mkdir()
    rules = (rules_folder() / "ais_reaction.fz").read_text(encoding="utf-8")
    (peak / "ais_reaction.fz").write_text(rules.replace("0.09, 0.18, inf)", "0.09, 0.19, inf)"), encoding="utf-8")
    return {
        "a scenario that is not there": (["nowhere.toml"], 2, ["no scenario 'nowhere.toml'", "paper"]),
        "a misspelt name": (["papper"], 2, ["did you mean 'paper'?"]),
        "a folder": ([tmp_path], 1, ["is a folder"]),
        "an empty file": ([tmp_path / "empty.toml"], 1, ["is empty"]),
        "binary data": ([tmp_path / "binary.toml"], 1, ["not UTF-8"]),
        "ten megabytes": ([tmp_path / "large.toml"], 1, ["10,000,000 bytes"]),
        "no TOML": ([tmp_path / "broken.toml"], 1, ["broken.toml:1", "not valid TOML"]),
        "a negative mass": (
            [tmp_path / "negative.toml"],
            1,
            [f"negative.toml:{MASS_LINE}", "robot.mass must be > 0 kg, got -120.0"],
        ),
        "an unknown key": (
            [tmp_path / "misspelt.toml"],
            1,
            ["robot.actuator.torqe_limit", "did you mean 'torque_limit'?"],
        ),
        "a wrong type": ([tmp_path / "wordy.toml"], 1, ["must be a number, got 'heavy'"]),
        "a bad override": (["paper", "--set", "robots.leader.mass=-1"], 1, ["--set robots.leader.mass=-1", "> 0 kg"]),
        "an override without value": (["paper", "--set", "run.horizon"], 2, ["expected key=value"]),
        "an unknown controller": (["paper", "--controller", "pid"], 2, ["'pid' is not one of", "aifqsmc"]),
        "a controller twice": (["paper", "--controller", "smc, smc"], 2, ["'smc' is given twice"]),
        "an unknown option": (["paper", "--fast"], 2, ["No such option"]),
        "a missing rules folder": (["paper", "--rules", tmp_path / "no"], 2, ["does not exist"]),
        "a missing rule file": (["paper", "--set", "rules.ais_reaction.file=no.fz"], 1, ["'no.fz'", "looked in"]),
        "a rule file for something else": (
            ["paper", "--set", "rules.ais_reaction.file=tipper.fz"],
            1,
            ["service, food"],
        ),
        "an unknown param": (
            ["paper", "--set", "rules.ais_reaction.k_t=1"],
            1,
            ["did you mean 'rules.ais_reaction.k_s'?"],
        ),
        "a peak that is too high": (
            ["paper", "--rules", peak],
            1,
            ["ais_reaction.fz:37", "0.19", "G_AIS > 0", "-0.0045"],
        ),
        "an output that is a file": (["paper", "-o", tmp_path / "file"], 1, ["cannot be written"]),
        "an output below a file": (["paper", "-o", tmp_path / "file" / "x"], 1, ["cannot be written"]),
    }


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """Bad inputs by what is bad about them: arguments, exit code, words of the answer."""
    return cases(tmp_path_factory.mktemp("bad"))


class TestBadInput:
    @pytest.mark.parametrize(
        "what",
        [
            "a scenario that is not there",
            "a misspelt name",
            "a folder",
            "an empty file",
            "binary data",
            "ten megabytes",
            "no TOML",
            "a negative mass",
            "an unknown key",
            "a wrong type",
            "a bad override",
            "an override without value",
            "an unknown controller",
            "an unknown option",
            "a missing rules folder",
            "a missing rule file",
            "a rule file for something else",
            "an unknown param",
            "a peak that is too high",
            "an output that is a file",
            "an output below a file",
        ],
    )
    def test_gets_a_clear_answer(self, table, tmp_path, what):
        arguments, status, words = table[what]
        done = here("run", *arguments, cwd=tmp_path, status=status)
        assert done.stdout == ""
        for word in words:
            assert word in done.stderr
        assert list(tmp_path.iterdir()) == []

    def test_is_machine_readable_on_request(self, table):
        arguments, _, _ = table["a negative mass"]
        done = here("run", *arguments, "--format", "json", status=1)
        (one,) = json.loads(done.stdout)["diagnostics"]
        assert (one["code"], one["line"]) == ("FZ904", MASS_LINE)


#: Runs commands one after the other: what one of them has loaded stays loaded.
SEVERAL = """
import json, sys
from dwmr.cli.main import main
for arguments in json.loads(sys.argv[1]):
    try:
        main(arguments)
    except SystemExit as stop:
        status = stop.code
    heavy = {'numba', 'matplotlib', 'scipy', 'distributed', 'pyarrow'} & set(sys.modules)
    print('HEAVY', sorted(heavy), status)
"""


class TestStartUp:
    def test_loads_nothing_heavy_before_a_run(self, tmp_path):
        commands = [
            (["--help"], 0),
            (["run", "--help"], 0),
            (["run", "nowhere.toml"], 2),
            (["run", "paper", "--set", "robot.mass=-1"], 1),
            (["run", "paper", "--set", "rules.ais_reaction.k_s=0.6"], 1),
            (["run", "paper", "--set", "rules.ais_reaction.file=tipper.fz"], 1),
            (["sweep", "nowhere.toml"], 2),
            (["compare", "paper", "--set", "robot.mass=-1"], 1),
            (["check", "--help"], 0),
            (["check", "paper", "csv-path"], 0),
            (["show"], 0),
            (["show", "csv-path"], 0),
            (["new", "mine"], 0),
        ]
        words = [sys.executable, "-c", SEVERAL, json.dumps([arguments for arguments, _ in commands])]
        done = subprocess.run(words, capture_output=True, text=True, timeout=LONG, check=True, cwd=tmp_path)
        found = [line for line in done.stdout.splitlines() if line.startswith("HEAVY")]
        for (arguments, status), line in zip(commands, found, strict=True):
            assert line == f"HEAVY [] {status}", arguments
