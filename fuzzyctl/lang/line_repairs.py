"""Repairs of one line: those that it needs, one after the other, until it can be read.

First come the repairs that know what was meant, in their order. Where they do not suffice, repairs are combined: those
after which more of the line can be read are kept, and tokens are changed where reading stops.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang.character_repairs import CHARACTERS
from fuzzyctl.lang.edits import Draft, Edit, Repair, Surroundings
from fuzzyctl.lang.lines import LineKind, LogicalLine, split
from fuzzyctl.lang.notations import SPELLING, STATEMENTS
from fuzzyctl.lang.rule_repairs import RULES
from fuzzyctl.lang.term_repairs import TERMS
from fuzzyctl.lang.token_repairs import changes_near, token_changes

#: Longer lines, and lines with longer gaps, are not repaired: they are no slips, and patterns would take long.
_LONGEST: Final = 300
_GAP: Final = re.compile(r"\s{41}")
#: In longer lines tokens are left alone: there are too many changes to try.
_LONGEST_OF_TOKENS: Final = 160

#: Largest number of tokens that are changed in a line, drafts that are followed for each, and readings of a line.
_TOKENS: Final = 3
_DRAFTS: Final = 4
_READINGS: Final = 1_000

_REPAIRS: Final[tuple[Repair, ...]] = (*STATEMENTS, *TERMS, *RULES, *SPELLING)

#: Says where reading a line of a text stops; None where all of it can be read.
Stops = Callable[[SourceText, LogicalLine, LineKind], "int | None"]


@dataclass
class Reading:
    """How a line is read.

    Args:
        stops: Says where reading a line stops.
        kind: What the line is, where that cannot be seen from the line alone.
        in_block: The first word of the controller, plant or loop that it belongs to; empty for none.
        left: How often it may still be read.
    """

    stops: Stops
    kind: LineKind
    in_block: str
    left: int = _READINGS

    def unread(self, text: str) -> int:
        """Return how many characters of a text are left where reading stops; 0 where all can be read."""
        self.left -= 1
        source = SourceText("", text)
        for line in split(source):
            if line.kind == "blank":
                continue
            known = self.kind if line.kind == "unknown" or self.kind == "block_statement" else line.kind
            at = self.stops(source, replace(line, in_block=line.in_block or self.in_block), known)
            if at is not None:
                return max(len(text) - at, 1)
            # The kinds of brackets are those of ranges, which may be half open in blocks.
            if line.mistake is not None and (line.mistake.code != "FZ103" or self.kind != "block_statement"):
                return 1
        return 0

    def reads(self, text: str) -> bool:
        """Return whether all lines of a text can be read."""
        return self.unread(text) == 0


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
    for repair in _REPAIRS:
        after = current.repaired_by(repair, around)
        if after is not current:
            made.append(repair)
            if reading.reads(after.text):
                return _needed(draft, made, around, reading)
        current = after
    for repair in _REPAIRS:
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


def combined(draft: Draft, known: Sequence[Edit], around: Surroundings, reading: Reading) -> Draft | None:
    """Return a line after a combination of repairs and changes of tokens; None where none makes it readable.

    Args:
        draft: The line as it was written.
        known: Edits of the line that may be among them.
        around: What stands around it.
        reading: How it is read, and how often.
    """
    edited = draft.edited(known)
    found = _combined(edited, around, reading) if known else None
    return found or _combined(draft, around, reading)


def _combined(draft: Draft, around: Surroundings, reading: Reading) -> Draft | None:
    if len(draft.text) > _LONGEST_OF_TOKENS or "\n" in draft.text or _GAP.search(draft.text):
        return None
    # Its characters are read as they are repaired, where they are no part of a line.
    for repair in CHARACTERS:
        draft = draft.repaired_by(repair, around)
    draft, comment = draft.before_comment()
    found = _search(draft, around, reading)
    return None if found is None else found.followed_by(comment)


def _search(draft: Draft, around: Surroundings, reading: Reading) -> Draft | None:
    drafts = [_climbed(draft, around, reading)]
    for _ in range(_TOKENS):
        for d in drafts:
            found = d if reading.reads(d.text) else _by_repairs(d, around, reading) or _by_one_token(d, around, reading)
            if found is not None:
                return found
        nearer: dict[str, tuple[int, int, Draft]] = {}
        for d in drafts:
            unread = reading.unread(d.text)
            for rank, change in changes_near(d.text, len(d.text) - unread, in_table=around.block == "table"):
                after = d.edited([change])
                left = reading.unread(after.text)
                if left < unread and "".join(after.text.split()) not in nearer:
                    nearer["".join(after.text.split())] = (left, rank, after)
                if reading.left <= 0:
                    return None
        best = sorted(nearer.values(), key=lambda n: n[:2])[:_DRAFTS]
        drafts = [_climbed(d, around, reading) for _, _, d in best]
    return None


def _climbed(draft: Draft, around: Surroundings, reading: Reading) -> Draft:
    """Return a line after each repair that makes more of it readable."""
    unread, before = reading.unread(draft.text), -1
    while unread not in (0, before):
        before = unread
        for repair in _REPAIRS:
            after = draft.repaired_by(repair, around)
            left = unread if after is draft else reading.unread(after.text)
            if left < unread:
                draft, unread = after, left
    return draft


def _by_one_token(draft: Draft, around: Surroundings, reading: Reading) -> Draft | None:
    """Return a line after the change of one token; None where none, or more than one of its kind, makes it readable."""
    for changes in token_changes(draft.text, in_table=around.block == "table"):
        found: dict[str, Draft] = {}
        for change in changes:
            if reading.left <= 0:
                return None
            after = draft.edited([change])
            form = "".join(after.text.split())
            if form not in found and reading.reads(after.text):
                found[form] = after
        if found:
            return next(iter(found.values())) if len(found) == 1 else None
    return None
