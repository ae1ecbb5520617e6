import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from fuzzyctl.cli import doctor
from fuzzyctl.cli.show import show_system
from fuzzyctl.kernels.algorithms.select import ALGORITHMS
from fuzzyctl.support.shipped import rules_folder
from tests.commands import runner

run = runner()


class TestDoctor:
    def test_says_what_is_in_use_and_why(self):
        result = run("doctor")
        assert result.exit_code == 0
        assert "backend: numba: it is installed and can be imported" in result.output
        assert "lark " in result.output

    def test_gives_data_to_programs(self):
        data = json.loads(run("doctor", "--format", "json").output)
        assert data["problems"] == []
        assert set(data["packages"]) == set(doctor.NEEDED)
        assert data["packages"]["numpy"].count(".") == 2
        assert data["cores"] >= 1

    def test_finds_what_is_missing(self, monkeypatch):
        versions = doctor._version
        monkeypatch.setattr(doctor, "_version", lambda name: None if name in ("rich", "pyarrow") else versions(name))
        result = run("doctor")
        assert result.exit_code == 1
        assert "problem: rich is not installed: pip install rich" in result.output
        assert "pyarrow: not installed; pip install 'fuzzyctl[data]' brings it" in result.output

    def test_without_numba_says_what_takes_its_place(self):
        script = (
            "import sys; sys.modules['numba'] = None\n"
            "from fuzzyctl.cli.main import main\nsys.argv = ['fuzzyctl', 'doctor']\nmain()"
        )
        found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
        assert found.returncode == 1, found.stderr
        assert "backend: numpy: " in found.stdout
        assert "problem: numba is installed but cannot be used" in found.stdout


class TestCache:
    @pytest.fixture
    def folder(self, tmp_path, monkeypatch):
        monkeypatch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path / "cache"))
        return tmp_path / "cache"

    def test_that_there_is_not_yet_is_no_problem(self, folder):
        assert f"cache: {folder}: 0 files, 0.0 MiB\n" in run("doctor").output

    def test_is_counted_and_cleared_and_nothing_else_is(self, folder):
        for name in ("kernels/a.py", "kernels/__pycache__/a.nbi", "dwmr/x/b.nbc", "mine.txt"):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(b"x" * 2**19)
        assert "4 files, 2.0 MiB" in run("doctor").output
        assert "3 files removed" in run("doctor", "--clear-cache").output
        assert [p.name for p in folder.rglob("*")] == ["mine.txt"]

    @pytest.mark.skipif(not hasattr(os, "geteuid"), reason="the platform has no owners of files")
    @pytest.mark.parametrize("shared", ["", "kernels", "dwmr"])
    def test_that_others_may_write_to_is_said_and_left_as_it_is(self, folder, shared):
        (folder / shared).mkdir(mode=0o700, parents=True)
        folder.chmod(0o700)
        (folder / shared).chmod(0o777)
        result = run("doctor")
        assert result.exit_code == 0
        assert f"anew: the cache folder {folder / shared} can be written to by other users" in result.output
        assert "set FUZZYCTL_CACHE_DIR to a folder of your own\n" in result.output
        assert [p.name for p in folder.rglob("*")] == [shared] * bool(shared)
        (folder / shared).chmod(0o700)
        assert json.loads(run("doctor", "--format", "json").output)["cache"]["danger"] is None

    def test_behind_links_nothing_is_removed(self, folder, tmp_path):
        (tmp_path / "other").mkdir()
        (tmp_path / "other" / "precious").write_text("x")
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "kernels").symlink_to(tmp_path / "other")
        result = run("doctor", "--clear-cache")
        assert result.exit_code == 1
        assert "kernels is a link, behind which nothing is removed" in result.output
        assert (tmp_path / "other" / "precious").exists()

    def test_files_that_cannot_be_removed_are_counted_and_said(self, folder, monkeypatch):
        for name in ("kernels/a.py", "kernels/x/a.nbi", "kernels/x/b.nbc", "dwmr/c.py"):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text("x")
        unlink = Path.unlink

        def refusing(path, **more):
            if path.parent.name == "x":
                raise PermissionError(13, "Permission denied")
            unlink(path, **more)

        # Modes of folders do not hold back root, who may run this.
        monkeypatch.setattr(Path, "unlink", refusing)
        result = run("doctor", "--clear-cache")
        assert result.exit_code == 1
        assert ": 2 files removed\n" in result.output
        assert f"problem: 2 files of {folder / 'kernels' / 'x'} cannot be removed: Permission denied\n" in result.output
        assert sorted(p.name for p in folder.rglob("*.*")) == ["a.nbi", "b.nbc"]
        data = json.loads(run("doctor", "--clear-cache", "--format", "json").output)
        assert (data["cache"]["removed"], data["cache"]["files"], len(data["problems"])) == (0, 2, 1)

    def test_folders_that_cannot_be_looked_into_are_said(self, folder, monkeypatch):
        (folder / "kernels").mkdir(parents=True)

        def refusing(place):
            raise PermissionError(13, "Permission denied", place)

        monkeypatch.setattr("os.scandir", refusing)
        result = run("doctor", "--clear-cache")
        assert result.exit_code == 1
        assert f"problem: {folder / 'kernels'} cannot be looked into: Permission denied" in result.output

    def test_that_cannot_be_written_to_is_said(self, tmp_path, monkeypatch):
        (tmp_path / "file").write_text("")
        monkeypatch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path / "file" / "cache"))
        assert "cannot be written to" in run("doctor").output

    def test_of_a_user_without_a_home_is_none(self, monkeypatch):
        def none():
            raise RuntimeError("Could not determine home directory.")

        for name in ("FUZZYCTL_CACHE_DIR", "XDG_CACHE_HOME"):
            monkeypatch.delenv(name, raising=False)
        monkeypatch.setattr("fuzzyctl.support.private_folders.Path.home", none)
        assert "cache: none, as there is no home" in run("doctor").output
        assert "every process compiles anew" in run("doctor", "--clear-cache").output


