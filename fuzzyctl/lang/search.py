"""Search for the repairs that a broken line needs: what they give is seen by reading the line again."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang.edits import Draft, Repair, Surroundings
from fuzzyctl.lang.lines import LineKind, LogicalLine, split
from fuzzyctl.lang.repairs import CHARACTERS, ROWS

#: Longer lines, and lines with longer gaps, are not repaired: they are no slips, and patterns would take long.
_LONGEST: Final = 300
_GAP: Final = re.compile(r"\s{41}")
#: Says where reading a line of a text stops; None where all of it can be read.
Stops = Callable[[SourceText, LogicalLine, LineKind], "int | None"]


@dataclass
class Reading:
    """How a line is read.

    Args:
        stops: Says where reading a line stops.
        kind: What the line is, where that cannot be seen from the line alone.
        in_block: The first word of the controller, plant or loop that it belongs to; empty for none.
    """

    stops: Stops
    kind: LineKind
    in_block: str

    def reads(self, text: str) -> bool:
        """Return whether all lines of a text can be read."""
        source = SourceText("", text)
        for line in split(source):
            if line.kind == "blank":
                continue
            known = self.kind if line.kind == "unknown" or self.kind == "block_statement" else line.kind
            if self.stops(source, replace(line, in_block=line.in_block or self.in_block), known) is not None:
                return False
            # The kinds of brackets are those of ranges, which may be half open in blocks.
            if line.mistake is not None and (line.mistake.code != "FZ103" or self.kind != "block_statement"):
                return False
        return True


def kind_of(line: LogicalLine, around: Surroundings) -> LineKind:
    """Return what a line is meant to be: a header with bars is none by its form, a row is known by its bar."""
    if around.block == "table" and around.is_first and line.kind == "row":
        return "header"
    return "block_statement" if line.in_block and line.kind == "unknown" else line.kind


def repaired_line(draft: Draft, around: Surroundings, reading: Reading) -> tuple[Draft, bool]:
    """Return a line after repairs that know what was meant, and whether it can be read then.

    Edits of characters that no valid line holds are kept in any case.
    """
    if len(draft.text) > _LONGEST or _GAP.search(draft.text) or reading.reads(draft.text):
        return draft, False
    sure = draft
    for repair in CHARACTERS:
        sure = sure.repaired_by(repair, around)
    if sure is not draft and reading.reads(sure.text):
        return sure, True
    # Repairs of the end of a line expect it before the comment.
    code, comment = (sure, None) if "\n" in sure.text else sure.before_comment()
    fixed = _by_repairs(code, around, reading)
    if fixed is None:
        return sure, False
    return fixed if comment is None else fixed.followed_by(comment), True


def _by_repairs(draft: Draft, around: Surroundings, reading: Reading) -> Draft | None:
    """Return a line after the repairs that it needs; None where it cannot be read after any."""
    current, made = draft, list[Repair]()
    for repair in ROWS:
        after = current.repaired_by(repair, around)
        if after is not current:
            made.append(repair)
            if reading.reads(after.text):
                return _needed(draft, made, around, reading)
        current = after
    for repair in ROWS:
        alone = draft.repaired_by(repair, around)
        if alone is not draft and reading.reads(alone.text):
            return alone
    return None


def _needed(draft: Draft, repairs: list[Repair], around: Surroundings, reading: Reading) -> Draft:
    """Return a line after those of some repairs without which it cannot be read; the last one is."""
    for repair in repairs[:-1]:
        fewer = [r for r in repairs if r is not repair]
        if reading.reads(_after(draft, fewer, around).text):
            repairs = fewer
    return _after(draft, repairs, around)


def _after(draft: Draft, repairs: list[Repair], around: Surroundings) -> Draft:
    for repair in repairs:
        draft = draft.repaired_by(repair, around)
    return draft
