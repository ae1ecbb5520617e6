"""File names of pictures, safe for any name of a system."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from fuzzyctl.formats.common.identifiers import identifier

#: Most bytes of one name in the name of a file; file systems take 255 for the whole.
LONGEST: Final = 100


def file_part(name: str, taken: Iterable[str] = ()) -> str:
    """Return a name as a part of a file's name: without separators, short, and none of those taken."""
    used = set(taken)
    found = _short(identifier(name))
    while found in used:
        found = identifier(found, used)
    return found


def _short(name: str) -> str:
    """Return as many whole characters of a name as the bytes have room for."""
    return name.encode()[:LONGEST].decode(errors="ignore")
