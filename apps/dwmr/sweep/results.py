"""Result files of a sweep: one row for each run as CSV or Parquet, their provenance, and separately the run times."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from dwmr.sweep.journal import ABOUT
from dwmr.sweep.plan import Run
from dwmr.sweep.worker import Outcome
from fuzzyctl.experiments.results.columns import Columns, columns_of, write_csv
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


def table(runs: Sequence[Run], done: Mapping[int, Outcome]) -> Columns:
    """Return the results by column, in the order of the runs; what a run does not have is None."""
    return columns_of([_row(run, done[run.number]) for run in runs])


def _row(run: Run, outcome: Outcome) -> dict[str, Any]:
    head = {"run": run.number, "scenario": run.scenario, "controller": run.controller, "repetition": run.repetition}
    return {**head, **run.values, **outcome.row}


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
    files.write_text(ABOUT, json.dumps(whole, indent=2, ensure_ascii=False) + "\n")
    for one in formats:
        if one == "csv":
            files.write("results.csv", lambda path: write_csv(path, found))
        else:
            from dwmr.output.data import parquet_file

            files.write("results.parquet", lambda path: parquet_file.write_table(path, found, whole))
    times: Columns = {"run": [r.number for r in runs], "wall_s": [done[r.number].wall_s for r in runs]}
    files.write("times.csv", lambda path: write_csv(path, times))
    files.publish()
