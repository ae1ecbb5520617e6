"""Means of measures under controllers over repeated runs, with confidence intervals."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fuzzyctl.experiments.sweep_plan import Run
from fuzzyctl.experiments.sweep_workers import Outcome

#: Share of such intervals that hold the true value.
CONFIDENCE = 0.95


def mean_interval(values: Sequence[float]) -> tuple[float, float] | None:
    """Return the confidence interval of a mean by Student's t; a single value has none.

    The values are taken for independent; the interval holds for the mean of many of them whatever their distribution,
    for that of a few when they are about normal.

    Args:
        values: One per run.

    Source:
        Student, The probable error of a mean, Biometrika 6, 1908: mean ± t(n − 1) s/√n.
    """
    n = len(values)
    if n < 2:
        return None
    from scipy import special  # a second to load, and a mistake on the command line is answered without it

    mean = math.fsum(values) / n
    deviation = math.sqrt(math.fsum((v - mean) ** 2 for v in values) / (n - 1))
    half = float(special.stdtrit(n - 1, 0.5 + 0.5 * CONFIDENCE)) * deviation / math.sqrt(n)
    return mean - half, mean + half


def share_interval(hits: int, n: int) -> tuple[float, float] | None:
    """Return the confidence interval of a probability that was seen as `hits` of `n` runs; a single run has none.

    Unlike mean ± z s/√n it has a width when nothing was hit, or everything.

    Source:
        Wilson, Probable inference, the law of succession, and statistical inference, JASA 22, 1927.
    """
    if n < 2:
        return None
    from scipy import special

    z = float(special.ndtri(0.5 + 0.5 * CONFIDENCE))
    share, spread = hits / n, z * z / n
    middle = (share + 0.5 * spread) / (1.0 + spread)
    half = z / (1.0 + spread) * math.sqrt(share * (1.0 - share) / n + 0.25 * spread / n)
    return max(0.0, middle - half), min(1.0, middle + half)


#: Resamples of a bootstrap.
RESAMPLES = 2000


def bootstrap_interval(values: Sequence[float], seed: int) -> tuple[float, float]:
    """Return the percentile interval of a mean over `RESAMPLES` seeded resamples.

    Source:
        Efron, Bootstrap methods: another look at the jackknife, Annals of Statistics 7, 1979.
    """
    import numpy as np

    picks = np.random.default_rng(seed).integers(len(values), size=(RESAMPLES, len(values)))
    means = np.sort(np.asarray(values)[picks].mean(axis=1))
    outside = round(0.5 * (1.0 - CONFIDENCE) * RESAMPLES)
    return float(means[outside]), float(means[-1 - outside])


Row = Mapping[str, Any]


@dataclass(frozen=True)
class Estimate:
    """Mean of a measure over runs.

    Args:
        n: Runs it was taken from.
        mean: None if no run has the measure.
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
    column_values = [row.get(column) for row in rows if not row["stopped"]]
    values = [value for value in column_values if value is not None and math.isfinite(value)]
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
