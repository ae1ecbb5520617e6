"""Computation of runs by the workers of a dask cluster."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from contextlib import nullcontext
from functools import partial
from itertools import islice
from typing import Any

from fuzzyctl.experiments.runnable import Runnable
from fuzzyctl.experiments.sweep_plan import Run
from fuzzyctl.experiments.sweep_workers import AHEAD, Outcome, Setup, SweepError, WorkerLostError, work

#: An address of this form is a cluster of N processes on this computer.
LOCAL = "local:"
#: Where its processes listen, each at a port that the system chooses: two sweeps can run at once.
HOST = "127.0.0.1"
#: How long a cluster has to answer [s].
PATIENCE = 10


class ClusterError(SweepError):
    """Raised when a cluster cannot be used."""


def available() -> bool:
    """Return whether dask is installed."""
    try:
        import distributed  # noqa: F401 - whether it can be imported is the question
    except ImportError:
        return False
    return True


def compute(setup: Setup, runs: Iterable[Run], address: str) -> Iterator[Outcome]:
    """Yield the outcomes of runs as they come, in any order.

    Workers need the same versions of everything and see the files under the same paths; a difference is refused.

    Args:
        setup: Setup of all runs.
        runs: What to compute.
        address: Of a scheduler, such as tcp://10.0.0.1:8786; or local:N for N processes here.

    Raises:
        ClusterError: When no cluster answers at the address.
        WorkerLostError: When the cluster loses a run again and again.
    """
    import distributed
    from distributed import KilledWorker
    from distributed.comm.core import CommClosedError

    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # this program reports it itself
    with _cluster(address) as where:
        try:
            _require_scheme(where)
            client = distributed.Client(where, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            raise ClusterError(f"no dask scheduler answers at {address}: {error}") from error
        with client:
            _require_workers(client, address, setup.runnable)
            try:
                yield from _feed(client, setup, iter(runs))
            except (KilledWorker, CommClosedError) as error:
                raise WorkerLostError(f"the cluster lost a run: {error}") from error


def _cluster(address: str) -> Any:
    """Return a context with the address to connect to."""
    if not address.startswith(LOCAL):
        return nullcontext(address)
    import distributed

    count = int(address.removeprefix(LOCAL))
    try:
        return distributed.LocalCluster(
            n_workers=count, threads_per_worker=1, processes=True, host=HOST, dashboard_address=f"{HOST}:0",
            silence_logs=logging.CRITICAL,  # a worker may ask for the scheduler while both end
        )  # fmt: skip
    except (RuntimeError, OSError) as error:
        raise ClusterError(f"no dask cluster can be started on this computer: {error}") from error


def _require_scheme(where: Any) -> None:
    """Refuse an address that no connection can be made to; a client would wait for it when it is taken down."""
    from distributed.comm.addressing import parse_address
    from distributed.comm.registry import get_backend

    if isinstance(where, str):
        scheme, _ = parse_address(where)
        get_backend(scheme)


def _require_workers(client: Any, address: str, runnable: Runnable[Any]) -> None:
    """Refuse a cluster without workers, or one with other versions.

    Raises:
        ClusterError: Naming the differences.
    """
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError as error:
        raise ClusterError(f"the dask scheduler at {address} has no workers") from error
    mine = runnable.software()
    for worker, theirs in client.run(runnable.software).items():
        other = sorted(name for name in mine if theirs.get(name) != mine[name])
        if other:
            versions = ", ".join(f"{name} {str(theirs.get(name))[:16]}" for name in other)
            raise ClusterError(f"the worker {worker} has other versions: {versions}")


def _feed(client: Any, setup: Setup, runs: Iterator[Run]) -> Iterator[Outcome]:
    import distributed

    submit = partial(client.submit, work, setup, pure=False)
    ahead = AHEAD * max(1, sum(client.nthreads().values()))
    going = distributed.as_completed([submit(run) for run in islice(runs, ahead)], loop=client.loop)
    for one in going:
        yield one.result()
        for run in islice(runs, 1):
            going.add(submit(run))
