"""CSV files with a row for each time, with every mistake at its line and column."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from dwmr.config.quantities import FARTHEST
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.support.files import to_number

#: Mistakes of one file that are reported; a file with more of them is of another kind.
MOST_MISTAKES = 20
#: Least time between two rows [s].
SHORTEST_STEP = 1e-6


@dataclass(frozen=True)
class Column:
    """A column of a kind of files.

    Args:
        name: Its name in messages.
        heads: Other words of the first line for it; the first one that a file has counts.
        is_required: Whether a file must have it.
        limit: Largest number in it.
        words: The words that it may hold, empty for a column of numbers.
    """

    name: str
    heads: tuple[str, ...] = ()
    is_required: bool = True
    limit: float = FARTHEST
    words: tuple[str, ...] = ()


@dataclass(frozen=True)
class Form:
    """A kind of files.

    Args:
        noun: Subject of a file.
        code: Of the diagnostics.
        columns: The first one holds times, which increase; with a column of words, among the rows of each word.
        help: How to write such a file.
    """

    noun: str
    code: str
    columns: tuple[Column, ...]
    help: str


@dataclass(frozen=True)
class Rows:
    """Rows of a file.

    Args:
        columns: Values by column, without columns that the file does not have.
        lines: Line of each row in the file, counted from 1.
        source: The file.
    """

    columns: dict[str, tuple[Any, ...]]
    lines: tuple[int, ...]
    source: SourceText


def read(name: str, content: bytes, form: Form) -> Rows:
    """Read a file.

    Args:
        name: Shown in diagnostics.
        content: CSV with a first line that names the columns, in any order; other columns, blank lines and lines that
            begin with # are passed over.
        form: Kind of the file.

    Raises:
        DiagnosticError: With the mistakes of the file.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        message = f"{name} is not UTF-8 text: byte {error.start} is 0x{content[error.start]:02x}"
        raise DiagnosticError([Diagnostic("FZ002", message, file=name)]) from error
    source = SourceText(name, text)
    lines = [(k, line) for k, line in enumerate(text.split("\n"), start=1) if line.strip() and line[:1] != "#"]
    if not lines:
        raise DiagnosticError([Diagnostic(form.code, f"{name} is empty", help=form.help, file=name)])
    reader = _Reader(source, form, *lines[0])
    mistakes: list[Diagnostic] = []
    for number, line in lines[1:]:
        mistakes += reader.mistakes(number, line)
        if len(mistakes) >= MOST_MISTAKES:
            break
    if mistakes:
        raise DiagnosticError(mistakes[:MOST_MISTAKES])
    if len(reader.rows) < 2:
        count = len(reader.rows)
        message = f"{name} has {count} row{'s' if count != 1 else ''}; a {form.noun} needs at least 2"
        raise DiagnosticError([Diagnostic(form.code, message, help=form.help, file=name)])
    columns = dict(zip((c.name for c, _ in reader.columns), zip(*reader.rows, strict=True), strict=True))
    return Rows(columns, tuple(number for number, _ in lines[1:]), source)


