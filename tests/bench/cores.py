"""Print what a second core gains in a batch of W1, beside a loop that only reads and writes the same memory.

    python tests/bench/cores.py [POINTS]

A point is two numbers read and one written, 24 bytes. No batch is faster than the loop, whatever it computes. Each way
is called several times in a row: a core that has been idle takes long to wake, which is the machine's and not the
batch's.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from threading import Thread
from time import perf_counter
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))

from bench.workloads import WORKLOADS

import fuzzyctl

BYTES = 24
ROUNDS = 40
IN_A_ROW = 6


def ways(count: int) -> dict[str, Callable[[], Any]]:
    """Return the batch and the loop, on one core and on two, over so many points."""
    import numba

    @numba.njit(nogil=True)
    def add(points: Any, out: Any) -> None:
        for k in range(points.shape[0]):
            out[k] = points[k, 0] + points[k, 1]

    workload = WORKLOADS[0]
    kernel = fuzzyctl.compile(fuzzyctl.loads(workload.text), "numba")
    points, out, half = workload.points(count), np.zeros(count), count // 2

    def both() -> None:
        other = Thread(target=add, args=(points[:half], out[:half]))
        other.start()
        add(points[half:], out[half:])
        other.join()

    return {
        "batch, one core": lambda: kernel.batch(points, out=out, parallel=False),
        "batch, all cores": lambda: kernel.batch(points, out=out),
        "batch, all cores, new array": lambda: kernel.batch(points),
        "memory only, one core": lambda: add(points, out),
        "memory only, two cores": both,
    }


def measured(count: int) -> dict[str, float]:
    """Return seconds by way; the best of some rounds, all ways in each round."""
    runs = ways(count)
    best = dict.fromkeys(runs, float("inf"))
    for _ in range(ROUNDS):
        for name, run in runs.items():
            for _ in range(IN_A_ROW):
                began = perf_counter()
                run()
                best[name] = min(best[name], perf_counter() - began)
    return best


def main() -> None:
    """Measure and print."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    for name, seconds in measured(count).items():
        print(f"{name:28} {seconds / count * 1e9:6.2f} ns a point {BYTES * count / seconds / 1e9:6.1f} GB/s")


if __name__ == "__main__":
    main()
