"""Clock of the time limits of proofs."""

from __future__ import annotations

import time
from collections.abc import Callable

#: Seconds from some moment on; tests set a clock that other processes do not move.
now: Callable[[], float] = time.monotonic
