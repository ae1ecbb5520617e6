"""Layout of some lines: of a selection, and of a table while it is typed."""

from __future__ import annotations

from fuzzyctl.diagnostics.fixes import Replacement
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.editor.document import Document
from fuzzyctl.lang.formatter import format_source


def laid_out(source: SourceText, first: int, last: int) -> list[Replacement]:
    """Return the changes that give some lines their canonical layout; blank lines stay.

    Args:
        source: The text.
        first, last: Lines, from 1.
    """
    after = [line for line in format_source(source).split("\n") if line.strip()]
    before = [n for n in range(1, source.line_count + 1) if source.line_text(n).strip()]
    if len(before) != len(after):  # as where lines were joined
        return []
    found = []
    for n, now in zip(before, after, strict=True):
        line = source.line_text(n)
        if first <= n <= last and line != now:
            at = source.line_start(n)
            found.append(Replacement(Span(source, at, at + len(line)), now))
    return found


def typed(document: Document, offset: int, character: str) -> list[Replacement]:
    """Return the changes of a table's lines after a character was typed in it.

    Behind `|` the lines above the cursor's are laid out, not its own, which is still being written; behind a line feed
    all that stand above it. Elsewhere nothing changes.

    Args:
        document: The document, with the character in it.
        offset: The offset behind the character.
        character: "|" or a line feed.
    """
    line = document.source.line_of(offset)
    kinds = {document.source.line_of(x.start): x for x in document.lines}
    at = line - 1
    while at in kinds and kinds[at].kind in ("row", "header"):
        at -= 1
    if at == line - 1 or at not in kinds or kinds[at].word != "table":
        return []
    if character == "|":
        own = kinds.get(line)
        if own is None or own.kind != "row":
            return []
    return laid_out(document.source, at, line - 1)
