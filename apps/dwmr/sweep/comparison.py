"""Comparison of control laws: its runs, and the mean of each measure with a confidence interval."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from dwmr.output.report import ABOUT_FILTER, table_by_law
from dwmr.results.paper_tables import MEASURES as PRINTED
from dwmr.results.paper_tables import TABLES, near
from dwmr.scenario import file
from dwmr.scenario.file import ScenarioFile
from dwmr.sweep.robots import Measure, Robots, read_spec, unit_of
from fuzzyctl.experiments import sweep_plan
from fuzzyctl.experiments.estimates import CONFIDENCE, grouped, mean_of, share_of
from fuzzyctl.experiments.estimates import stopped as count_of_stopped
from fuzzyctl.experiments.sweep_plan import Plan, Run
from fuzzyctl.experiments.sweep_spec import SpecFile
from fuzzyctl.experiments.sweep_variables import has
from fuzzyctl.experiments.sweep_workers import Outcome

#: Default variation.
VARIATION = Path(__file__).with_name("variation.toml")
#: Groups of measures that are compared.
GROUPS: tuple[Measure, ...] = (
    "rmse", "centre_distance", "obstacle_gap", "robot_gap", "obstacles_hit", "robots_hit", "arrival", "chattering",
    "safety",
)  # fmt: skip
#: Measures of a robot, as columns of the results have them with the robot's name in place of the star.
MEASURES = (
    "rmse.*.x_e",
    "rmse.*.y_e",
    "rmse.*.theta_e",
    "rmse.*.theta_e_unwrapped",
    "chattering.*.v",
    "chattering.*.omega",
    "centre_distance.*",
    "obstacle_gap.*",
    "robot_gap.*",
    "arrival.*.t",
)
#: Those that only a run behind the safety filter has.
FILTER = ("safety.disc_gap.*", "safety.acts.*", "safety.infeasible.*", "safety.missed.*")  # fmt: skip
#: Measures that are shares of runs.
SHARES = ("obstacles_hit.*", "robots_hit.*", "arrival.*.reached")


@dataclass(frozen=True)
class Entry:
    """One measure of one robot under one control law.

    Args:
        scenario, controller, robot: Where it is measured.
        measure: Without the robot's name, such as rmse.x_e; obstacles_hit, robots_hit and
            arrival.reached are the shares of runs in which its body touched an obstacle or another robot's body, and in
            which it was at its place at the end; arrival.t is the mean of those.
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
    """Return the SPEC whose `[set]` and `[random]` vary the runs.

    Raises:
        DiagnosticError: With its mistakes; a grid has no place in a comparison.
    """
    return read_spec(path or VARIATION)


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
    return sweep_plan.make(Robots(rules_folder), dataclasses.replace(varied, spec=changed), overrides, report)


def entries(runs: Sequence[Run], done: Mapping[int, Outcome]) -> Iterator[Entry]:
    """Yield every measure of every robot under every control law in every scenario."""
    for (scenario, controller), rows in grouped(runs, done).items():
        for robot in _robots(rows[0]):
            guarded = FILTER if FILTER[0].replace("*", robot) in rows[0] else ()
            for measure in (*MEASURES, *SHARES, *guarded):
                yield _entry(scenario, controller, robot, measure, rows)


def _robots(row: Mapping[str, Any]) -> list[str]:
    prefix = SHARES[0].removesuffix("*")
    return [name.removeprefix(prefix) for name in row if name.startswith(prefix)]


def _entry(scenario: str, controller: str, robot: str, measure: str, rows: Sequence[Mapping[str, Any]]) -> Entry:
    column, name = measure.replace("*", robot), measure.replace(".*", "")
    estimate = (share_of if measure in SHARES else mean_of)(rows, column)
    numbers = (estimate.n, estimate.mean, estimate.low, estimate.high)
    return Entry(scenario, controller, robot, name, unit_of(column) or "-", *numbers, count_of_stopped(rows))


#: Columns by title of the table: heads by measure.
_TABLES = {
    "RMSE and chattering": {
        "rmse.x_e": "x_e\nm", "rmse.y_e": "y_e\nm", "rmse.theta_e": "θ_e\nrad",
        "chattering.v": "|dv_c|\nm/s²", "chattering.omega": "|dω_c|\nrad/s²",
    },
    "least distances, collisions and arrivals": {
        "centre_distance": "centre\nm", "obstacle_gap": "obstacle\ngap m", "robot_gap": "robot\ngap m",
        "obstacles_hit": "obstacles\nhit, %", "robots_hit": "robots\nhit, %", "arrival.reached": "arrive\n%",
        "arrival.t": "at\ns",
    },
    "safety filter": {
        "safety.disc_gap": "disc\ngap m", "safety.acts": "changed\n%", "safety.infeasible": "infeasible\nmoments",
        "safety.missed": "missed\nmoments",
    },
}  # fmt: skip
_ABOUT = (
    "centre: least distance of the reference point from an obstacle's centre. gap: least distance of the body from an "
    "obstacle and from another robot's body, negative where they overlap. hit: share of runs in which it touched one. "
    "arrive: share of runs in which it is at its place at the end, and the mean time since when."
)
#: Measures shown in percent with an interval.
_SHARES = tuple(one.replace(".*", "") for one in SHARES)


