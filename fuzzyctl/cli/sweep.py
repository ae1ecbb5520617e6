"""`fuzzyctl sweep SPEC`: many runs of loops, with values from a grid or drawn at random."""

from __future__ import annotations

import math
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
    from fuzzyctl.experiments.sweep_plan import Run as SweepRun
    from fuzzyctl.experiments.sweep_spec import Spec, SpecFile
    from fuzzyctl.experiments.sweep_workers import Outcome


@click.command()
@click.argument("spec")
@click.option(
    "--set", "overrides", multiple=True, metavar="NAME=VALUE", help="Set a param in all runs: PARAM, or BLOCK.PARAM."
)
@click.option(
    "--for",
    "members",
    type=click.IntRange(1, 1_000_000),
    metavar="N",
    help="Run N members of the family of the loops, corners first; SPEC may be their rule file.",
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
    members: int | None,
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
    from fuzzyctl.sweep.loop_files import against, read, spec_of_family, with_members
    from fuzzyctl.sweep.loops import Loops

    place, suffix = place_of(spec, ".toml"), ".toml"
    if members is not None and (place.path.suffix == ".fz" or not place.path.exists()):
        place, suffix = place_of(spec), ".fz"
    if place.path.exists():
        remark_hidden(spec, place, suffix)

    def chosen(path: Path) -> SpecFile:
        if members is None:
            return read(path)
        return spec_of_family(path, members) if suffix == ".fz" else with_members(read(path), members)

    file, plan = planned(place.path, chosen, lambda found: Loops(against(found)), overrides)
    for name in (file.spec.scenario, *getattr(file.spec, "against", ())):
        remark_hidden(name, place_of(name, folder=place.path.parent))
    finished = swept(file, plan, overrides, folder, formats, (jobs, cluster), resume)
    if form == "json":
        more = {"worst": list(worst(plan, file.spec, finished.outcomes))} if file.spec.draws > 1 else {}
        write_json(finished.summary | more)
        return DONE
    lines = [sentence(finished.summary, folder), *text_of(plan, file.spec, finished.outcomes)]
    say("\n".join([*lines, *_worst_text(plan, file.spec, finished.outcomes)]))
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


def worst(plan: Plan[Any], spec: Spec, outcomes: Mapping[int, Outcome]) -> Iterator[dict[str, Any]]:
    """Yield the worst run of each measure, the first stopped one, the first that breaks each claim.

    The smallest value of a measure is the worst if a claim asks for a large one, else the largest; no value is worse.

    Args:
        plan: The runs.
        spec: The SPEC.
        outcomes: The results, by number.
    """
    from fuzzyctl.simulation.members import STOPPED

    for label in dict.fromkeys(run.controller for run in plan.runs):
        runs = [run for run in plan.runs if run.controller == label]
        rows = {run.number: outcomes[run.number].row for run in runs}
        for name in spec.measures or plan.runnable.measures(plan.scenario, [label]):
            sign = -1.0 if plan.runnable.is_better_large(plan.scenario, label, name) else 1.0
            values = {n: math.inf if row[name] is None else sign * row[name] for n, row in rows.items() if name in row}
            if values:
                run = max(runs, key=lambda r: values.get(r.number, -math.inf))
                yield {"loop": label, "measure": name, "value": rows[run.number][name], **_replay(run, plan)}
        stopped = [run for run in runs if rows[run.number].get("stopped")]
        ended = [run for run in runs if not rows[run.number].get("stopped")]
        if stopped:
            yield {"loop": label, "claim": STOPPED, "broken_by": len(stopped), **_replay(stopped[0], plan)}
        for claim in (name for name in rows[runs[0].number] if name.startswith(REQUIRE)):
            broken = [run for run in ended if not rows[run.number][claim]]
            if broken:
                yield {"loop": label, "claim": claim, "broken_by": len(broken), **_replay(broken[0], plan)}


def _replay(run: SweepRun, plan: Plan[Any]) -> dict[str, Any]:
    """Return the number of a run, and the options of `fuzzyctl simulate` that run it; noise is drawn as in the file."""
    values = (text for text in run.overrides if text.partition("=")[0] != plan.runnable.seed)
    return {"run": run.number, "replay": " ".join(f"--set {text}" for text in values)}


def _worst_text(plan: Plan[Any], spec: Spec, outcomes: Mapping[int, Outcome]) -> Iterator[str]:
    from fuzzyctl.simulation.members import STOPPED

    if spec.draws == 1:
        return
    several = len({run.controller for run in plan.runs}) > 1
    yield ""
    for one in worst(plan, spec, outcomes):
        head = f"{one['loop']}: " if several else ""
        if "measure" in one:
            unit = plan.runnable.unit(plan.scenario, one["measure"])
            value = "none" if one["value"] is None else f"{one['value']:.5g} {unit}".rstrip()
            yield f"{head}worst {one['measure']}: {value}  run {one['run']}: {one['replay']}"
        else:
            count = sum(run.controller == one["loop"] for run in plan.runs)
            first = f"first by run {one['run']}: {one['replay']}"
            how = "" if one["claim"] == STOPPED else "broken by "
            yield f"{head}{one['claim']}: {how}{one['broken_by']} of {count}, {first}"
