"""Definition, references and renaming of names."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from itertools import pairwise, zip_longest

from fuzzyctl.diagnostics.fixes import Fix, Replacement, fixed
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.symbols import Symbol
from fuzzyctl.lang.formatter import format_source
from fuzzyctl.lang.syntax import HEADS, MAX_NAME, NAME, RESERVED
from fuzzyctl.resolve.context import is_function

#: A file, a line, and the number of a name among those of the line.
_Place = tuple[str, int, int]


class RenameError(ValueError):
    """Raised where a name cannot be given another one; the message is for the user."""


def symbol_at(document: Document, offset: int) -> tuple[Span, Symbol] | None:
    """Return the name at an offset with its symbol; None where there is none."""
    return document.symbols.at(document.source.name, offset)


def definition(document: Document, offset: int) -> Span | None:
    """Return where the name at an offset is declared, which may be in a used file."""
    found = symbol_at(document, offset)
    return found[1].span if found is not None else None


def references(
    document: Document, offset: int, *, declaration: bool = True, others: Iterable[Document] = ()
) -> list[Span]:
    """Return where the name at an offset is used, in this file, in those that it uses, and in others that use these.

    Args:
        document: The file.
        offset: The name.
        declaration: Whether the declaration is among them.
        others: Files that may use what is declared here.
    """
    found = symbol_at(document, offset)
    if found is None:
        return []
    symbol = found[1]
    spans = document.symbols.uses_of(symbol)
    for other in others:
        if other.source.name != document.source.name:
            spans += _uses_in(other, symbol)
    return [s for s in spans if declaration or s != symbol.span]


def _uses_in(other: Document, symbol: Symbol) -> list[Span]:
    """Return where another file uses a symbol of a file that it uses."""
    path = os.path.abspath(symbol.span.source.name)
    if path not in other.used:
        return []
    # By name and owners: the file on disk may be another version than the text on the screen.
    same = [s for s in other.symbols.known.values() if s.path == symbol.path]
    here = [s for s in same if os.path.abspath(s.span.source.name) == path]
    return [span for s in here for span in other.symbols.uses_of(s) if span.source.name == other.source.name]


def rename(document: Document, offset: int, name: str, others: Iterable[Document] = ()) -> list[Replacement]:
    """Return the changes of all files that give the name at an offset another one, of those that use it, too.

    Where the file was laid out by `fuzzyctl fmt`, it is afterwards: columns of tables are aligned again.

    Raises:
        RenameError: Where there is no name, or the new one is none or is taken.
    """
    found = symbol_at(document, offset)
    if found is None:
        raise RenameError("there is no name here")
    symbol = found[1]
    if not re.fullmatch(NAME, name) or name in RESERVED or len(name) > MAX_NAME:
        raise RenameError(f"'{name}' cannot be a name: it has letters, digits and '_', and is no word of the language")
    if name == symbol.name:
        return []
    if symbol.kind != "term" and is_function(name, output=symbol.kind == "output"):
        raise RenameError(f"'{name}' is a function of the language")
    taken = _taken(document, symbol, name)
    if taken is not None:
        raise RenameError(f"'{name}' is declared already in line {taken.line}")
    others = [o for o in others if o.source.name != document.source.name]
    changes = [Replacement(span, name) for span in references(document, offset, others=others)]
    clash = _mixed_up(symbol, changes, [document, *others])
    if clash is not None:
        place = f"line {clash.line}"
        if clash.source.name != document.source.name:
            place += f" of {os.path.basename(clash.source.name)}"
        raise RenameError(f"'{name}' has another meaning already in {place}")
    own = [c for c in changes if c.span.source.name == document.source.name]
    elsewhere = [c for c in changes if c.span.source.name != document.source.name]
    return [*_laid_out(document, own), *elsewhere]


def _taken(document: Document, symbol: Symbol, name: str) -> Span | None:
    """Return where the new name is declared among those that it would be mixed up with.

    What stands above all blocks is seen in each of them.
    """
    for other in document.symbols.all:
        same_kind = (other.kind == "term") == (symbol.kind == "term")
        is_seen = (
            symbol.kind not in ("term", *HEADS) and other.kind not in HEADS and None in (symbol.owner, other.owner)
        )
        if other.name == name and same_kind and (other.owner is symbol.owner or is_seen):
            return other.span
    return None


def _mixed_up(symbol: Symbol, changes: list[Replacement], documents: Iterable[Document]) -> Span | None:
    """Return a name that is another one after some changes; None where each name stands for what it did.

    Args:
        symbol: What gets another name.
        changes: The changes of all files.
        documents: The files that may be concerned.
    """
    documents = list(documents)
    before = {c.span.source.name: c.span.source.text for c in changes}
    before |= {d.source.name: _concerned(d, changes) for d in documents if d.source.name in before}
    after = {}
    for name, text in before.items():
        source = SourceText(name, text)
        own = [
            Replacement(Span(source, c.span.start, c.span.end), c.text) for c in changes if c.span.source.name == name
        ]
        after[name] = fixed(source, [Fix(tuple(own), "sure")])
    declared = os.path.abspath(symbol.span.source.name)
    for document in documents:
        if document.source.name not in after and declared not in document.used:
            continue
        was, now = (_meanings(_with_texts(document, texts)) for texts in (before, after))
        for (span, meaning), (_, old) in zip_longest(now, was, fillvalue=(None, None)):
            if meaning != old:
                return span or symbol.span
    return None


def _concerned(document: Document, changes: Iterable[Replacement]) -> str:
    """Return a text with spaces for what stands in blocks without a change and without the new name."""
    text, own = document.text, [c for c in changes if c.span.source.name == document.source.name]
    new = re.compile(rf"\b({'|'.join({c.text for c in own})})\b")
    for start, end in _blocks(document):
        if not any(start <= c.span.start < end for c in own) and not new.search(text, start, end):
            head, *lines = text[start:end].split("\n")
            text = text[:start] + "\n".join([head, *(" " * len(line) for line in lines)]) + text[end:]
    return text


def _blocks(document: Document) -> list[tuple[int, int]]:
    """Return where each block of a text begins and ends."""
    starts = [start for start, _, head in document.symbols.scopes if head is not None]
    return list(pairwise([*starts, len(document.text)]))


def _with_texts(document: Document, texts: Mapping[str, str]) -> Document:
    """Return a document where some files have other texts."""
    name = document.source.name
    buffers = {**document.buffers, **{os.path.abspath(n): text for n, text in texts.items() if n != name}}
    return Document(SourceText(name, texts.get(name, document.text)), document.folder, buffers)


def _meanings(document: Document) -> list[tuple[Span | None, _Place | None]]:
    """Return each name of a file with the place of its declaration, which another length of names does not move."""
    uses = sorted(document.symbols.uses, key=lambda use: (use[0].source.name, use[0].start))
    places: dict[tuple[str, int], _Place] = {}
    on_line: dict[tuple[str, int], int] = {}
    for span, _ in uses:
        if (span.source.name, span.start) not in places:
            line = (span.source.name, span.line)
            on_line[line] = on_line.get(line, -1) + 1
            places[span.source.name, span.start] = (*line, on_line[line])
    own = [use for use in uses if use[0].source.name == document.source.name]
    return [(span, places.get((s.span.source.name, s.span.start))) for span, s in own]


def _laid_out(document: Document, changes: list[Replacement]) -> list[Replacement]:
    """Return changes of lines that also keep the layout of blocks that had the canonical one."""
    blocks = [(a, b) for a, b in _blocks(document) if any(a <= c.span.start < b for c in changes)]
    is_within = all(any(a <= c.span.start < b for a, b in blocks) for c in changes)
    first, last = (blocks[0][0], blocks[-1][1]) if blocks and is_within else (0, len(document.text))
    text = document.text[first:last].rstrip("\n") + "\n"
    part = SourceText(document.source.name, text)
    if format_source(part) != text:
        return changes
    moved = [Replacement(Span(part, c.span.start - first, c.span.end - first), c.text) for c in changes]
    after = format_source(SourceText(part.name, fixed(part, [Fix(tuple(moved), "sure")])))
    before_lines, after_lines = text.split("\n"), after.split("\n")
    if len(before_lines) != len(after_lines):
        return changes
    found, at = [], first
    for before, now in zip(before_lines, after_lines, strict=True):
        if before != now:
            found.append(Replacement(Span(document.source, at, at + len(before)), now))
        at += len(before) + 1
    return found
