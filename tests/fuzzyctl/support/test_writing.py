"""Files are written completely or not at all, and sets of files together."""

import os
import resource
import stat
from pathlib import Path

import pytest

from fuzzyctl import DiagnosticError, dump, dumps, load
from fuzzyctl.testing import run_command

TIPPER = load("tipper")


def held(folder):
    return {p.name: p.read_text() for p in folder.iterdir() if p.is_file()}


@pytest.fixture
def full(monkeypatch):
    """Let files of this process have no more bytes than a number."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda most: resource.setrlimit(resource.RLIMIT_FSIZE, (most, limits[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, limits)


class TestOneFile:
    def test_a_failure_leaves_the_old_file_and_no_other(self, tmp_path, full):
        target = tmp_path / "a.fz"
        target.write_text("old")
        full(100)
        with pytest.raises(DiagnosticError, match="cannot be written: File too large"):
            dump(TIPPER, target)
        full(10_000)
        assert held(tmp_path) == {"a.fz": "old"}
        dump(TIPPER, target)
        assert held(tmp_path) == {"a.fz": dumps(TIPPER)}

    def test_permissions_follow_the_umask_or_the_old_file(self, tmp_path):
        target = tmp_path / "a.fz"
        old = os.umask(0o027)
        try:
            dump(TIPPER, target)
        finally:
            os.umask(old)
        assert stat.S_IMODE(target.stat().st_mode) == 0o640
        target.chmod(0o600)
        dump(TIPPER, target)
        assert stat.S_IMODE(target.stat().st_mode) == 0o600

    def test_a_missing_folder_and_a_folder_are_diagnostics(self, tmp_path):
        with pytest.raises(DiagnosticError, match="FZ005"):
            dump(TIPPER, tmp_path / "no" / "a.fz")
        with pytest.raises(DiagnosticError, match="this is a folder"):
            dump(TIPPER, tmp_path)

    @pytest.mark.parametrize("name", ["pipe", "link"])
    def test_a_pipe_and_a_link_to_it_are_refused_and_stay(self, tmp_path, name):
        os.mkfifo(tmp_path / "pipe")
        (tmp_path / "link").symlink_to(tmp_path / "pipe")
        with pytest.raises(DiagnosticError, match="not a regular file"):
            dump(TIPPER, tmp_path / name)
        assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)
        assert {p.name for p in tmp_path.iterdir()} == {"pipe", "link"}


class TestSets:
    @pytest.fixture
    def old(self, tmp_path):
        """An old set of files of generated code, whose last one is missing."""
        for name in ("tipper.h", "tipper.c"):
            (tmp_path / name).write_text(f"old {name}")
        return held(tmp_path)

    def write(self, folder):
        return run_command("codegen", "tipper", "--target", "c", "-o", folder)

    def test_all_files_are_written_with_their_old_permissions_and_no_others(self, tmp_path, old):
        (tmp_path / "tipper.h").chmod(0o640)
        assert self.write(tmp_path).exit_code == 0
        assert sorted(held(tmp_path)) == ["tipper.c", "tipper.h", "tipper_selftest.c"]
        assert stat.S_IMODE((tmp_path / "tipper.h").stat().st_mode) == 0o640

    def test_a_full_disk_leaves_the_old_set(self, tmp_path, old, full):
        full(3000)
        result = self.write(tmp_path)
        full(1 << 20)
        assert (result.exit_code, held(tmp_path)) == (1, old)
        assert "cannot be written: File too large" in result.errors

    @pytest.mark.parametrize("last", ["tipper.c", "tipper_selftest.c"])
    @pytest.mark.parametrize("moves", [False, True])
    @pytest.mark.parametrize("error", [OSError(5, "Input/output error"), KeyboardInterrupt()])
    def test_a_file_that_cannot_be_moved_leaves_the_old_set(self, tmp_path, old, monkeypatch, last, error, moves):
        replace = Path.replace

        def failing(path, target):
            if Path(target).name == last and not path.read_text().startswith("old"):
                if moves:  # an interrupt may come right after the last step
                    replace(path, target)
                raise error
            return replace(path, target)

        monkeypatch.setattr(Path, "replace", failing)
        assert self.write(tmp_path).exit_code != 0
        assert held(tmp_path) == old

    def test_a_folder_in_the_place_of_one_leaves_the_others(self, tmp_path, old):
        (tmp_path / "tipper_selftest.c").mkdir()
        assert "this is a folder" in self.write(tmp_path).errors
        assert held(tmp_path) == old
