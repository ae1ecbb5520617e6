"""Changes between the controllers, plants and loops of two files, statement by statement."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from fuzzyctl.comparison.changes import Change, Kind

if TYPE_CHECKING:
    from fuzzyctl.model.controller import EquationBlock


def block_changes(
    first: Sequence[EquationBlock], second: Sequence[EquationBlock]
) -> list[tuple[str, tuple[Change, ...]]]:
    """Return what differs between the blocks of the same kind and name, as `KIND NAME` with its changes.

    The order of statements does not count.
    """
    before, after = ({f"{b.kind} {b.name}": b for b in blocks} for blocks in (first, second))
    found = []
    for name in dict.fromkeys([*before, *after]):
        one, other = before.get(name), after.get(name)
        if one != other:
            found.append((name, tuple(_changes(name, one, other))))
    return found


def _changes(name: str, one: EquationBlock | None, other: EquationBlock | None) -> Iterator[Change]:
    if one is None or other is None:
        kind: Kind = "added" if one is None else "removed"
        keyword, _, own = name.partition(" ")
        texts = (None, "in the second file only") if one is None else ("in the first file only", None)
        yield Change(kind, keyword, own, *texts)
        return
    before, after = _statements(one), _statements(other)
    for key in dict.fromkeys([*before, *after]):
        old, new = before.get(key), after.get(key)
        if old != new:
            yield Change("added" if old is None else "removed" if new is None else "changed", *key, old, new)


def _statements(block: EquationBlock) -> dict[tuple[str, str], str]:
    """Return the statements of a block by keyword and name; claims by their text."""
    from fuzzyctl.formats.fz_blocks import sections

    found = {("title", ""): block.title, ("source", ""): block.citation}
    for line in sections(block):
        keyword, _, rest = line.partition(" ")
        name = rest.partition(" ")[0].partition("(")[0] if keyword not in ("every", "run", "require") else ""
        found[keyword, rest if keyword == "require" else name] = line
    found.pop(("", ""), None)
    return {key: text for key, text in found.items() if text}
