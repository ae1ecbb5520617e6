"""`fuzzyctl sweep SPEC`: many runs of loops, with values from a grid or drawn at random."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from fuzzyctl.cli.common import DONE, FORMAT, QUIET, answers_with_diagnostics
from fuzzyctl.cli.loading import remark_hidden
from fuzzyctl.cli.streams import say, table_lines, write_json
from fuzzyctl.cli.sweeps import (
    dask_option,
    data_option,
    jobs_option,
    planned,
    require_formats,
    require_one,
    sentence,
    swept,
)
from fuzzyctl.support.files import place_of

if TYPE_CHECKING:
    from fuzzyctl.experiments.estimates import Row
    from fuzzyctl.experiments.sweep_plan import Plan
    from fuzzyctl.experiments.sweep_spec import Spec
    from fuzzyctl.experiments.sweep_workers import Outcome


@click.command()
@click.argument("spec")
@click.option(
    "--set", "overrides", multiple=True, metavar="NAME=VALUE", help="Set a param in all runs: PARAM, or BLOCK.PARAM."
)
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(path_type=Path),
    default=Path("fuzzyctl-sweep"),
    show_default=True,
    metavar="DIR",
    help="Folder for the results.",
)
@data_option(("csv", "parquet"), "csv", "results")
@jobs_option
@dask_option
@click.option("--resume", is_flag=True, help="Go on with a sweep that was interrupted.")
@FORMAT
@QUIET
@answers_with_diagnostics
def sweep(
    spec: str,
    overrides: tuple[str, ...],
    folder: Path,
    formats: tuple[str, ...],
    jobs: int | None,
    cluster: str | None,
    resume: bool,
    form: str,
) -> int:
    """Run loops many times, with values that SPEC, a TOML file or a shipped name, gives or draws.

    \b
    scenario = "water_tank"
    runs = 20
    [grid]
    "law.GU" = [4.0, 8.0, 16.0]
    [random]
    "tank.A" = { uniform = [15.0, 25.0] }

    The folder receives results.csv or results.parquet with one row per run, sweep.json, which says where they come
    from, and times.csv. A sweep that was interrupted or killed goes on with --resume.

    Exit code: 0; 1 for mistakes, or if a run cannot be computed.
    """
    require_one(jobs, cluster)
    require_formats(formats)
    from fuzzyctl.sweep.loop_files import against, read
    from fuzzyctl.sweep.loops import Loops

    place = place_of(spec, ".toml")
    if place.path.exists():
        remark_hidden(spec, place, ".toml")
    file, plan = planned(place.path, read, lambda found: Loops(against(found)), overrides)
    for name in (file.spec.scenario, *getattr(file.spec, "against", ())):
        remark_hidden(name, place_of(name, folder=place.path.parent))
    finished = swept(file, plan, overrides, folder, formats, (jobs, cluster), resume)
    if form == "json":
        write_json(finished.summary)
        return DONE
    say("\n".join([sentence(finished.summary, folder), *text_of(plan, file.spec, finished.outcomes)]))
    return DONE


#: Most rows that are printed; the files hold all.
MOST_ROWS: Final = 40
#: Beginning of the columns that say whether a requirement is met.
REQUIRE: Final = "require "


def text_of(plan: Plan[Any], spec: Spec, outcomes: Mapping[int, Outcome]) -> Iterator[str]:
    """Yield the lines of the table and a remark on its numbers; none if there are too many rows.

    Args:
        plan: The runs.
        spec: The SPEC.
        outcomes: The results, by number.
    """
    groups: dict[tuple[str, ...], list[Row]] = {}
    for run in plan.runs:
        point = (run.controller, *(f"{run.values[key]:.6g}" for key in spec.grid))
        groups.setdefault(point, []).append(outcomes[run.number].row)
    if len(groups) > MOST_ROWS:
        return
    measures = plan.runnable.measures(plan.scenario, [run.controller for run in plan.runs])
    columns = spec.measures or measures
    units = [plan.runnable.unit(plan.scenario, name) for name in (*spec.grid, *columns)]
    judged = any(name.startswith(REQUIRE) for rows in groups.values() for row in rows for name in row)
    table = [["loop", *spec.grid, *columns, *(["met"] if judged else [])], ["", *units, *(["%"] if judged else [])]]
    for point, rows in groups.items():
        cells = [_mean(rows, name) for name in columns]
        table.append([*point, *cells, *([_met(rows)] if judged else [])])
    yield ""
    yield from table_lines(table, ">")
    if any("±" in cell for row in table for cell in row):
        yield "means over the runs with a finite value ± half of their 95 % confidence interval"


def _mean(rows: Sequence[Row], name: str) -> str:
    from fuzzyctl.experiments.estimates import mean_of

    estimate = mean_of(rows, name)
    if estimate.mean is None:
        return "none"
    half = "" if estimate.high is None else f" ± {estimate.high - estimate.mean:.2g}"
    some = "" if estimate.n == len(rows) else f" ({estimate.n} of {len(rows)})"
    return f"{estimate.mean:.5g}{half}{some}"


def _met(rows: Sequence[Row]) -> str:
    """Return the share of runs that meet all requirements."""
    met = [all(value for name, value in row.items() if name.startswith(REQUIRE)) for row in rows]
    return f"{100 * sum(met) / len(met):.0f}"
