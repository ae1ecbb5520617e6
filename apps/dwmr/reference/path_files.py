"""CSV files of a reference path: times and positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dwmr.config import csv_rows
from dwmr.core.arrays import FloatArray
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.source import SourceText

#: A path file beyond this is refused before it is read [bytes].
LARGEST_PATH = 4 << 20
#: Kind of these files.
FORM = csv_rows.Form(
    "path",
    "FZ910",
    tuple(map(csv_rows.Column, ("t", "x", "y"))),
    "write a line 't,x,y' and below it a row for each time [s] and place [m, m]",
)


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
        return csv_rows.place(self.source, FORM.code, self.lines[k], message, facts, help_text)


def read_rows(name: str, content: bytes) -> PathRows:
    """Read the rows of a path file with the columns t [s], x [m] and y [m]; `name` is shown in diagnostics.

    Raises:
        DiagnosticError: With the mistakes of the file.
    """
    rows = csv_rows.read(name, content, FORM)
    data = np.array([rows.columns[c.name] for c in FORM.columns])
    return PathRows(data[0], data[1:].T, rows.lines, rows.source)
