"""Columns of numbers that are known before a run: noise, and tables of CSV files."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.suggestions import did_you_mean
from fuzzyctl.simulation.signals import Given, Noise, Table
from fuzzyctl.support.files import read_source

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]


def columns(given: Iterable[Given], times: FloatArray, folder: Path, seed: int | None = None) -> FloatArray:
    """Return the columns side by side, shape (samples, columns).

    Args:
        given: Noise and tables.
        times: Times of the samples, shape (samples,) [s].
        folder: Folder of the tables.
        seed: Draws each noise anew, from this and the seed of the noise; None for the latter alone.

    Raises:
        DiagnosticError: For a file that cannot be read, and for columns that it does not have.
    """
    series: list[FloatArray] = []
    for one in given:
        if isinstance(one, Noise):
            generator = np.random.Generator(np.random.PCG64(one.seed if seed is None else [seed, one.seed]))
            series.append(one.sigma * generator.standard_normal(len(times)))
        else:
            series += lines_of(one, times, folder)
    return np.stack(series, axis=1) if series else np.empty((len(times), 0))


def lines_of(table: Table, times: FloatArray, folder: Path) -> list[FloatArray]:
    """Return offset and slope of the straight line from each sample to the next."""
    rows, values = _read(table, folder)
    at = np.interp(times, rows, values)
    slope = np.append(np.diff(at) / np.diff(times), 0.0)
    return [at - slope * times, slope]


def _read(table: Table, folder: Path) -> tuple[FloatArray, FloatArray]:
    """Return times and values of a table."""
    text = read_source(folder / table.file, only_regular=True).text
    rows = [row for row in csv.reader(io.StringIO(text)) if row]
    header = [name.strip() for name in rows[0]] if rows else []
    time = table.time or (header[0] if header else "")
    for name in (time, table.column):
        if name not in header:
            facts = (f"columns: {', '.join(header) or 'none'}",)
            message = f"'{table.file}' has no column '{name}'"
            raise DiagnosticError(
                [Diagnostic("FZ705", message, table.span, facts=facts, help=did_you_mean(name, header))]
            )
    at, values = (
        [_cell(table, row, line, header.index(n)) for line, row in enumerate(rows[1:], 2)] for n in (time, table.column)
    )
    if not at:
        raise DiagnosticError([Diagnostic("FZ705", f"'{table.file}' has no rows below its header", table.span)])
    moments = np.array(at)
    if np.any(np.diff(moments) <= 0.0):
        line = int(np.argmax(np.diff(moments) <= 0.0)) + 3
        message = f"times in column '{time}' of '{table.file}' do not ascend at line {line}"
        raise DiagnosticError([Diagnostic("FZ705", message, table.span, help="sort the rows by time")])
    return moments, np.array(values)


def _cell(table: Table, row: list[str], line: int, column: int) -> float:
    try:
        value = float(row[column])
        if np.isfinite(value):
            return value
    except (ValueError, IndexError):
        pass
    cell = row[column] if column < len(row) else ""
    message = f"'{cell}' is not a finite number, in line {line} of '{table.file}'"
    raise DiagnosticError([Diagnostic("FZ705", message, table.span)])
