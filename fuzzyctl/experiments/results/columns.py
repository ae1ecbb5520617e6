"""Tables of results by column, each of one type, and their CSV."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from fuzzyctl.experiments.settings.overrides import literal

Columns = dict[str, list[Any]]


def columns_of(rows: Sequence[Mapping[str, Any]]) -> Columns:
    """Return rows by column; what a row does not have is None."""
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: _uniform([row.get(name) for row in rows]) for name in names}


def _uniform(values: list[Any]) -> list[Any]:
    """Give a column one type: numbers with a fraction make all of them such, other mixtures become text."""
    kinds = {type(v) for v in values if v is not None}
    if kinds == {int, float}:
        return [None if v is None else float(v) for v in values]
    if len(kinds) > 1 or kinds & {list, tuple, dict}:
        return [None if v is None else literal(v) for v in values]
    return values


def write_csv(path: Path, columns: Mapping[str, Sequence[Any]]) -> None:
    """Write columns of equal length; numbers read back bit for bit, None is an empty cell."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([_cell(v) for v in row] for row in zip(*columns.values(), strict=True))


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else literal(value)
