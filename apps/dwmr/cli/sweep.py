"""`dwmr sweep SPEC`: many runs of a scenario, with values from a grid or drawn at random."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dwmr.cli import formats as data_formats
from dwmr.cli import run_options, worker_options
from dwmr.cli.common import interrupts_wait, mistakes_as_diagnostics, terminated_as_interrupted, warn
from fuzzyctl.cli.streams import say, write_json

if TYPE_CHECKING:
    from dwmr.sweep.journal import Journal
    from dwmr.sweep.plan import Plan
    from dwmr.sweep.spec_file import SpecFile


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
        summary = _sweep(file, plan, overrides, folder, formats, (jobs, cluster), resume)
    if style == "json":
        write_json(summary)
    else:
        say(_sentence(summary, folder))


def _plan(spec: Path, rules_folder: Path | None, overrides: Sequence[str]) -> tuple[SpecFile, Plan]:
    """Read the SPEC, lay out its runs and check them."""
    from dwmr.sweep import plan, spec_file
    from fuzzyctl.experiments.settings.overrides import OverrideError

    if not spec.exists():
        raise click.UsageError(f"no SPEC {str(spec)[:200]!r}: there is no such file")
    file = spec_file.read(spec)
    try:
        with worker_options.checking(plan.count(file)) as report:
            made = plan.make(file, rules_folder, overrides, report)
    except OverrideError as error:
        raise click.UsageError(str(error)) from error
    warn((*made.scenario.warnings, *made.warnings))
    return file, made


def _sweep(
    file: SpecFile,
    plan: Plan,
    overrides: Sequence[str],
    folder: Path,
    formats: Sequence[str],
    who: tuple[int | None, str | None],
    resume: bool,
) -> dict[str, Any]:
    """Compute what is not done yet, write the results, and return what there is to say."""
    from dwmr.sweep import journal, provenance
    from dwmr.sweep.results import NAMES, write
    from dwmr.sweep.worker import Setup
    from fuzzyctl.experiments.results.folder import results

    rests_on = provenance.describe(file, plan, overrides)
    setup = Setup(plan.rules_folder, tuple(sorted(plan.used.items())), file.spec.measures)
    journal.require_own(folder, NAMES)
    with results(folder, NAMES) as files:
        if resume:
            journal.require_something(folder, rests_on)
        with journal.journal(folder, rests_on, resume) as done:
            left = [run for run in plan.runs if run.number not in done.done]
            _compute(setup, left, who, done, len(plan.runs), folder)
            with interrupts_wait():
                write(files, formats, plan.runs, done.done, rests_on)
                journal.remove(folder)
    stopped = [done.done[run.number].row for run in plan.runs if done.done[run.number].row["stopped"]]
    return {
        "runs": len(plan.runs),
        "computed": len(left),
        "stopped": len(stopped),
        "reasons": dict(sorted(_count(str(row["stop_reason"]) for row in stopped).items())),
        "files": [name for name in NAMES if (folder / name).exists()],
    }


def _compute(
    setup: Any, left: Sequence[Any], who: tuple[int | None, str | None], done: Journal, total: int, folder: Path
) -> None:
    if not left:
        return
    try:
        worker_options.collect(worker_options.compute(setup, left, *who), total, total - len(left), done.add)
    except KeyboardInterrupt:
        say(f"interrupted{_kept(done, total, folder)}", err=True)
        sys.exit(1)
    except click.ClickException as error:
        raise click.ClickException(f"{error.message}{_kept(done, total, folder)}") from error


def _kept(done: Journal, total: int, folder: Path) -> str:
    count = len(done.done)
    return f": {count:,} of {total:,} runs are kept in {folder}; go on with --resume" if count else ""


def _count(words: Any) -> dict[str, int]:
    from collections import Counter

    return Counter(words)


def _sentence(summary: dict[str, Any], folder: Path) -> str:
    runs, stopped = summary["runs"], summary["stopped"]
    ends = "all to the end" if not stopped else f"{runs - stopped:,} to the end, {stopped:,} stopped"
    reasons = "".join(f"\n  {count:,} x {reason}" for reason, count in summary["reasons"].items())
    files = ", ".join(summary["files"])
    return f"{runs:,} run{'s' if runs != 1 else ''}, {ends}{reasons}\nresults in {folder}: {files}"
