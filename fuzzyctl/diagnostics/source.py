"""Source text and locations in it: the only module that counts lines and columns."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import field
from functools import cached_property
from itertools import accumulate

from fuzzyctl.records import dataclass, record


@dataclass(frozen=True)
class SourceText:
    """Hold a text together with the name it is shown under.

    Args:
        name: The name.
        text: The text.
        encoding: The encoding of its bytes, for people; empty for UTF-8.
    """

    name: str
    text: str = field(repr=False)
    encoding: str = field(default="", compare=False)

    @cached_property
    def _line_starts(self) -> list[int]:
        lengths = (len(line) + 1 for line in self.text.split("\n")[:-1])
        return list(accumulate(lengths, initial=0))

    @property
    def line_count(self) -> int:
        """Number of lines, counting a last one without line end."""
        return len(self._line_starts)

    def line_of(self, offset: int) -> int:
        """Return the 1-based line that holds a character offset."""
        return bisect_right(self._line_starts, min(max(offset, 0), len(self.text)))

    def column_of(self, offset: int) -> int:
        """Return the 1-based column, in characters, of a character offset."""
        return offset - self._line_starts[self.line_of(offset) - 1] + 1

    def utf16_column_of(self, offset: int) -> int:
        """Return the 0-based column in UTF-16 units, as editors count."""
        start = self._line_starts[self.line_of(offset) - 1]
        return len(self.text[start:offset].encode("utf-16-le")) // 2

    def line_start(self, line: int) -> int:
        """Return the character offset at which a 1-based line begins."""
        return self._line_starts[line - 1]

    def line_text(self, line: int) -> str:
        """Return the text of a 1-based line without its line end."""
        start = self._line_starts[line - 1]
        end = self._line_starts[line] - 1 if line < len(self._line_starts) else len(self.text)
        return self.text[start:end].rstrip("\r")


@record(frozen=True, slots=True)
class Span:
    """Mark a half-open range of characters in a source text."""

    source: SourceText
    start: int
    end: int

    @property
    def line(self) -> int:
        """1-based line of the first character."""
        return self.source.line_of(self.start)

    @property
    def column(self) -> int:
        """1-based column of the first character."""
        return self.source.column_of(self.start)

    @property
    def end_line(self) -> int:
        """1-based line of the last character."""
        return self.source.line_of(max(self.start, self.end - 1))

    @property
    def text(self) -> str:
        """The characters themselves."""
        return self.source.text[self.start : self.end]

    def to(self, other: Span) -> Span:
        """Return the smallest span that covers this one and another of the same source."""
        return Span(self.source, min(self.start, other.start), max(self.end, other.end))

    def __str__(self) -> str:
        return f"{self.source.name}:{self.line}:{self.column}"
