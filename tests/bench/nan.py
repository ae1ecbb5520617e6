"""Print what it costs that NaN in gives NaN out: kernels with and without the test, compiled alike, in one run.

    python tests/bench/nan.py

Time is that of the thread, so that other programs disturb it little. Interpolation carries NaN along without a test.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from time import thread_time
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

import fuzzyctl
from fuzzyctl.kernels.backends.numba import source as numba_backend
from fuzzyctl.kernels.backends.numba.machine_code import Loop
from tests.bench.measure import _loop
from tests.bench.workloads import WORKLOADS, Workload

COUNT, ROUNDS = 200_000, 30
#: A result as numba's modules have it.
_TEST = re.compile(r"\(nan if \((?:\(x\d_? != x\d_?\)(?: or )?)+\) else (\w+)\)")


def without_test(source: str) -> str:
    """Return a module that gives the result whatever the inputs are."""
    return _TEST.sub(r"\1", source)


def cost(workload: Workload, rounds: int = ROUNDS) -> dict[str, tuple[float, float]]:
    """Return nanoseconds with the test and without it, of a point of a batch and of a call in a compiled loop."""
    kernel = fuzzyctl.compile(fuzzyctl.loads(workload.text), "numba")
    batch = numba_backend.batch_source(kernel.algorithm.many)
    points, out = workload.points(COUNT), np.empty((COUNT, 1))
    runs: dict[str, Any] = {}
    for which, change in (("with", str), ("without", without_test)):
        many = Loop(numba_backend.compile_source(change(batch)))
        runs["batch", which] = lambda many=many: many(points, None, out)
        runs["loop", which] = _loop(numba_backend.compile_source(change(kernel.source)), points)
    best = dict.fromkeys(runs, float("inf"))
    for run in runs.values():
        run()  # compiles
    for _ in range(rounds):
        for key, run in runs.items():
            began = thread_time()
            run()
            best[key] = min(best[key], (thread_time() - began) / COUNT * 1e9)
    return {form: (best[form, "with"], best[form, "without"]) for form in ("batch", "loop")}


def main() -> None:
    """Measure and print."""
    for workload in WORKLOADS:
        for form, (own, bare) in cost(workload).items():
            difference = f"{own - bare:+.2f} ns, x {own / bare:.2f}"
            print(f"{workload.name} {form}: {own:.2f} ns, without the test {bare:.2f} ns: {difference}")


if __name__ == "__main__":
    main()
