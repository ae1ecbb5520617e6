"""Clocks of the time limits of proofs and of commands."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

#: Seconds from some moment on; tests set a clock that other processes do not move.
now: Callable[[], float] = time.monotonic
#: Processor seconds of this process, which a busy machine does not use up.
used: Callable[[], float] = time.process_time

_until: ContextVar[float] = ContextVar("until", default=math.inf)


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """End the searches of a block after some processor seconds, whatever work is left."""
    token = _until.set(min(_until.get(), used() + seconds))
    try:
        yield
    finally:
        _until.reset(token)


def is_over(more: float = 0.0) -> bool:
    """Return whether the limit is reached within some more seconds; without a limit no clock is read."""
    until = _until.get()
    return until < math.inf and used() + more > until
