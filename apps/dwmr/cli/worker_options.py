"""Options of commands that compute many runs, --jobs and --dask, and the choice of workers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeVar

import click

from dwmr.cli.common import progress
from fuzzyctl.support.cores import cores

if TYPE_CHECKING:
    from dwmr.sweep.plan import Run
    from dwmr.sweep.worker import Outcome, Setup

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
    from dwmr.sweep import cluster as dask

    if cluster is None:
        return
    if jobs is not None:
        raise click.UsageError("--jobs is for this computer, --dask for a cluster: give one of them")
    if not dask.available():
        raise click.ClickException("--dask needs dask, which is not installed: pip install 'fuzzyctl[cluster]'")


def compute(setup: Setup, runs: Sequence[Run], jobs: int | None, cluster: str | None) -> Iterator[Outcome]:
    """Yield the outcomes of runs as they come, from processes here or from a cluster."""
    from dwmr.sweep import cluster as dask
    from dwmr.sweep import pool

    if cluster is not None:
        return dask.compute(setup, runs, cluster)
    return pool.compute(setup, runs, min(jobs or cores(), max(1, len(runs))))


def collect(outcomes: Iterable[Outcome], total: int, ready: int, keep: Callable[[Outcome], None]) -> None:
    """Take in outcomes, with a progress display on a terminal.

    Args:
        outcomes: As they come.
        total: Runs there are.
        ready: Runs done before.
        keep: Called with each outcome.

    Raises:
        click.ClickException: When runs cannot be computed; what is kept stays.
    """
    from dwmr.sweep.cluster import ClusterError
    from dwmr.sweep.pool import WorkerLostError

    try:
        with progress(" (compiling at the first run)", left=True) as start:
            move = start(f"{total:,} runs", total)
            for one in outcomes:
                if one.problem:
                    raise click.ClickException(one.problem)
                keep(one)
                ready += 1
                move(ready)
    except (ClusterError, WorkerLostError) as error:
        raise click.ClickException(str(error)) from error


@contextmanager
def checking(total: int) -> Iterator[Callable[[int], None]]:
    """Offer a function that shows how many runs are checked."""
    with progress("") as start:
        yield start("checking", total)
