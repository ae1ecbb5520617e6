"""Parquet: tables with their metadata as JSON; the only module that imports pyarrow."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dwmr.output.data.signals import Data, described, from_rows, rows

#: Under this key a file holds its metadata.
KEY = b"dwmr"


def available() -> bool:
    """Return whether pyarrow is installed."""
    try:
        import pyarrow.parquet  # noqa: F401 - whether it can be imported is the question
    except ImportError:
        return False
    return True


def write_table(path: Path, columns: Mapping[str, Sequence[Any]], metadata: Mapping[str, Any]) -> None:
    """Write columns of equal length; None is null."""
    import pyarrow as pa

    _write(path, pa.table({name: list(values) for name, values in columns.items()}), metadata)


def read_table(path: Path) -> tuple[dict[str, list[Any]], dict[str, Any]]:
    """Return the columns of a file, and its metadata."""
    from pyarrow import parquet

    found = parquet.read_table(path)
    return found.to_pydict(), _metadata(found)


def save(path: Path, data: Data) -> None:
    """Write the signals: a row for each law, time and robot; a signal that a law has not is null."""
    import pyarrow as pa

    parts = []
    for columns in rows(data).values():
        count = len(columns["controller"])
        parts.append(
            pa.table({name: pa.nulls(count, pa.float64()) if c is None else pa.array(c) for name, c in columns.items()})
        )
    _write(path, pa.concat_tables(parts), described(data))


def load(path: Path) -> Data:
    """Read what `save` wrote.

    Raises:
        ValueError: When it is something else.
    """
    from pyarrow import parquet

    found = parquet.read_table(path)
    laws = found.column("controller").to_pylist()
    names = [name for name in found.column_names if name not in ("controller", "robot")]
    numbers = {name: np.asarray(found.column(name).to_numpy(), dtype=np.float64) for name in names}
    return from_rows(laws, numbers, _metadata(found))


def _write(path: Path, table: Any, metadata: Mapping[str, Any]) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    floats = [f.name for f in table.schema if pa.types.is_floating(f.type)]
    named = table.replace_schema_metadata({KEY: json.dumps(metadata, ensure_ascii=False).encode()})
    parquet.write_table(
        named, path, compression="zstd", use_dictionary=[n for n in table.column_names if n not in floats],
        column_encoding=dict.fromkeys(floats, "BYTE_STREAM_SPLIT"),
    )  # fmt: skip


def _metadata(table: Any) -> dict[str, Any]:
    found = (table.schema.metadata or {}).get(KEY)
    if found is None:
        raise ValueError("it has no metadata of dwmr")
    metadata: dict[str, Any] = json.loads(found)
    return metadata
