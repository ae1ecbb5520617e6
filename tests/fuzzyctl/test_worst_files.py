"""Files at the limits of the language, made smaller, are checked within counted work and a generous processor time."""

import sys
import time
from pathlib import Path

import pytest

from fuzzyctl import loading
from fuzzyctl.analysis.holes import BUDGET
from fuzzyctl.analysis.work import SpentError, Work
from fuzzyctl.checking import check_source
from fuzzyctl.loading import load
from fuzzyctl.reading import read_source

sys.path.insert(0, str(Path(__file__).parent.parent / "fuzz"))
from worst_files import CASES  # its folder is no package

#: Cases whose cost does not shrink with the file, or that took hours, with the size at which they are tried here.
TRIED = {
    "blank-lines-in-a-parenthesis": 0.2,
    "a-hedge-that-turns-often-in-a-row": 1.0,
    "names-in-one-terms-line": 0.2,
    "own-hedges-of-consequents": 1.0,
    "own-hedges-that-turn-often": 0.05,
    "long-unknown-names": 0.2,
    "one-rule-over-20-inputs": 1.0,
    "one-rule-over-20-inputs-without-else": 1.0,
    "one-rule-over-90-inputs-without-else": 1.0,
    "one-rule-over-nested-inputs": 1.0,
    "small-systems": 0.5,
    "systems-that-share-much": 0.2,
    "tables-from-one-csv-file": 0.05,
    "used-systems": 0.05,
}


@pytest.mark.parametrize(("name", "size"), TRIED.items())
def test_a_file_at_a_limit_is_checked_in_little_time(name, size, tmp_path):
    files = CASES[name](size)
    for file, text in files.items():
        (tmp_path / file).write_text(text, encoding="utf-8")
    started = time.process_time()
    check_source(read_source(tmp_path / next(iter(files))), folder=tmp_path)
    assert time.process_time() - started < 10.0


class TestWork:
    def test_of_a_part_is_that_of_the_whole(self):
        whole = Work(100)
        part = whole.part(30)
        assert part.takes(20)
        assert (part.left, whole.left) == (10, 80)
        with pytest.raises(SpentError):
            part.spend(11)
        assert (part.left, whole.left) == (0, 70)

    def test_suffices_for_less_than_a_check(self):
        assert Work().left > BUDGET


class TestSystems:
    def test_more_than_the_limit_are_refused_with_a_repair(self):
        from fuzzyctl.errors import DiagnosticError

        text = "".join(f"system s{k}\n" for k in range(loading.MAX_SYSTEMS + 1))
        with pytest.raises(DiagnosticError, match="holds 201 systems, more than 200"):
            loading.loads(text)


class TestUsedFiles:
    def test_each_is_read_once_however_many_ways_lead_to_it(self, tmp_path):
        """Layers of two files that use both files of the next layer: 2^20 ways from the first to the last."""
        body = "input x in [0, 1]\n  terms a b\noutput y in [0, 1] else 0\n  terms c d\nif x is a then y is c\n"
        for layer in range(20):
            for side in "lr":
                uses = "".join(f'use "{layer + 1}{other}.fz"\n' for other in "lr") if layer < 19 else ""
                text = f"{uses}system s{layer}{side}\n{body}"
                claim = f"require y == s{layer + 1}{side}.y\n" if layer < 19 else ""
                (tmp_path / f"{layer}{side}.fz").write_text(text + claim, encoding="utf-8")
        assert load(tmp_path / "0l.fz").compared[0].name == "s1l"
