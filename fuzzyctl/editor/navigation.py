"""Definitions, uses and renaming of names; outline, folds, selections and links of a file."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise, zip_longest
from pathlib import PurePath

from fuzzyctl.diagnostics.fixes import Fix, Replacement, fixed
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.symbols import Symbol
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.formatter import format_source
from fuzzyctl.lang.syntax import HEADS, MAX_NAME, NAME, RESERVED
from fuzzyctl.resolve.context import is_function

#: A file, a line, and the number of a name among those of the line.
_Place = tuple[str, int, int]


class RenameError(ValueError):
    """Raised where a name cannot be given another one; the message is for the user."""


def symbol_at(document: Document, offset: int) -> tuple[Span, Symbol] | None:
    """Return the name at an offset with its symbol, or None."""
    return document.symbols.at(document.source.name, offset)


def definition(document: Document, offset: int) -> Span | None:
    """Return where the name at an offset is declared, which may be in a used file."""
    name = symbol_at(document, offset)
    return name[1].span if name is not None else None


def references(
    document: Document, offset: int, *, declaration: bool = True, others: Iterable[Document] = ()
) -> list[Span]:
    """Return where the name at an offset is used, in this file, in those that it uses, and in others that use these.

    Args:
        document: The file.
        offset: The name.
        declaration: Whether the declaration is among them.
        others: Files that may use declarations of this one.
    """
    name = symbol_at(document, offset)
    if name is None:
        return []
    symbol = name[1]
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
        RenameError: Without a name at the offset, or for an invalid new name or one in use.
    """
    found = symbol_at(document, offset)
    if found is None:
        raise RenameError("there is no name here")
    symbol = found[1]
    if not re.fullmatch(NAME, name) or name in RESERVED or len(name) > MAX_NAME:
        raise RenameError(
            f"'{name}' cannot be a name: it has letters, digits and '_', and is not a word of the language"
        )
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

    Declarations above all blocks are seen in each of them.
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
    """Return a name with another meaning after some changes; None if each name keeps its meaning.

    Args:
        symbol: The symbol to rename.
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
    """Return a text with spaces in place of blocks without a change and without the new name."""
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


@dataclass(frozen=True)
class Entry:
    """A symbol with those inside of it."""

    symbol: Symbol
    inside: tuple[Entry, ...]


def outline(document: Document) -> list[Entry]:
    """Return the blocks of a file with their variables, and the terms of these."""
    own = [s for s in document.symbols.all if s.span.source.name == document.source.name]
    inside: dict[Symbol | None, list[Symbol]] = {}
    for symbol in own:
        owner = symbol.owner
        # Lines before the first system are common to all, and lie in none.
        is_inside = owner is not None and owner.whole.start <= symbol.whole.start
        inside.setdefault(owner if is_inside else None, []).append(symbol)

    def entries(owner: Symbol | None) -> tuple[Entry, ...]:
        return tuple(Entry(s, entries(s)) for s in inside.get(owner, []))

    return list(entries(None))


def folds(document: Document) -> Iterator[tuple[int, int]]:
    """Yield first and last line, from 1, of parts that can be folded: blocks, variables with terms, tables."""
    source = document.source
    heads = [s for s in document.tree.statements if isinstance(s, sx.System | sx.Head)]
    starts = [source.line_of(s.span.start) for s in heads]
    ends = [*(line - 1 for line in starts[1:]), source.line_of(len(source.text.rstrip()))][: len(heads)]
    lines = source.text.split("\n")
    for head, end in zip(heads, ends, strict=True):
        last = end
        while last > head.span.line and (not lines[last - 1].strip() or lines[last - 1].startswith("#")):
            last -= 1
        if last > head.span.line:
            yield head.span.line, last
    before = (0, 0)
    for s in document.tree.statements:
        below: tuple[sx.Statement, ...] = ()
        if isinstance(s, sx.Variable):
            below = s.terms
        elif isinstance(s, sx.Table) and not s.csv:
            below = s.rows
        fold = (s.span.line, max((line.span.end_line for line in below), default=s.span.line))
        if below and fold != before:  # variables of one line fold together
            yield fold
        before = fold


def selections(document: Document, offset: int) -> list[Span]:
    """Return the parts around an offset, from small to large: word, line, statement with its lines, block, file."""
    source, text = document.source, document.text
    first = last = offset
    while first > 0 and (text[first - 1].isalnum() or text[first - 1] == "_"):
        first -= 1
    while last < len(text) and (text[last].isalnum() or text[last] == "_"):
        last += 1
    spans = [Span(source, first, last)]
    line = text.rfind("\n", 0, offset) + 1
    stop = text.find("\n", offset)
    spans.append(Span(source, line, len(text) if stop < 0 else stop))
    wholes = [s.whole for s in document.symbols.all if s.whole.source.name == source.name]
    spans += [w for w in wholes if w.start <= offset <= w.end]
    spans.append(Span(source, 0, len(text)))
    ordered = sorted(spans, key=lambda s: s.end - s.start)
    nested: list[Span] = []
    for span in ordered:
        if not nested or (span.start <= nested[-1].start and nested[-1].end <= span.end and span != nested[-1]):
            nested.append(span)
    return nested


def links(document: Document) -> Iterator[tuple[Span, str]]:
    """Yield the locations of names of files with the file, relative to the folder: `use` and tables in CSV files.

    Files outside of the folder, which a rule file cannot use, have none.
    """
    for s in document.tree.statements:
        span, name = None, ""
        if isinstance(s, sx.Use):
            span, name = s.path_span, s.path
        elif isinstance(s, sx.Table):
            span, name = s.csv_span, s.csv
        path = PurePath(name)
        if span is not None and path.parts and not path.is_absolute() and ".." not in path.parts:
            yield span, name
