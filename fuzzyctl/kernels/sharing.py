"""Loops in machine code over many points, shared among threads that need nothing of the interpreter meanwhile.

To wake a thread takes as long as tens of thousands of points of a small system. So a thread that has helped goes on
looking for a moment whether there is more to do, as OpenMP's do, and begins at once with the next batch in a row.
"""

from __future__ import annotations

import ctypes
import math
import os
from functools import cache
from threading import Lock, Thread
from time import perf_counter, sleep
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.kernels import entry, shares
from fuzzyctl.kernels.batching import cores
from fuzzyctl.kernels.shares import MOST, Place, Word, WordOfThread, functions

if TYPE_CHECKING:
    from ctypes import Array, c_int64

    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

#: Seconds of work for each thread from which on a second one pays if it is awake.
ENOUGH: Final = 30e-6
#: Seconds of work from which on others are woken, which takes some of the caller's time, too.
WAKING: Final = 500e-6
#: Seconds within which a batch follows another one: then others are woken for less, since more batches may follow.
SOON: Final = 1e-3
#: Seconds that a point takes as long as nobody knows.
_GUESS: Final = 1.5e-9
#: With fewer points the time that they take tells little of others.
_TELLING: Final = 4096
#: Points of the smallest share: so few that no thread waits long for the last one, so many that taking it costs little.
LEAST: Final = 1 << 11
#: Seconds that a thread looks for more to do before it sleeps.
LINGERING: Final = 300e-6
#: Seconds that a caller looks whether another thread is done with its last share, and then sleeps at a time.
PATIENCE: Final = 50e-6

#: Plain numbers: to look an entry of an enumeration up takes its time.
_COUNT, _NEXT, _REFUSED, _NAN = (p.value for p in (Place.COUNT, Place.NEXT, Place.REFUSED, Place.NAN))


class Loop:
    """A loop in machine code over points, and the table of its numbers.

    Args:
        code: The address of a function int64(points, states, results, table, count), see `numba_backend.batch_source`.
        table: What its fourth argument points to.
        refusals: The number of kinds of refusals.
        kept: What must last as long as the loop.
    """

    def __init__(self, code: int, table: FloatArray, refusals: int, kept: Any) -> None:
        self._kept, self._refusals = (kept, table), max(refusals, 1)
        self._code, self._table = code, table.ctypes.data
        self._pace = _GUESS

    def run(
        self, points: FloatArray, states: FloatArray | None, results: FloatArray, *, parallel: bool, looks: bool
    ) -> tuple[int | None, bool]:
        """Fill the results.

        Args:
            points: Shape (n, inputs), contiguous and aligned, as the others are.
            states: Shape (n, states); None without a state.
            results: Shape (n, outputs).
            parallel: Whether other threads may help.
            looks: Whether to look for NaN among the results.

        Returns:
            The number of kinds of refusals · the first point that was refused + the kind, or None; and whether a result
            is NaN, or may be: infinities of both signs count as well.
        """
        count = len(results)
        if not count:
            return None, False
        expected = count * self._pace
        workers = _workers(expected) if parallel else 1
        job = shares.job(
            self._code,
            entry.address_of_array(points),
            0 if states is None else entry.address_of_array(states),
            entry.address_of_array(results),
            self._table,
            count,
            8 * points.shape[1],
            0 if states is None else 8 * states.shape[1],
            8 * results.shape[1],
            2 * workers,
            LEAST if workers > 1 else MOST,
            self._refusals,
            looks,
        )
        # A thread that helps keeps the job for as long as it may write.
        job.kept = (self, points, states, results)  # type: ignore[attr-defined]
        began = perf_counter()
        threads = _do(job, workers - 1)
        if count >= _TELLING and job[_REFUSED] == shares.NEVER:
            self._pace = (perf_counter() - began) * threads / count
        if parallel and expected >= 2 * ENOUGH:
            _ended()
        refused = job[_REFUSED]
        return None if refused == shares.NEVER else refused, bool(job[_NAN])


