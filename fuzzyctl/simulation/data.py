"""Signals of a run as a file: CSV, npz or Parquet."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.experiments.parquet import available, write_table
from fuzzyctl.experiments.result_files import write_csv
from fuzzyctl.simulation.run import Run

#: Formats of data, each with the suffix of its files.
FORMATS: Final = ("csv", "npz", "parquet")


def require_format(form: str) -> None:
    """Refuse a format whose package is missing.

    Raises:
        ArgumentError: For Parquet without pyarrow.
    """
    if form == "parquet" and not available():
        raise ArgumentError("Parquet needs pyarrow: pip install 'fuzzyctl[data]'")


def save(run: Run, path: Path, form: str) -> None:
    """Write the times and signals of a run to a file of one of `FORMATS`."""
    columns = {"t": run.t} | {name: run[name] for name in run.names}
    if form == "npz":
        with path.open("wb") as binary:
            np.savez_compressed(binary, **columns)  # type: ignore[arg-type]  # no signal is called allow_pickle
        return
    lists = {name: values.tolist() for name, values in columns.items()}
    if form == "csv":
        write_csv(path, lists)
    else:
        write_table(path, lists, {"loop": run.loop.name}, "fuzzyctl")
