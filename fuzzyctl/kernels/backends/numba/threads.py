"""Loops in machine code over many points, shared among threads that need nothing of the interpreter meanwhile.

To wake a thread takes as long as tens of thousands of points of a small system. So a thread that has helped goes on
looking for a moment whether there is more to do, as OpenMP's do, and begins at once with the next batch in a row.
"""

from __future__ import annotations

import _thread
import ctypes
import math
import os
import signal
from functools import cache
from threading import Lock, RLock
from time import perf_counter
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.kernels.backends.numba import thread_ir as shares
from fuzzyctl.kernels.backends.numba import vectorcall as entry
from fuzzyctl.kernels.backends.numba.thread_ir import Place, Posted, Word, WordsOfThread, functions
from fuzzyctl.support.cores import cores

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
#: What takes less seconds only says that a point takes no more.
_TELLING: Final = 10e-6
#: Points of the smallest share of small systems: so few that no thread waits long for the last one, so many that taking
#: it costs little; those of others take this part of what is enough for a thread.
LEAST: Final = 1 << 11
_PART: Final = 0.25
#: Seconds of the largest share: an interrupt is heeded between two of them, and nobody waits longer for another thread.
PROMPT: Final = 0.02
#: Points of the largest share, and of the first one of a loop.
MOST: Final = 1 << 18
_TRIED: Final = 1 << 10
#: Seconds that a thread looks for more to do before it sleeps.
LINGERING: Final = 300e-6
#: Seconds that a caller looks whether another thread is done with its last share before it naps.
PATIENCE: Final = 50e-6
#: Seconds until threads are started again after none could be.
_RETRY: Final = 1.0

#: Plain numbers: to look an entry of an enumeration up takes its time.
_REFUSED, _NAN, _MOST, _UNSEEN = Place.REFUSED.value, Place.NAN.value, Place.MOST.value, Posted.UNSEEN.value


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
        self._pace, self._is_known = _GUESS, False
        functions()  # which takes longer than a batch, and is not to be measured

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
        pace = self._pace
        expected = count * pace
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
            MOST if workers == 1 else LEAST if pace * LEAST < _PART * ENOUGH else max(int(_PART * ENOUGH / pace), 1),
            self._refusals,
            looks,
            most=_most(pace) if self._is_known else _TRIED,
        )
        if workers == 1:
            self._take(job)
        else:
            self._take_with(_crew(os.getpid()).of(workers - 1), job)
        if parallel and expected >= 2 * ENOUGH:
            _ended()
        refused = job[_REFUSED]
        return None if refused == shares.NEVER else refused, bool(job[_NAN])

    def _take_with(self, helpers: list[_Helper], job: Array[c_int64]) -> None:
        """Do a job in this thread and others; once this returns or raises, nobody writes to its arrays."""
        leave, looks, (sleep, time) = functions().leave, _looks(PATIENCE), shares.nap()
        try:
            for helper in helpers:
                helper.begin(job)
            self._take(job)
        finally:
            # A single call, since interrupts come between calls.
            leave(job, looks, sleep, time)

    def _take(self, job: Array[c_int64]) -> None:
        """Take shares in this thread until there are none, and learn what a point takes."""
        take, done, began = functions().take, 0, perf_counter()
        while (taken := take(job)) >= 0:
            done += taken
            job[_MOST] = _most((perf_counter() - began) / done)
        done += ~taken
        if done and job[_REFUSED] == shares.NEVER:
            seconds = perf_counter() - began
            self._is_known |= seconds >= _TELLING
            self._pace = seconds / done if seconds >= _TELLING else min(self._pace, seconds / done)


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


def _most(pace: float) -> int:
    """Return the points of the largest share if each takes so many seconds."""
    return MOST if pace * MOST < PROMPT else max(int(PROMPT / pace), 1)


class _Helper:
    """A thread that takes shares of others' jobs."""

    def __init__(self) -> None:
        self._wanted, self._words = Lock(), WordsOfThread()
        self._wanted.acquire()

    def live(self) -> None:
        """Take shares for ever, in a thread of its own."""
        if hasattr(signal, "pthread_sigmask"):  # signals are for threads that know of them
            signal.pthread_sigmask(signal.SIG_SETMASK, signal.valid_signals())
        serve, looks = functions().serve, _looks(LINGERING)
        while True:
            self._wanted.acquire()
            serve(self._words, looks)

    def begin(self, job: Array[c_int64]) -> None:
        """Have it take shares of a job, unless it does so of another caller's."""
        # The lock may be locked though the thread is awake, which then looks once more than it had to.
        if functions().post(self._words, ctypes.addressof(job)) == _UNSEEN and self._wanted.locked():
            self._wanted.release()


class _Crew:
    """The threads of a process that help, started when they are first wanted."""

    def __init__(self) -> None:
        # A signal's handler may come here while the thread that it interrupts is here.
        self._lock, self._helpers = RLock(), list[_Helper]()
        self._failed = -math.inf

    def of(self, count: int) -> list[_Helper]:
        """Return so many, or as many as can be started."""
        if len(self._helpers) < count and perf_counter() - self._failed > _RETRY:
            with self._lock:
                while len(self._helpers) < count and self._start():
                    pass
        return self._helpers[:count]

    def _start(self) -> bool:
        """Start one more, unless the interpreter is about to end, or there are too many threads."""
        helper = _Helper()
        self._helpers.append(helper)
        try:
            # `Thread.start` waits, and an interrupt then would leave a thread that nobody knows.
            _thread.start_new_thread(helper.live, ())
        except RuntimeError:
            self._helpers.remove(helper)
            self._failed = perf_counter()
            return False
        return True


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
    looks, word = 1000, WordsOfThread(Word.LINGERS)
    began = perf_counter()
    functions().serve(word, looks)
    return (perf_counter() - began) / looks
