"""Error recovery: a line with a known error is repaired, reported, and parsed as repaired.

A line that fails goes through the repairs of lang/repairs.py. Edits of characters that no valid line
holds are kept in any case; all others only when the line can be read with them. The repaired file is read again, since
the repaired line may be the head of a block, until nothing more can be repaired.
"""

from __future__ import annotations

import dataclasses
import re
from bisect import bisect_right
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.fixes import Fix, Replacement
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.edits import Declared, Draft, Edit, Repair, Surroundings
from fuzzyctl.lang.lines import LineKind, LogicalLine, split
from fuzzyctl.lang.repaired_text import RepairedText, in_original
from fuzzyctl.lang.repairs import CHARACTERS, COMMENT, ROWS
from fuzzyctl.lang.syntax import STATEMENT_KEYWORDS

#: Longer lines, and lines with longer gaps, are not repaired: they are not slips, and patterns would take long.
_LONGEST: Final = 300
_GAP: Final = re.compile(r"\s{41}")
#: Says where reading a line of a text stops; None where all of it can be read.
Stops = Callable[[SourceText, LogicalLine, LineKind], "int | None"]


@dataclass
class Reading:
    """How a line is read.

    Args:
        stops: Says where reading a line stops.
        kind: The kind of the line, if the line alone does not show it.
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
            kind = self.kind if line.kind == "unknown" or self.kind == "block_statement" else line.kind
            if self.stops(source, replace(line, in_block=line.in_block or self.in_block), kind) is not None:
                return False
            # The kinds of brackets are those of ranges, which may be half open in blocks.
            if line.mistake is not None and (line.mistake.code != "FZ103" or self.kind != "block_statement"):
                return False
        return True


def kind_of(line: LogicalLine, around: Surroundings) -> LineKind:
    """Return the intended kind of a line: a header with bars is malformed, and a row is known by its bar."""
    if around.block == "table" and around.is_first and line.kind == "row":
        return "header"
    return "block_statement" if line.in_block and line.kind == "unknown" else line.kind


def repaired_line(draft: Draft, around: Surroundings, reading: Reading) -> tuple[Draft, bool]:
    """Return a line after sure repairs, and whether it can be read then.

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
    current, repairs = draft, list[Repair]()
    for repair in ROWS:
        after = current.repaired_by(repair, around)
        if after is not current:
            repairs.append(repair)
            if reading.reads(after.text):
                return _needed(draft, repairs, around, reading)
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


#: Largest number of rounds of reading a file again; each round shows mistakes that the previous one uncovered.
_ROUNDS: Final = 4

#: Characters that are read in all rounds together; a longer text is repaired in one.
_READ: Final = 200_000

#: Characters of the lines repaired in one round, so that hostile files take no longer than others.
_MOST: Final = 10_000

_RULE: Final = re.compile(r"[ \t]*((?:else[ \t]+)?if\b[^\n#]*)", re.IGNORECASE)

_LAST_WORD: Final = re.compile(rf"{sx.NAME}\Z")

#: Longer chains of `else if` are not repaired.
_CHAIN: Final = 10

#: The result of reading a text: the tree, the mistakes, and those of lines in the form of other tools.
Found = tuple[sx.SyntaxTree, list[Diagnostic], list[Diagnostic]]
#: Reads a text.
Read = Callable[[SourceText], Found]


