"""`dwmr sweep SPEC`: many runs of a scenario, with values from a grid or drawn at random."""

from __future__ import annotations

from pathlib import Path

import click

from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics
from fuzzyctl.cli.streams import say, write_json
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


@click.command(context_settings={"show_default": True})
@click.argument("spec", type=click.Path(path_type=Path))
@run_options.rules_option
@run_options.set_option
@run_options.output_option("folder", "dwmr-sweep", "DIR", "Folder for the results.")
@data_option(("csv", "parquet"), "csv", "results")
@jobs_option
@dask_option
@click.option("--resume", is_flag=True, help="Go on with a sweep that was interrupted.")
@run_options.format_option
def sweep(
    spec: Path,
    rules_folder: Path | None,
    overrides: tuple[str, ...],
    folder: Path,
    formats: tuple[str, ...],
    jobs: int | None,
    cluster: str | None,
    resume: bool,
    style: str,
) -> None:
    """Run a scenario many times, with the values that SPEC, a TOML file, gives or draws.

    \b
    scenario = "paper"
    runs = 3
    [set]
    "run.horizon" = 5.0
    [random]
    "robots.*.x_0" = { normal = [0.0, 0.2], relative = "offset" }

    `scenario` is a file beside the SPEC, or a shipped name: 'dwmr show' lists these.

    The folder receives results.csv or results.parquet with one row a run, sweep.json, which says where they come from,
    and times.csv. A sweep that was interrupted or killed goes on with --resume.
    """
    require_one(jobs, cluster)
    require_formats(formats)
    with mistakes_as_diagnostics(style):
        from dwmr.sweep.robots import Robots
        from dwmr.sweep.spec import read

        file, plan = planned(spec, read, lambda _: Robots(rules_folder), overrides)
        summary = swept(file, plan, overrides, folder, formats, (jobs, cluster), resume).summary
    if style == "json":
        write_json(summary)
    else:
        say(sentence(summary, folder))
