"""Print how many times faster than on one core batches are on all cores, in a row and apart.

    python tests/bench/cores.py [POINTS ...]

In a row, each batch begins when the last one ends, as in sweeps and rasters. Apart, the machine had nothing to do for
ten milliseconds, so that the other cores are asleep.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, sleep
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

import fuzzyctl
from tests.bench.workloads import WORKLOADS, Workload

POINTS = (20_000, 50_000, 100_000, 200_000, 500_000, 1_000_000)
ROUNDS = 40
IN_A_ROW = 10
PAUSE = 0.01


def seconds(run: Callable[[], Any]) -> float:
    """Return how long a run took."""
    began = perf_counter()
    run()
    return perf_counter() - began


def gains(workload: Workload, count: int) -> tuple[float, float, float]:
    """Return nanoseconds a point on one core, and the gain of all cores in a row and apart; the best of some rounds."""
    kernel = fuzzyctl.compile(fuzzyctl.loads(workload.text), "numba")
    points, out = workload.points(count), np.zeros(count)
    one = row = alone = apart = float("inf")
    for _ in range(ROUNDS):
        for _ in range(IN_A_ROW):
            one = min(one, seconds(lambda: kernel.batch(points, out=out, parallel=False)))
        for _ in range(IN_A_ROW):
            row = min(row, seconds(lambda: kernel.batch(points, out=out)))
        for _ in range(2):  # what follows on a moment without pause is faster
            sleep(PAUSE)
            alone = min(alone, seconds(lambda: kernel.batch(points, out=out, parallel=False)))
            sleep(PAUSE)
            apart = min(apart, seconds(lambda: kernel.batch(points, out=out)))
    return one / count * 1e9, one / row, alone / apart


def main() -> None:
    """Measure and print."""
    counts = [int(a) for a in sys.argv[1:]] or POINTS
    print("        points  ns a point, one core  in a row  apart")
    for workload in WORKLOADS:
        for count in counts:
            one, row, apart = gains(workload, count)
            print(f"{workload.name:4} {count:9,} {one:21.2f} {row:9.2f} {apart:6.2f}", flush=True)


if __name__ == "__main__":
    main()
