"""`fuzzyctl watch`: check, numbers and picture again at every save."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

import click

from fuzzyctl.cli.common import DONE, answers_with_diagnostics
from fuzzyctl.cli.streams import say
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.support.reading import read_place

#: Seconds between two looks at the files.
_INTERVAL: Final = 0.2
#: When a file was written, and its size; None for one that is not there.
_State = dict[Path, tuple[int, int] | None]


@click.command()
@click.argument("file")
@click.argument("values", nargs=-1, metavar="[INPUT=VALUE]...")
@click.option("-o", "--output", "out", metavar="OUT", help="Picture of the surface, or with --loop folder of the run.")
@click.option("--loop", metavar="NAME", help="Run this loop; its measures are the numbers.")
@answers_with_diagnostics
def watch(file: str, values: tuple[str, ...], out: str | None, loop: str | None) -> int:
    """Check a rule file again at every save, and show what comes out.

    \b
    fuzzyctl watch tipper service=7 food=8 -o tip.png
    fuzzyctl watch water_tank --loop fill -o fill

    A save of a file that it uses counts, too. After a file with mistakes the picture is that of the last one without;
    guarantees that do not hold stop no picture. Ctrl-C ends it.
    """
    path = read_place(file)[1].path
    if loop is not None and values:
        raise click.UsageError("values of inputs belong to a system, and '--loop' runs a loop")
    commands = list(_commands(file, values, out, loop))
    try:
        for _ in _saves(path, lambda: time.sleep(_INTERVAL)):
            if sys.stdout.isatty():
                click.clear()
            say(f"{file}, {time.strftime('%H:%M:%S')}")
            for command in commands:
                if _run(command) != DONE and (command[0] != "check" or _is_stopped(path)):
                    break
    except KeyboardInterrupt:
        say("", err=True)
    return DONE


def _commands(file: str, values: tuple[str, ...], out: str | None, loop: str | None) -> Iterator[list[str]]:
    """Yield what is run at a save; each only where the one before found no mistake."""
    yield ["check", file]
    written = ["-o", out] if out is not None else []
    if loop is not None:
        yield ["simulate", file, loop, *written]
        return
    if values:
        yield ["eval", file, *values]
    if written:
        yield ["plot-surface", file, *written]


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
