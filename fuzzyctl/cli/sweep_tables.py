"""Table of a sweep over loops: a row for each loop at each point of the grid, means over the repetitions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.experiments.estimates import Row, mean_of

if TYPE_CHECKING:
    from fuzzyctl.experiments.sweep_plan import Plan
    from fuzzyctl.experiments.sweep_spec import Spec
    from fuzzyctl.experiments.sweep_workers import Outcome

#: Most rows that are printed; the files hold all.
MOST_ROWS: Final = 40
#: Beginning of the columns that say whether a requirement is met.
REQUIRE: Final = "require "


def text_of(plan: Plan[Any], spec: Spec, outcomes: Mapping[int, Outcome]) -> Iterator[str]:
    """Yield the lines of the table, and what its numbers are; nothing where there would be too many rows.

    Args:
        plan: The runs.
        spec: What varied.
        outcomes: What came out, by number.
    """
    groups: dict[tuple[str, ...], list[Row]] = {}
    for run in plan.runs:
        point = (run.controller, *(f"{run.values[key]:.6g}" for key in spec.grid))
        groups.setdefault(point, []).append(outcomes[run.number].row)
    if len(groups) > MOST_ROWS:
        return
    measures = plan.runnable.measures(plan.scenario, [run.controller for run in plan.runs])
    shown = spec.measures or measures
    units = [plan.runnable.unit(plan.scenario, name) for name in (*spec.grid, *shown)]
    judged = any(name.startswith(REQUIRE) for rows in groups.values() for row in rows for name in row)
    table = [["loop", *spec.grid, *shown, *(["met"] if judged else [])], ["", *units, *(["%"] if judged else [])]]
    for point, rows in groups.items():
        cells = [_mean(rows, name) for name in shown]
        table.append([*point, *cells, *([_met(rows)] if judged else [])])
    widths = [max(len(row[k]) for row in table) for k in range(len(table[0]))]
    yield ""
    for row in table:
        yield "  ".join([row[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True))])
    if any("±" in cell for row in table for cell in row):
        yield "means over the runs with a finite value ± half of their 95 % confidence interval"


def _mean(rows: Sequence[Row], name: str) -> str:
    found = mean_of(rows, name)
    if found.mean is None:
        return "none"
    half = "" if found.high is None else f" ± {found.high - found.mean:.2g}"
    some = "" if found.n == len(rows) else f" ({found.n} of {len(rows)})"
    return f"{found.mean:.5g}{half}{some}"


def _met(rows: Sequence[Row]) -> str:
    """Return the share of runs that meet all requirements."""
    met = [all(value for name, value in row.items() if name.startswith(REQUIRE)) for row in rows]
    return f"{100 * sum(met) / len(met):.0f}"
