"""Changes of one token of a line: removed, respelt, moved, or put in.

They are the last resort, beside the repairs that know what was meant.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Final

from fuzzyctl.diagnostics.suggestions import closest, is_slip
from fuzzyctl.lang.edits import Edit
from fuzzyctl.lang.syntax import NAME, STATEMENT_KEYWORDS

#: A change of a line: from where to where, and what comes there.
_Change = tuple[int, int, str]
#: Makes changes of a line, whose tokens are known.
_Changes = Callable[[str, Sequence[tuple[int, int]]], Iterator[_Change]]

_TOKEN: Final = re.compile(rf'"[^"\n]*"|(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?|{NAME}|<=|>=|==|!=|\S')
#: Keywords inside statements that may be misspelt.
_INNER: Final = (
    "in", "unit", "else", "is", "and", "or", "not", "then", "weight", "within", "when", "defuzzifier", "implication",
    "aggregation", "adaptive", "rate", "extrapolate", "clamp", "unless", "hold", "step",
)  # fmt: skip
#: What may be missing between two tokens.
_MISSING: Final = ("=", ",", "(", ")", "[", "]", "|", "in", "is", "then", "unit")


def _respelt(text: str, tokens: Sequence[tuple[int, int]]) -> Iterator[_Change]:
    """Yield keywords inside the line for words that are slips of them."""
    for first, last in tokens[1:]:
        word = text[first:last]
        near = closest(word, _INNER) if re.fullmatch(NAME, word) and word not in _INNER else None
        if near is not None and is_slip(word, near, _INNER):
            yield first, last, near


def _of_another_letter(text: str, tokens: Sequence[tuple[int, int]]) -> Iterator[_Change]:
    """Yield keywords of two letters for short words that differ in one letter, where several keywords may do."""
    for first, last in tokens[1:]:
        word = text[first:last]
        if re.fullmatch(NAME, word) and len(word) <= 3 and word not in _INNER:
            for near in _INNER:
                if len(near) == 2 and _differ_in_one_letter(word, near):
                    yield first, last, near


def _differ_in_one_letter(word: str, near: str) -> bool:
    """Whether a word is one of two letters with one changed, swapped, left out, or put in."""
    if len(word) == 2:
        return (word[0] == near[0]) != (word[1] == near[1]) or word == near[::-1]
    return word in near if len(word) == 1 else near in (word[1:], word[:2], word[0] + word[2])


def _repeated(text: str, tokens: Sequence[tuple[int, int]]) -> Iterator[_Change]:
    """Yield the removal of each token but a number that repeats the one before it."""
    for (first, last), (again, stop) in pairwise(tokens):
        if text[first:last] == text[again:stop] and not text[last - 1].isdigit():
            yield last, stop, ""


def _repeated_numbers(text: str, tokens: Sequence[tuple[int, int]]) -> Iterator[_Change]:
    """Yield the removal of each number that repeats the one before it, which may be another number."""
    if not tokens or text[tokens[0][0]].isdigit():
        return
    for (first, last), (again, stop) in pairwise(tokens):
        if text[first:last] == text[again:stop] and text[last - 1].isdigit():
            yield last, stop, ""


def _swapped(text: str, tokens: Sequence[tuple[int, int]]) -> Iterator[_Change]:
    """Yield each two neighbours in the other order."""
    for (first, last), (again, stop) in pairwise(tokens):
        opening = text[first:last] in ("(", "[")
        behind = stop + len(text[stop:]) - len(text[stop:].lstrip()) if opening else stop
        apart = " " if re.match(r"\w\w", text[first - 1 : first] + text[again:stop]) else ""
        yield first, behind, f"{apart}{text[again:stop]}{text[last:again] or ' '}{text[first:last]}"


def _put_in(text: str, tokens: Sequence[tuple[int, int]]) -> Iterator[_Change]:
    """Yield each token that may be missing, in front of each token and at the end; two tokens say too little."""
    if len(tokens) < 3:
        return
    is_row = text[slice(*tokens[0])] not in STATEMENT_KEYWORDS
    end = len(text.rstrip())
    for (_, last), (at, _) in pairwise([*tokens, (end, end)]):
        for new in _MISSING if is_row else [m for m in _MISSING if m != "|"]:
            behind = " " if new in ("=", ",", "|") or new[0].isalpha() else ""
            if new in (")", "]", ","):  # which stand behind a word without a blank
                yield last, last, new + (behind if last == at < end else "")
            else:
                before = " " if new[0].isalpha() and not text[:at].endswith(" ") else ""
                yield at, at, before + new + behind


#: Kinds of changes, the likeliest first, why each is made, and whether it gives what was meant.
_KINDS: Final[tuple[tuple[_Changes, str, bool], ...]] = (
    (_respelt, "it is a slip of a keyword", True),
    (_repeated, "it stands there twice", True),
    (_repeated_numbers, "it stands there twice", False),
    (_of_another_letter, "it is like a keyword", False),
    (_swapped, "the order is another one", False),
    (_put_in, "with it the line can be read", False),
)


def token_changes(text: str, *, in_table: bool) -> Iterator[Iterator[Edit]]:
    """Yield the changes of one token of a line by their kinds, the likeliest kind first.

    Args:
        text: The line.
        in_table: Whether it belongs to a table, whose rows have a bar.
    """
    tokens = _tokens(text)
    for changes, why, sure in _KINDS:
        yield (Edit(a, b, new, why, sure) for a, b, new in changes(text, tokens) if in_table or "|" not in new)


def changes_near(text: str, stop: int, *, in_table: bool) -> Iterator[tuple[int, Edit]]:
    """Yield those that concern the token where reading stops and its neighbours, each behind the number of its kind."""
    ends = [last for _, last in _tokens(text)]
    at = bisect_right(ends, stop)
    low, high = ends[at - 3] if at > 2 else 0, ends[min(at + 1, len(ends) - 1)] if ends else 0
    for rank, changes in enumerate(token_changes(text, in_table=in_table)):
        yield from ((rank, c) for c in changes if low <= c.start <= c.end <= high)


def _tokens(text: str) -> list[tuple[int, int]]:
    return [(m.start(), m.end()) for m in _TOKEN.finditer(text)]
