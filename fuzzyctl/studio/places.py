"""Places of a text as browsers count them: in units of UTF-16."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from fuzzyctl.diagnostics.fixes import Replacement
from fuzzyctl.diagnostics.source import Span


def units(text: str, offset: int) -> int:
    """Return an offset in characters as one in units of UTF-16."""
    before = text[:offset]
    return len(before) if before.isascii() else len(before.encode("utf-16-le", "surrogatepass")) // 2


def characters(text: str, offset: int) -> int:
    """Return an offset in units of UTF-16 as one in characters: the nearest within the text, never inside one."""
    if text.isascii():
        return min(max(offset, 0), len(text))
    before = text.encode("utf-16-le", "surrogatepass")[: 2 * max(offset, 0)]
    return len(before.decode("utf-16-le", "ignore"))


def ends(span: Span) -> dict[str, int]:
    """Return the ends of a location in its text."""
    text = span.source.text
    return {"from": units(text, span.start), "to": units(text, max(span.start, span.end))}


def edits(replacements: Iterable[Replacement], file: str) -> list[dict[str, Any]]:
    """Return the replacements of one file."""
    return [{**ends(r.span), "text": r.text} for r in replacements if r.span.source.name == file]
