"""Comparison of control laws: its runs, and the mean of each measure with a confidence interval."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dwmr.scenario import file
from dwmr.sweep import plan, spec_file
from dwmr.sweep.plan import Plan, Run
from dwmr.sweep.results import unit
from dwmr.sweep.spec import Measure
from dwmr.sweep.spec_file import SpecFile
from dwmr.sweep.variables import has
from dwmr.sweep.worker import Outcome
from fuzzyctl.experiments.intervals import mean_interval, share_interval

#: What varies unless one says otherwise.
VARIATION = Path(__file__).with_name("variation.toml")
#: Groups of measures that are compared.
GROUPS: tuple[Measure, ...] = (
    "rmse", "centre_distance", "obstacle_gap", "robot_gap", "obstacles_hit", "robots_hit", "chattering"
)  # fmt: skip
#: Measures of a robot, as columns of the results have them with the robot's name in place of the star.
MEASURES = (
    "rmse.*.x_e", "rmse.*.y_e", "rmse.*.theta_e", "chattering.*.v", "chattering.*.omega",
    "centre_distance.*", "obstacle_gap.*", "robot_gap.*",
)  # fmt: skip
#: Measures that are shares of runs.
HITS = ("obstacles_hit.*", "robots_hit.*")


@dataclass(frozen=True)
class Entry:
    """One measure of one robot under one control law.

    Args:
        scenario, controller, robot: Where it is measured.
        measure: Without the robot's name, such as rmse.x_e; obstacles_hit and robots_hit are the shares of runs in
            which its body touched an obstacle or another robot's body.
        unit: Of the mean.
        n: Runs it was taken from: those that came to their end, for contacts all.
        mean: None where no run came to its end, or the scenario has no obstacles.
        low, high: Confidence interval, None for a single run.
        stopped: Runs that stopped before their end.
    """

    scenario: str
    controller: str
    robot: str
    measure: str
    unit: str
    n: int
    mean: float | None
    low: float | None
    high: float | None
    stopped: int


def variation(path: Path | None) -> SpecFile:
    """Return the SPEC whose `[set]` and `[random]` say what varies.

    Raises:
        DiagnosticError: With its mistakes; a grid has no place in a comparison.
    """
    return spec_file.read(path or VARIATION)


def make(
    varied: SpecFile,
    scenario: Path,
    laws: Sequence[str],
    runs: int,
    seed: int,
    rules_folder: Path | None,
    overrides: Sequence[str],
    report: Callable[[int], None] | None = None,
) -> Plan:
    """Lay out the runs of one scenario; a single run is the scenario as it is.

    Raises:
        DiagnosticError: With the mistakes of the first runs that have any.
    """
    random = dict(varied.spec.random) if runs > 1 else {}
    if varied.path == VARIATION:
        base = file.read(scenario, overrides).scenario
        random = {key: one for key, one in random.items() if has(base, key)}
    spec = varied.spec.model_copy(
        update={
            "scenario": str(scenario.resolve()), "controllers": tuple(laws), "runs": runs, "seed": seed,
            "random": random, "measures": GROUPS, "grid": {},
        }
    )  # fmt: skip
    return plan.make(dataclasses.replace(varied, spec=spec), rules_folder, overrides, report)


def joined(plans: Sequence[Plan]) -> list[Run]:
    """Return the runs of several scenarios, numbered through."""
    runs = [run for one in plans for run in one.runs]
    return [dataclasses.replace(run, number=number) for number, run in enumerate(runs)]


def entries(runs: Sequence[Run], done: Mapping[int, Outcome]) -> Iterator[Entry]:
    """Yield every measure of every robot under every control law in every scenario."""
    groups: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for run in runs:
        groups.setdefault((run.scenario, run.controller), []).append(done[run.number].row)
    for (scenario, controller), rows in groups.items():
        for robot in _robots(rows[0]):
            for measure in (*MEASURES, *HITS):
                yield _entry(scenario, controller, robot, measure, rows)


def _robots(row: Mapping[str, Any]) -> list[str]:
    prefix = HITS[0].removesuffix("*")
    return [name.removeprefix(prefix) for name in row if name.startswith(prefix)]


def _entry(scenario: str, controller: str, robot: str, measure: str, rows: Sequence[Mapping[str, Any]]) -> Entry:
    column, stopped = measure.replace("*", robot), sum(bool(row["stopped"]) for row in rows)
    if measure in HITS:
        n, hits = len(rows), sum(row[column] > 0 for row in rows)
        mean, interval = hits / n, share_interval(hits, n)
    else:
        found = [row[column] for row in rows if not row["stopped"]]
        values = [value for value in found if value is not None and math.isfinite(value)]
        n, mean, interval = len(values), math.fsum(values) / len(values) if values else None, mean_interval(values)
    low, high = interval or (None, None)
    name = measure.replace(".*", "")
    return Entry(scenario, controller, robot, name, unit(column) or "-", n, mean, low, high, stopped)
