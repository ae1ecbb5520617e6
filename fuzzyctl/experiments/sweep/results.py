"""Result files of a sweep: one row for each run as CSV or Parquet, their provenance, and separately the run times."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from fuzzyctl.experiments.results import parquet
from fuzzyctl.experiments.results.columns import Columns, columns_of, write_csv
from fuzzyctl.experiments.results.folder import Results
from fuzzyctl.experiments.sweep.journal import ABOUT
from fuzzyctl.experiments.sweep.plan import Plan, Run
from fuzzyctl.experiments.sweep.worker import Outcome

#: Files that a sweep may leave.
NAMES = ("results.csv", "results.parquet", ABOUT, "times.csv")
FORMATS = ("csv", "parquet")


def table(runs: Sequence[Run], done: Mapping[int, Outcome]) -> Columns:
    """Return the results by column, in the order of the runs; what a run does not have is None."""
    return columns_of([_row(run, done[run.number]) for run in runs])


def _row(run: Run, outcome: Outcome) -> dict[str, Any]:
    head = {"run": run.number, "scenario": run.scenario, "controller": run.controller, "repetition": run.repetition}
    return {**head, **run.values, **outcome.row}


def write(
    files: Results, formats: Iterable[str], plan: Plan[Any], done: Mapping[int, Outcome], about: Mapping[str, Any]
) -> None:
    """Write the results; with the same description they are the same bytes, `times.csv` aside."""
    found = table(plan.runs, done)
    application = plan.runnable.application
    whole = {**about, "columns": {name: {"unit": plan.runnable.unit(plan.scenario, name)} for name in found}}
    files.write_text(ABOUT, json.dumps(whole, indent=2, ensure_ascii=False) + "\n")
    for one in formats:
        if one == "csv":
            files.write("results.csv", lambda path: write_csv(path, found))
        else:
            files.write("results.parquet", lambda path: parquet.write_table(path, found, whole, application))
    times: Columns = {"run": [r.number for r in plan.runs], "wall_s": [done[r.number].wall_s for r in plan.runs]}
    files.write("times.csv", lambda path: write_csv(path, times))
    files.publish()
