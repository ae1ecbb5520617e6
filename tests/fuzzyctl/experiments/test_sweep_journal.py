import os
import resource

import pytest

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.experiments import sweep_journal
from fuzzyctl.experiments.sweep_journal import NAME, Journal
from fuzzyctl.experiments.sweep_workers import Outcome

ABOUT = {"runs": 3, "scenario": {"sha256": "ab"}}


class TestJournal:
    def write(self, folder, count=2):
        with sweep_journal.journal(folder, ABOUT, False) as one:
            for k in range(count):
                one.add(Outcome(k, {"rmse": 0.1 + k, "stop_reason": "σ", "none": None, "nan": float("nan")}, 0.5))
        return (folder / NAME).read_bytes()

    def resumed(self, folder, about=None) -> Journal:
        with sweep_journal.journal(folder, about or ABOUT, True) as one:
            return one

    def test_gives_back_what_was_done(self, tmp_path):
        self.write(tmp_path)
        done = self.resumed(tmp_path).done
        assert list(done) == [0, 1]
        assert done[1].row["rmse"] == 1.1
        assert (done[0].row["stop_reason"], done[0].row["none"], done[0].wall_s) == ("σ", None, 0.5)

    def test_a_record_cut_anywhere_is_noticed_and_cut_off(self, tmp_path):
        whole = self.write(tmp_path)
        first_two = whole[: whole.rindex(b"\n", 0, len(whole) - 1) + 1]
        for length in range(len(first_two), len(whole)):
            (tmp_path / NAME).write_bytes(whole[:length])
            assert list(self.resumed(tmp_path).done) == [0]
            assert (tmp_path / NAME).read_bytes() == first_two

    def test_a_damaged_record_is_done_again(self, tmp_path):
        whole = self.write(tmp_path)
        (tmp_path / NAME).write_bytes(whole.replace(b'"rmse": 1.1', b'"rmse": 1.2'))
        assert list(self.resumed(tmp_path).done) == [0]

    def test_a_torn_header_begins_anew(self, tmp_path):
        whole = self.write(tmp_path, 1)
        (tmp_path / NAME).write_bytes(whole[:40])
        assert self.write(tmp_path, 1) == whole

    def test_without_runs_there_is_nothing_to_keep(self, tmp_path):
        with sweep_journal.journal(tmp_path, ABOUT, False):
            header = (tmp_path / NAME).read_bytes()
        assert not (tmp_path / NAME).exists()
        (tmp_path / NAME).write_bytes(header)
        with sweep_journal.journal(tmp_path, {"runs": 3}, False):
            assert len((tmp_path / NAME).read_bytes()) < len(header)

    @pytest.mark.parametrize(("room", "kept", "repair"), [(10, [], "-o DIR"), (200, [0], "make room, and go on with")])
    def test_a_full_disk_is_reported_with_the_file(self, tmp_path, room, kept, repair):
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, limits[1]))
        try:
            with pytest.raises(DiagnosticError, match=f"{NAME} cannot be written: File too large(?s:.*){repair}"):
                self.write(tmp_path)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert (tmp_path / NAME).exists() == bool(kept)
        assert list(self.resumed(tmp_path).done) == kept

    def test_what_changed_is_named(self, tmp_path):
        self.write(tmp_path)
        with pytest.raises(DiagnosticError, match=r"changed: text of the scenario"):
            self.resumed(tmp_path, {"runs": 3, "scenario": {"sha256": "cd"}})

    def test_is_not_lost_without_asking(self, tmp_path):
        self.write(tmp_path)
        with pytest.raises(DiagnosticError, match="2 of 3 runs") as caught:
            self.write(tmp_path)
        assert "--resume" in str(caught.value)

    def test_two_sweeps_cannot_write_into_it(self, tmp_path):
        self.write(tmp_path)
        with (
            sweep_journal.journal(tmp_path, ABOUT, True),
            pytest.raises(DiagnosticError, match="in use by another sweep"),
        ):
            self.resumed(tmp_path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the platform has no named pipes")
def test_a_journal_that_is_a_pipe_is_refused(tmp_path):
    os.mkfifo(tmp_path / "journal.jsonl")
    with (
        pytest.raises(DiagnosticError, match="is not a regular file"),
        sweep_journal.journal(tmp_path, {}, resume=True),
    ):
        pass


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the platform has no named pipes")
def test_a_description_of_a_sweep_that_is_a_pipe_is_no_sweep(tmp_path):
    os.mkfifo(tmp_path / "sweep.json")
    with pytest.raises(DiagnosticError, match="no sweep wrote that"):
        sweep_journal.require_own(tmp_path, ["sweep.json"])
