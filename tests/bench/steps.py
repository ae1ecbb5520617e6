"""Compilation of steps with numba: delays as loops and written out, and curved sets that are called several times.

python tests/bench/steps.py
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

import fuzzyctl
from fuzzyctl.kernels.backends.numba.machine_code import sequence
from fuzzyctl.kernels.program import printer as stores

CURVED = """system curved
defuzzifier centroid
input e in [-1, 1]
  N = triangle(-inf, -1, 0)
  Z = triangle(-1, 0, 1)
  P = triangle(0, 1, inf)
output u in [-1, 1]
  N = gaussian(-1, 0.4)
  Z = gaussian(0, 0.4)
  P = gaussian(1, 0.4)
table u = e
     N Z P
   | N Z P
"""
DELAY = "output u = 0.5 * delay(x, {samples}) + x"
CALLS = "output u = curved(x) + curved(0.5 * x) + curved(x * x)"


def step_of(lines: str) -> Any:
    """Return the compiled step of a controller with one input."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "c.fz"
        path.write_text(f"{CURVED}controller c\ninput x\n{lines}\nevery 10 ms\n", encoding="utf-8")
        return fuzzyctl.compile(fuzzyctl.load(path, block=fuzzyctl.Controller), "numba")


def compiling(step: Any) -> float:
    """Return the time of the processor to compile the loop over steps [s]."""
    begin = process_time()
    sequence(step.form.point("numba"), 1)
    return process_time() - begin


def stepping(step: Any, count: int = 2000) -> float:
    """Return the shortest time of a step in the compiled loop [µs]."""
    inputs, found = np.random.default_rng(1).normal(size=count), float("inf")
    for _ in range(20):
        begin = perf_counter()
        step.run(inputs)
        found = min(found, (perf_counter() - begin) / count * 1e6)
    return found


def main() -> None:
    """Print a table; each row is compiled from nothing where FUZZYCTL_CACHE_DIR is an empty folder."""
    print("| | compiling | a step |\n|---|---|---|")
    least = stores.LEAST_LOOP
    for text, samples, own in (
        ("delay of 200 samples, written out", 200, 1 << 30),
        ("delay of 200 samples", 200, least),
        ("delay of 10,000 samples", 10_000, least),
    ):
        stores.LEAST_LOOP = own
        step = step_of(DELAY.format(samples=samples))
        print(f"| {text} | {compiling(step):.2g} s | {stepping(step):.2g} µs |", flush=True)
    stores.LEAST_LOOP = least
    for text, lines in (
        ("exact centroid of curved sets", "output u = curved(x)"),
        ("the same, called three times", CALLS),
    ):
        step = step_of(lines)
        print(f"| {text} | {compiling(step):.2g} s | {stepping(step, 200):.2g} µs |", flush=True)


if __name__ == "__main__":
    main()
