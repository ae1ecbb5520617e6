"""Computation of a sweep by a command, its options and its messages."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from fuzzyctl.cli.common import show
from fuzzyctl.cli.progress import progress
from fuzzyctl.cli.streams import INTERRUPTED, interrupts_wait, say, terminated_as_interrupted

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
        runnable: Returns the runnable of a SPEC.
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
            with checking(sweep_plan.count(file)) as report:
                plan = sweep_plan.make(runnable(file), file, overrides, report)
        except OverrideError as error:
            raise click.UsageError(str(error)) from error
    show((*plan.scenario.warnings, *plan.warnings))
    return file, plan


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

    about, bar = sweep_journal.describe(file, plan, overrides), computing
    with terminated_as_interrupted(), failures():
        return sweep_run.run(
            plan,
            file.spec.measures,
            about,
            folder,
            formats,
            sweep_run.Workers(*workers),
            resume,
            bar,
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
    """Return the outcome of a sweep in a sentence.

    Args:
        summary: From `run`.
        folder: Of the results.
    """
    runs, stopped = summary["runs"], summary["stopped"]
    ends = "all to the end" if not stopped else f"{runs - stopped:,} to the end, {stopped:,} stopped"
    reasons = "".join(f"\n  {count:,} x {reason}" for reason, count in summary["reasons"].items())
    files = ", ".join(summary["files"])
    return f"{runs:,} run{'s' if runs != 1 else ''}, {ends}{reasons}\nresults in {folder}: {files}"


Command = TypeVar("Command", bound=Callable[..., object])


def jobs_option(command: Command) -> Command:
    """Add --jobs to a command."""
    return click.option(
        "--jobs",
        type=click.IntRange(1, 1000),
        metavar="N",
        show_default="one for each processor",
        help="Processes that compute; the results do not depend on it.",
    )(command)


def dask_option(command: Command) -> Command:
    """Add --dask to a command."""
    return click.option(
        "--dask",
        "cluster",
        metavar="ADDRESS",
        callback=_address,
        help="Compute on a dask cluster: the address of its scheduler, or local:N for N processes here.",
    )(command)


def _address(context: click.Context, option: click.Parameter, address: str | None) -> str | None:
    count = (address or "").removeprefix("local:")
    if address is not None and address != count and not (count.isdecimal() and 1 <= int(count) <= 1000):
        raise click.BadParameter(f"{address!r}: local:N needs a number of processes from 1 to 1000")
    return address


def require_one(jobs: int | None, cluster: str | None) -> None:
    """Refuse both ways of computing at once, and dask where it is not installed."""
    from fuzzyctl.experiments import dask_workers as dask

    if cluster is None:
        return
    if jobs is not None:
        raise click.UsageError("--jobs is for this computer, --dask for a cluster: give one of them")
    if not dask.available():
        raise click.ClickException("--dask needs dask, which is not installed: pip install 'fuzzyctl[cluster]'")


@contextmanager
def computing(total: int) -> Iterator[Callable[[int], None]]:
    """Offer a function that shows how many runs are done."""
    with progress(left=True) as start:
        yield start(f"{total:,} runs", total)


@contextmanager
def checking(total: int) -> Iterator[Callable[[int], None]]:
    """Offer a function that shows how many runs are checked."""
    with progress("") as start:
        yield start("checking", total)


def data_option(formats: Sequence[str], default: str, what: str) -> Callable[[Command], Command]:
    """Add --data to a command: names of formats, separated by commas, which it gets once each."""

    def names(context: click.Context, option: click.Parameter, value: str) -> tuple[str, ...]:
        parts = [part.strip() for part in value.split(",")]
        for name in parts:
            if name not in formats:
                raise click.BadParameter(f"{name!r} is not one of {', '.join(formats)}.")
        return tuple(name for name in formats if name in parts)

    return click.option(
        "--data",
        "formats",
        default=default,
        callback=names,
        metavar="FORMATS",
        help=f"Formats of the {what}, separated by commas: {', '.join(formats)}.",
    )


def require_formats(formats: Sequence[str]) -> None:
    """Refuse Parquet where it cannot be written.

    Raises:
        click.ClickException: Naming what to install.
    """
    if "parquet" not in formats:
        return
    from fuzzyctl.experiments import parquet

    if not parquet.available():
        raise click.ClickException("Parquet needs pyarrow, which is not installed: pip install 'fuzzyctl[data]'")
