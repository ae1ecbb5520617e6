"""Result files of a sweep: one row for each run as CSV or Parquet, their provenance, and separately the run times."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from dwmr.sweep.journal import ABOUT
from dwmr.sweep.plan import Run
from dwmr.sweep.variables import literal
from dwmr.sweep.worker import Outcome
from fuzzyctl.experiments.results.folder import Results

#: Files that a sweep may leave.
NAMES = ("results.csv", "results.parquet", ABOUT, "times.csv")
FORMATS = ("csv", "parquet")

#: Units of what is kept of a run, by the last part of its column, and of its first part where that has one for all.
_UNITS = {
    "t_end": "s", "x_e": "m", "y_e": "m", "theta_e": "rad", "theta_e_star": "rad", "theta_e_unwrapped": "rad",
}  # fmt: skip
_GROUP_UNITS = {
    "centre_distance": "m", "obstacle_gap": "m", "robot_gap": "m", "avoidance_s": "s", "g_ais_min": "m/s, rad/s",
}  # fmt: skip
_CHATTERING = {"v": "m/s²", "omega": "rad/s²"}

Table = dict[str, list[Any]]


def table(runs: Sequence[Run], done: Mapping[int, Outcome]) -> Table:
    """Return the results by column, in the order of the runs; what a run does not have is None."""
    rows = [_row(run, done[run.number]) for run in runs]
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: _uniform([row.get(name) for row in rows]) for name in names}


def _row(run: Run, outcome: Outcome) -> dict[str, Any]:
    head = {"run": run.number, "scenario": run.scenario, "controller": run.controller, "repetition": run.repetition}
    return {**head, **run.values, **outcome.row}


def _uniform(values: list[Any]) -> list[Any]:
    """Give a column one type: numbers with a fraction make all of them such, other mixtures become text."""
    kinds = {type(v) for v in values if v is not None}
    if kinds == {int, float}:
        return [None if v is None else float(v) for v in values]
    if len(kinds) > 1 or kinds & {list, tuple, dict}:
        return [None if v is None else literal(v) for v in values]
    return values


def unit(column: str) -> str:
    """Return the unit of a column, or nothing for what has none or is a value of the scenario."""
    group, last = column.partition(".")[0], column.rpartition(".")[2]
    if group == "chattering":
        return _CHATTERING.get(last, "")
    if group in _GROUP_UNITS:
        return _GROUP_UNITS[group]
    return _UNITS.get(last, "") if group.startswith("rmse") or column == "t_end" else ""


def write(
    files: Results, formats: Iterable[str], runs: Sequence[Run], done: Mapping[int, Outcome], about: Mapping[str, Any]
) -> None:
    """Write the results; with the same description they are the same bytes, `times.csv` aside."""
    found = table(runs, done)
    whole = {**about, "columns": {name: {"unit": unit(name)} for name in found}}
    files.write(ABOUT, lambda path: _write_json(path, whole))
    for one in formats:
        if one == "csv":
            files.write("results.csv", lambda path: write_csv(path, found))
        else:
            from dwmr.output.data import parquet_file

            files.write("results.parquet", lambda path: parquet_file.write_table(path, found, whole))
    times: Table = {"run": [r.number for r in runs], "wall_s": [done[r.number].wall_s for r in runs]}
    files.write("times.csv", lambda path: write_csv(path, times))
    files.publish()


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


def _write_json(path: Path, data: Any) -> None:
    path.write_text(json.dumps(data, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