def recover(source: SourceText, found: Found, read: Read, stops: Stops) -> tuple[sx.SyntaxTree, list[Diagnostic]]:
    """Read a text again after each round of repairs.

    Args:
        source: The text.
        found: The parts that were read of it.
        read: Reads a whole text.
        stops: Says where reading one line stops.

    Returns:
        The tree of the repaired text, and the diagnostics by their locations in the text as it was written.
    """
    text: SourceText = source
    tree, mistakes, foreign = found
    reports: dict[int, Diagnostic] = {}
    for _ in range(max(1, min(_ROUNDS, _READ // (len(source.text) + 1)))):
        if not mistakes and not foreign:
            break
        repaired = _repaired(source, text, [*mistakes, *foreign], stops, reports)
        if repaired is None:
            break
        text = repaired
        tree, mistakes, foreign = read(text)
    tree = dataclasses.replace(
        tree, repaired=bool(reports) and not mistakes, unread=tree.unread | _half_typed(source, reports.values())
    )
    return tree, _joined(source, reports.values(), map(in_original, mistakes))


def _half_typed(source: SourceText, reports: Iterable[Diagnostic]) -> set[str]:
    """Return the last words of lines whose parentheses were closed for them: there typing may have stopped."""
    fixes = [d.fix for d in reports if d.code == "FZ103" and d.fix is not None]
    ends = [r.span.start for fix in fixes for r in fix.replacements if r.text.strip(")]") == ""]
    words = (_LAST_WORD.search(source.text, source.text.rfind("\n", 0, end) + 1, end) for end in ends)
    return {word[0] for word in words if word is not None}


def _joined(source: SourceText, reports: Iterable[Diagnostic], mistakes: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return all diagnostics in order; other mistakes of a repaired line become facts of its report."""
    by_line = {d.span.line: d for d in reports if d.span is not None}
    rest = []
    for d in mistakes:
        report = by_line.get(d.span.line) if d.span is not None else None
        if report is None or d.span is None:
            rest.append(d)
        else:
            fact = f"column {d.span.column}: {d.message}"
            by_line[d.span.line] = dataclasses.replace(report, facts=(*report.facts, fact))
    return sorted((*by_line.values(), *rest), key=lambda d: d.span.start if d.span is not None else -1)


def _repaired(
    source: SourceText,
    text: SourceText,
    mistakes: Iterable[Diagnostic],
    stops: Stops,
    reports: dict[int, Diagnostic],
) -> RepairedText | None:
    """Return a text after one round of repairs and enter their reports; None without a change."""
    size = len(text.text)
    origin = text.origin if isinstance(text, RepairedText) else range(size + 1)
    ends = text.ends if isinstance(text, RepairedText) else range(1, size + 1)
    # Where reading stopped the line itself may be right.
    placed = [
        (d.span.start, d) for d in mistakes if d.span is not None and d.code != "FZ112" and not _touches_other_lines(d)
    ]
    last = max((start for start, _ in placed), default=-1)
    lines = [line for line in takewhile(lambda line: line.start <= last, split(text)) if line.kind != "blank"]
    starts = [line.start for line in lines]
    first: dict[int, Diagnostic] = {}
    for start, d in placed:
        first.setdefault(bisect_right(starts, start) - 1, d)
    pieces: list[str] = []
    origins: list[int] = []
    all_ends: list[int] = []
    at = 0
    spent = 0
    for k, line, around in _surrounded(text.text, lines, first):
        spent += line.end - line.start
        if spent > _MOST:
            break
        for stop in _ends(text.text, line):
            part = slice(line.start, stop)
            draft = Draft(text.text[part], list(origin[line.start : stop + 1]), list(ends[part]))
            fixed, whole = repaired_line(draft, around, Reading(stops, kind_of(line, around), line.in_block))
            if whole:
                break
        if fixed is draft:
            continue
        place = min(e.start for e in fixed.edits)
        reports[place] = _report(source, fixed, first[k], whole=whole)
        pieces += [text.text[at : line.start], fixed.text]
        origins += [*origin[at : line.start], *fixed.origin[:-1]]
        all_ends += [*ends[at : line.start], *fixed.ends]
        at = stop
    if not pieces:
        return None
    pieces.append(text.text[at:])
    origins += origin[at:]
    all_ends += ends[at:]
    return RepairedText(source.name, "".join(pieces), source.encoding, source, origins, all_ends)


def _touches_other_lines(d: Diagnostic) -> bool:
    """Whether the fix of a mistake changes another line than its own."""
    return d.fix is not None and d.span is not None and any(r.span.line != d.span.line for r in d.fix.replacements)


def _surrounded(
    text: str, lines: Sequence[LogicalLine], wanted: Container[int]
) -> Iterator[tuple[int, LogicalLine, Surroundings]]:
    """Yield the lines of some numbers, each with those above it; lines above are read once for all of them."""
    declared = Declared(text)
    chain: tuple[str, ...] = ()
    statement, is_first = "", False
    for k, line in enumerate(lines):
        if k in wanted:
            yield (
                k,
                line,
                Surroundings(declared, chain if len(chain) <= _CHAIN else (), statement, is_first, line.in_block),
            )
        word = line.word.lower()
        is_first = word in STATEMENT_KEYWORDS
        if word in STATEMENT_KEYWORDS and word != "terms":
            statement = text[line.start : line.end].strip()
        rule = _RULE.match(text, line.start, line.end) if word in ("if", "else") else None
        if rule is not None and word == "if":
            chain = (rule[1].strip(),)
        elif rule is not None and len(chain) <= _CHAIN:
            chain = (*chain, rule[1].strip())


def _ends(text: str, line: LogicalLine) -> tuple[int, ...]:
    """Return where the first line of text ends, and where the logical line that an open parenthesis continues.

    The longer one comes first where its parentheses are closed.
    """
    first = text.find("\n", line.start, line.end)
    ends = (line.end,) if first < 0 else (first, line.end)
    return ends if line.mistake is not None else ends[::-1]


def _report(source: SourceText, draft: Draft, first: Diagnostic, *, whole: bool) -> Diagnostic:
    """Return the diagnostic of a repaired line, whose sentences are made of its edits."""
    edits = sorted(draft.edits, key=lambda e: (e.start, e.end))
    lead = next((e for e in edits if source.text[e.start : e.end].strip()), edits[0])
    facts, reasons = [], {lead.why}
    for e in edits:
        if e is lead:
            continue
        column = source.column_of(e.start)
        facts.append(f"column {column}: {_instruction(source, e)}{'' if e.why in reasons else f': {e.why}'}")
        reasons.add(e.why)
    written = [line.strip() for line in draft.text.split("\n") if line.strip()]
    line = f"write: {written[0]}" if written else "remove the line"
    if len(written) > 1:
        line = "\n".join((f"write {len(written)} lines:", *written))
    help_text = line if whole else _instruction(source, lead)
    fix = _fix(source, edits) if whole else None
    if whole and first.code in ("FZ103", "FZ104", "FZ109") and lead.why != COMMENT and len({e.why for e in edits}) == 1:
        # An open part is named as it was before the repair, which may be anywhere after it.
        return dataclasses.replace(in_original(first), facts=(*first.facts, *facts), help=help_text, fix=fix)
    message = f"{_found(source, lead)}: {lead.why}"
    old = source.text[lead.start : lead.end]
    start = lead.start + len(old) - len(old.lstrip())
    place = Span(source, start, max(start + len(old.strip()), start + 1))
    return Diagnostic(first.code, message, place, facts=tuple(facts), help=help_text, fix=fix)


def _fix(source: SourceText, edits: Sequence[Edit]) -> Fix:
    """Return the edits of a line that can be read after them."""
    replacements = tuple(Replacement(Span(source, e.start, e.end), e.text) for e in edits)
    return Fix(replacements, "sure" if all(e.sure for e in edits) else "likely")


def _found(source: SourceText, edit: Edit) -> str:
    old = source.text[edit.start : edit.end]
    if old.isspace() and not old.isascii():
        return "unexpected character"
    return f"unexpected '{_short(old.strip())}'" if old.strip() else f"missing '{_short(edit.text.strip())}'"


def _instruction(source: SourceText, edit: Edit) -> str:
    old, new = source.text[edit.start : edit.end].strip(), edit.text.strip()
    if not old:
        return f"insert '{_short(new)}'"
    if not new:
        return f"begin a new line instead of '{_short(old)}'" if edit.text.strip(" ") else f"remove '{_short(old)}'"
    return f"write '{_short(new)}' for '{_short(old)}'"


def _short(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."
