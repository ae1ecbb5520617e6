"""Comparison of control laws: its runs, and the mean of each measure with a confidence interval."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dwmr.scenario import file
from dwmr.scenario.file import ScenarioFile
from dwmr.sweep import plan, spec
from dwmr.sweep.columns import unit
from dwmr.sweep.spec import Measure
from fuzzyctl.experiments.estimates import grouped, mean_of, share_of
from fuzzyctl.experiments.estimates import stopped as count_of_stopped
from fuzzyctl.experiments.sweep_plan import Plan, Run
from fuzzyctl.experiments.sweep_spec import SpecFile
from fuzzyctl.experiments.sweep_variables import has
from fuzzyctl.experiments.sweep_workers import Outcome

#: What varies unless one says otherwise.
VARIATION = Path(__file__).with_name("variation.toml")
#: Groups of measures that are compared.
GROUPS: tuple[Measure, ...] = (
    "rmse", "centre_distance", "obstacle_gap", "robot_gap", "obstacles_hit", "robots_hit", "chattering", "safety",
)  # fmt: skip
#: Measures of a robot, as columns of the results have them with the robot's name in place of the star.
MEASURES = (
    "rmse.*.x_e",
    "rmse.*.y_e",
    "rmse.*.theta_e",
    "chattering.*.v",
    "chattering.*.omega",
    "centre_distance.*",
    "obstacle_gap.*",
    "robot_gap.*",
)
#: Those that only a run behind the safety filter has.
FILTER = ("safety.disc_gap.*", "safety.acts.*", "safety.infeasible.*", "safety.missed.*")  # fmt: skip
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
    return spec.read(path or VARIATION)


def make(
    varied: SpecFile,
    scenario: Path,
    laws: Sequence[str],
    runs: int,
    seed: int,
    rules_folder: Path | None,
    overrides: Sequence[str],
    report: Callable[[int], None] | None = None,
) -> Plan[ScenarioFile]:
    """Lay out the runs of one scenario; a single run is the scenario as it is.

    Raises:
        DiagnosticError: With the mistakes of the first runs that have any.
    """
    random = dict(varied.spec.random) if runs > 1 else {}
    if varied.path == VARIATION:
        base = file.read(scenario, overrides).scenario
        random = {key: one for key, one in random.items() if has(base, key)}
    changed = varied.spec.model_copy(
        update={
            "scenario": str(scenario.resolve()), "controllers": tuple(laws), "runs": runs, "seed": seed,
            "random": random, "measures": GROUPS, "grid": {},
        }
    )  # fmt: skip
    return plan.make(dataclasses.replace(varied, spec=changed), rules_folder, overrides, report)


def entries(runs: Sequence[Run], done: Mapping[int, Outcome]) -> Iterator[Entry]:
    """Yield every measure of every robot under every control law in every scenario."""
    for (scenario, controller), rows in grouped(runs, done).items():
        for robot in _robots(rows[0]):
            guarded = FILTER if FILTER[0].replace("*", robot) in rows[0] else ()
            for measure in (*MEASURES, *HITS, *guarded):
                yield _entry(scenario, controller, robot, measure, rows)


def _robots(row: Mapping[str, Any]) -> list[str]:
    prefix = HITS[0].removesuffix("*")
    return [name.removeprefix(prefix) for name in row if name.startswith(prefix)]


def _entry(scenario: str, controller: str, robot: str, measure: str, rows: Sequence[Mapping[str, Any]]) -> Entry:
    column, name = measure.replace("*", robot), measure.replace(".*", "")
    found = (share_of if measure in HITS else mean_of)(rows, column)
    stopped = count_of_stopped(rows)
    return Entry(
        scenario, controller, robot, name, unit(column) or "-", found.n, found.mean, found.low, found.high, stopped
    )
