"""Blocks of a batch: conversion of arguments, and shares of threads."""

from __future__ import annotations

import math
import os
import signal
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, wait
from functools import cache, partial
from time import perf_counter, sleep
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.kernels.backends.arguments import float_array
from fuzzyctl.support.cores import cores

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor

    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]
    #: Writes the results of some points: (points (n, inputs), states (n, states) or None, results (n, outputs)).
    Fill = Callable[[FloatArray, FloatArray | None, FloatArray], None]
    #: Fills the results from one index to before another.
    Work = Callable[[int, int], None]

#: Points that are converted at a time where an array is not as compiled code takes it, at most.
BLOCK: Final = 8192
#: Bytes of the blocks that are converted, of all threads together, and of the arrays that numpy computes with.
CONVERTED: Final = 90_000
COMPUTED: Final = 860_000
#: Points of the first block, whose time is measured; each further one is longer by a factor until the time is telling.
TRIED: Final = 512
GROWTH: Final = 4
#: Seconds from which on the time of a block tells how long a point takes.
TELLING: Final = 50e-6
#: Seconds of the smallest share that a thread takes: with less, waking it and waiting for it costs more than it saves.
ENOUGH: Final = 250e-6
#: Seconds of machine code between looks for interrupts, unless the first block takes longer.
PROMPT: Final = 5e-3
#: Seconds between looks whether interrupted threads are done.
_NAP: Final = 1e-4
_MASKS: Final = hasattr(signal, "pthread_sigmask")


def run(fill: Fill, points: Any, states: FloatArray | None, results: FloatArray) -> None:
    """Fill the results in this thread, block by block where arrays are converted.

    Args:
        fill: Computes a block.
        points: n points, shape (..., inputs), of any type of numbers and any layout.
        states: Shape (n, states), perhaps one row repeated; None without a state.
        results: Shape (n, outputs), contiguous.
    """
    if len(results) <= TRIED and _are_plain(points, states):
        fill(points, states, results)
    else:
        _work(fill, points, states, results, 1)(0, len(results))


def run_compiled(
    fill: Fill, points: Any, states: FloatArray | None, results: FloatArray, *, parallel: bool = True
) -> None:
    """Fill the results by machine code that needs no lock of the interpreter, in several threads where that pays.

    The first points tell how long one takes. From that follow the number of threads, and shares so short that an
    interrupt ends the batch soon.

    Args:
        fill: Computes a block; the rest as for `run`.
        points: As for `run`.
        states: As for `run`.
        results: As for `run`.
        parallel: Whether several threads may share the work.
    """
    count = len(results)
    if count <= TRIED and _are_plain(points, states):
        fill(points, states, results)
        return
    done, pace = _try(_work(fill, points, states, results, 1), count)
    if done < count:
        workers = max(min(cores(), int((count - done) * pace / ENOUGH)), 1) if parallel else 1
        shares = _shares(done, count, workers, *(max(int(seconds / pace), TRIED) for seconds in (ENOUGH, PROMPT)))
        _share(_work(fill, points, states, results, workers), shares, workers)


def _try(work: Work, count: int) -> tuple[int, float]:
    """Fill the first points; return how many they are, and the seconds that each of the last ones took."""
    done, size = 0, TRIED
    while True:
        last, began = min(done + size, count), perf_counter()
        work(done, last)
        seconds = perf_counter() - began
        if seconds > TELLING or last == count:
            return last, seconds / max(last - done, 1)
        done, size = last, GROWTH * size


