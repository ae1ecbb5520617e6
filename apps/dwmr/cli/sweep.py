"""`dwmr sweep SPEC`: many runs of a scenario, with values from a grid or drawn at random."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dwmr.cli import run_options
from dwmr.cli.common import mistakes_as_diagnostics, warn
from fuzzyctl.cli import data_formats, worker_options
from fuzzyctl.cli.interruptions import interrupts_wait, terminated_as_interrupted
from fuzzyctl.cli.streams import say, write_json
from fuzzyctl.cli.sweeps import failures, sentence

if TYPE_CHECKING:
    from dwmr.scenario.file import ScenarioFile
    from fuzzyctl.experiments.sweep.plan import Plan
    from fuzzyctl.experiments.sweep.spec_file import SpecFile


@click.command(context_settings={"show_default": True})
@click.argument("spec", type=click.Path(path_type=Path))
@run_options.rules_option
@run_options.set_option
@run_options.output_option("folder", "dwmr-sweep", "DIR", "Folder for the results.")
@data_formats.data_option(("csv", "parquet"), "csv", "results")
@worker_options.jobs_option
@worker_options.dask_option
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

    The folder receives results.csv or results.parquet with one row a run, sweep.json, which says where they come from,
    and times.csv. A sweep that was interrupted or killed goes on with --resume.
    """
    worker_options.require_one(jobs, cluster)
    data_formats.require(formats)
    with mistakes_as_diagnostics(style), terminated_as_interrupted():
        file, plan = _plan(spec, rules_folder, overrides)
        from fuzzyctl.experiments.sweep import provenance, run

        about, workers = provenance.describe(file, plan, overrides), run.Workers(jobs, cluster)
        shown, measures = worker_options.computing, file.spec.measures
        with failures():
            summary = run.run(plan, measures, about, folder, formats, workers, resume, shown, interrupts_wait)
    if style == "json":
        write_json(summary)
    else:
        say(sentence(summary, folder))


def _plan(spec: Path, rules_folder: Path | None, overrides: Sequence[str]) -> tuple[SpecFile, Plan[ScenarioFile]]:
    """Read the SPEC, lay out its runs and check them."""
    from dwmr.sweep import plan
    from dwmr.sweep.spec import read
    from fuzzyctl.experiments.settings.overrides import OverrideError
    from fuzzyctl.experiments.sweep.plan import count

    if not spec.exists():
        raise click.UsageError(f"no SPEC {str(spec)[:200]!r}: there is no such file")
    file = read(spec)
    try:
        with worker_options.checking(count(file)) as report:
            made = plan.make(file, rules_folder, overrides, report)
    except OverrideError as error:
        raise click.UsageError(str(error)) from error
    warn((*made.scenario.warnings, *made.warnings))
    return file, made
