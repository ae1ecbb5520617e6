"""Options of commands that compute many runs, --jobs and --dask, and their progress."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

import click

from fuzzyctl.cli.bars import progress

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