#: Columns of the ratios to a table of the paper.
_RATIOS = {"ratio.x_e": "x_e\n", "ratio.y_e": "y_e\n", "ratio.theta_e": "θ_e\n"}


def print_comparison(
    out: Console, found: Sequence[Entry], runs: int, printed: Mapping[str, int | None] | None = None
) -> None:
    """Print the tables, a legend of the intervals, and the stopped runs.

    Args:
        out: Where to.
        found: The measures.
        runs: Repetitions of each run.
        printed: Number of the paper's table beside a scenario, by the scenario's name.
    """
    for scenario in dict.fromkeys(one.scenario for one in found):
        entries = [one for one in found if one.scenario == scenario]
        for title, heads in _TABLES.items():
            if not any(one.measure in heads for one in entries):
                continue
            out.print(f"{escape(scenario)}: {title}", style="bold", highlight=False)
            out.print(_table(entries, heads))
            out.print()
        if number := (printed or {}).get(scenario):
            _print_ratios(out, scenario, list(_ratios(entries, number)), number)
    out.print(_ABOUT, style="dim", highlight=False)
    if any(one.measure.startswith("safety.") for one in found):
        out.print(ABOUT_FILTER, style="dim", highlight=False)
    if runs > 1:
        sure = f"{100 * CONFIDENCE:.0f} %"
        out.print(
            f"{runs} runs each. Below means ± half of the {sure} confidence interval, by Student's t;", highlight=False
        )
        out.print(f"below shares of runs their {sure} confidence interval, by Wilson.", highlight=False)
    for (scenario, law), count in {(one.scenario, one.controller): one.stopped for one in found}.items():
        if count:
            text = f"warning: {scenario}, {law}: {count} of {runs} stopped; they count among those that hit only"
            out.print(escape(text), highlight=False)


def _ratios(found: Sequence[Entry], number: int) -> Iterator[Entry]:
    """Yield the root mean square errors over those of a table of the paper, for the laws and robots that it has."""
    names = {f"rmse.{measure}": name for name, measure in PRINTED.items()}
    for one in found:
        name = names.get(one.measure, "")
        wanted = TABLES[number].get(one.controller, {}).get(one.robot, {}).get(name)
        if wanted is not None and one.mean is not None:
            yield dataclasses.replace(one, measure=f"ratio.{name}", mean=one.mean / wanted, low=None, high=None)


def _print_ratios(out: Console, scenario: str, found: Sequence[Entry], number: int) -> None:
    if not found:
        return
    out.print(f"{escape(scenario)}: RMSE over those of Table {number} of the paper", style="bold", highlight=False)
    out.print(_table(found, _RATIOS))
    laws = tuple(dict.fromkeys(one.controller for one in found))
    for group in dict.fromkeys([*((law,) for law in laws), laws]):
        values = [one.mean for one in found if one.controller in group and one.mean is not None]
        out.print(f"{', '.join(group)}: {near(values, number)}", style="dim", highlight=False)
    out.print()


def _table(found: Sequence[Entry], heads: Mapping[str, str]) -> Table:
    rows: dict[str, dict[str, list[str]]] = {}
    for one in found:
        cells = rows.setdefault(one.controller, {}).setdefault(one.robot, [""] * len(heads))
        if one.measure in heads:
            cells[list(heads).index(one.measure)] = _cell(one)
    return table_by_law(heads.values(), rows)


def _cell(one: Entry) -> str:
    if one.mean is None:
        return ""
    if one.measure in _SHARES:
        interval = "" if one.low is None or one.high is None else f"\n{100 * one.low:.0f} to {100 * one.high:.0f}"
        return f"{100 * one.mean:.0f}{interval}"
    if one.measure == "safety.acts":
        return f"{100 * one.mean:.1f}" + ("" if one.high is None else f"\n±{100 * (one.high - one.mean):.2g}")
    if one.measure in _RATIOS:
        return f"{one.mean:.2f}"
    return f"{one.mean:.4g}" + ("" if one.high is None else f"\n±{one.high - one.mean:.2g}")
