"""Computation of a sweep by a command, and what the command says of it."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from fuzzyctl.cli.streams import say


@contextmanager
def failures() -> Iterator[None]:
    """Print why a sweep cannot go on, in one line, and leave with status 1."""
    from fuzzyctl.experiments.sweep.run import InterruptedSweepError
    from fuzzyctl.experiments.sweep.worker import SweepError

    try:
        yield
    except InterruptedSweepError as error:
        say(str(error), err=True)
        sys.exit(1)
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
