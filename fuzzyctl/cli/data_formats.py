"""Option --data: lists of file formats, and a check that their optional packages are installed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., object])


def data_option(known: Sequence[str], default: str, what: str) -> Callable[[Command], Command]:
    """Add --data to a command: names of formats, separated by commas, which it gets once each."""

    def names(context: click.Context, option: click.Parameter, value: str) -> tuple[str, ...]:
        given = [part.strip() for part in value.split(",")]
        for name in given:
            if name not in known:
                raise click.BadParameter(f"{name!r} is not one of {', '.join(known)}.")
        return tuple(name for name in known if name in given)

    return click.option(
        "--data",
        "formats",
        default=default,
        callback=names,
        metavar="FORMATS",
        help=f"Formats of the {what}, separated by commas: {', '.join(known)}.",
    )


def require(formats: Sequence[str]) -> None:
    """Refuse Parquet where it cannot be written.

    Raises:
        click.ClickException: Naming what to install.
    """
    if "parquet" not in formats:
        return
    from fuzzyctl.experiments import parquet

    if not parquet.available():
        raise click.ClickException("Parquet needs pyarrow, which is not installed: pip install 'fuzzyctl[data]'")
