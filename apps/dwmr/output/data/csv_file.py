"""CSV: a line of metadata as JSON, the names of the columns, then a row for each law, time and robot."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np

from dwmr.output.data.signals import TIME, Data, described, from_rows, rows

_MARK = "# metadata: "
#: Rows converted to text at a time.
_CHUNK = 20_000


def save(path: Path, data: Data) -> None:
    """Write the shortest text of every number that reads back bit for bit; a signal that a law has not is empty."""
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(f"{_MARK}{json.dumps(described(data), ensure_ascii=False)}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["controller", TIME, "robot", *data.signals()])
        for columns in rows(data).values():
            count = len(columns["controller"])
            for first in range(0, count, _CHUNK):
                writer.writerows(
                    zip(*(_text(c, first, min(first + _CHUNK, count)) for c in columns.values()), strict=True)
                )


def _text(column: Any, first: int, last: int) -> list[Any]:
    if column is None:
        return [""] * (last - first)
    part = column[first:last]
    # Python's own floats, which the csv module writes by repr
    return part if isinstance(part, list) else part.tolist()


def load(path: Path) -> Data:
    """Read what `save` wrote.

    Raises:
        ValueError: When it is something else.
    """
    with path.open(encoding="utf-8", newline="") as file:
        first = file.readline()
        if not first.startswith(_MARK):
            raise ValueError(f"its first line does not begin with '{_MARK.strip()}'")
        metadata = json.loads(first.removeprefix(_MARK))
        reader = csv.reader(file)
        names = next(reader)
        columns = list(zip(*reader, strict=True)) or [()] * len(names)
    found = dict(zip(names, columns, strict=True))
    numbers = {
        name: np.array([float(cell or "nan") for cell in cells]) for name, cells in found.items()
        if name not in ("controller", "robot")
    }  # fmt: skip
    return from_rows(found["controller"], numbers, metadata)