RULES = ("--algorithm", "rules")


class TestPlan:
    def test_the_algorithms_of_the_option_are_those_of_kernels(self):
        option = next(p for p in show_system.params if p.name == "algorithm")
        assert tuple(option.type.choices) == ALGORITHMS

    def test_of_a_partition_is_looked_up(self):
        output = run("show", "--plan", str(rules_folder() / "ais_reaction.fz")).output
        assert output.startswith("ais_reaction: interpolation\n  it looks up the output at 5 x 5 knots of the inputs\n")
        assert "25 rules, 25 distinct firing strengths of 10 degrees" in output

    def test_of_other_systems_says_why_rules_are_evaluated(self):
        output = run("show", "--plan", str(rules_folder() / "tipper.fz")).output
        assert "tipper: rules\n  it evaluates all rules: not all defuzzifiers are averages over rules\n" in output
        assert "tip: centroid in closed form" in output

    def test_says_where_numba_would_take_long(self, monkeypatch):
        file = str(rules_folder() / "tipper.fz")
        assert "numba" not in run("show", "--plan", file).output
        monkeypatch.setattr("fuzzyctl.display.plan_summary.MOST_OPERATIONS", 20)
        assert "operations would take numba long: backend 'auto' takes numpy\n" in run("show", "--plan", file).output

    def test_of_another_algorithm_is_what_that_would_do(self):
        file = str(rules_folder() / "ais_reaction.fz")
        pages = [run("show", "--plan", "--format", "json", file, *more).output for more in ((), RULES)]
        usual, rules = map(json.loads, pages)
        assert (usual["algorithm"], rules["algorithm"]) == ("interpolation", "rules")
        assert rules["operations"] > usual["operations"]
        assert "it evaluates all rules: it was asked for\n" in run("show", "--plan", file, *RULES).output

    def test_of_an_algorithm_that_the_system_does_not_allow_says_why(self):
        result = run("show", "--plan", str(rules_folder() / "tipper.fz"), "--algorithm", "interpolation")
        assert result.exit_code == 1
        assert result.stderr == "error: the system does not interpolate: not all defuzzifiers are averages over rules\n"

    def test_an_algorithm_without_it_is_wrong_usage(self):
        result = run("show", str(rules_folder() / "tipper.fz"), *RULES)
        assert result.exit_code == 2
        assert "add --plan" in result.stderr

    def test_is_data_for_programs(self):
        data = json.loads(run("show", "--plan", "--format", "json", str(rules_folder() / "fcafsmc.fz")).output)
        assert (data["algorithm"], data["reason"], data["states"]) == ("rules", "it has a state", 7)