class _Reader:
    """Reads rows one after the other.

    Args:
        source, form: File and its kind.
        number, line: Number and text of its first line.

    Attributes:
        columns: Columns that the file has, and their positions.
        rows: Values of the rows without mistakes.
    """

    def __init__(self, source: SourceText, form: Form, number: int, line: str) -> None:
        self._source, self._form = source, form
        self.rows: list[tuple[Any, ...]] = []
        #: Time and line of the latest row of each group, and the line of the latest mistake in times.
        self._latest: dict[str, tuple[float, int]] = {}
        self._jump = 0
        self._unknown = set[str]()
        names = [cell.strip() for cell in line.split(",")]
        heads = {c: next((h for h in (*c.heads, c.name) if h in names), None) for c in form.columns}
        if missing := [c for c, head in heads.items() if head is None and c.is_required]:
            message = f"the first line names no column {', '.join(c.name for c in missing)}"
            others = (f"other names of {c.name}: {', '.join(c.heads)}" for c in missing if c.heads)
            facts = (f"its columns are {', '.join(n or '(blank)' for n in names[:10])}", *others)
            hint = did_you_mean(missing[0].name, tuple({*names} - {"", *heads.values()})) or form.help
            raise DiagnosticError([place(source, form.code, number, message, facts, hint)])
        if twice := [head for head in heads.values() if head is not None and names.count(head) > 1]:
            message = f"the first line names column {twice[0]} twice"
            raise DiagnosticError([place(source, form.code, number, message)])
        self._count = len(names)
        self.columns = [(c, names.index(head)) for c, head in heads.items() if head is not None]

    def mistakes(self, number: int, line: str) -> Iterator[Diagnostic]:
        """Yield the mistakes of a row, or append it to `rows`."""
        cells = line.split(",")
        if len(cells) != self._count:
            count = f"{len(cells)} cell{'s' if len(cells) != 1 else ''}"
            yield self._at(number, f"the row has {count} for {self._count} columns")
            return
        values: dict[str, Any] = {}
        for column, k in self.columns:
            cell = cells[k].strip()
            if column.words:
                values[column.name] = cell
                if cell not in column.words and cell not in self._unknown:
                    self._unknown.add(cell)
                    hint = did_you_mean(cell, column.words) or f"there are {', '.join(column.words)}"
                    yield self._at(number, f"column {column.name}: unknown name {cell[:40]!r}", k, hint)
                continue
            value = _number(cells[k])
            if value is not None and abs(value) <= column.limit:
                values[column.name] = value
            else:
                fault = f": {cell[:40]} {_fault(value, column.limit)}" if cell else " is empty"
                yield self._at(number, f"column {column.name}{fault}", k)
        yield from self._not_later(number, values)
        if len(values) == len(self.columns):
            self.rows.append(tuple(values.values()))

    def _not_later(self, number: int, values: dict[str, Any]) -> Iterator[Diagnostic]:
        """Drop the time of a row that is not later than that of the one before, and yield the mistake.

        A clock that jumps back does so for all groups of rows; only the first one is reported.
        """
        name, group = self._form.columns[0].name, next((v for v in values.values() if isinstance(v, str)), "")
        before, line = self._latest.get(group, (-math.inf, 0))
        now = values.get(name, before)
        if name in values and not now - before >= SHORTEST_STEP:
            del values[name]
            if line >= self._jump:
                of, self._jump = f" of {group}" if group else "", number
                message = f"column {name}: {now:.15g}{of} comes after {before:.15g}"
                yield self._at(number, f"{message}; times must increase by {SHORTEST_STEP:g} s", self.columns[0][1])
        self._latest[group] = now, number

    def _at(self, number: int, message: str, column: int | None = None, help: str = "") -> Diagnostic:
        return place(self._source, self._form.code, number, message, help=help, column=column)


def _fault(value: float | None, limit: float) -> str:
    if value is None:
        return "is not a number"
    return f"is beyond {limit:g}" if math.isfinite(value) else "is not a finite number"


def _number(text: str) -> float | None:
    try:
        return to_number(text)
    except OverflowError:
        return math.inf
    except ValueError:
        return None


def place(
    source: SourceText,
    code: str,
    number: int,
    message: str,
    facts: tuple[str, ...] = (),
    help: str = "",
    column: int | None = None,
) -> Diagnostic:
    """Return a diagnostic at a line of a file, or at one of its cells."""
    line, start = source.line_text(number), source.line_start(number)
    first, last = 0, len(line)
    if column is not None:
        cells = line.split(",")
        first = sum(len(c) + 1 for c in cells[:column])
        last = first + len(cells[column]) if column < len(cells) else last
    span = Span(source, start + first, start + max(last, first + 1))
    return Diagnostic(code, message, span, facts=facts, help=help)
