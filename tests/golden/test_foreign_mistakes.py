"""Files of other tools with one mistake each: every one is answered at its place, in words of its format.

Each heading of foreign_mistakes.txt has a file, a part of it and its replacement; errors follow, or else warnings.
After a new line, or an intended change of wording: FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest
tests/golden/test_foreign_mistakes.py, then read the difference.
"""

import os
import re
from pathlib import Path

from tests.fuzzyctl.formats.files import SAMPLES, examined

TABLE = Path(__file__).parent / "foreign_mistakes.txt"
CASES = re.findall(r"^--- ([\w.]+): (.*?) -> (.*)$", TABLE.read_text(encoding="utf-8"), re.MULTILINE)


def answer(name, old, new):
    """Return the answer to a file with a mistake as the table has it."""
    old, changed = old.replace("\\n", "\n"), new.replace("\\n", "\n")
    assert old in SAMPLES[name], (name, old)
    system, found = examined(name, SAMPLES[name].replace(old, changed, 1))
    errors = [d for d in found if d.severity == "error"]
    assert errors or system is not None
    assert all(d.span is not None for d in errors)
    shown = errors or [d for d in found if d.severity == "warning"]
    assert shown, (name, old, new)
    return "".join(f"{d}\n" for d in shown)


def test_they_are_as_in_the_table():
    parts = [f"--- {n}: {old} -> {new}\n{answer(n, old, new)}" for n, old, new in CASES]
    shown = "\n".join(parts)
    if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        TABLE.write_text(shown, encoding="utf-8", newline="\n")
    assert TABLE.read_text(encoding="utf-8") == shown
