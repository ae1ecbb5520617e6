"""Runs of a scenario with many sets of values under the laws of Table 12, in the processes of `dwmr sweep`."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from dwmr.results.paper_tables import MEASURES, TABLE_12
from dwmr.scenario.file import find, read
from dwmr.sweep.robots import Robots
from fuzzyctl.experiments.sweep_plan import Run
from fuzzyctl.experiments.sweep_run import SweepError, Workers
from fuzzyctl.experiments.sweep_workers import Setup

LAWS = ("aifqsmc", "fcafsmc", "smc")
#: Law, robot and error of one number of Table 12.
Entry = tuple[str, str, str]
ENTRIES: tuple[Entry, ...] = tuple((law, robot, name) for law in LAWS for robot in TABLE_12[law] for name in MEASURES)
#: Arguments of `--set`.
Arguments = Sequence[str]


def rows(
    scenario: str,
    sets: Sequence[Arguments],
    laws: Sequence[str] = LAWS,
    jobs: int | None = None,
    measures: tuple[str, ...] = ("rmse",),
) -> list[dict[str, Mapping[str, Any]]]:
    """Return the measures of each set of values by law, as `dwmr sweep` has them; progress goes to stderr.

    Args:
        scenario: Shipped name or path.
        sets: Values that replace those of the scenario, as arguments of `--set`.
        laws: Control laws.
        jobs: Processes, None for all cores; the result does not depend on it.
        measures: As in a SPEC.

    Raises:
        DiagnosticError: For a value that the scenario does not take.
        SweepError: For a run that cannot be computed.
    """
    path, robots = find(scenario), Robots()
    file = read(path, ())
    used = robots.check(file, laws)
    setup = Setup(robots, tuple((name, one.sha256) for name, one in used.items()), measures)
    runs = [
        Run(k * len(laws) + number, file.name, path, law, k, {}, tuple(arguments), file.sha256)
        for k, arguments in enumerate(sets)
        for number, law in enumerate(laws)
    ]
    result: list[dict[str, Mapping[str, Any]]] = [{} for _ in sets]
    for done, one in enumerate(Workers(jobs).compute(setup, runs), start=1):
        if one.problem:
            raise SweepError(one.problem)
        k, number = divmod(one.number, len(laws))
        result[k][laws[number]] = one.row
        if sys.stderr.isatty():
            print(f"\r{done} of {len(runs)} runs", end="\n" if done == len(runs) else "", file=sys.stderr)
    return result


def ratios(by_law: Mapping[str, Mapping[str, Any]]) -> dict[Entry, float]:
    """Return the errors of some runs over those of Table 12; infinite for a run that stopped early."""
    return {
        (law, robot, name): float("inf") if row["stopped"] else row[f"rmse.{robot}.{MEASURES[name]}"] / wanted
        for law, row in by_law.items()
        for robot, printed in TABLE_12[law].items()
        for name, wanted in printed.items()
    }


def keys(kind: str, **values: float) -> Iterator[str]:
    """Yield arguments that give the disturbances of `paper` of one kind some values."""
    for k in {"sinusoid": (0, 2), "constant": (1, 3), "both": (0, 1, 2, 3)}[kind]:
        yield from (f"disturbances.{k}.{name}={value!r}" for name, value in values.items())
