"""Shipped files are found by name; a file of the folder hides one."""

import json
from pathlib import Path

import pytest

import fuzzyctl
from fuzzyctl.testing import run_command as run
from tests.shipped import SYSTEMS

RULES = SYSTEMS[0].parent

#: Commands that take a file, with further words, by what they print or write of the shipped file of a name.
COMMANDS = [
    ("check tipper", "tipper: tipper: 3 rules, no errors"),
    ("eval tipper service=7 food=8", "tip = 20.344474774540"),
    ("show tipper", "tipper: Tip for service and food"),
    ("show aifqsmc", "aifqsmc: Adaptive immune"),
    ("prove tipper", "bounded(tip, 0, 30)"),
    ("fmt --check tipper zhao_1993", ""),
    ("plot-surface tipper -o out.svg", "wrote out.svg"),
    ("page tipper", "wrote tipper.html"),
    ("codegen tipper --target python", "wrote tipper.py"),
    ("convert tipper tip.md", "wrote tip.md"),
    ("compare --changes tipper tipper", "nothing was changed"),
    ("compare --loops water_tank water_tank", "fill"),
    ("simulate water_tank --against water_tank", "water_tank.fill"),
]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


class TestNames:
    def test_each_names_one_file_and_all_are_listed(self):
        groups = json.loads(run("show", "--format", "json").output)
        names = [entry["name"] if isinstance(entry, dict) else entry for files in groups.values() for entry in files]
        assert len(names) == len(set(names)) > 25
        assert {"tipper", "water_tank", "zhao_1993"} < set(names)
        listed = run("show").output
        assert all(f"\n  {name} " in listed for name in names)

    @pytest.mark.parametrize(("command", "text"), COMMANDS, ids=[c for c, _ in COMMANDS])
    def test_every_command_takes_them(self, command, text, folder):
        result = run(*command.split())
        assert result.exit_code == 0, result
        assert text in result.output + result.errors
        assert str(RULES) not in result.output + result.errors

    def test_python_takes_them(self):
        assert fuzzyctl.load("tipper") == fuzzyctl.load(RULES / "tipper.fz")
        assert [s.name for s in fuzzyctl.load_all("matlab_pid")] == ["plane", "curved"]
        assert fuzzyctl.load(Path("aifqsmc"), block=fuzzyctl.Controller).name == "aifqsmc"
        assert fuzzyctl.load("water_tank", block=fuzzyctl.Loop).name == "fill"

    def test_a_sweep_takes_them(self, folder):
        (folder / "spec.toml").write_text('scenario = "water_tank"\nagainst = ["pendulum"]\nruns = 1\n')
        result = run("sweep", "spec.toml", "--jobs", "1")
        assert (result.exit_code, result.errors) == (0, "")
        run("new", "pendulum", "--from", "pendulum")
        note = "note: 'pendulum.fz' of this folder is read in place of the shipped 'pendulum'"
        assert run("sweep", "spec.toml", "--jobs", "1", "-o", "again").errors.splitlines() == [note]

    def test_a_shipped_spec_is_swept_by_its_name_and_one_of_the_folder_wins(self, folder):
        result = run("sweep", "water_tank_gains", "--jobs", "1")
        assert result.output.startswith("15 runs, all to the end\n"), result.output
        (folder / "water_tank_gains.toml").write_text('scenario = "water_tank"\nruns = 1\n')
        result = run("sweep", "water_tank_gains", "--jobs", "1")
        assert "1 run, " in result.output
        note = "note: 'water_tank_gains.toml' of this folder is read in place of the shipped 'water_tank_gains'"
        assert note in result.errors

    def test_a_file_beside_the_spec_comes_before_the_shipped_one(self, folder):
        (folder / "specs").mkdir()
        (folder / "specs" / "spec.toml").write_text('scenario = "water_tank"\nagainst = ["pendulum"]\nruns = 1\n')
        run("new", "water_tank", "--from", "water_tank")
        said = run("sweep", "specs/spec.toml", "--jobs", "1").errors.splitlines()
        assert said == ["note: the shipped 'water_tank' is read, not 'water_tank.fz' of this folder"]
        for name in ("water_tank", "pendulum"):
            run("new", name, "--from", name, "-o", f"specs/{name}.fz")
            with (folder / "specs" / f"{name}.fz").open("a", encoding="utf-8") as file:
                file.write("# mine\n")
        result = run("sweep", "specs/spec.toml", "--jobs", "1", "-o", "again")
        assert result.exit_code == 0, result.output
        assert result.errors.splitlines() == [
            f"note: 'specs/{name}.fz' is read in place of the shipped '{name}'" for name in ("water_tank", "pendulum")
        ]
        texts = json.loads((folder / "again" / "sweep.json").read_text(encoding="utf-8"))["scenario"]["text"]
        assert [one["text"].endswith("# mine\n") for one in texts] == [True, True]


