"""Print what one evaluation of a cost function takes with new numbers: a fuzzy PI loop of 300 samples.

python tests/bench/free_numbers.py
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from numba import njit

sys.path.insert(0, str(Path(__file__).parents[2]))

import fuzzyctl

SAMPLES = 300
NAMES = ("GE", "surface.error.PS.peak", "surface.move.PS.value")
LABELS = ("NB", "NM", "NS", "Z", "PS", "PM", "PB")


def text() -> str:
    """Return a fuzzy PI controller: 7 x 7 rules, product, centre average."""
    rows = "\n".join(
        f"  {name} | " + " ".join(LABELS[min(max(i + j - 3, 0), 6)] for j in range(7)) for i, name in enumerate(LABELS)
    )
    peaks = "  terms NB@-1 NM@-0.6 NS@-0.3 Z@0 PS@0.3 PM@0.6 PB@1"
    return f"""
system surface
and product
defuzzifier center_average
input error in [-1, 1]
{peaks}
input change in [-1, 1]
{peaks}
output move in [-1, 1]
{peaks.replace("@", "=")}
table move = error x change
  {" ".join(LABELS)}
{rows}

controller law
input reference
input level
param GE in (0, 10] = 2
let error = reference - level
output u = integral(0.8 * surface(GE * error, 0.5 * difference(error)))
every 50 ms
"""


@njit
def loop(surface: Any, values: Any, gain: float) -> float:
    """Return the integral of the absolute error of a first-order plant."""
    level, before, integral, total = 0.0, 1.0, 0.0, 0.0
    for _ in range(SAMPLES):
        error = 1.0 - level
        move = surface(gain * error, 0.5 * (error - before), values)
        before = error
        level += 0.05 * (integral - level)
        integral += 0.05 * 0.8 * move
        total += 0.05 * abs(error)
    return total


@njit
def loop_of_value(surface: Any, gain: float) -> float:
    """Return the same for a kernel whose numbers are in its machine code."""
    level, before, integral, total = 0.0, 1.0, 0.0, 0.0
    for _ in range(SAMPLES):
        error = 1.0 - level
        move = surface(gain * error, 0.5 * (error - before))
        before = error
        level += 0.05 * (integral - level)
        integral += 0.05 * 0.8 * move
        total += 0.05 * abs(error)
    return total


def costs() -> dict[str, Callable[[float], float]]:
    """Return ways to compute a cost for a peak of a term, by what they do."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "law.fz"
        path.write_text(text(), encoding="utf-8")
        controller = fuzzyctl.load(path, block="law")
    (surface,) = controller.systems
    kernel = fuzzyctl.compile(surface, "numba", free=["error.PS.peak"])
    step = fuzzyctl.compile(controller, "numba", free=NAMES)
    inputs = np.column_stack([np.ones(SAMPLES), np.linspace(0.0, 1.2, SAMPLES)])
    typed = fuzzyctl.loads(
        text().split("controller")[0].replace("PS@0.3", "PS@(p)", 1).replace("and", "param p=0.3\nand", 1)
    )

    def one_by_one(peak: float) -> float:
        changed = fuzzyctl.compile(typed.with_params(p=peak), "numba", algorithm="rules")
        return float(loop_of_value(changed.value, 2.0))

    def closed_loop(peak: float) -> float:
        return float(loop(kernel.jit, kernel.start({"error.PS.peak": peak}), 2.0))

    def recorded(peak: float) -> float:
        outputs, _ = step.run(inputs, step.start({"surface.error.PS.peak": peak}))
        return float(np.sum(outputs))

    return {
        "with_params, compile and a compiled loop": one_by_one,
        "kernel.jit with free numbers in a compiled loop": closed_loop,
        "step.run with free numbers": recorded,
    }


def milliseconds(cost: Callable[[float], float], count: int) -> float:
    """Return the processor time of one evaluation, each with other numbers."""
    cost(0.31)  # compiles what is compiled once
    began = process_time()
    for k in range(count):
        cost(0.2 + 0.2 * k / count)
    return (process_time() - began) / count * 1e3


def main() -> None:
    """Measure and print; what is compiled goes to a folder of its own, so that nothing comes from a cache."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["FUZZYCTL_CACHE_DIR"] = folder
        for what, cost in costs().items():
            count = 5 if "with_params" in what else 500
            print(f"{what}: {milliseconds(cost, count):.3f} ms")


if __name__ == "__main__":
    main()
