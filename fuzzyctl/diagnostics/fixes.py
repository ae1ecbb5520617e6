"""Repairs of a text as data: what to replace, how sure it is, and a text after many of them."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from typing import Any, Final, Literal

from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import closest, is_slip
from fuzzyctl.records import dataclass

#: A sure fix gives the intended text; a likely one is the best guess, which the user should read.
Applicability = Literal["sure", "likely"]

APPLICABILITIES: Final[tuple[Applicability, ...]] = ("sure", "likely")

#: Longer texts are not searched for other places of a name.
_LONGEST: Final = 100_000


@dataclass(frozen=True)
class Replacement:
    """Replace the characters of a location by a text; an empty location is an insertion."""

    span: Span
    text: str


@dataclass(frozen=True)
class Fix:
    """The repair of one mistake.

    Args:
        replacements: What to replace; they do not overlap.
        applicability: "sure" or "likely".
    """

    replacements: tuple[Replacement, ...]
    applicability: Applicability

    def as_dict(self) -> dict[str, Any]:
        """Return the fix as plain data: columns from 1, ends exclusive."""
        return {
            "applicability": self.applicability,
            "edits": [
                {
                    "line": source.line_of(r.span.start),
                    "column": source.column_of(r.span.start),
                    "end_line": source.line_of(r.span.end),
                    "end_column": source.column_of(r.span.end),
                    "text": r.text,
                }
                for r in self.replacements
                for source in (r.span.source,)
            ],
        }


def respelt(span: Span | None, name: str, meant: str | None, known: Collection[str]) -> Fix | None:
    """Return the fix of a misspelt name; None if the intended name is unknown.

    If the text has the intended name once, in its declaration, and the other one several times, the
    slip is in the declaration. If it has each name once, either may be the slip, and the fix is only likely.

    Args:
        span: A location that begins with the name, such as that of a call.
        name: The name as it was written.
        meant: The name that was most likely meant.
        known: All names that would have been right.
    """
    if span is None or meant is None or not name or not span.text.startswith(name):
        return None
    place = Span(span.source, span.start, span.start + len(name))
    if not is_slip(name, meant, known):
        return Fix((Replacement(place, meant),), "likely")
    uses, declared = _words(span.source, name), _words(span.source, meant)
    if len(declared) != 1:
        return Fix((Replacement(place, meant),), "sure")
    if len(uses) > 1:
        return Fix((Replacement(declared[0], name),), "sure")
    return Fix((Replacement(place, meant),), "likely")


def respelt_as_suggested(span: Span | None, name: str, known: Collection[str]) -> Fix | None:
    """Return the fix that goes with the help `did_you_mean(name, known)`; see `respelt`."""
    return respelt(span, name, closest(name, known), known)


def with_decimal_points(span: Span | None, given: int, due: int) -> Fix | None:
    """Return the fix of a call that has too many arguments because commas stand for decimal points; None for another.

    Commas without a blank are those of decimals where they are as many as the arguments that are too many, and, less
    surely, every other one where each number has one.

    Args:
        span: Location of the call.
        given: Number of its arguments.
        due: Number of arguments that the function takes.
    """
    if span is None or given <= due:
        return None
    commas = [m.start(1) for m in re.finditer(r"(?<![\w.])\d+(,)(?=\d+(?![\w.]))", span.text)]
    applicability: Applicability = "sure" if len(commas) == given - due else "likely"
    if len(commas) == 2 * (given - due) - 1:
        commas = commas[::2]
    if len(commas) != given - due:
        return None
    places = [Span(span.source, span.start + at, span.start + at + 1) for at in commas]
    return Fix(tuple(Replacement(place, ".") for place in places), applicability)


def _words(source: SourceText, name: str) -> list[Span]:
    """Return the first locations of a word, at most two, comments left out; none in a very long text."""
    if len(source.text) > _LONGEST:
        return []
    words: list[Span] = []
    for m in re.finditer(rf"(?<![\w#]){re.escape(name)}(?!\w)", source.text):
        line = source.text.rfind("\n", 0, m.start()) + 1
        if "#" not in source.text[line : m.start()]:
            words.append(Span(source, *m.span()))
        if len(words) == 2:
            break
    return words


def fixed(source: SourceText, fixes: Iterable[Fix]) -> str:
    """Return a text after those of some fixes that concern it; of two that overlap the first counts."""
    chosen: list[Replacement] = []
    for fix in fixes:
        mine = [r for r in fix.replacements if r.span.source is source or r.span.source == source]
        if len(mine) == len(fix.replacements) and not any(_overlap(a, b) for a in mine for b in chosen):
            chosen += mine
    text = source.text
    for r in sorted(chosen, key=lambda r: (r.span.start, r.span.end), reverse=True):
        text = text[: r.span.start] + r.text + text[r.span.end :]
    return text


def _overlap(a: Replacement, b: Replacement) -> bool:
    """Whether two replacements touch the same characters, or insert at the same place."""
    if a.span.start == b.span.start:
        return True
    first, second = sorted((a, b), key=lambda r: r.span.start)
    return first.span.end > second.span.start
