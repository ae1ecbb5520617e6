"""Evaluation of the rows of a CSV file, a block at a time."""

from __future__ import annotations

import csv
import io
import json
import math
import tempfile
import unicodedata
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final, TextIO, cast

from fuzzyctl.cli.common import STDIN, plain, standard_input, state_of
from fuzzyctl.cli.streams import write_data
from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.suggestions import closest
from fuzzyctl.kernels.compile import Kernel
from fuzzyctl.kernels.compile import compile as compile_block
from fuzzyctl.support.files import to_number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fuzzyctl.model.block import Block
    from fuzzyctl.model.system import FuzzySystem

#: Rows that are evaluated at once: bounded memory whatever the file's length.
BLOCK: Final = 8192


def evaluate_rows(system: Block, points: str, state: Sequence[str], form: str) -> list[Diagnostic]:
    """Print every row of a CSV file with its outputs.

    Args:
        system: A system or controller.
        points: The file; '-' is standard input.
        state: Numbers of the state before the first row that are not those of the start, as `NAME=VALUE`.
        form: "text" for CSV, "json" for a list of inputs and outputs.

    Returns:
        Warnings of clamped values.

    Raises:
        DiagnosticError: For a file that cannot be read, before anything is printed.
    """
    kernel = compile_block(cast("FuzzySystem", system), backend="numpy")
    before = list(state_of(kernel, state).values())
    name = STDIN if points == "-" else points
    try:
        # Results wait in a file until all rows are done, so that a malformed one prints nothing half-written.
        with tempfile.TemporaryFile("w+", encoding="utf-8", newline="") as results:
            if points == "-":
                piped = io.TextIOWrapper(standard_input(), encoding="utf-8-sig", newline="")
                warnings = _evaluate_rows(system, kernel, before, piped, name, form, results)
                piped.detach()
            else:
                with open(points, encoding="utf-8-sig", newline="") as stream:
                    warnings = _evaluate_rows(system, kernel, before, stream, name, form, results)
            results.seek(0)
            for part in iter(lambda: results.read(1 << 16), ""):
                write_data(part)
        return warnings
    except UnicodeDecodeError:
        raise DiagnosticError([Diagnostic("FZ002", "the points are not UTF-8 text", file=name)]) from None
    except OSError as error:
        raise DiagnosticError(
            [Diagnostic("FZ001", f"the file cannot be read: {error.strerror}", file=points)]
        ) from None


def _evaluate_rows(
    system: Block, kernel: Kernel, state: Any, stream: TextIO, name: str, form: str, results_file: TextIO
) -> list[Diagnostic]:
    """Evaluate all rows into a file; return warnings of clamped values."""
    reader = csv.reader(stream)
    header = [unicodedata.normalize("NFC", cell.strip()) for cell in _next(reader, name) or []]
    outputs = kernel.output_names
    names = (*kernel.input_names, *(["dt"] if kernel.form.needs_time else []))
    columns = _columns(names, outputs, header, name)
    writer = csv.writer(results_file, lineterminator="\n")
    clamped = _Clamped(system)
    first = True
    for rows, points, results in _blocks(kernel, state, reader, columns, header, name):
        clamped.count(points)
        if form == "text":
            # The header waits for the first block, so that a malformed file prints only its error.
            writer.writerows([[*header, *outputs]] if first else [])
            writer.writerows([*row, *map(repr, result)] for row, result in zip(rows, results, strict=True))
            first = False
            continue
        for point, result in zip(points.tolist(), results, strict=True):
            inputs = dict(zip(names, point, strict=True))
            item = {"inputs": plain(inputs), "outputs": plain(dict(zip(outputs, result, strict=True)))}
            results_file.write(("[" if first else ",\n ") + json.dumps(item, ensure_ascii=False))
            first = False
    if form == "json":
        results_file.write("[]\n" if first else "]\n")
    elif first:
        writer.writerow([*header, *outputs])
    return clamped.warnings()


def _next(reader: Any, name: str) -> list[str] | None:
    """Return the next row, None at the end."""
    try:
        row: list[str] | None = next(reader, None)
    except csv.Error as error:
        place = f"{name}:{reader.line_num}"
        raise DiagnosticError([Diagnostic("FZ505", f"the row cannot be read: {error}", file=place)]) from None
    return row


