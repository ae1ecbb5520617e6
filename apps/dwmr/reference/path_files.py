"""CSV files of a reference path: times and positions, with every mistake at its line and column."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from dwmr.config.quantities import FARTHEST
from dwmr.core.arrays import FloatArray
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import SourceText, Span
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.support.files import to_number

#: A path file beyond this is refused before it is read [bytes].
LARGEST_PATH = 4 << 20
#: Mistakes of one file that are reported; a file with more of them is not a path.
MOST_MISTAKES = 20

#: Times and places beyond this are mistakes [s, m].
LARGEST_VALUE = FARTHEST
#: Least time between two rows [s].
SHORTEST_STEP = 1e-6

COLUMNS = ("t", "x", "y")


@dataclass(frozen=True)
class PathRows:
    """The rows of a path file.

    Args:
        t: Increasing times, shape (n,) [s].
        points: Places, shape (n, 2) [m].
        lines: Line of each row in the file, counted from 1.
        source: The file.
    """

    t: FloatArray
    points: FloatArray
    lines: tuple[int, ...]
    source: SourceText

    def standstill(self, when: float, speed: float, least: float) -> Diagnostic:
        """Describe where the path does not move."""
        k = max(0, int(np.searchsorted(self.t, when, side="right")) - 1)
        message = f"the reference stands still: its speed is {speed:.3g} m/s at t = {when:.6g} s"
        facts = (f"below {least:g} m/s its direction is undefined, and with it the auxiliary angular velocity",)
        help_text = "leave out rows that stand still, and lead the path around corners"
        return _at(self.source, self.lines[k], message, facts, help_text)


def read_rows(name: str, content: bytes) -> PathRows:
    """Read the rows of a path file.

    Args:
        name: Shown in diagnostics.
        content: CSV with a first line that names the columns t [s], x [m], y [m], in any order; further columns, blank
            lines and lines that begin with # are passed over.

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
        raise DiagnosticError([Diagnostic("FZ910", f"{name} is empty", help=_HELP, file=name)])
    columns = _header(source, *lines[0])
    mistakes: list[Diagnostic] = []
    rows: list[tuple[float, ...]] = []
    for number, line in lines[1:]:
        mistakes += _cells(source, number, line, columns, rows)
        if len(mistakes) >= MOST_MISTAKES:
            break
    if mistakes:
        raise DiagnosticError(mistakes)
    if len(rows) < 2:
        message = f"{name} has {len(rows)} row{'s' if len(rows) != 1 else ''}; a path needs at least 2"
        raise DiagnosticError([Diagnostic("FZ910", message, help=_HELP, file=name)])
    data = np.array(rows)
    return PathRows(data[:, 0], data[:, 1:], tuple(k for k, _ in lines[1:]), source)


_HELP = "write a line 't,x,y' and below it a row for each time [s] and place [m, m]"


def _header(source: SourceText, number: int, line: str) -> tuple[list[int], int]:
    """Return the numbers of the columns t, x, y, and the number of columns."""
    names = [cell.strip() for cell in line.split(",")]
    missing = [c for c in COLUMNS if c not in names]
    if missing:
        message = f"the first line names no column {', '.join(missing)}"
        facts = (f"its columns are {', '.join(n or '(blank)' for n in names[:10])}",)
        hint = did_you_mean(missing[0], tuple(n for n in names if n)) or _HELP
        raise DiagnosticError([_at(source, number, message, facts, hint)])
    if twice := [c for c in COLUMNS if names.count(c) > 1]:
        raise DiagnosticError([_at(source, number, f"the first line names column {twice[0]} twice")])
    return [names.index(c) for c in COLUMNS], len(names)


def _cells(
    source: SourceText, number: int, line: str, columns: tuple[list[int], int], rows: list[tuple[float, ...]]
) -> Iterator[Diagnostic]:
    """Append one row to those before it, or describe its mistake."""
    where, count = columns
    cells = line.split(",")
    if len(cells) != count:
        yield _at(source, number, f"the row has {len(cells)} cell{'s' if len(cells) != 1 else ''} for {count} columns")
        return
    values = []
    for name, k in zip(COLUMNS, where, strict=True):
        value = _number(cells[k])
        if value is None or not abs(value) <= LARGEST_VALUE:
            text = cells[k].strip()[:40]
            message = f"column {name}: {text} {_fault(value)}" if text else f"column {name} is empty"
            yield _at(source, number, message, column=k)
        else:
            values.append(value)
    if len(values) < len(COLUMNS):
        return
    if rows and not values[0] - rows[-1][0] >= SHORTEST_STEP:
        message = f"column t: {values[0]:.9g} comes after {rows[-1][0]:.9g}; times must increase by {SHORTEST_STEP:g} s"
        yield _at(source, number, message, column=where[0])
        return
    rows.append(tuple(values))


def _fault(value: float | None) -> str:
    if value is None:
        return "is not a number"
    return f"is beyond {LARGEST_VALUE:g}" if math.isfinite(value) else "is not a finite number"


def _number(text: str) -> float | None:
    try:
        return to_number(text)
    except OverflowError:
        return math.inf
    except ValueError:
        return None


def _at(
    source: SourceText,
    number: int,
    message: str,
    facts: tuple[str, ...] = (),
    help: str = "",
    column: int | None = None,
) -> Diagnostic:
    """Return a diagnostic at a line of the file, or at one of its cells."""
    line = source.line_text(number)
    start = sum(len(x) + 1 for x in source.text.split("\n")[: number - 1])
    first, last = 0, len(line)
    if column is not None:
        cells = line.split(",")
        first = sum(len(c) + 1 for c in cells[:column])
        last = first + len(cells[column]) if column < len(cells) else last
    return Diagnostic(
        "FZ910", message, Span(source, start + first, start + max(last, first + 1)), facts=facts, help=help
    )
