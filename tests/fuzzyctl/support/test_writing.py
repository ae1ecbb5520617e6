import os
import resource
import stat
from pathlib import Path

import pytest

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.support.writing import write_together, written_whole


class TestWrittenWhole:
    def test_the_file_appears_when_the_block_ends(self, tmp_path):
        target = tmp_path / "a.txt"
        with written_whole(target) as temporary:
            temporary.write_text("new")
            assert not target.exists()
        assert target.read_text() == "new"
        assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]

    def test_a_failure_leaves_the_old_file_and_nothing_else(self, tmp_path):
        target = tmp_path / "a.txt"
        target.write_text("old")

        def fail():
            with written_whole(target) as temporary:
                temporary.write_text("half")
                raise RuntimeError

        with pytest.raises(RuntimeError):
            fail()
        assert target.read_text() == "old"
        assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]

    def test_permissions_follow_the_umask_or_the_old_file(self, tmp_path):
        target = tmp_path / "a.txt"
        old = os.umask(0o027)
        try:
            with written_whole(target) as temporary:
                temporary.write_text("x")
        finally:
            os.umask(old)
        assert stat.S_IMODE(target.stat().st_mode) == 0o640
        target.chmod(0o600)
        with written_whole(target) as temporary:
            temporary.write_text("y")
        assert stat.S_IMODE(target.stat().st_mode) == 0o600

    def test_a_missing_folder_is_a_diagnostic(self, tmp_path):
        with pytest.raises(DiagnosticError, match="FZ005"), written_whole(tmp_path / "no" / "a.txt"):
            pass

    @pytest.mark.parametrize("link", [False, True])
    def test_what_is_no_regular_file_is_refused_and_stays(self, tmp_path, link):
        pipe = tmp_path / "pipe"
        os.mkfifo(pipe)
        target = pipe
        if link:
            target = tmp_path / "link"
            target.symlink_to(pipe)
        with pytest.raises(DiagnosticError, match="not a regular file"), written_whole(target) as temporary:
            temporary.write_text("new")
        assert stat.S_ISFIFO(pipe.stat().st_mode)
        assert {p.name for p in tmp_path.iterdir()} == {"pipe", target.name}

    def test_a_folder_is_refused_before_anything_is_computed(self, tmp_path):
        def fail():
            with written_whole(tmp_path):
                pytest.fail("the block was entered")

        with pytest.raises(DiagnosticError, match="this is a folder"):
            fail()


class TestWriteTogether:
    @pytest.fixture
    def old(self, tmp_path):
        """An old set whose middle one is missing."""
        for name in ("a.h", "c.txt"):
            (tmp_path / name).write_text(f"old {name}")
        return {tmp_path / name: f"new {name}" for name in ("a.h", "b.c", "c.txt")}

    @staticmethod
    def held(folder):
        return {p.name: p.read_text() for p in folder.iterdir()}

    def test_all_files_are_written_and_nothing_else(self, tmp_path, old):
        write_together(old)
        assert self.held(tmp_path) == {"a.h": "new a.h", "b.c": "new b.c", "c.txt": "new c.txt"}

    def test_a_full_disk_leaves_the_old_set(self, tmp_path, old):
        before = self.held(tmp_path)
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
        try:
            with pytest.raises(DiagnosticError, match=r"b\.c.*cannot be written: File too large"):
                write_together(old | {tmp_path / "b.c": "x" * 1001})
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert self.held(tmp_path) == before

    @pytest.mark.parametrize("last", ["b.c", "c.txt"])
    @pytest.mark.parametrize("moves", [False, True])
    @pytest.mark.parametrize("error", [OSError(5, "Input/output error"), KeyboardInterrupt()])
    def test_a_file_that_cannot_be_moved_leaves_the_old_set(self, tmp_path, old, monkeypatch, last, error, moves):
        before, replace = self.held(tmp_path), Path.replace

        def failing(path, target):
            if Path(target).name == last and "new" in path.read_text():
                if moves:  # an interrupt may come right after the last step
                    replace(path, target)
                raise error
            return replace(path, target)

        monkeypatch.setattr(Path, "replace", failing)
        with pytest.raises((DiagnosticError, KeyboardInterrupt)):
            write_together(old)
        assert self.held(tmp_path) == before

    def test_permissions_stay(self, tmp_path, old):
        (tmp_path / "a.h").chmod(0o640)
        write_together(old)
        assert stat.S_IMODE((tmp_path / "a.h").stat().st_mode) == 0o640

    def test_a_folder_in_the_place_of_one_leaves_the_others(self, tmp_path, old):
        (tmp_path / "b.c").mkdir()
        with pytest.raises(DiagnosticError, match="this is a folder"):
            write_together(old)
        assert (tmp_path / "a.h").read_text() == "old a.h"