def _work(fill: Fill, points: Any, states: FloatArray | None, results: FloatArray, workers: int) -> Work:
    """Return the function that fills a part of the results, in blocks of bounded memory if arrays are converted."""
    size = len(results)
    if not _are_plain(points, states):
        numbers = points.shape[-1] + (0 if states is None else states.shape[-1])
        size = min(BLOCK, CONVERTED // (8 * max(numbers, 1) * workers))

    def work(first: int, last: int) -> None:
        for start in range(first, last, max(size, 1)):
            part = slice(start, min(start + size, last))
            block = plain(float_array(listed(points, part.start, part.stop), "points"))
            fill(block, None if states is None else plain(states[part]), results[part])

    return work


def plain(array: FloatArray) -> FloatArray:
    """Return an array of floats as machine code reads it: contiguous and aligned; a copy only where it is not."""
    return np.require(array, requirements=["C", "A"])


def is_plain(array: npt.NDArray[Any]) -> bool:
    """Return whether compiled code can read an array as it is."""
    return array.ndim == 2 and array.dtype == np.float64 and array.flags.c_contiguous and array.flags.aligned


def _are_plain(points: npt.NDArray[Any], states: FloatArray | None) -> bool:
    return is_plain(points) and (states is None or is_plain(states))


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


def _share(work: Work, shares: Iterator[tuple[int, int]], workers: int) -> None:
    """Let several threads, this one among them, take one share after the other.

    A core that is busy with something else takes fewer shares.
    """
    left = deque(shares)
    begun: list[None] = []
    ended: list[None] = []
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

    def help_out() -> None:
        begun.append(None)
        try:
            take()
        finally:
            ended.append(None)

    try:
        helping = list(_begun(help_out, workers - 1))
        take()
        wait([help for help in helping if not help.cancel()])
    finally:
        left.clear()
        _wait_until(lambda: len(begun) == len(ended))
    if failed:  # shares are taken in order, so that the first point that fails is among these
        raise min(failed, key=lambda f: f[0])[1]


def _begun(work: Callable[[], None], count: int) -> Iterator[Future[None]]:
    """Yield the futures of `count` threads that do some work, or of as many as can be started."""
    try:
        for _ in range(count):
            yield _pool(os.getpid()).submit(work)
    except RuntimeError:  # the interpreter is about to end, or there are too many
        return


def _wait_until(done: Callable[[], bool]) -> None:
    """Wait, through interrupts, which are raised in the end."""
    try:
        while not done():
            sleep(_NAP)
    except BaseException:
        _wait_until(done)
        raise


def _shares(first: int, count: int, workers: int, least: int, most: int) -> Iterator[tuple[int, int]]:
    """Yield the shares of points: two thirds of a thread's part of the rest, within the least and the most."""
    while first < count:
        share = max(2 * (count - first) // (3 * workers), least) if workers > 1 else count - first
        last = min(first + min(share, most), count)
        yield first, last
        first = last


@cache
def _pool(_process: int) -> ThreadPoolExecutor:
    """Return the threads that help, one pool for each process, since a fork copies none."""
    # Its module cannot be loaded any more once the interpreter is about to end.
    from concurrent.futures import ThreadPoolExecutor

    # Signals are for threads that know of them.
    begin = partial(signal.pthread_sigmask, signal.SIG_SETMASK, signal.valid_signals()) if _MASKS else None
    return ThreadPoolExecutor(max(cores() - 1, 1), thread_name_prefix="fuzzyctl", initializer=begin)


def results_for(out: Any, shape: tuple[int, ...], *read: FloatArray | None) -> FloatArray:
    """Return the array to write to: a new one, or the caller's.

    Args:
        out: The caller's, None for a new one.
        shape: The required shape.
        read: Arrays that are read while it is written.

    Raises:
        ArgumentError: For an array of another shape or type, one that is not contiguous, cannot be written to, or
            shares memory with one that is read.
    """
    if out is None:
        return np.empty(shape)
    if not isinstance(out, np.ndarray) or isinstance(out, np.ma.MaskedArray) or out.dtype != np.float64:
        plain = isinstance(out, np.ndarray) and not isinstance(out, np.ma.MaskedArray)
        kind = out.dtype if plain else type(out).__name__
        raise ArgumentError(f"out must be an array of float64, got {kind}")
    if out.shape != shape:
        raise ArgumentError(f"out must have the shape {shape}, got {out.shape}")
    if not out.flags.carray:
        raise ArgumentError("out must be contiguous, aligned and writable")
    if any(a is not None and np.shares_memory(out, a) for a in read):
        raise ArgumentError("out must not share memory with what is read while it is written")
    return out
