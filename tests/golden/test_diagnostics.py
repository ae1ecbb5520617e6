"""Each diagnostic code has a rule file that provokes it and the text it gives.

After an intended change of wording: FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest tests/golden, then read the difference.
"""

import os
import re
from pathlib import Path

import pytest

from fuzzyctl.diagnostics.diagnostic import CODES
from fuzzyctl.testing import run_command

FOLDER = Path(__file__).parent / "diagnostics"
FILES = sorted(FOLDER.glob("*.fz"))

#: Codes that no rule file can provoke: they belong to files as such, to values given to commands, to
#: fixed point, to files of other tools, to runs, and to scenarios.
ELSEWHERE = {"FZ001", "FZ002", "FZ003", "FZ005", "FZ006", "FZ112", "FZ410"} | {c for c in CODES if c[2] in "5679"}


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_a_mistake_gives_its_message_and_no_other_error(path):
    shown = run_command("check", path.name, folder=FOLDER).errors
    text = re.sub(r"\n\n?(?:\d+ errors?, .*\n)?$", "\n", shown)
    golden = path.with_suffix(".txt")
    if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        golden.write_text(text, encoding="utf-8")
    assert text == golden.read_text(encoding="utf-8")
    assert f"[{path.stem}]" in text
    assert text.count("error[FZ") <= 1


def test_every_code_has_a_golden_file():
    assert {p.stem for p in FILES} == set(CODES) - ELSEWHERE
