"""Progress line on the terminal."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

from fuzzyctl.diagnostics.terminal import printable

#: Seconds after which it is shown.
PATIENCE: Final = 1.0


@contextmanager
def progress() -> Iterator[Callable[[str], None] | None]:
    """Give a function that shows how far work is once it has taken a while; None where no terminal shows it."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.status import Status
    from rich.text import Text

    status, begun, shown = Status("", console=Console(stderr=True)), time.monotonic(), False

    def report(text: str) -> None:
        nonlocal shown
        if time.monotonic() - begun >= PATIENCE:
            status.update(Text(printable(text)), spinner="dots")
            if not shown:
                status.start()
                shown = True

    try:
        yield report
    finally:
        if shown:
            status.stop()
