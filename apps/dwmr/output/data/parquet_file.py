"""Parquet: a table of the signals with their metadata as JSON."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from dwmr.output.data.signals import Data, described, from_rows, rows
from fuzzyctl.experiments import parquet

#: Under this key a file holds its metadata.
KEY = "dwmr"

available = parquet.available
write_table = partial(parquet.write_table, application=KEY)
read_table = partial(parquet.read_table, application=KEY)


def save(path: Path, data: Data) -> None:
    """Write the signals: a row for each law, time and robot; a signal that a law has not is null."""
    import pyarrow as pa

    parts = []
    for columns in rows(data).values():
        count = len(columns["controller"])
        parts.append(
            pa.table({name: pa.nulls(count, pa.float64()) if c is None else pa.array(c) for name, c in columns.items()})
        )
    parquet.write(path, pa.concat_tables(parts), described(data), KEY)


def load(path: Path) -> Data:
    """Read what `save` wrote.

    Raises:
        ValueError: When it is something else.
    """
    found = parquet.read(path)
    laws = found.column("controller").to_pylist()
    names = [name for name in found.column_names if name not in ("controller", "robot")]
    numbers = {name: np.asarray(found.column(name).to_numpy(), dtype=np.float64) for name in names}
    return from_rows(laws, numbers, parquet.metadata_of(found, KEY))
