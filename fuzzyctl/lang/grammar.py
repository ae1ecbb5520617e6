"""Grammar of logical lines: a line becomes a node, or a diagnostic."""

from __future__ import annotations

import threading
from functools import cache
from importlib import resources
from typing import Any

from lark import Lark
from lark.exceptions import UnexpectedInput, UnexpectedToken

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText
from fuzzyctl.lang.builder import Builder
from fuzzyctl.lang.lines import LineKind, LogicalLine
from fuzzyctl.lang.mistakes import describe

# Lark calls the builder while it parses, and the builder must know where the line stands; one parse at a time.
_LOCK = threading.Lock()


@cache
def grammar_text() -> str:
    """Return the text of the grammar."""
    return resources.files("fuzzyctl.lang").joinpath("grammar.lark").read_text(encoding="utf-8")


@cache
def _machine() -> tuple[Lark, Builder]:
    builder = Builder()
    starts = ["statement", "block_statement", "term_line", "header", "row", "label", "cell"]
    lark = Lark(
        grammar_text(),
        parser="lalr",
        lexer="contextual",
        start=starts,
        transformer=builder,
        maybe_placeholders=True,
    )
    return lark, builder


def parse_line(source: SourceText, line: LogicalLine, kind: LineKind) -> tuple[Any, list[Diagnostic]]:
    """Parse one line as one kind; the node is None when it could not be read."""
    lark, builder = _machine()
    with _LOCK:
        builder.begin(source, line)
        try:
            node = lark.parse(source.text[line.start : line.end], start=kind)
        except UnexpectedInput as error:
            return None, [describe(source, line, error)]
        return (None if builder.problems else node), builder.problems


def read_line(source: SourceText, line: LogicalLine, kind: LineKind) -> tuple[Any, int]:
    """Parse one line without saying what is wrong: the node, None when it cannot be read, and where reading stops."""
    lark, builder = _machine()
    with _LOCK:
        builder.begin(source, line)
        try:
            node = lark.parse(source.text[line.start : line.end], start=kind)
        except UnexpectedInput as error:
            # The token of the end of a line has the place of the one before it.
            is_end = isinstance(error, UnexpectedToken) and error.token.type == "$END"
            return None, line.end if is_end else line.start + (error.pos_in_stream or 0)  # type: ignore[redundant-expr]
        if builder.problems:
            span = builder.problems[0].span
            return None, span.start if span is not None else line.start
        return node, line.end
