"""Computation of a sweep by a command, and what the command says of it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fuzzyctl.cli import worker_options
from fuzzyctl.cli.common import show
from fuzzyctl.cli.interruptions import interrupts_wait, terminated_as_interrupted
from fuzzyctl.cli.streams import INTERRUPTED, say

if TYPE_CHECKING:
    from fuzzyctl.experiments.runnable import Runnable
    from fuzzyctl.experiments.sweep_plan import Plan
    from fuzzyctl.experiments.sweep_run import Finished
    from fuzzyctl.experiments.sweep_spec import SpecFile


def planned(
    spec: Path,
    read: Callable[[Path], SpecFile],
    runnable: Callable[[SpecFile], Runnable[Any]],
    overrides: Sequence[str],
) -> tuple[SpecFile, Plan[Any]]:
    """Read a SPEC, lay out its runs and check them; warnings are printed.

    Args:
        spec: The file.
        read: Reads it.
        runnable: Returns what it runs.
        overrides: Values for all runs, as `--set` has them.

    Raises:
        DiagnosticError: With the mistakes in the SPEC, or of the first runs that have any.
    """
    from fuzzyctl.experiments import sweep_plan
    from fuzzyctl.experiments.scenario_keys import OverrideError

    if not spec.exists():
        raise click.UsageError(f"no SPEC {str(spec)[:200]!r}: there is no such file")
    with terminated_as_interrupted():
        file = read(spec)
        try:
            with worker_options.checking(sweep_plan.count(file)) as report:
                made = sweep_plan.make(runnable(file), file, overrides, report)
        except OverrideError as error:
            raise click.UsageError(str(error)) from error
    show((*made.scenario.warnings, *made.warnings))
    return file, made


def swept(
    file: SpecFile,
    plan: Plan[Any],
    overrides: Sequence[str],
    folder: Path,
    formats: Sequence[str],
    workers: tuple[int | None, str | None],
    resume: bool,
) -> Finished:
    """Compute a sweep and write its results; leaves with status 1 where it cannot go on.

    Args:
        file: The SPEC.
        plan: Its runs.
        overrides: Values for all runs.
        folder: Of the results.
        formats: Of the results.
        workers: Number of processes, or the address of a dask cluster.
        resume: Whether to go on with a sweep that was interrupted.

    Raises:
        DiagnosticError: When the results cannot be written, or belong to another sweep.
    """
    from fuzzyctl.experiments import sweep_journal, sweep_run

    about, shown = sweep_journal.describe(file, plan, overrides), worker_options.computing
    with terminated_as_interrupted(), failures():
        return sweep_run.run(
            plan,
            file.spec.measures,
            about,
            folder,
            formats,
            sweep_run.Workers(*workers),
            resume,
            shown,
            interrupts_wait,
        )


@contextmanager
def failures() -> Iterator[None]:
    """Print why a sweep cannot go on, in one line, and leave with status 1, or `INTERRUPTED`."""
    from fuzzyctl.experiments.sweep_run import InterruptedSweepError
    from fuzzyctl.experiments.sweep_workers import SweepError

    try:
        yield
    except InterruptedSweepError as error:
        say(str(error), err=True)
        sys.exit(INTERRUPTED)
    except SweepError as error:
        raise click.ClickException(str(error)) from error


def sentence(summary: Mapping[str, Any], folder: Path) -> str:
    """Return what became of a sweep.

    Args:
        summary: From `run`.
        folder: Of the results.
    """
    runs, stopped = summary["runs"], summary["stopped"]
    ends = "all to the end" if not stopped else f"{runs - stopped:,} to the end, {stopped:,} stopped"
    reasons = "".join(f"\n  {count:,} x {reason}" for reason, count in summary["reasons"].items())
    files = ", ".join(summary["files"])
    return f"{runs:,} run{'s' if runs != 1 else ''}, {ends}{reasons}\nresults in {folder}: {files}"
