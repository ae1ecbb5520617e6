"""`dwmr run`, and mistakes in the options that all commands share."""

import dataclasses
import json
import re
import subprocess
import sys

import numpy as np
import pytest

from dwmr.cli.main import main
from tests.commands import commands_of
from tests.dwmr.paper import NAMES, TABLE_12
from tests.dwmr.process import LONG, here, in_short
from tests.dwmr.scenarios import DIVERGES, PAPER, ROBOTS, edited, edited_rules

MASS_LINE = PAPER.read_text(encoding="utf-8").split("mass = 120.0")[0].count("\n") + 1
FILES = ["errors.png", "path.png", "summary.json", "trajectory.npz"]


def summary_of(folder):
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Results of one short run of all laws."""
    folder = tmp_path_factory.mktemp("run")
    done = in_short("run", "paper", "--controller", "all", "--set", "run.horizon=3", "-o", folder)
    return folder, done


def test_help_teaches_by_example_and_cuts_no_line():
    text = here("--help").stdout
    assert "dwmr run paper --controller all" in text
    lines = text.partition("Commands:\n")[2].splitlines()
    assert len(lines) == len(commands_of(main)) == 12
    for line in lines:
        assert line.endswith(".")
        assert not line.endswith("..")


class TestRun:
    def test_shows_errors_of_all_robots_stability_and_drift(self, short):
        folder, done = short
        for word in ("aifqsmc", "fcafsmc", "smc", "follower2", "G_AIS", "dV/dt > 0"):
            assert word in done.stdout
        assert "Table 12" not in done.stdout  # a short run
        assert done.stderr == ""
        run = summary_of(folder)["controllers"]["aifqsmc"]
        row = next(line for line in done.stdout.split("Stability")[1].splitlines() if line.startswith("aifqsmc"))
        assert f"{100 * run['lyapunov']['leader']['V_dot_23_positive']:.1f}" in row.split()
        assert f"{run['drift']['leader']['k_h_omega']['final']:.3f}" in row.split()

    def test_writes_four_files_with_every_promised_entry(self, short):
        assert sorted(p.name for p in short[0].iterdir()) == FILES
        summary = summary_of(short[0])
        assert list(summary["controllers"]) == ["aifqsmc", "fcafsmc", "smc"]
        for law, run in summary["controllers"].items():
            for section in ("rmse", "rmse_body", "rmse_inertial"):
                for robot in ROBOTS:
                    assert {"x_e", "y_e", "theta_e", "theta_e_star", "theta_e_unwrapped"} <= run[section][robot].keys()
            assert run["steps"] == 600
            assert run["centre_distance"].keys() == set(ROBOTS)
            assert run["chattering"]["leader"].keys() == {"v", "omega"}
            assert ("g_ais_min" in run) == (law == "aifqsmc")
            assert run["wall_s"] > 0.0
        assert len(summary["rules"]["ais_reaction"]["sha256"]) == 64
        assert summary["versions"]["numpy"] == np.__version__
        with np.load(short[0] / "trajectory.npz") as data:
            assert data["aifqsmc/x"].shape == (151, 3)
            assert data["smc/t"][1] == pytest.approx(0.02)
            about = json.loads(str(data["metadata"]))
        assert about["robots"] == list(ROBOTS)
        assert about["signals"]["v_c"]["unit"] == "m/s"

    def test_gives_the_same_bytes_twice(self, tmp_path):
        for folder in ("a", "b"):
            here("run", "paper", "--controller", "smc", "--set", "run.horizon=1", "-o", tmp_path / folder)
        for name in FILES:
            first, second = ((tmp_path / folder / name).read_bytes() for folder in ("a", "b"))
            assert re.sub(rb'"wall_s".*', b"", first) == re.sub(rb'"wall_s".*', b"", second)

    @pytest.mark.parametrize(
        ("laws", "names"),
        [
            pytest.param(
                "ablations",
                ["aifqsmc", *(f"aifqsmc_without_{p}" for p in ("adaptation", "immunity", "layer"))],
                marks=pytest.mark.long,
            ),
            ("smc, all", ["smc", "aifqsmc", "fcafsmc"]),
        ],
    )
    def test_takes_several_laws(self, tmp_path, laws, names):
        done = here("run", "paper", "--controller", laws, "--set", "run.horizon=0.1", "-o", tmp_path)
        assert list(summary_of(tmp_path)["controllers"]) == names
        assert max(len(line) for line in done.stdout.partition("results in")[0].splitlines()) <= 80

    def test_compares_laws_that_reached_the_end_with_the_paper(self, recorded, run_paper, measured, tmp_path):
        stop = run_paper("smc", "run.horizon=20", *DIVERGES)[1].stop
        stopped = dataclasses.replace(run_paper("fcafsmc")[1], stop=stop)
        recorded(run_paper("aifqsmc")[1], run_paper("smc")[1], stopped)
        text = here("run", "paper", "--controller", "all", "-o", tmp_path, status=1).stdout
        assert "beside Table 12 of the paper" in text
        rows = [row.split() for row in text.partition("Safety")[0].splitlines()]
        for law, table in TABLE_12.items():
            shown = [f"{number:.4f}" for robot in ROBOTS for number in table[robot].values()]
            assert all(any(number in row for row in rows) for number in shown) == (law != "fcafsmc")
        (row,) = [row[1:] for row in rows if row[:2] == ["aifqsmc", "leader"]]
        errors = measured("aifqsmc")["rmse"]["leader"]
        ours = [(errors[name], TABLE_12["aifqsmc"]["leader"][name]) for name in NAMES]
        assert row[1:] == [cell for own, one in ours for cell in (f"{own:.4f}", f"{one:.4f}", f"{own / one:.2f}")]

    def test_of_an_edited_rule_has_other_numbers(self, short, tmp_path):
        edited_rules(tmp_path, "ais_reaction.fz", ("ZO |  ZO  PS  PM  PS  ZO", "ZO |  ZO  PS  NS  PS  ZO"))
        options = ("--rules", tmp_path, "--set", "run.horizon=3", "-o", tmp_path / "out", "--format", "json")
        changed = json.loads(here("run", "paper", *options).stdout)["controllers"]["aifqsmc"]["rmse"]
        assert changed != summary_of(short[0])["controllers"]["aifqsmc"]["rmse"]

    @pytest.mark.parametrize("base", [None, "below/base.toml"])
    def test_takes_rule_files_beside_its_scenario_and_beside_the_one_that_is_extended(self, tmp_path, base):
        folder = tmp_path / "below" if base else tmp_path
        folder.mkdir(exist_ok=True)
        edited(PAPER, folder / "base.toml")
        if base:
            (tmp_path / "mine.toml").write_text(f'extends = "{base}"\n', encoding="utf-8")
        edited_rules(folder, "ais_reaction.fz", ("0.09, 0.18, inf)", "0.09, 0.19, inf)"))
        done = here("run", tmp_path / ("mine.toml" if base else "base.toml"), "-o", tmp_path / "out", status=1)
        assert f"{folder / 'ais_reaction.fz'}:47" in done.stderr

    def test_that_diverges_says_so_and_keeps_its_data(self, tmp_path):
        values = [word for value in DIVERGES for word in ("--set", value)]
        done = here("run", "paper", "--controller", "smc", *values, "-o", tmp_path, status=1)
        assert summary_of(tmp_path)["controllers"]["smc"]["stopped"]["robot"] == "leader"
        assert "stopped at t =" in done.stdout
        assert (tmp_path / "trajectory.npz").exists()


def scenario(text):
    """Return a function that writes a scenario into a folder and returns its path."""

    def write(folder):
        (folder / "mine.toml").write_bytes(text)
        return folder / "mine.toml"

    return write


def peak(folder):
    return edited_rules(folder, "ais_reaction.fz", ("0.09, 0.18, inf)", "0.09, 0.19, inf)"))


def paper_with(old, new):
    return scenario(PAPER.read_bytes().replace(old, new))


def a_file(folder):
    (folder / "file").write_text("x", encoding="utf-8")
    return folder / "file"


#: Bad inputs: arguments (a function writes a file and returns its path), exit code, words of the answer.
BAD = {
    "a scenario that is not there": (["nowhere.toml"], 2, ["no scenario 'nowhere.toml'", "paper"]),
    "a misspelt name": (["papper"], 2, ["did you mean 'paper'?"]),
    "a folder": ([lambda folder: folder], 1, ["is a folder"]),
    "an empty file": ([scenario(b"")], 1, ["is empty"]),
    "binary data": ([scenario(bytes(range(256)))], 1, ["not UTF-8"]),
    "ten megabytes": ([scenario(b"# garbage\n" * 1_000_000)], 1, ["10,000,000 bytes"]),
    "no TOML": ([scenario(b"[run\ndt = 1")], 1, ["mine.toml:1", "not valid TOML"]),
    "a negative mass": (
        [paper_with(b"mass = 120.0", b"mass = -120.0")], 1,
        [f"mine.toml:{MASS_LINE}", "robot.mass must be > 0 kg, got -120.0"],
    ),
    "an unknown key": (
        [paper_with(b"torque_limit", b"torqe_limit")], 1,
        ["robot.actuator.torqe_limit", "did you mean 'torque_limit'?"],
    ),
    "a wrong type": ([paper_with(b"mass = 120.0", b'mass = "heavy"')], 1, ["must be a number, got 'heavy'"]),
    "a bad override": (["paper", "--set", "robots.leader.mass=-1"], 1, ["--set robots.leader.mass=-1", "> 0 kg"]),
    "an override without value": (["paper", "--set", "run.horizon"], 2, ["expected key=value"]),
    "an override twice": (["paper", "--set", "run.dt=1", "--set", "run.dt=2"], 2, ["run.dt is given twice"]),
    "an unknown controller": (["paper", "--controller", "pid"], 2, ["'pid' is not one of", "aifqsmc"]),
    "a long controller": (["paper", "--controller", "a" * 300], 2, ["is not one of"]),
    "a controller twice": (["paper", "--controller", "smc, smc"], 2, ["'smc' is given twice"]),
    "an unknown option": (["paper", "--fast"], 2, ["No such option"]),
    "a missing rules folder": (["paper", "--rules", "nowhere"], 2, ["does not exist"]),
    "a folder without rules": (
        ["paper", "--rules", lambda folder: folder], 1, ["looked for ais_reaction.fz, boundary_layer.fz, fcafsmc.fz"]
    ),
    "a missing rule file": (["paper", "--set", "rules.ais_reaction.file=no.fz"], 1, ["'no.fz'", "looked in"]),
    "a rule file for something else": (["paper", "--set", "rules.ais_reaction.file=tipper.fz"], 1, ["service, food"]),
    "an unknown param": (["paper", "--set", "rules.ais_reaction.k_t=1"], 1, ["did you mean 'rules.ais_reaction.k_s'?"]),
    "a computed param": (["paper", "--set", "rules.ais_reaction.f_max=0.1"], 1, ["set k_h_min, G_min, k_s instead"]),
    "a peak that is too high": (
        ["paper", "--rules", peak], 1, ["ais_reaction.fz:47", "G_AIS > 0", "-0.0045"]
    ),
    "an output that is a file": (["paper", "-o", a_file], 1, ["cannot be written"]),
    "an output below a file": (["paper", "-o", lambda folder: a_file(folder) / "x"], 1, ["cannot be written"]),
    "many digits": (["paper", "--set", "run.horizon=" + "1" * 5000], 2, ["too many digits"]),
    "many hexadecimal digits": (["paper", "--set", "run.horizon=0x" + "f" * 5000], 1, ["thousands of digits"]),
    "many digits in a file": ([scenario(b"x = " + b"1" * 5000)], 1, ["too many digits"]),
    "many brackets": (["paper", "--set", "run.horizon=" + "[" * 5000], 2, ["nested too deeply"]),
    "many parts": (["paper", "--set", ".".join(["a"] * 3000) + "=1"], 2, ["3000 parts"]),
    "two lines": (["paper", "--set", "run.horizon=2\nrun.dt=1"], 2, ["line break"]),
    "a value for a table": (["paper", "--set", "robot=5"], 1, ["robot must be a table, got 5"]),
    "a long file name": (["paper", "--set", "rules.ais_reaction.file=" + "a" * 5000], 1, ["does not exist"]),
    "a small radius": (["paper", "--set", "avoidance.largest_radius=0.4"], 1, ["no robot would ever avoid it"]),
    "a tiny period": (["paper", "--set", "run.dt=1e-300"], 1, ["run.dt must be >= 1e-06 s"]),
    "a long scenario name": (["a" * 5000], 2, ["no scenario"]),
    "a long output": (["paper", "-o", "/".join(["a" * 200] * 40)], 1, ["cannot be written"]),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_input_gets_a_clear_answer(tmp_path, case):
    arguments, status, words = BAD[case]
    (tmp_path / "files").mkdir()
    (tmp_path / "empty").mkdir()
    arguments = [word(tmp_path / "files") if callable(word) else word for word in arguments]
    done = here("run", *arguments, cwd=tmp_path / "empty", status=status)
    assert done.stdout == ""
    for word in words:
        assert word in done.stderr
    assert list((tmp_path / "empty").iterdir()) == []


@pytest.mark.parametrize("command", ["run", "figures", "animate", "report", "compare", "check", "show"])
def test_every_command_answers_mistakes_of_scenario_and_options_and_leaves_nothing(tmp_path, command):
    for arguments, status, words in (
        (["papper"], 2, "did you mean 'paper'?"),
        (["paper", "--set", "robot.mass=-1"], 1, "robot.mass must be > 0 kg, got -1"),
        (["paper", "--set", "run.horizon"], 2, "expected key=value"),
    ):
        done = here(command, *arguments, cwd=tmp_path, status=status)
        assert words in done.stderr
        assert done.stdout == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", ["animate", "report", "compare"])
def test_every_command_that_simulates_answers_an_unknown_law(command):
    assert "'pid' is not one of" in here(command, "paper", "--controller", "pid", status=2).stderr


#: Commands that draw a run, each with the file it writes.
DRAWING = {"figures": ("--only", "13"), "animate": (), "report": ()}


@pytest.mark.parametrize("command", DRAWING)
def test_a_run_that_diverges_is_shown_as_far_as_it_went(tmp_path, command):
    out = tmp_path / {"figures": "out", "animate": "a.gif", "report": "a.html"}[command]
    values = [word for value in (*DIVERGES, "run.horizon=5") for word in ("--set", value)]
    done = here(command, "paper", *values, *DRAWING[command], "-o", out, status=1)
    assert "warning: aifqsmc stopped at t = 1.005 s" in done.stderr
    assert out.exists()
    if command == "report":
        assert "aifqsmc: stopped at t = 1.005 s" in out.read_text(encoding="utf-8")


@pytest.mark.parametrize(("command", "name"), [("animate", "a.gif"), ("report", "a.html")])
def test_huge_numbers_are_drawn_without_further_words(tmp_path, command, name):
    done = here(command, "paper", "--set", "robots.leader.d=1e-300", "-o", tmp_path / name, status=1)
    assert done.stderr.splitlines() == [
        "warning: aifqsmc stopped at t = 0.005 s: v_c is beyond 1e+12 m/s, "
        "omega_c is beyond 1e+12 rad/s: the run diverged"
    ]


def test_mistakes_are_machine_readable_on_request(tmp_path):
    path = paper_with(b"mass = 120.0", b"mass = -120.0")(tmp_path)
    (one,) = json.loads(here("run", path, "--format", "json", status=1).stdout)["diagnostics"]
    assert (one["code"], one["line"]) == ("FZ904", MASS_LINE)


#: Runs commands one after the other: modules that one of them has loaded stay loaded.
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


def test_nothing_heavy_is_loaded_before_a_run(tmp_path):
    commands = {
        "--help": 0,
        "run --help": 0,
        "run nowhere.toml": 2,
        "run paper --set robot.mass=-1": 1,
        "run paper --set rules.ais_reaction.k_s=0.6": 1,
        "run paper --set rules.ais_reaction.file=tipper.fz": 1,
        "sweep nowhere.toml": 2,
        "compare paper --set robot.mass=-1": 1,
        "check paper csv-path": 0,
        "show": 0,
        "show csv-path": 0,
        "new mine": 0,
    }
    words = [sys.executable, "-c", SEVERAL, json.dumps([line.split() for line in commands])]
    done = subprocess.run(words, capture_output=True, text=True, timeout=LONG, check=True, cwd=tmp_path)
    found = [line for line in done.stdout.splitlines() if line.startswith("HEAVY")]
    assert found == [f"HEAVY [] {status}" for status in commands.values()]
