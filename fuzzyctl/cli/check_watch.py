"""`fuzzyctl check --watch`: check, numbers and picture again at every save."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Final

import click

from fuzzyctl.cli.common import DONE
from fuzzyctl.cli.streams import say
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.support.reading import read_place

#: Seconds between two looks at the files.
_INTERVAL: Final = 0.2
#: When a file was written, and its size; None for one that is not there.
_State = dict[Path, tuple[int, int] | None]


def watch(file: str, values: Sequence[str], out: str | None, name: str | None) -> int:
    """Check a rule file again at every save, and show what comes out, until Ctrl-C.

    Args:
        file: The file; a save of a file that it uses counts, too.
        values: `INPUT=VALUE` of a point to evaluate.
        out: The picture of the surface, or the folder of the run of a loop.
        name: The block; a loop is run.
    """
    path = read_place(file)[1].path
    try:
        for _ in _saves(path, lambda: time.sleep(_INTERVAL)):
            if sys.stdout.isatty():
                click.clear()
            say(f"{file}, {time.strftime('%H:%M:%S')}")
            for command in _commands(file, path, values, out, name):
                if _run(command) != DONE and (command[0] != "check" or _is_stopped(path)):
                    break
    except KeyboardInterrupt:
        say("", err=True)
    return DONE


def _commands(file: str, path: Path, values: Sequence[str], out: str | None, name: str | None) -> Iterator[list[str]]:
    """Yield the commands of a save; each runs only if the one before found no mistake."""
    from fuzzyctl.loading.examination import look_through
    from fuzzyctl.support.reading import read_source

    yield ["check", file]
    chosen, written = ([option, text] if text is not None else [] for option, text in (("--block", name), ("-o", out)))
    loops = look_through(read_source(path), folder=path.parent, loop=name).loops if chosen else ()
    if name in [loop.name for loop in loops]:
        if values:
            raise click.UsageError(f"values of inputs belong to a system, and '{name}' is a loop")
        yield ["simulate", file, *chosen, *written]
        return
    if values:
        yield ["eval", file, *values, *chosen]
    if written:
        yield ["plot-surface", file, *chosen, *written]


def _is_stopped(path: Path) -> bool:
    """Return whether a file has mistakes besides guarantees that do not hold."""
    from fuzzyctl.analysis.check import check_source
    from fuzzyctl.support.reading import read_source

    try:
        return any(d.stops for d in check_source(read_source(path), folder=path.parent)[1])
    except DiagnosticError:
        return True


def _run(words: list[str]) -> int:
    """Run a command of this program and return its exit code."""
    from fuzzyctl.cli.main import main

    try:
        main.main(args=words, prog_name="fuzzyctl", standalone_mode=False)
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else 1
    except click.ClickException as error:
        error.show()
        return error.exit_code
    return DONE


def _saves(path: Path, wait: Callable[[], object]) -> Iterator[None]:
    """Yield once at first, and then whenever a file or one that it brings in has changed."""
    seen: _State | None = None
    while True:
        now = _state(path)
        if now != seen:
            seen = now
            yield
        else:
            wait()


def _state(path: Path) -> _State:
    """Return when each of the files was written."""
    from fuzzyctl.loading.assembly import files_read

    try:
        used = files_read(path)
    except DiagnosticError:
        used = ()
    return {p: _written(p) for p in (path, *used)}


def _written(path: Path) -> tuple[int, int] | None:
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size
