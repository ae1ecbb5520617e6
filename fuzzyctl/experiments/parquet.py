"""Parquet tables with their metadata as JSON, under the name of the application."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any


def available() -> bool:
    """Return whether pyarrow is installed."""
    try:
        import pyarrow.parquet  # noqa: F401 - whether it can be imported is the question
    except ImportError:
        return False
    return True


def write_table(
    path: Path, columns: Mapping[str, Sequence[Any]], metadata: Mapping[str, Any], application: str
) -> None:
    """Write columns of equal length; None is null."""
    import pyarrow as pa

    write(path, pa.table({name: list(values) for name, values in columns.items()}), metadata, application)


def write(path: Path, table: Any, metadata: Mapping[str, Any], application: str) -> None:
    """Write a table of pyarrow."""
    import pyarrow as pa
    from pyarrow import parquet

    floats = [f.name for f in table.schema if pa.types.is_floating(f.type)]
    named = table.replace_schema_metadata({application.encode(): json.dumps(metadata, ensure_ascii=False).encode()})
    parquet.write_table(
        named, path, compression="zstd", use_dictionary=[n for n in table.column_names if n not in floats],
        column_encoding=dict.fromkeys(floats, "BYTE_STREAM_SPLIT"),
    )  # fmt: skip


def read(path: Path) -> Any:
    """Return the table of pyarrow in a file."""
    from pyarrow import parquet

    return parquet.read_table(path)


def metadata_of(table: Any, application: str) -> dict[str, Any]:
    """Return the metadata of a table of pyarrow.

    Raises:
        ValueError: When it has none of the application.
    """
    found = (table.schema.metadata or {}).get(application.encode())
    if found is None:
        raise ValueError(f"it has no metadata of {application}")
    metadata: dict[str, Any] = json.loads(found)
    return metadata
