"""Sections of a `.fis` file: `key=value` lines, without comments and blank lines."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.formats.common.report import Findings

#: What opens and closes a string; word processors make the curly ones.
QUOTES: Final = {"'": "'", '"': '"', "\u2018": "\u2019", "\u201c": "\u201d"}

_HEADER: Final = re.compile(r"\[ *([A-Za-z_]+?) *([0-9]*) *\]")

#: Names of sections in small letters.
KINDS: Final = ("system", "input", "output", "rules")


@dataclass(frozen=True)
class Entry:
    """One line `key = value`, or a whole line in the section of rules, where the key is empty."""

    key: str
    value: Span
    span: Span

    @property
    def key_span(self) -> Span:
        """Where the key stands."""
        return Span(self.span.source, self.span.start, self.span.start + len(self.key))


@dataclass(frozen=True)
class Section:
    """A section with its header.

    Args:
        kind: One of `KINDS`.
        number: Of inputs and outputs, else 0.
        header: Where its header stands.
        entries: Its lines.
    """

    kind: str
    number: int
    header: Span
    entries: list[Entry] = field(default_factory=list)

    def entry(self, key: str) -> Entry | None:
        """Return the last entry of a key, whose letters may be capital or small."""
        return next((e for e in reversed(self.entries) if e.key.lower() == key.lower()), None)


@dataclass(frozen=True)
class Sections:
    """A file in sections, with its comments, which tell who wrote it."""

    sections: tuple[Section, ...]
    comments: tuple[str, ...]

    def of(self, kind: str) -> list[Section]:
        """Return the sections of a kind in the order of their numbers."""
        return sorted((s for s in self.sections if s.kind == kind), key=lambda s: s.number)


def split(source: SourceText, findings: Findings) -> Sections:
    """Split a file; what belongs to no section and unknown sections are reported."""
    sections: list[Section] = []
    comments: list[str] = []
    unknown = False
    for number, line in enumerate(_lines(source), 1):
        if findings.too_many(number, line):
            break
        text = line.text
        if text.startswith(("%", "#", "//")):
            comments.append(text)
        elif text.startswith("[") and (header := _HEADER.match(text)) is not None:
            kind, digits = header.group(1).lower(), header.group(2)
            unknown = kind not in KINDS
            if unknown:
                known = "[System], [Input1], [Output1] and [Rules] are"
                message = f"there is no section '{header.group()}'"
                findings.error("FZ601", message, line, help=f"{known} sections")
            else:
                sections.append(Section(kind, int(digits[:6] or 0), line))
        elif sections and not unknown:
            _add(sections[-1], line, findings)
        elif not unknown:
            _before_sections(line, findings)
            unknown = True  # one message is enough
    return Sections(tuple(sections), tuple(comments))


def _before_sections(line: Span, findings: Findings) -> None:
    message, help_text = "unexpected line before the first section", "a file begins with [System]"
    findings.error("FZ601", message, line, help=help_text)


def _add(section: Section, line: Span, findings: Findings) -> None:
    if section.kind == "rules":
        section.entries.append(Entry("", line, line))
        return
    key, equals, _ = line.text.partition("=")
    if not equals or not key.strip():
        findings.error("FZ601", "the line is not of the form key=value", line, help="comments begin with % or #")
        return
    start = line.start + len(key) + 1
    value = trimmed(line.source, start, line.end)
    section.entries.append(Entry(key.strip(), value, line))


def _lines(source: SourceText) -> Iterator[Span]:
    """Yield the lines that are not blank, without blanks around them and without comments behind them."""
    at = 0
    for raw in source.text.split("\n"):
        line = trimmed(source, at, at + len(raw))
        at += len(raw) + 1
        if line.start == line.end:
            continue
        if not line.text.startswith(("%", "#")):
            line = trimmed(source, line.start, line.start + _comment(line.text))
        yield line


def _comment(text: str) -> int:
    """Return where a comment behind a line begins, or the length of the line.

    A mark within quotes or brackets begins none.
    """
    closing = ""
    for i, c in enumerate(text):
        if closing:
            if c == closing:
                closing = ""
        elif c in QUOTES and (i == 0 or not text[i - 1].isalnum()):
            closing = QUOTES[c]
        elif c in "%#":
            return i
    if closing:  # a quote that is never closed hides nothing
        marks = [i for i in (text.find(" %"), text.find(" #"), text.find("\t%")) if i >= 0]
        return min(marks, default=len(text))
    return len(text)


def trimmed(source: SourceText, start: int, end: int) -> Span:
    """Return a stretch of text without the blanks around it."""
    text = source.text[start:end]
    left = len(text) - len(text.lstrip())
    return Span(source, start + left, start + max(left, len(text.rstrip())))
