import os
import stat

import pytest

from fuzzyctl.errors import DiagnosticError
from fuzzyctl.files import written_whole


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
        with pytest.raises(DiagnosticError, match="no regular file"), written_whole(target) as temporary:
            temporary.write_text("new")
        assert stat.S_ISFIFO(pipe.stat().st_mode)
        assert {p.name for p in tmp_path.iterdir()} == {"pipe", target.name}

    def test_a_folder_is_refused_before_anything_is_computed(self, tmp_path):
        def fail():
            with written_whole(tmp_path):
                pytest.fail("the block was entered")

        with pytest.raises(DiagnosticError, match="this is a folder"):
            fail()
