"""Outline of a rule file: its blocks with their names, what can be folded, what a selection grows to, links."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import PurePath

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.symbols import Symbol
from fuzzyctl.lang import syntax as sx


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
        # What stands before the first system is common to all, and lies in none.
        is_inside = owner is not None and owner.whole.start <= symbol.whole.start
        inside.setdefault(owner if is_inside else None, []).append(symbol)

    def entries(owner: Symbol | None) -> tuple[Entry, ...]:
        return tuple(Entry(s, entries(s)) for s in inside.get(owner, []))

    return list(entries(None))


def folds(document: Document) -> Iterator[tuple[int, int]]:
    """Yield first and last line, from 1, of what can be folded: blocks, variables with terms, tables."""
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
    """Return what holds an offset, from small to large: word, line, statement with lines below it, block, file."""
    source, text = document.source, document.text
    first = last = offset
    while first > 0 and (text[first - 1].isalnum() or text[first - 1] == "_"):
        first -= 1
    while last < len(text) and (text[last].isalnum() or text[last] == "_"):
        last += 1
    found = [Span(source, first, last)]
    line = text.rfind("\n", 0, offset) + 1
    stop = text.find("\n", offset)
    found.append(Span(source, line, len(text) if stop < 0 else stop))
    wholes = [s.whole for s in document.symbols.all if s.whole.source.name == source.name]
    found += [w for w in wholes if w.start <= offset <= w.end]
    found.append(Span(source, 0, len(text)))
    ordered = sorted(found, key=lambda s: s.end - s.start)
    kept: list[Span] = []
    for span in ordered:
        if not kept or (span.start <= kept[-1].start and kept[-1].end <= span.end and span != kept[-1]):
            kept.append(span)
    return kept


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
