"""Tables of a calibration: the values, and the ratios to Table 12 before and after."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.table import Table

from dwmr.calibration.cost import ENTRIES
from dwmr.calibration.parameters import PARAMETERS
from dwmr.calibration.search import Found
from dwmr.results.metrics import TABLE_12


def as_data(found: Found) -> dict[str, Any]:
    """Return what was found as plain data."""
    entries = []
    for k, (law, robot, name) in enumerate(ENTRIES):
        around = [outcome.ratios[k] for outcome in (found.outcome, *found.neighbours)]
        entries.append(
            {
                "law": law,
                "robot": robot,
                "error": name,
                "table_12": TABLE_12[law][robot][name],
                "before": found.start.ratios[k],
                "ratio": found.outcome.ratios[k],
                "least": min(around),
                "greatest": max(around),
            }
        )
    costs = [outcome.cost for outcome in found.neighbours]
    return {
        "parameters": {
            name: {"before": found.start_values[name], "value": value, "unit": PARAMETERS[name].unit}
            for name, value in found.values.items()
        },
        "cost": {
            "before": found.start.cost,
            "value": found.outcome.cost,
            "of_neighbours": [min(costs), max(costs)] if costs else None,
        },
        "entries": entries,
        "evaluations": found.evaluations,
        "interrupted": found.interrupted,
    }


def show(out: Console, data: Mapping[str, Any]) -> None:
    """Print what was found."""
    values = _table("Values", "parameter", "unit", "from", "to", "before", "now")
    for name, one in data["parameters"].items():
        bounds = (f"{PARAMETERS[name].low:g}", f"{PARAMETERS[name].high:g}")
        values.add_row(name, one["unit"], *bounds, f"{one['before']:.3f}", f"{one['value']:.3f}")
    out.print(values)
    out.print()
    ratios = _table("Errors over Table 12; least and greatest with one value changed by 5 %", "law", "robot", "error")
    for title in ("Table 12", "before", "now", "least", "greatest"):
        ratios.add_column(title, justify="right")
    for k, one in enumerate(data["entries"]):
        numbers = (f"{one[name]:.2f}" for name in ("before", "ratio", "least", "greatest"))
        ratios.add_row(
            one["law"], one["robot"], one["error"], f"{one['table_12']:.4f}", *numbers, end_section=k % 9 == 8
        )
    out.print(ratios)
    cost = data["cost"]
    out.print(f"cost {cost['before']:.2f} before, {cost['value']:.2f} now", highlight=False)


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", header_style="bold dim", box=None)
    for column in columns:
        table.add_column(column)
    return table
