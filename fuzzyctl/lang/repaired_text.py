"""Repaired text with its original locations."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from dataclasses import field

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.fixes import Fix, Replacement
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.records import dataclass


@dataclass(frozen=True)
class RepairedText(SourceText):
    """A text after repairs, read in place of its original so that one mistake hides no other.

    Args:
        original: The text as it was written.
        origin: For each offset in this text the offset in the original.
        ends: For each character of this text the offset in the original after what it stands for.
    """

    original: SourceText = field(default_factory=lambda: SourceText("", ""), compare=False, repr=False)
    origin: Sequence[int] = field(default=(0,), compare=False, repr=False)
    ends: Sequence[int] = field(default=(), compare=False, repr=False)


def rewritten(span: Span, text: str) -> str:
    """Return the line of a location with another text in its place, without indentation and comment."""
    line, first = span.source.line_text(span.line), span.column - 1
    whole = line[:first] + text + line[first + span.end - span.start :]
    return re.sub(r"\s*#[^\"]*$", "", whole).strip()


def _original_span(span: Span) -> Span:
    text = span.source
    if not isinstance(text, RepairedText):
        return span
    last = len(text.origin) - 1
    start = text.origin[min(span.start, last)]
    end = text.ends[min(span.end, last) - 1] if span.end > span.start and last > 0 else start
    return Span(text.original, start, max(start, end))


def in_original(diagnostic: Diagnostic) -> Diagnostic:
    """Return a diagnostic whose locations are in texts as they were written."""
    replacements = diagnostic.fix.replacements if diagnostic.fix is not None else ()
    places = (diagnostic.span, *(n.span for n in diagnostic.notes), *(r.span for r in replacements))
    spans = [s for s in places if s is not None]
    if not any(isinstance(s.source, RepairedText) for s in spans):
        return diagnostic
    notes = tuple(dataclasses.replace(n, span=_original_span(n.span)) for n in diagnostic.notes)
    span = None if diagnostic.span is None else _original_span(diagnostic.span)
    fix = None
    if diagnostic.fix is not None:
        moved = tuple(Replacement(_original_span(r.span), r.text) for r in replacements)
        fix = Fix(moved, diagnostic.fix.applicability)
    return dataclasses.replace(diagnostic, span=span, notes=notes, fix=fix)
