"""Reader of rule tables in CSV files: header and rows, one field for each cell."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from typing import Any, Final, Literal

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.lang import syntax as sx
from fuzzyctl.lang.lines import LogicalLine
from fuzzyctl.lang.parser import MAX_MISTAKES, parse_line

#: The form of a CSV file: the help on one of another form.
CSV_FORM: Final = (
    "the first line holds a field for the corner and the terms of the columns, each further line a term and its cells; "
    "a one-way table has one further line, which begins with an empty field"
)

_LINE: Final = re.compile(r"[^\n]+")
#: A field that the grammar need not read.
_PLAIN: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,50}")
_LONE_CR: Final = re.compile(r"\r(?!\n|\Z)")


def parse_csv_table(table: sx.Table, source: SourceText) -> tuple[sx.Table, list[Diagnostic]]:
    """Read header and rows of a table from a CSV file.

    Args:
        table: The statement that names the file.
        source: The text of the file; fields are parted by commas, or by semicolons where the first line has no comma.

    Returns:
        The table with header and rows, and a diagnostic for each field that could not be read.
    """
    reader = _Reader(source)
    lines = reader.without_surplus(list(reader.lines())) if reader.is_csv() else []
    header = reader.header(lines[0], [len(line) for line in lines[1:2]]) if lines else None
    rows = [row for line in lines[1:] if (row := reader.row(line)) is not None]
    incomplete = bool(reader.problems)
    table = dataclasses.replace(table, header=header, rows=tuple(rows), incomplete=incomplete)
    return table, reader.problems[:MAX_MISTAKES]


class _Reader:
    """Cuts lines into fields and parses each on its own."""

    def __init__(self, source: SourceText) -> None:
        self.source = source
        self.problems: list[Diagnostic] = []
        self.separator = ","

    def is_csv(self) -> bool:
        """Report a file whose lines or fields are parted by something else, once for all of them."""
        text = self.source.text
        first = next((m for m in _LINE.finditer(text) if m[0].strip()), None)
        lone = _LONE_CR.search(text)
        if lone is not None:
            place = Span(self.source, lone.start(), lone.end())
            self._report("FZ105", "a line ends with CR alone", place, "save the file with line ends LF or CRLF")
        elif first is not None and "\t" in first[0].rstrip() and not set(",;") & set(first[0]):
            tab = first.start() + first[0].index("\t")
            message, help_text = "the fields are parted by tabs", "part them by commas or semicolons"
            self._report("FZ105", message, Span(self.source, tab, tab + 1), help_text)
        return not self.problems

    def without_surplus(self, lines: list[list[Span]]) -> list[list[Span]]:
        """Drop the empty field behind a separator at the end of a line, and report it once."""
        if not lines:
            return lines
        due = len(lines[0]) - (not lines[0][-1].text and len(lines[0]) > 1)
        surplus = [line for line in lines if len(line) == due + 1 and not line[-1].text]
        if surplus:
            more = len(surplus) - 1
            help_text = "remove it" if not more else f"remove it here and in {counted(more, 'other line')}"
            at = surplus[0][-1].start
            place = Span(self.source, max(0, at - 1), at)
            self._report("FZ207", f"the line ends with a '{self.separator}' too many", place, help_text)
        return [line[:due] if len(line) == due + 1 and not line[-1].text else line for line in lines]

    def lines(self) -> Iterator[list[Span]]:
        """Yield the fields of each line; lines of nothing but separators and blanks hold no row."""
        start = 0
        first = True
        for text in self.source.text.split("\n"):
            end = start + len(text.rstrip())
            if text.strip(" \t\r,;"):
                if first and "," not in text and ";" in text:
                    self.separator = ";"
                first = False
                fields = self._fields(start, end)
                if fields:
                    yield fields
            start += len(text) + 1

    def _fields(self, start: int, end: int) -> list[Span]:
        """Return the fields of a line between separators outside of double quotes; none if they are ambiguous."""
        fields: list[Span] = []
        quoted, at = False, start
        for i in range(start, end):
            char = self.source.text[i]
            quoted ^= char == '"'
            if char == self.separator and not quoted:
                fields.append(self._stripped(at, i))
                at = i + 1
        fields.append(self._stripped(at, end))
        if quoted:
            self._report("FZ104", "a quoted field is not closed", fields[-1], 'end it with a double quote (")')
            return []
        torn = next((f for f in fields if f.text.count("(") > f.text.count(")")), None)
        if torn is not None:
            self._report("FZ103", "'(' is not closed in its field", torn, "put a cell with commas in double quotes")
            return []
        return fields

    def _stripped(self, start: int, end: int) -> Span:
        """Return a field without the blanks around it and without its quotes."""
        text = self.source.text[start:end]
        start += len(text) - len(text.lstrip())
        end = max(start, end - (len(text) - len(text.rstrip())))
        text = self.source.text[start:end]
        if len(text) > 1 and text[0] == text[-1] == '"':
            return self._stripped(start + 1, end - 1)
        return Span(self.source, start, end)

    def header(self, fields: list[Span], below: list[int]) -> sx.HeaderLine | None:
        """Parse the first line, whose corner is for readers."""
        whole = fields[0].to(fields[-1])
        if fields[0].text and below == [len(fields) + 1]:
            message = f"the first line has {len(fields)} fields, the one below it {below[0]}"
            self._report("FZ207", message, whole, "begin it with an empty field: the corner above the labels")
            return None
        words = [self._parse(f, "label", f"column {n}") for n, f in enumerate(fields[1:], 1)]
        return sx.HeaderLine(whole, tuple(w for w in words if w is not None))

    def row(self, fields: list[Span]) -> sx.RowLine | None:
        """Parse a further line: a term, or an empty field, and the cells."""
        label = self._parse(fields[0], "label", "") if fields[0].text else None
        cells = [self._parse(f, "cell", f"cell {n}") for n, f in enumerate(fields[1:], 1)]
        if (label is None and fields[0].text) or any(c is None for c in cells):
            return None
        return sx.RowLine(fields[0].to(fields[-1]), label, tuple(cells))

    def _parse(self, field: Span, kind: Literal["label", "cell"], what: str) -> Any:
        if not field.text:
            help_text = "write '.' where there is to be no rule" if kind == "cell" else "write the term of the column"
            self._report("FZ207", f"the field of {what} is empty", field, help_text)
            return None
        if "#" in field.text:
            at = field.start + field.text.index("#")
            help_text = "a CSV file has no comments; leave it out"
            self._report("FZ105", "unexpected '#'", Span(self.source, at, at + 1), help_text)
            return None
        if _PLAIN.fullmatch(field.text):
            word = sx.Word(field.text, field)
            return word if kind == "label" else sx.CellText((word,), None, field)
        line = LogicalLine(field.start, field.end, "", kind, "")
        node, problems = parse_line(self.source, line, kind)
        self.problems.extend(problems)
        return node

    def _report(self, code: str, message: str, place: Span, help_text: str) -> None:
        self.problems.append(Diagnostic(code, message, place, help=help_text))
