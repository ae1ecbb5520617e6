"""Tables of a comparison on the terminal: two for each scenario, with a row for each control law and robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from dwmr.sweep.comparison import Entry
from fuzzyctl.experiments.intervals import CONFIDENCE

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
}  # fmt: skip
_ABOUT = (
    "centre: least distance of the reference point from an obstacle's centre. gap: least distance of the body from an "
    "obstacle and from another robot's body, negative where they overlap. hit: share of runs in which it touched one."
)


def print_comparison(out: Console, found: Sequence[Entry], runs: int) -> None:
    """Print the tables, what the intervals are, and which runs stopped."""
    for scenario in dict.fromkeys(one.scenario for one in found):
        for title, heads in _TABLES.items():
            out.print(f"{escape(scenario)}: {title}", style="bold", highlight=False)
            out.print(_table([one for one in found if one.scenario == scenario], heads))
            out.print()
    out.print(_ABOUT, style="dim", highlight=False)
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
            table.add_row(escape(name), escape(robot), *(_cell(cells[measure]) for measure in heads))
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
    return f"{one.mean:.4g}" + ("" if one.high is None else f"\n±{one.high - one.mean:.2g}")
