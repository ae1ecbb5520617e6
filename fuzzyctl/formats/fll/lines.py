"""Blocks of an `.fll` file: `key: value` lines, without comments and blank lines."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.formats.common.report import Findings, meant

#: Keys that begin a block, each with the keys of its lines, the last ones of fuzzylite 4 and 5.
BLOCKS: Final[dict[str, tuple[str, ...]]] = {
    "Engine": ("description",),
    "InputVariable": ("description", "enabled", "range", "lock-range", "term"),
    "OutputVariable": (
        "description", "enabled", "range", "lock-range", "aggregation", "defuzzifier", "default", "lock-previous",
        "term", "accumulation", "lock-valid",
    ),
    "RuleBlock": ("description", "enabled", "conjunction", "disjunction", "implication", "activation", "rule"),
}  # fmt: skip

_KINDS: Final = {kind.lower(): kind for kind in BLOCKS}

#: Keys that a block may have many of.
_MANY: Final = ("term", "rule")

#: A semicolon that separates lines: the next word is a key.
_SEPARATOR: Final = re.compile(
    rf";(?=[ \t]{{0,20}}(?:{'|'.join(dict.fromkeys([*BLOCKS, *(k for keys in BLOCKS.values() for k in keys)]))})"
    r"[ \t]{0,20}:)",
    re.IGNORECASE,
)

_WORD: Final = re.compile(r"\S+")


@dataclass(frozen=True)
class Line:
    """One line `key: value`; `key` is in small letters."""

    key: str
    value: Span
    span: Span


@dataclass(frozen=True)
class Block:
    """A block: the line that begins it and the lines below."""

    kind: str
    head: Line
    lines: list[Line] = field(default_factory=list)

    def line(self, *keys: str) -> Line | None:
        """Return the last line of one of some keys."""
        return next((line for line in reversed(self.lines) if line.key in keys), None)

    def all(self, key: str) -> list[Line]:
        """Return all lines of a key."""
        return [line for line in self.lines if line.key == key]

    @property
    def description(self) -> str:
        """The text of its description."""
        line = self.line("description")
        return line.value.text if line is not None else ""

    @property
    def place(self) -> Span:
        """The place of its name, or its first line."""
        return self.head.value if self.head.value.text else self.head.span


def words(span: Span) -> list[Span]:
    """Return the words of a text with their places."""
    return [Span(span.source, m.start(), m.end()) for m in _WORD.finditer(span.source.text, span.start, span.end)]


def split(source: SourceText, findings: Findings) -> list[Block]:
    """Split a file into blocks; report lines that belong to no block."""
    blocks: list[Block] = []
    lost = False
    for number, span in enumerate(_lines(source), 1):
        if findings.too_many(number, span):
            break
        text = span.text
        key, colon, _ = text.partition(":")
        if not colon:
            findings.error("FZ601", "the line has no colon", span, help="a line is written: key: value")
            continue
        line = Line(key.strip().lower(), _trimmed(source, span.start + len(key) + 1, span.end), span)
        if line.key in _KINDS:
            blocks.append(Block(_KINDS[line.key], line))
        elif blocks:
            _add(blocks[-1], line, findings)
        elif not lost:
            lost = True  # one message is enough
            message, help_text = "unexpected line before the first block", "a file begins with: Engine: NAME"
            findings.error("FZ601", message, span, help=help_text)
    return blocks


def _add(block: Block, line: Line, findings: Findings) -> None:
    keys = BLOCKS[block.kind]
    if line.key not in keys:
        message = f"'{block.kind}' has no key '{line.key[:40]}'"
        facts = (f"keys of {block.kind}: {', '.join(keys)}",)
        place = Span(line.span.source, line.span.start, line.span.start + line.span.text.find(":"))
        findings.error("FZ601", message, place, help=meant(line.key, [*keys, *BLOCKS]), facts=facts)
        return
    earlier = block.line(line.key) if line.key not in _MANY else None
    if earlier is not None:
        findings.given_twice(f"'{line.key}'", line.span, earlier.span)
    block.lines.append(line)


def _lines(source: SourceText) -> Iterator[Span]:
    """Yield the stretches between line ends, or semicolons before keys, without comments and blanks around them."""
    start = 0
    for raw in source.text.split("\n"):
        text = raw.partition("#")[0]
        edges = [0, *(end for match in _SEPARATOR.finditer(text) for end in match.span()), len(text)]
        for left, right in zip(edges[::2], edges[1::2], strict=True):
            span = _trimmed(source, start + left, start + right)
            if span.start < span.end:
                yield span
        start += len(raw) + 1


def _trimmed(source: SourceText, start: int, end: int) -> Span:
    text = source.text[start:end]
    left = len(text) - len(text.lstrip(" \t\r;\ufeff\v\f"))
    right = len(text.rstrip(" \t\r;\v\f"))
    return Span(source, start + left, start + max(left, right))