class TestAFileOfTheFolder:
    def test_it_wins_and_one_line_names_it(self, folder):
        text = (RULES / "tipper.fz").read_text(encoding="utf-8")
        (folder / "tipper.fz").write_text(text, encoding="utf-8")
        result = run("check", "tipper")
        assert result.errors.splitlines()[0] == (
            "note: 'tipper.fz' of this folder is read in place of the shipped 'tipper'"
        )
        assert run("check", "tipper").output == run("check", "tipper.fz").output.replace("tipper.fz:", "tipper:")
        assert "note" not in run("show", "-q", "tipper").errors
        assert "note" not in run("check", "tipper.fz").output

    def test_a_file_without_suffix_comes_first_and_a_folder_does_not_count(self, folder):
        (folder / "tipper").mkdir()
        assert run("check", "tipper").exit_code == 0
        (folder / "smc").write_text("nothing", encoding="utf-8")
        assert run("check", "smc").errors.startswith("note: 'smc' of this folder is read")

    def test_a_name_that_is_not_shipped_is_a_file_of_the_folder_too(self, folder):
        run("new", "heater")
        result = run("check", "heater")
        assert (result.exit_code, result.errors) == (0, "")

    def test_used_files_are_never_names(self, folder):
        (folder / "a.fz").write_text('use "tipper"\ncontroller c\ninput x in [0, 1]\noutput y = x\n', encoding="utf-8")
        assert "cannot be used" in run("check", "a.fz").errors


class TestMistakes:
    @pytest.mark.parametrize(
        ("name", "help_text"),
        [
            ("tiper", "did you mean the shipped 'tipper'? 'fuzzyctl show' lists the shipped files"),
            ("zhao1993", "did you mean the shipped 'zhao_1993'? 'fuzzyctl show' lists the shipped files"),
            ("qqq", "'fuzzyctl show' lists the shipped files"),
            ("tipper.fz", "did you mean the shipped 'tipper'? 'fuzzyctl show' lists the shipped files"),
            ("rules/tipper.fz", "did you mean the shipped 'tipper'? 'fuzzyctl show' lists the shipped files"),
        ],
    )
    def test_an_unknown_name_is_a_diagnostic_with_the_closest_one(self, name, help_text):
        result = run("eval", name, "service=7")
        assert (result.exit_code, result.errors) == (
            1,
            f"{name}: error[FZ001]: there is no such file\n = help: {help_text}\n",
        )

    def test_a_shipped_file_of_this_name_comes_before_similar_files(self, folder):
        (folder / "smc.fz").mkdir()
        (folder / "ais_reactions.fz").touch()
        assert run("show", "smc").exit_code == 0
        for command in (("show",), ("check", "--watch")):
            help_text = "did you mean the shipped 'ais_reaction'? 'fuzzyctl show' lists the shipped files"
            assert run(*command, "ais_reaction.fz").errors.endswith(f"there is no such file\n = help: {help_text}\n")

    @pytest.mark.parametrize("words", [("fmt",), ("check", "--fix"), ("check", "--fix", "likely")])
    def test_a_shipped_file_is_not_written(self, words):
        before = (RULES / "tipper.fz").read_bytes()
        result = run(*words, "tipper")
        assert result.exit_code == 1
        assert "tipper: error[FZ005]: a shipped file is not changed" in result.errors
        assert "fuzzyctl new NAME --from tipper" in result.errors
        assert (RULES / "tipper.fz").read_bytes() == before

    def test_what_needs_a_file_does_not_list(self):
        assert run("show", "--plan").exit_code == 2
        assert run("show", "--set", "a=1").exit_code == 2
