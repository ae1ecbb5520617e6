"""`fuzzyctl sweep SPEC`: many runs of loops, with values from a grid or drawn at random."""

from __future__ import annotations

from pathlib import Path

import click

from fuzzyctl.cli import data_formats, worker_options
from fuzzyctl.cli.common import DONE, FORMAT, QUIET, answers_with_diagnostics
from fuzzyctl.cli.loading import remark_hidden
from fuzzyctl.cli.streams import say, write_json
from fuzzyctl.cli.sweeps import planned, sentence, swept
from fuzzyctl.support.shipped import place_of


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
@data_formats.data_option(("csv", "parquet"), "csv", "results")
@worker_options.jobs_option
@worker_options.dask_option
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

    The folder receives results.csv or results.parquet with one row a run, sweep.json, which says where they come from,
    and times.csv. A sweep that was interrupted or killed goes on with --resume.

    Exit code: 0; 1 for mistakes, or where a run cannot be computed.
    """
    worker_options.require_one(jobs, cluster)
    data_formats.require(formats)
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
    from fuzzyctl.cli.sweep_tables import text_of

    say("\n".join([sentence(finished.summary, folder), *text_of(plan, file.spec, finished.outcomes)]))
    return DONE
