import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.commands import runner

run = runner("doctor")


class TestDoctor:
    def test_says_what_is_in_use_and_why(self):
        result = run()
        assert result.exit_code == 0
        assert "backend: numba: it is installed and can be imported" in result.output
        assert "lark " in result.output
        data = json.loads(run("--format", "json").output)
        assert data["problems"] == []
        assert data["packages"]["numpy"].count(".") == 2
        assert data["cores"] >= 1

    def test_finds_what_is_missing(self, monkeypatch):
        monkeypatch.setattr("fuzzyctl.cli.doctor._version", lambda name: None if name in ("rich", "pyarrow") else "1.0")
        result = run()
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

    def test_a_plan_says_if_numba_would_take_long(self, monkeypatch):
        plan = runner("show", "--plan", "tipper")
        assert "numba" not in plan().output
        monkeypatch.setattr("fuzzyctl.display.plan_summary.MOST_OPERATIONS", 20)
        assert "operations would take numba long: backend 'auto' takes numpy\n" in plan().output


class TestCache:
    @pytest.fixture
    def folder(self, tmp_path, monkeypatch):
        monkeypatch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path / "cache"))
        return tmp_path / "cache"

    def write(self, folder, *names, size=1):
        for name in names:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(b"x" * size)

    def test_that_there_is_not_yet_is_no_problem(self, folder):
        assert f"cache: {folder}: 0 files, 0.0 MiB\n" in run().output

    def test_is_counted_and_cleared_and_nothing_else_is(self, folder):
        self.write(folder, "kernels/a.py", "kernels/__pycache__/a.nbi", "dwmr/x/b.nbc", "mine.txt", size=2**19)
        assert "4 files, 2.0 MiB" in run().output
        assert "3 files removed" in run("--clear-cache").output
        assert [p.name for p in folder.rglob("*")] == ["mine.txt"]

    @pytest.mark.skipif(not hasattr(os, "geteuid"), reason="the platform has no owners of files")
    @pytest.mark.parametrize("shared", ["", "kernels", "dwmr"])
    def test_that_others_may_write_to_is_reported_and_left_as_it_is(self, folder, shared):
        (folder / shared).mkdir(mode=0o700, parents=True)
        folder.chmod(0o700)
        (folder / shared).chmod(0o777)
        result = run()
        assert result.exit_code == 0
        assert f"anew: the cache folder {folder / shared} can be written to by other users" in result.output
        assert "set FUZZYCTL_CACHE_DIR to a folder of your own\n" in result.output
        assert [p.name for p in folder.rglob("*")] == [shared] * bool(shared)
        (folder / shared).chmod(0o700)
        assert json.loads(run("--format", "json").output)["cache"]["danger"] is None

    def test_behind_links_nothing_is_removed(self, folder, tmp_path):
        self.write(tmp_path, "other/precious")
        folder.mkdir()
        (folder / "kernels").symlink_to(tmp_path / "other")
        result = run("--clear-cache")
        assert result.exit_code == 1
        assert "kernels is a link, behind which nothing is removed" in result.output
        assert (tmp_path / "other" / "precious").exists()

    def test_files_that_cannot_be_removed_are_counted(self, folder, monkeypatch):
        self.write(folder, "kernels/a.py", "kernels/x/a.nbi", "kernels/x/b.nbc", "dwmr/c.py")
        unlink = Path.unlink

        def refusing(path, **more):
            if path.parent.name == "x":
                raise PermissionError(13, "Permission denied")
            unlink(path, **more)

        # Modes of folders do not hold back root, who may run this.
        monkeypatch.setattr(Path, "unlink", refusing)
        result = run("--clear-cache")
        assert result.exit_code == 1
        assert ": 2 files removed\n" in result.output
        assert f"problem: 2 files of {folder / 'kernels' / 'x'} cannot be removed: Permission denied\n" in result.output
        assert sorted(p.name for p in folder.rglob("*.*")) == ["a.nbi", "b.nbc"]
        data = json.loads(run("--clear-cache", "--format", "json").output)
        assert (data["cache"]["removed"], data["cache"]["files"], len(data["problems"])) == (0, 2, 1)

    def test_folders_that_cannot_be_looked_into_are_named(self, folder, monkeypatch):
        self.write(folder, "kernels/a.py")

        def refusing(place):
            raise PermissionError(13, "Permission denied", place)

        monkeypatch.setattr("os.scandir", refusing)
        result = run("--clear-cache")
        assert result.exit_code == 1
        assert f"problem: {folder / 'kernels'} cannot be looked into: Permission denied" in result.output

    def test_that_cannot_be_written_to_is_reported(self, tmp_path, monkeypatch):
        (tmp_path / "file").write_text("")
        monkeypatch.setenv("FUZZYCTL_CACHE_DIR", str(tmp_path / "file" / "cache"))
        assert "cannot be written to" in run().output

    def test_a_user_without_a_home_has_none(self, monkeypatch):
        def no_home():
            raise RuntimeError("Could not determine home directory.")

        for name in ("FUZZYCTL_CACHE_DIR", "XDG_CACHE_HOME"):
            monkeypatch.delenv(name, raising=False)
        monkeypatch.setattr("fuzzyctl.support.private_folders.Path.home", no_home)
        assert "cache: none, as there is no home" in run().output
        assert "every process compiles anew" in run("--clear-cache").output
