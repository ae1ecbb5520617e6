"""Tables of a comparison on the terminal: two for each scenario, with a row for each control law and robot."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from dwmr.output.report import ABOUT_FILTER
from dwmr.results.metrics import TABLES
from dwmr.sweep.comparison import Entry
from fuzzyctl.experiments.estimates import CONFIDENCE

#: Columns by title of the table: heads by measure.
_TABLES = {
    "RMSE and chattering": {
        "rmse.x_e": "x_e\nm", "rmse.y_e": "y_e\nm", "rmse.theta_e": "θ_e\nrad",
        "chattering.v": "|dv_c|\nm/s²", "chattering.omega": "|dω_c|\nrad/s²",
    },
    "least distances and collisions": {
        "centre_distance": "centre\nm", "obstacle_gap": "obstacle\ngap m", "robot_gap": "robot\ngap m",
        "obstacles_hit": "obstacles\nhit, %", "robots_hit": "robots\nhit, %",
    },
    "safety filter": {
        "safety.disc_gap": "disc\ngap m", "safety.acts": "changed\n%", "safety.infeasible": "infeasible\nmoments",
        "safety.missed": "missed\nmoments",
    },
}  # fmt: skip
_ABOUT = (
    "centre: least distance of the reference point from an obstacle's centre. gap: least distance of the body from an "
    "obstacle and from another robot's body, negative where they overlap. hit: share of runs in which it touched one."
)


#: Columns of the ratios to a table of the paper, and how near to 1 they are counted.
_RATIOS = {"ratio.x_e": "x_e\n", "ratio.y_e": "y_e\n", "ratio.theta_e": "θ_e\n"}
_NEAR = 0.10


def print_comparison(
    out: Console, found: Sequence[Entry], runs: int, printed: Mapping[str, int | None] | None = None
) -> None:
    """Print the tables, what the intervals are, and which runs stopped.

    Args:
        out: Where to.
        found: The measures.
        runs: Repetitions of each run.
        printed: Number of the paper's table that a scenario stands beside, by the scenario's name.
    """
    for scenario in dict.fromkeys(one.scenario for one in found):
        own = [one for one in found if one.scenario == scenario]
        for title, heads in _TABLES.items():
            if not any(one.measure in heads for one in own):
                continue
            out.print(f"{escape(scenario)}: {title}", style="bold", highlight=False)
            out.print(_table(own, heads))
            out.print()
        if number := (printed or {}).get(scenario):
            _print_ratios(out, scenario, list(_ratios(own, number)), number)
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
    for one in found:
        group, _, name = one.measure.partition(".")
        wanted = TABLES[number].get(one.controller, {}).get(one.robot, {}).get(name) if group == "rmse" else None
        if wanted is not None and one.mean is not None:
            yield dataclasses.replace(one, measure=f"ratio.{name}", mean=one.mean / wanted, low=None, high=None)


def _print_ratios(out: Console, scenario: str, found: Sequence[Entry], number: int) -> None:
    if not found:
        return
    out.print(f"{escape(scenario)}: RMSE over those of Table {number} of the paper", style="bold", highlight=False)
    out.print(_table(found, _RATIOS))
    for law in dict.fromkeys(one.controller for one in found):
        values = [one.mean for one in found if one.controller == law and one.mean is not None]
        near = sum(abs(value - 1.0) <= _NEAR for value in values)
        span = f"{min(values):.2f} to {max(values):.2f}"
        out.print(f"{law}: {near} of {len(values)} within {_NEAR:.0%}, {span}", style="dim", highlight=False)
    out.print()


def _table(found: Sequence[Entry], heads: Mapping[str, str]) -> Table:
    table = Table(header_style="bold dim", box=None, pad_edge=False, collapse_padding=True)
    table.add_column("\nlaw")
    table.add_column("\nrobot")
    for head in heads.values():
        table.add_column(head, justify="right")
    for law in dict.fromkeys(one.controller for one in found):
        robots = tuple(dict.fromkeys(one.robot for one in found if one.controller == law))
        for k, robot in enumerate(robots):
            cells = {one.measure: one for one in found if (one.controller, one.robot) == (law, robot)}
            name = _name(law, k, len(robots))
            table.add_row(
                escape(name), escape(robot), *(_cell(cells[measure]) if measure in cells else "" for measure in heads)
            )
    return table


def _name(law: str, row: int, rows: int) -> str:
    """Return what stands beside one of a law's rows: its name, that of an ablation word by word down the rows."""
    words = law.split("_") if "_without_" in law else [law]
    return "\n".join(words[row:]) if row == rows - 1 else "".join(words[row : row + 1])


def _cell(one: Entry) -> str:
    if one.mean is None:
        return ""
    if one.measure in ("obstacles_hit", "robots_hit"):
        interval = "" if one.low is None or one.high is None else f"\n{100 * one.low:.0f} to {100 * one.high:.0f}"
        return f"{100 * one.mean:.0f}{interval}"
    if one.measure == "safety.acts":
        return f"{100 * one.mean:.1f}" + ("" if one.high is None else f"\n±{100 * (one.high - one.mean):.2g}")
    if one.measure in _RATIOS:
        return f"{one.mean:.2f}"
    return f"{one.mean:.4g}" + ("" if one.high is None else f"\n±{one.high - one.mean:.2g}")
