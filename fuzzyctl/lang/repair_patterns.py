"""Repairs of a line by regular expressions."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Final

from fuzzyctl.lang.edits import Edit, Repair, Surroundings
from fuzzyctl.lang.syntax import NAME

NUMBER: Final = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"

#: Makes the replacement of a match out of its groups; None where there is none.
Replacement = Callable[["list[str]", Surroundings], "str | None"]


def by_pattern(pattern: str, new: str | Replacement, why: str, *, heads: str = "", sure: bool = True) -> Repair:
    """Return the repair of all matches of a pattern.

    Args:
        pattern: A regular expression without regard to case; its group `x`, if it has one, is what is replaced.
        new: The replacement, with `{1}` for the first group, or a function of all groups.
        why: The rule of the language behind it.
        heads: Words that the line may begin with, in small or capital letters; none for any line.
        sure: Whether the replacement is what was meant; else it is a guess, such as a name that is made up.
    """
    form = re.compile(pattern, re.IGNORECASE | re.MULTILINE)
    words = frozenset(heads.split())

    def repair(code: str, text: str, around: Surroundings) -> Iterator[Edit]:
        if words and head(code) not in words:
            return
        for m in form.finditer(code):
            start, end = m.span("x") if "x" in form.groupindex else m.span()
            groups = [text[m.start(i) : m.end(i)] if m.start(i) >= 0 else "" for i in range((form.groups or 0) + 1)]
            made = new.format(*groups) if isinstance(new, str) else new(groups, around)
            if made is not None and made != text[start:end]:
                yield Edit(start, end, made, why, sure)

    return repair


def head(code: str) -> str:
    """Return the first word of a line in small letters."""
    found = re.match(rf"\s*({NAME})", code)
    return found[1].lower() if found else ""
