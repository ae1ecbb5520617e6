"""Texts that are kept in files, so that moves and simplifications are seen to change nothing."""

import os
from pathlib import Path

HERE = Path(__file__).parent


def check_kept(folder, name, text):
    """Compare a text with the file that keeps it.

    After an intended change: FUZZYCTL_UPDATE_GOLDEN=1 python -m pytest tests/frozen, then read the difference.
    """
    path = HERE / folder / f"{name}.txt"
    if os.environ.get("FUZZYCTL_UPDATE_GOLDEN"):
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
    assert text == path.read_text(encoding="utf-8")
