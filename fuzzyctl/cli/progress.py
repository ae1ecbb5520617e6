"""Progress of long commands on the terminal: a line, or bars."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from fuzzyctl.diagnostics.terminal import printable

if TYPE_CHECKING:
    from rich.progress import Progress, ProgressColumn

#: Seconds after which it is shown.
PATIENCE: Final = 1.0


@contextmanager
def status_line() -> Iterator[Callable[[str], None] | None]:
    """Give a function that shows how far work is once it has taken a while; None where no terminal shows it."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.status import Status
    from rich.text import Text

    status, begun, started = Status("", console=Console(stderr=True)), time.monotonic(), False

    def report(text: str) -> None:
        nonlocal started
        if time.monotonic() - begun >= PATIENCE:
            status.update(Text(printable(text)), spinner="dots")
            if not started:
                status.start()
                started = True

    try:
        yield report
    finally:
        if started:
            status.stop()


#: Begins a stage of a command by its name and number of steps, 0 where that is unknown; returns a function to call with
#: the number of steps done.
Begin = Callable[[str, int], Callable[[float], None]]


@contextmanager
def progress(remark: str = " (compiling at the first run)", left: bool = False) -> Iterator[Begin]:
    """Offer a function that begins a progress bar and returns how to move it; silent unless on a terminal.

    Args:
        remark: The text after the name of the bar until it first moves.
        left: Whether to show the time that is left besides the time that has passed.
    """
    with _display(left) as display:

        def start(name: str, total: int) -> Callable[[float], None]:
            if display is None:
                return lambda done: None
            task = display.add_task(f"{name}{remark}", total=total)
            return lambda done: display.update(task, completed=done, description=name)

        yield start


@contextmanager
def stages() -> Iterator[Begin]:
    """Offer a function that begins the next stage of a command, in the place of the one before.

    On a terminal one line says which stage it is, how far it is, and how much time has passed and is left; it goes when
    the command has ended. Elsewhere it is silent.
    """
    with _display(left=True) as display:

        def begin(name: str, total: int) -> Callable[[float], None]:
            if display is None:
                return lambda done: None
            for earlier in display.task_ids:
                display.remove_task(earlier)
            task = display.add_task(name, total=total or None)
            return lambda done: display.update(task, completed=done)

        yield begin


@contextmanager
def _display(left: bool) -> Iterator[Progress | None]:
    """Offer a display of progress on standard error, None unless that is a terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        *((_time_left(),) if left else ()),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True, redirect_stdout=False) as display:
        yield display


def _time_left() -> ProgressColumn:
    """Return a column with the time that is left, empty where the number of steps is not known."""
    from rich.progress import Task, TimeRemainingColumn
    from rich.text import Text

    class Left(TimeRemainingColumn):
        def render(self, task: Task) -> Text:
            return Text.assemble(super().render(task), " left") if task.total is not None else Text("")

    return Left()
