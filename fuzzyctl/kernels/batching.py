"""Many points: in blocks that need no memory to speak of, on all cores where that pays."""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import cache
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from fuzzyctl.errors import ArgumentError
from fuzzyctl.kernels.arguments import float_array, writable

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]
    #: Writes the results of some points: (points (n, inputs), states (n, states) or None, results (n, outputs)).
    Fill = Callable[[FloatArray, FloatArray | None, FloatArray], None]

#: Points that are converted at a time where an array is not as compiled code takes it.
BLOCK: Final = 8192
#: With fewer points waking a thread, and waiting for one whose core is busy, costs more than it saves.
ENOUGH: Final = 100_000
#: Points of the smallest share that a thread takes at a time: few enough that none waits long for the last one.
LEAST: Final = 1 << 13


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def run(fill: Fill, points: Any, states: FloatArray | None, results: FloatArray, *, parallel: bool) -> None:
    """Fill the results block by block.

    Args:
        fill: Computes a block.
        points: n points, shape (..., inputs), of any type of numbers and any layout.
        states: Shape (n, states), perhaps one row repeated; None without a state.
        results: Shape (n, outputs), contiguous.
        parallel: Whether several threads may share the work.
    """
    count = len(results)

    ready = is_plain(points) and points.flags.writeable and states is None

    def work(first: int, last: int) -> None:
        step = last - first if ready else BLOCK
        for start in range(first, last, max(step, 1)):
            part = slice(start, min(start + step, last))
            block = points[part] if ready else writable(float_array(listed(points, part.start, part.stop), "points"))
            fill(block, None if states is None else writable(states[part]), results[part])

    workers = min(cores(), 2 * count // ENOUGH) if parallel and count >= ENOUGH else 1
    if workers == 1:
        work(0, count)
    else:
        _share(work, count, workers)


def is_plain(array: npt.NDArray[Any]) -> bool:
    """Return whether compiled code can read an array as it is."""
    return array.ndim == 2 and array.dtype == np.float64 and array.flags.c_contiguous and array.flags.aligned


def listed(points: npt.NDArray[Any], first: int, last: int) -> npt.NDArray[Any]:
    """Return the points from one index to before another of an array of shape (..., inputs), in the order of indices.

    They are copied where the array does not hold them as a list, and no others.
    """
    if points.ndim == 2:
        return points[first:last]
    if points.ndim == 1:
        return points[np.newaxis, :][first:last]
    inner = max(math.prod(points.shape[1:-1]), 1)
    begin, end = -(-first // inner), last // inner
    if begin > end:  # all within one
        return listed(points[end], first - end * inner, last - end * inner)
    parts = [points[begin:end].reshape(-1, points.shape[-1])]
    if first < begin * inner:
        parts.insert(0, listed(points[begin - 1], first - (begin - 1) * inner, inner))
    if last > end * inner:
        parts.append(listed(points[end], 0, last - end * inner))
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _share(work: Callable[[int, int], None], count: int, workers: int) -> None:
    """Let several threads, this one among them, take one share after the other.

    A core that is busy with something else takes fewer shares, so that the others need not wait for it.
    """
    left = deque(_shares(count, workers))
    failed: list[tuple[int, Exception]] = []

    def take() -> None:
        while not failed:
            try:
                first, last = left.popleft()
            except IndexError:  # another thread took the last one
                return
            try:
                work(first, last)
            except Exception as error:  # noqa: BLE001 - raised below, in the thread of the caller
                failed.append((first, error))

    helping: list[Future[None]] = []
    try:
        for _ in range(workers - 1):
            helping.append(_pool(os.getpid()).submit(take))
    except RuntimeError:  # no thread can be begun: the interpreter is about to end, or there are too many
        pass
    try:
        take()
    finally:  # whatever interrupts this thread, nobody writes to the results any more once it is gone
        left.clear()
        wait([help for help in helping if not help.cancel()])
    if failed:  # shares are taken in order, so that the first point that fails is among these
        raise min(failed, key=lambda f: f[0])[1]


def _shares(count: int, workers: int) -> Iterator[tuple[int, int]]:
    """Yield what to take at a time: half of what is left, shared out, until that is little."""
    first = 0
    while first < count:
        last = min(first + max((count - first) // (2 * workers), LEAST), count)
        yield first, last
        first = last


@cache
def _pool(_process: int) -> ThreadPoolExecutor:
    """Return the threads that help, one pool for each process, since a fork copies none."""
    return ThreadPoolExecutor(max(cores() - 1, 1), thread_name_prefix="fuzzyctl")


def results_for(out: Any, shape: tuple[int, ...], *read: FloatArray | None) -> FloatArray:
    """Return the array to write to: a new one, or the caller's.

    Args:
        out: The caller's, None for a new one.
        shape: What it must be.
        read: Arrays that are read while it is written.

    Raises:
        ArgumentError: For an array of another shape or type, one that is not contiguous, cannot be written to, or
            shares memory with one that is read.
    """
    if out is None:
        return np.empty(shape)
    if not isinstance(out, np.ndarray) or isinstance(out, np.ma.MaskedArray) or out.dtype != np.float64:
        plain = isinstance(out, np.ndarray) and not isinstance(out, np.ma.MaskedArray)
        found = out.dtype if plain else type(out).__name__
        raise ArgumentError(f"out must be an array of float64, got {found}")
    if out.shape != shape:
        raise ArgumentError(f"out must have the shape {shape}, got {out.shape}")
    if not out.flags.carray:
        raise ArgumentError("out must be contiguous, aligned and writable")
    if any(a is not None and np.shares_memory(out, a) for a in read):
        raise ArgumentError("out must not share memory with what is read while it is written")
    return out
