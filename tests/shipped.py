"""Shipped rule files: those of fuzzy systems, and those of control laws."""

from pathlib import Path


def rules_folder():
    """Return the folder of the shipped rule files."""
    return Path(__file__).parents[1] / "rules"


_FILES = sorted(rules_folder().glob("*.fz"))
#: Files that hold one fuzzy system.
SYSTEMS = [p for p in _FILES if "\nsystem " in p.read_text(encoding="utf-8")]
#: Files that hold controllers, which call systems of the others.
LAWS = [p for p in _FILES if p not in SYSTEMS]
