"""Comparison of controllers over repeated runs: the mean of each measure with a confidence interval."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fuzzyctl.experiments.intervals import mean_interval, share_interval
from fuzzyctl.experiments.sweep.plan import Run
from fuzzyctl.experiments.sweep.worker import Outcome

Row = Mapping[str, Any]


@dataclass(frozen=True)
class Estimate:
    """Mean of a measure over runs.

    Args:
        n: Runs it was taken from.
        mean: None where no run has the measure.
        low, high: Confidence interval, None for a single run.
    """

    n: int
    mean: float | None
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class Entry:
    """One measure under one controller.

    Args:
        scenario, controller: Where it is measured.
        measure: Column of the results.
        unit: Of the mean, "-" for none.
        estimate: Over the runs that came to their end.
        stopped: Runs that stopped before their end.
    """

    scenario: str
    controller: str
    measure: str
    unit: str
    estimate: Estimate
    stopped: int


def mean_of(rows: Sequence[Row], column: str) -> Estimate:
    """Return the mean of a measure over the runs that came to their end and have it."""
    found = [row.get(column) for row in rows if not row["stopped"]]
    values = [value for value in found if value is not None and math.isfinite(value)]
    mean = math.fsum(values) / len(values) if values else None
    return Estimate(len(values), mean, *(mean_interval(values) or ()))


def share_of(rows: Sequence[Row], column: str) -> Estimate:
    """Return the share of all runs in which a count is not zero."""
    n, hits = len(rows), sum(row[column] > 0 for row in rows)
    return Estimate(n, hits / n, *(share_interval(hits, n) or ()))


def grouped(runs: Sequence[Run], done: Mapping[int, Outcome]) -> dict[tuple[str, str], list[Row]]:
    """Return the rows of the runs by scenario and controller."""
    groups: dict[tuple[str, str], list[Row]] = {}
    for run in runs:
        groups.setdefault((run.scenario, run.controller), []).append(done[run.number].row)
    return groups


def stopped(rows: Sequence[Row]) -> int:
    """Return how many runs stopped before their end."""
    return sum(bool(row["stopped"]) for row in rows)


def entries(
    runs: Sequence[Run], done: Mapping[int, Outcome], measures: Sequence[str], unit: Callable[[str], str]
) -> Iterator[Entry]:
    """Yield each measure under each controller in each scenario.

    Args:
        runs: Of one or several plans, see `joined`.
        done: Their outcomes by number.
        measures: Columns of the results.
        unit: Returns the unit of a column.
    """
    for (scenario, controller), rows in grouped(runs, done).items():
        for measure in measures:
            yield Entry(scenario, controller, measure, unit(measure) or "-", mean_of(rows, measure), stopped(rows))
