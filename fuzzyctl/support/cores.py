"""Number of usable cores: CPU affinity, limited by the control group's share of time; processes without Ctrl-C.

A container that is given two cores of a large machine sees all of them, and more threads than two would only stop each
other.
"""

from __future__ import annotations

import math
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path, PurePosixPath
from typing import Final

#: Where Linux shows control groups, and the group of this process.
_GROUPS: Final = Path("/sys/fs/cgroup")
_OWN: Final = Path("/proc/self/cgroup")


def cores() -> int:
    """Return the number of cores that this process may use."""
    bound = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(min(bound, _granted()), 1)


@cache
def _granted() -> int:
    return granted(_GROUPS, _OWN)


def granted(groups: Path, own: Path) -> int:
    """Return how many cores' time control groups grant, rounded up; a great many where they set no limit.

    Args:
        groups: The folder of the groups of both versions.
        own: The file with the groups of a process.
    """
    try:
        lines = own.read_text(encoding="utf-8", errors="surrogateescape").splitlines()
    except OSError:
        return 1 << 20  # no Linux, or none that shows them
    shares = [share for line in lines for folder in _folders(groups, line) for share in _shares(folder)]
    return math.ceil(min(shares, default=1 << 20))


def _folders(groups: Path, line: str) -> Iterator[Path]:
    """Yield the folders of a group and of those that it is in; in a container, up to its group."""
    _, controllers, path = (*line.split(":", 2), "", "")[:3]
    if controllers not in ("", "cpu", "cpu,cpuacct", "cpuacct,cpu"):
        return
    root = groups / controllers if controllers else groups
    place = PurePosixPath(path.lstrip("/"))
    if ".." not in place.parts:
        yield root / place
        for parent in place.parents:
            yield root / parent


def _shares(folder: Path) -> Iterator[float]:
    """Yield the share of a group, as a number of cores, if it has one."""
    limits = _words(folder / "cpu.max")  # version 1 has a file for each of the two
    match limits or _words(folder / "cpu.cfs_quota_us") + _words(folder / "cpu.cfs_period_us"):
        case [quota, period] if quota.isdecimal() and period.isdecimal() and int(period):
            yield int(quota) / int(period)


def _words(file: Path) -> list[str]:
    try:
        return file.read_text(encoding="ascii").split()
    except (OSError, UnicodeDecodeError):
        return []


@contextmanager
def interrupts_blocked() -> Iterator[None]:
    """Start processes that never get Ctrl-C, not even while they import; this process gets it afterwards.

    Windows has no signal masks: there a process gets Ctrl-C until it ignores it.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