class _Clamped:
    """Counts the values that lie outside their input's range."""

    def __init__(self, system: Block) -> None:
        self.names = [v.name for v in system.inputs]
        free = [system.kind != "system" or v.extrapolate for v in system.inputs]
        ends = [system.range_of(v) for v in system.inputs]
        self.low = [-math.inf if f else low for (low, _), f in zip(ends, free, strict=True)]
        self.high = [math.inf if f else high for (_, high), f in zip(ends, free, strict=True)]
        self.outside = [0] * len(self.names)
        self.total = 0

    def count(self, points: Any) -> None:
        inputs = points[:, : len(self.names)]
        outside = ((inputs < self.low) | (inputs > self.high)).sum(axis=0)
        self.outside = [a + int(b) for a, b in zip(self.outside, outside, strict=True)]
        self.total += len(points)

    def warnings(self) -> list[Diagnostic]:
        help_text = "widen the range in the file, or write 'extrapolate' behind it"
        return [
            Diagnostic(
                "FZ504",
                f"{count} of {self.total} values of '{name}' lie outside [{low:.6g}, {high:.6g}] and are clamped to it",
                severity="warning",
                help=help_text,
            )
            for name, low, high, count in zip(self.names, self.low, self.high, self.outside, strict=True)
            if count
        ]


def _columns(names: Sequence[str], outputs: Sequence[str], header: list[str], name: str) -> list[int]:
    """Find the column of each input, and of the times between the rows if a controller takes them."""
    mistakes = []
    first_line = f"the first line names the columns: {','.join(names)}"
    if not any(header):
        raise DiagnosticError([Diagnostic("FZ505", "the file has no header line", file=name, help=first_line)])
    if len(header) == 1 and any(c in header[0] for c in ";\t") and len(names) > 1:
        facts = (f"the first line is: {header[0]!r}",)
        message = "the columns are not separated by commas"
        raise DiagnosticError([Diagnostic("FZ505", message, file=name, facts=facts, help=first_line)])
    for variable in names:
        count = header.count(variable)
        if count == 1:
            continue
        near = closest(variable, header)
        what = f"no column '{variable}'" if not count else f"{count} columns '{variable}'"
        help_text = f"is '{near}' meant? {first_line}" if near and not count else first_line
        mistakes.append(Diagnostic("FZ505", what, file=name, facts=(f"columns: {', '.join(header)}",), help=help_text))
    for output in outputs:
        if output in header:
            message = f"the file already has a column '{output}', the name of an output"
            mistakes.append(Diagnostic("FZ505", message, file=name, help="rename or remove it"))
    if mistakes:
        raise DiagnosticError(mistakes)
    return [header.index(v) for v in names]


def _blocks(
    kernel: Kernel, state: Any, reader: Any, columns: list[int], header: list[str], name: str
) -> Iterator[tuple[list[list[str]], Any, list[list[float]]]]:
    """Yield rows, their points as an array (rows, inputs), and their results."""
    import numpy as np

    done = False
    while not done:
        rows: list[list[str]] = []
        points = np.empty((BLOCK, len(columns)))
        while len(rows) < BLOCK:
            row = _next(reader, name)
            if row is None:
                done = True
                break
            if not row:
                continue
            point = _point(row, columns, header, f"{name}:{reader.line_num}")
            if kernel.form.needs_time and not 0.0 < point[-1] < math.inf:
                message = f"'dt' must be > 0 s and finite, got {point[-1]:g}"
                raise DiagnosticError([Diagnostic("FZ505", message, file=f"{name}:{reader.line_num}")])
            points[len(rows)] = point
            rows.append(row)
        points = points[: len(rows)]
        if rows:
            inputs = len(kernel.input_names)
            times = points[:, inputs] if kernel.form.needs_time else None
            results, state = kernel.run(points[:, :inputs], state, dt=times)
            yield rows, points, results.reshape(len(rows), -1).tolist()


def _point(row: list[str], columns: list[int], header: list[str], place: str) -> list[float]:
    """Return the values of the inputs in a row."""
    if len(row) != len(header):
        message = f"the row has {len(row)} cell{'' if len(row) == 1 else 's'} for {len(header)} columns"
        raise DiagnosticError([Diagnostic("FZ505", message, file=place)])
    values = []
    for c in columns:
        try:
            values.append(to_number(row[c]))
        except (ValueError, OverflowError):
            text = row[c] if len(row[c]) <= 40 else f"{row[c][:40]}…"
            message = f"'{text}' in column '{header[c]}' is not a number"
            help_text = "write numbers with a decimal point"
            raise DiagnosticError([Diagnostic("FZ505", message, file=place, help=help_text)]) from None
    return values
