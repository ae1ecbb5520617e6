"""Computation of the runs of a sweep by local worker processes."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from itertools import islice
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.experiments.runnable import Runnable
from fuzzyctl.experiments.sweep_plan import Plan, Run
from fuzzyctl.support.cores import interrupts_blocked


class SweepError(Exception):
    """Raised when a sweep cannot go on."""


@dataclass(frozen=True)
class Setup:
    """What all runs of a sweep have in common.

    Args:
        runnable: Subject of the sweep.
        used: Checksums of the files that the runs rest on, by name, as they were checked.
        measures: What to keep of each run.
    """

    runnable: Runnable[Any]
    used: tuple[tuple[str, str], ...]
    measures: tuple[str, ...]


@dataclass(frozen=True)
class Outcome:
    """What became of a run.

    Args:
        number: Of the run.
        row: Its measures by column.
        wall_s: Computing time [s].
        problem: Why it could not be computed at all, which ends the sweep; else empty.
    """

    number: int
    row: Mapping[str, Any]
    wall_s: float
    problem: str = ""


def setup_of(*plans: Plan[Any], measures: tuple[str, ...]) -> Setup:
    """Return what all runs of some plans have in common."""
    used = {item for one in plans for item in one.used.items()}
    return Setup(plans[0].runnable, tuple(sorted(used)), measures)


def work(setup: Setup, run: Run) -> Outcome:
    """Compute a run."""

    def failure(problem: str) -> Outcome:
        return Outcome(run.number, {}, 0.0, problem)

    runnable = _kept(setup).runnable
    try:
        scenario = runnable.read(run.path, run.overrides)
        ready = runnable.prepare(scenario, run.controller, setup.measures)
    except DiagnosticError as error:  # it was checked before: a file has changed, or code of the user raises
        return failure(f"run {run.number} of {run.path} was checked, but cannot be prepared:\n{error}")
    if scenario.sha256 != run.sha256:
        return failure(f"{run.path} changed while the sweep ran")
    for name, used in ready.used.items():
        if (name, used.sha256) not in setup.used:
            return failure(f"{used.path} changed while the sweep ran")
    try:
        computed = ready.compute()
    except DiagnosticError as error:  # code of the user raises
        return failure(f"run {run.number} of {run.path} cannot be computed:\n{error}")
    return Outcome(run.number, computed.row, computed.wall_s)


@cache
def _kept(setup: Setup) -> Setup:
    """Return the first of equal setups, so that files and proofs of its runnable serve all runs of a process."""
    return setup


#: Runs that wait in the queue of each worker, so that no worker has to wait for its next one.
AHEAD = 3
#: Each worker is one thread: they would get in each other's way.
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
#: The record of a run is large: kept by the process from one run to the next, its pages need not be allocated anew.
MEMORY = {"MALLOC_MMAP_THRESHOLD_": str(1 << 30), "MALLOC_TRIM_THRESHOLD_": str(1 << 30), "MALLOC_TOP_PAD_": "0"}


class WorkerLostError(SweepError):
    """Raised when a worker ended in the middle of a run, such as for want of memory."""


def compute(setup: Setup, runs: Iterable[Run], jobs: int) -> Iterator[Outcome]:
    """Yield the outcomes of runs as they come, in any order.

    Workers end with this process, however it ends: they hold one end of a pipe whose other end dies with it.

    Raises:
        WorkerLostError: When a worker ended otherwise.
    """
    context = get_context("spawn")
    theirs, ours = context.Pipe(duplex=False)
    with _environment():
        pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_begin, initargs=(theirs,))
        try:
            yield from _feed(pool, setup, iter(runs), AHEAD * jobs)
        except BrokenProcessPool as error:
            raise WorkerLostError(
                "a worker process ended in the middle of a run, perhaps for want of memory"
            ) from error
        finally:
            ours.close()
            pool.shutdown(wait=True, cancel_futures=True)
            theirs.close()


def _feed(pool: ProcessPoolExecutor, setup: Setup, runs: Iterator[Run], ahead: int) -> Iterator[Outcome]:
    waiting: set[Future[Outcome]] = set()
    with interrupts_blocked():
        waiting |= {pool.submit(work, setup, run) for run in islice(runs, ahead)}
    while waiting:
        done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
        waiting |= {pool.submit(work, setup, run) for run in islice(runs, len(done))}
        for one in done:
            yield one.result()


@contextmanager
def _environment() -> Iterator[None]:
    """Set the variables that workers inherit."""
    wanted = {**dict.fromkeys(ONE_THREAD, "1"), **MEMORY}
    before = {name: os.environ.get(name) for name in wanted}
    os.environ.update({name: value for name, value in wanted.items() if before[name] is None})
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)


def _begin(alive: Connection) -> None:
    """Prepare a worker: Ctrl-C is its parent's business, and it ends with its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, args=(alive,), daemon=True).start()


def _end_with_parent(alive: Connection) -> None:
    try:
        alive.recv_bytes()
    except (EOFError, OSError):
        os._exit(0)
