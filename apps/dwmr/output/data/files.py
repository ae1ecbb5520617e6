"""Choice of the file format by suffix; all formats give back the same numbers, bit for bit."""

from __future__ import annotations

import json
import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from dwmr.output.data import csv_file
from dwmr.output.data.signals import Data

#: What `dwmr run --data` takes; the suffix of the file is the same word.
FORMATS = ("npz", "csv", "mat", "parquet")


class UnreadableDataError(ValueError):
    """Raised when a file does not hold the signals of runs."""


def suffix(path: Path) -> str:
    """Return the format that a file's name stands for."""
    return path.suffix.removeprefix(".").lower()


def load(path: str | os.PathLike[str]) -> Data:
    """Read the signals of runs from a file that `dwmr run` wrote.

    Args:
        path: Its suffix says which format it has: npz, csv, mat or parquet.

    Raises:
        OSError: When it cannot be read.
        UnreadableDataError: When it holds something else.
        ImportError: When Parquet is to be read without pyarrow.
    """
    path = Path(path)
    if suffix(path) not in FORMATS:
        raise UnreadableDataError(f"{path}: the suffix must be one of {', '.join(FORMATS)}")
    try:
        return _load(path)
    except (KeyError, ValueError, TypeError, IndexError, EOFError, zipfile.BadZipFile) as error:
        raise UnreadableDataError(f"{path} does not hold the signals of runs: {error}") from error


def _load(path: Path) -> Data:
    match suffix(path):
        case "npz":
            return _load_npz(path)
        case "csv":
            return csv_file.load(path)
        case "mat":
            from dwmr.output.data import mat_file

            return mat_file.load(path)
    from dwmr.output.data import parquet_file

    return parquet_file.load(path)


def save(path: Path, data: Data) -> None:
    """Write the signals of runs in the format of the file's suffix."""
    match suffix(path):
        case "npz":
            _save_npz(path, data)
        case "csv":
            csv_file.save(path, data)
        case "mat":
            from dwmr.output.data import mat_file

            mat_file.save(path, data)
        case "parquet":
            from dwmr.output.data import parquet_file

            parquet_file.save(path, data)


def _save_npz(path: Path, data: Data) -> None:
    arrays: dict[str, Any] = {f"{law}/{name}": a for law, run in data.runs.items() for name, a in run.items()}
    arrays["metadata"] = np.array(json.dumps(data.metadata, indent=2, ensure_ascii=False))
    with path.open("wb") as file:
        np.savez(file, **arrays)


def _load_npz(path: Path) -> Data:
    runs: dict[str, dict[str, Any]] = {}
    with np.load(path, allow_pickle=False) as archive:
        for key in archive.files:
            law, slash, name = key.partition("/")
            if slash:
                runs.setdefault(law, {})[name] = archive[key]
        return Data(runs, json.loads(str(archive["metadata"])))
