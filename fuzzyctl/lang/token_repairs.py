"""Repairs of a line by one token: removed, respelt, moved, or put in, so that the line can be read.

They are the last resort, after the repairs that know what was meant. They change no message; each gives the fix of a
line that is still broken.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Final

from fuzzyctl.diagnostics.fixes import Applicability, Fix, Replacement
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import closest, is_slip
from fuzzyctl.lang.syntax import NAME, STATEMENT_KEYWORDS

#: Whether a line can be read.
Reads = Callable[[str], bool]
#: A change of a line: from where to where, and what comes there.
_Change = tuple[int, int, str]

_TOKEN: Final = re.compile(rf'"[^"\n]*"|(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?|{NAME}|<=|>=|==|!=|\S')
#: Longer lines are left alone: there are too many changes to try.
_LONGEST: Final = 160
#: Keywords inside statements that may be misspelt.
_INNER: Final = (
    "in", "unit", "else", "is", "and", "or", "not", "then", "weight", "within", "when", "defuzzifier", "implication",
    "aggregation", "adaptive", "rate", "extrapolate", "clamp", "unless", "hold", "step",
)  # fmt: skip
#: What may be missing between two tokens.
_MISSING: Final = ("=", ",", "(", ")", "[", "]", "|", "in", "is", "then", "unit")


def token_fix(source: SourceText, start: int, end: int, reads: Reads) -> Fix | None:
    """Return the fix of a line by one token; None where no change, or more than one of its kind, makes it readable.

    Args:
        source: The text.
        start: Offset of the line's first character.
        end: Offset after its code.
        reads: Says whether a line of that text can be read.
    """
    text = source.text[start:end]
    if len(text) > _LONGEST:
        return None
    tokens = [(m.start(), m.end()) for m in _TOKEN.finditer(text)]
    kinds: tuple[tuple[Callable[[str, Sequence[tuple[int, int]]], Iterator[_Change]], Applicability], ...] = (
        (_respelt, "sure"),
        (_repeated, "sure"),
        (_of_another_letter, "likely"),
        (_swapped, "likely"),
        (_put_in, "likely"),
    )
    for changes, applicability in kinds:
        found: dict[str, _Change] = {}
        for first, last, new in changes(text, tokens):
            after = text[:first] + new + text[last:]
            if "".join(after.split()) not in found and reads(after):
                found["".join(after.split())] = (first, last, new)
        if len(found) == 1:
            ((first, last, new),) = found.values()
            return Fix((Replacement(Span(source, start + first, start + last), new),), applicability)
        if found:
            return None
    return None


def _respelt(text: str, tokens: Sequence[tuple[int, int]]) -> Iterator[_Change]:
    """Yield keywords inside the line for words that are slips of them."""
    for first, last in tokens[1:]:
        word = text[first:last]
        near = closest(word, _INNER) if re.fullmatch(NAME, word) and word not in _INNER else None
        if near is not None and is_slip(word, near, _INNER):
            yield first, last, near


def _of_another_letter(text: str, tokens: Sequence[tuple[int, int]]) -> Iterator[_Change]:
    """Yield keywords of two letters for words that differ in one of these, where several keywords may do."""
    for first, last in tokens[1:]:
        word = text[first:last]
        if re.fullmatch(NAME, word) and len(word) == 2 and word not in _INNER:
            for near in _INNER:
                if len(near) == 2 and (word[0] == near[0]) != (word[1] == near[1]):
                    yield first, last, near


def _repeated(text: str, tokens: Sequence[tuple[int, int]]) -> Iterator[_Change]:
    """Yield the removal of each token that repeats the one before it."""
    for (first, last), (again, stop) in pairwise(tokens):
        if text[first:last] == text[again:stop]:
            yield last, stop, ""


def _swapped(text: str, tokens: Sequence[tuple[int, int]]) -> Iterator[_Change]:
    """Yield each two neighbours in the other order."""
    for (first, last), (again, stop) in pairwise(tokens):
        opening = text[first:last] in ("(", "[")
        behind = stop + len(text[stop:]) - len(text[stop:].lstrip()) if opening else stop
        yield first, behind, f"{text[again:stop]}{text[last:again] or ' '}{text[first:last]}"


def _put_in(text: str, tokens: Sequence[tuple[int, int]]) -> Iterator[_Change]:
    """Yield each token that may be missing, in front of each token and at the end."""
    is_row = text[slice(*tokens[0])] not in STATEMENT_KEYWORDS if tokens else False
    for at in [*(first for first, _ in tokens[1:]), len(text.rstrip())]:
        for new in _MISSING if is_row else [m for m in _MISSING if m != "|"]:
            before = " " if new[0].isalpha() and not text[:at].endswith(" ") else ""
            yield at, at, before + new + (" " if new in ("=", ",", "|") or new[0].isalpha() else "")
