"""Definition, references and renaming of names."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace

from fuzzyctl.diagnostics.fixes import Fix, Replacement, fixed
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.symbols import Symbol
from fuzzyctl.lang.formatter import format_source
from fuzzyctl.lang.syntax import MAX_NAME, NAME, RESERVED


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
        RenameError: Where there is no name, or the new one is none, is taken, or makes a mistake of the text.
    """
    found = symbol_at(document, offset)
    if found is None:
        raise RenameError("there is no name here")
    symbol = found[1]
    if not re.fullmatch(NAME, name) or name in RESERVED or len(name) > MAX_NAME:
        raise RenameError(f"'{name}' cannot be a name: it has letters, digits and '_', and is no word of the language")
    if name == symbol.name:
        return []
    taken = _taken(document, symbol, name)
    if taken is not None:
        raise RenameError(f"'{name}' is declared already in line {taken.line}")
    changes = [Replacement(span, name) for span in references(document, offset, others=others)]
    _check(document, changes, name)
    own = [c for c in changes if c.span.source.name == document.source.name]
    elsewhere = [c for c in changes if c.span.source.name != document.source.name]
    return [*_laid_out(document.source, own), *elsewhere]


def _check(document: Document, changes: list[Replacement], name: str) -> None:
    """Raise a RenameError where changes of a document and of files bring it a mistake that it has not had."""
    changed: dict[SourceText, list[Replacement]] = {}
    for change in changes:
        changed.setdefault(change.span.source, []).append(change)
    texts = {source: fixed(source, [Fix(tuple(found), "sure")]) for source, found in changed.items()}
    own = {s.name: text for s, text in texts.items()}.get(document.source.name, document.text)
    buffers = {**document.buffers, **{os.path.abspath(s.name): text for s, text in texts.items()}}
    after = replace(document, source=SourceText(document.source.name, own), buffers=buffers)
    before = Counter(d.code for d in document.mistakes if d.severity == "error")
    for mistake in after.mistakes:
        if mistake.severity == "error" and not before[mistake.code]:
            raise RenameError(f"'{name}' cannot be the name: {mistake.message}")
        before[mistake.code] -= 1


def _taken(document: Document, symbol: Symbol, name: str) -> Span | None:
    """Return where the new name is declared among those that it would be mixed up with."""
    for other in document.symbols.all:
        same_kind = (other.kind == "term") == (symbol.kind == "term")
        if other.name == name and same_kind and other.owner is symbol.owner:
            return other.span
    return None


def _laid_out(source: SourceText, changes: list[Replacement]) -> list[Replacement]:
    """Return changes of lines that also keep the layout of a file that had the canonical one."""
    if format_source(source) != source.text:
        return changes
    after = format_source(SourceText(source.name, fixed(source, [Fix(tuple(changes), "sure")])))
    before_lines, after_lines = source.text.split("\n"), after.split("\n")
    if len(before_lines) != len(after_lines):
        return changes
    found, at = [], 0
    for before, now in zip(before_lines, after_lines, strict=True):
        if before != now:
            found.append(Replacement(Span(source, at, at + len(before)), now))
        at += len(before) + 1
    return found