#: When a batch that was worth sharing last ended.
_last = -math.inf


def _workers(expected: float) -> int:
    """Return how many threads are to share so many seconds of work."""
    if expected < 2 * ENOUGH:
        return 1
    if expected < WAKING and perf_counter() - _last > SOON:
        return 1
    return min(int(expected / ENOUGH), cores())


def _ended() -> None:
    global _last
    _last = perf_counter()


def _do(job: Array[c_int64], others: int) -> int:
    """Do a job in this thread and so many others; once this returns or raises, nobody writes to its arrays.

    Returns:
        The number of threads that took part or were woken for it.
    """
    take = functions().take
    if not others:
        while take(job):
            pass
        return 1
    helpers = _crew(os.getpid()).of(others)
    try:
        threads = 1 + sum(helper.begin(job) for helper in helpers)
        while take(job):
            pass
        return threads
    finally:
        job[_NEXT] = job[_COUNT]
        _leave(helpers, job)


def _leave(helpers: list[_Helper], job: Array[c_int64]) -> None:
    """Wait until all are done with their shares of a job; an interrupt meanwhile is raised once they are."""
    interrupted: BaseException | None = None
    for helper in helpers:
        while True:
            try:
                helper.leave(job)
                break
            except BaseException as error:  # noqa: BLE001 - raised below
                interrupted = error
    if interrupted is not None:
        raise interrupted


class _Helper:
    """A thread that takes shares of others' jobs."""

    def __init__(self) -> None:
        self._wanted, self._word = Lock(), WordOfThread()
        self._wanted.acquire()
        # The job that it is given, if any, by its only key: to enter and to delete that is one step, in which no
        # interrupt can come.
        self._given: dict[int, Array[c_int64]] = {}
        Thread(target=self._live, name="fuzzyctl", daemon=True).start()

    def _live(self) -> None:
        serve, looks = functions().serve, _looks(LINGERING)
        while True:
            self._wanted.acquire()
            serve(self._word, looks)

    def begin(self, job: Array[c_int64]) -> bool:
        """Have it take shares of a job, unless it does so of another caller's."""
        if self._given.setdefault(0, job) is not job:
            return False
        # It may be locked though the thread is awake, which then looks once more than it had to.
        if functions().post(self._word, ctypes.addressof(job)) and self._wanted.locked():
            self._wanted.release()
        return True

    def leave(self, job: Array[c_int64]) -> None:
        """If it has begun with a job, wait until it is done with its share, and have it take no other."""
        if self._given.get(0) is not job:
            return
        while functions().leave(self._word, ctypes.addressof(job), _looks(PATIENCE)):
            sleep(PATIENCE)
        del self._given[0]


class _Crew:
    """The threads of a process that help, started when they are first wanted."""

    def __init__(self) -> None:
        self._lock, self._helpers = Lock(), list[_Helper]()

    def of(self, count: int) -> list[_Helper]:
        """Return so many, or as many as can be started."""
        with self._lock:
            try:
                while len(self._helpers) < count:
                    self._helpers.append(_Helper())
            except RuntimeError:  # the interpreter is about to end, or there are too many threads
                return self._helpers
            return self._helpers[:count]


@cache
def _crew(_process: int) -> _Crew:
    """Return the threads of a process: a fork copies none."""
    return _Crew()


@cache
def _looks(seconds: float) -> int:
    """Return how often a thread looks in so many seconds, by the shortest of some measurements of one process."""
    return max(int(seconds / min(_look() for _ in range(5))), 1)


def _look() -> float:
    """Return the seconds that one look takes, of which others of the machine may make more."""
    looks, word = 1000, WordOfThread(Word.LINGERS)
    began = perf_counter()
    functions().serve(word, looks)
    return (perf_counter() - began) / looks
