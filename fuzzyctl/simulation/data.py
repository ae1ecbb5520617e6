"""Signals of a run as a file: CSV, npz or Parquet."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Final

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.experiments.results.parquet import available, write_table
from fuzzyctl.simulation.run import Run
from fuzzyctl.support.writing import written_whole

#: Formats of data, each with the suffix of its files.
FORMATS: Final = ("csv", "npz", "parquet")


def require_format(form: str) -> None:
    """Refuse a format whose package is missing.

    Raises:
        ArgumentError: For Parquet without pyarrow.
    """
    if form == "parquet" and not available():
        raise ArgumentError("Parquet needs pyarrow: pip install 'fuzzyctl[data]'")


def save(run: Run, folder: Path, form: str) -> Path:
    """Write the times and signals of a run.

    Args:
        run: The run.
        folder: An existing folder.
        form: One of `FORMATS`.

    Returns:
        The file, `data.FORMAT` in the folder.

    Raises:
        DiagnosticError: When it cannot be written.
    """
    target = folder / f"data.{form}"
    columns = {"t": run.t} | {name: run[name] for name in run.names}
    with written_whole(target) as temporary:
        if form == "csv":
            with temporary.open("w", encoding="utf-8", newline="") as file:
                writer = csv.writer(file, lineterminator="\n")
                writer.writerow(columns)
                writer.writerows(np.column_stack(list(columns.values())).tolist())
        elif form == "npz":
            with temporary.open("wb") as binary:
                np.savez_compressed(binary, **columns)  # type: ignore[arg-type]  # no signal is called allow_pickle
        else:
            write_table(temporary, {n: c.tolist() for n, c in columns.items()}, {"loop": run.loop.name}, "fuzzyctl")
    return target
