"""File names and axes of pictures, chosen without matplotlib."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from fuzzyctl.formats.common.identifiers import identifier

#: Most bytes of one name in the name of a file; file systems take 255 for the whole.
LONGEST: Final = 100


def file_part(name: str, others: Iterable[str] = ()) -> str:
    """Return a name as a part of a file's name: without separators, short, and none of those taken."""
    used = set(others)
    part = _short(identifier(name))
    while part in used:
        part = identifier(part, used)
    return part


def _short(name: str) -> str:
    """Return as many whole characters of a name as the bytes have room for."""
    return name.encode()[:LONGEST].decode(errors="ignore")


def chosen_axes(inputs: Sequence[str], x: str | None, y: str | None, fixed: Mapping[str, float]) -> list[str]:
    """Return the one or two axes: those named, else the first inputs that have no value.

    Args:
        inputs: Names of all inputs.
        x: Input along the first axis, if it is named.
        y: Input along the second axis, if it is named.
        fixed: Values of inputs.
    """
    free = [name for name in inputs if name not in fixed and name not in (x, y)]
    if x is None and y is None:
        return free[:2] if free else list(inputs[:1])
    if y is None:
        assert x is not None
        # With one axis named, a value of another input asks for a curve.
        return [x] if fixed or not free else [x, free[0]]
    return [x, y] if x is not None else [free[0], y] if free else [y]
