"""Semantic tokens: what each word of a rule file is, names by their declaration."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.editor.document import Document
from fuzzyctl.editor.symbols import Symbol
from fuzzyctl.editor.words import called
from fuzzyctl.lang.highlight import CLAUSES
from fuzzyctl.lang.lines import LogicalLine
from fuzzyctl.lang.lines import Token as Piece
from fuzzyctl.lang.lines import tokens as pieces
from fuzzyctl.resolve.settings import SETTINGS

#: Kinds of tokens by their names in the protocol; a token's number there is its position here.
KINDS: Final = (
    "namespace", "class", "function", "property", "variable", "parameter", "enumMember",
    "keyword", "comment", "string", "number",
)  # fmt: skip
MODIFIERS: Final = ("declaration", "readonly")

_OF_SYMBOLS: Final = {
    "system": "namespace",
    "loop": "namespace",
    "rules": "namespace",
    "controller": "class",
    "plant": "class",
    "hedge": "function",
    "function": "function",
    "state": "property",
    "input": "parameter",
    "term": "enumMember",
}
#: Kinds of tokens that need no names to be known, by their kinds in texts.
_ALWAYS: Final = {"comment": "comment", "text": "string", "number": "number"}
_WORDS: Final = frozenset(CLAUSES)


@dataclass(frozen=True)
class Token:
    """A word, a number, a text or a comment.

    Args:
        span: Its location, on one line.
        kind: One of `KINDS`.
        modifiers: Some of `MODIFIERS`.
    """

    span: Span
    kind: str
    modifiers: tuple[str, ...] = ()


def tokens(document: Document, start: int = 0, end: int | None = None) -> Iterator[Token]:
    """Yield the tokens of a range of offsets in the order of the text; words of unknown meaning are left out."""
    text, source = document.text, document.source
    names = {span.start: (span, s) for span, s in document.symbols.uses if span.source.name == source.name}
    lines = iter([*document.lines, LogicalLine(len(text), len(text), "", "blank", "")])
    line, following = next(lines), None
    for piece in pieces(text, start, end):
        while following is None or following.start <= piece.start:
            line, following = following or line, next(lines, None)
            if following is None:
                break
        kind = _ALWAYS.get(piece.kind, "")
        if piece.kind == "name" and piece.start in names:
            yield _named(*names[piece.start])
        elif kind := kind or (_word(text, line, piece) if piece.kind == "name" else ""):
            yield Token(Span(source, piece.start, piece.end), kind)


def _named(span: Span, symbol: Symbol) -> Token:
    found = []
    if span == symbol.span:
        found.append("declaration")
    if symbol.kind in ("param", "term"):
        found.append("readonly")
    return Token(span, _OF_SYMBOLS.get(symbol.kind, "variable"), tuple(found))


def _word(text: str, line: LogicalLine, piece: Piece) -> str:
    """Return what a word is that names nothing; an empty text for what is not known."""
    word = piece.text
    begins = not text[line.start : piece.start].strip()
    if begins and word == line.word and line.kind in ("statement", "block_statement"):
        return "keyword"
    if text[piece.end : piece.end + 8].lstrip(" \t").startswith("(") and word in called(line.in_block):
        return "function"
    if word in _WORDS or (word == "x" and line.word == "table"):
        return "keyword"
    return "enumMember" if line.word in SETTINGS and word in SETTINGS[line.word] else ""
