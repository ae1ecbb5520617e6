"""Interruptions of long commands by Ctrl-C and SIGTERM."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import click

from fuzzyctl.cli.streams import OUTLIVED, say


@contextmanager
def interrupts_wait() -> Iterator[None]:
    """Let Ctrl-C wait while results are written, which takes a second or two; the command exits with `INTERRUPTED`."""
    asked: list[int] = []
    before = {}
    for number in (signal.SIGINT, signal.SIGTERM):
        with suppress(ValueError):  # signals belong to the main thread
            before[number] = signal.signal(number, lambda n, _: asked.append(n))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if asked:
            say("interrupted while the results were written; they are whole", err=True)
            outlive()


def outlive() -> None:
    """Let the command finish its output after an interruption, and then exit with `INTERRUPTED`."""
    context = click.get_current_context(silent=True)
    if context is not None:
        context.meta[OUTLIVED] = True


@contextmanager
def terminated_as_interrupted() -> Iterator[None]:
    """Take SIGTERM for Ctrl-C, so that it keeps what is done."""
    before = None
    with suppress(ValueError):
        before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        if before is not None:
            signal.signal(signal.SIGTERM, before)
