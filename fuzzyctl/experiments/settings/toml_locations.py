"""Locations of the keys of a TOML text."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping

Path = tuple[str, ...]

_KEY = r'(?:[A-Za-z0-9_-]+|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\')'
_DOTTED = rf"{_KEY}(?:\s*\.\s*{_KEY})*"
_HEADER = re.compile(rf"^\s*(\[\[?)\s*({_DOTTED})\s*\]\]?")
_PAIR = re.compile(rf"^\s*({_DOTTED})\s*=")


def key_places(text: str) -> Mapping[Path, tuple[int, int]]:
    """Return the character range of every key that begins a line, by its full path.

    Keys inside inline tables and arrays have no line of their own; look up their parent. The text must be valid TOML,
    so a line inside a multi-line string that looks like a key can only mislead a diagnostic's line, never its content.

    Args:
        text: A TOML document.
    """
    places: dict[Path, tuple[int, int]] = {}
    counts: dict[Path, int] = {}
    table: Path = ()
    offset = 0
    for line in text.splitlines(keepends=True):
        if header := _HEADER.match(line):
            table = _resolve(_parts(header[2]), counts)
            if header[1] == "[[":
                index = counts.get(table, -1) + 1
                counts[table] = index
                table = (*table, str(index))
            places.setdefault(table, (offset + header.start(2), offset + header.end(2)))
        elif pair := _PAIR.match(line):
            places.setdefault((*table, *_parts(pair[1])), (offset + pair.start(1), offset + pair.end(1)))
        offset += len(line)
    return places


def _parts(dotted: str) -> Path:
    return tuple(_unquoted(p) for p in re.findall(_KEY, dotted))


def _unquoted(key: str) -> str:
    """Return a part of a key without its quotes and escapes."""
    return str(tomllib.loads(f"key = {key}")["key"]) if key[0] in "\"'" else key


def _resolve(path: Path, counts: Mapping[Path, int]) -> Path:
    """Put the current index after every part that is an array of tables, except the last."""
    resolved: Path = ()
    for k, part in enumerate(path):
        resolved = (*resolved, part)
        if k + 1 < len(path) and resolved in counts:
            resolved = (*resolved, str(counts[resolved]))
    return resolved
