"""Time of runs: the shipped loops, a cost with new numbers, and a fuzzy loop beside the same in hand-written C.

python tests/bench/loops.py
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[1]))

import fuzzyctl  # noqa: E402 - found by the line above
from tests.bench.measure import FLAGS, pointer  # noqa: E402 - found by the line above
from tests.shipped import rules_folder  # noqa: E402 - found by the line above

#: Samples of the fuzzy loop beside C, and signals of it that are recorded.
SAMPLES = 100_001
SIGNALS = ("reference", "leak", "law.reference", "law.level", "law.valve", "tank.v", "tank.h", "tank.y")
TANK = (rules_folder() / "loops" / "water_tank.fz").read_text(encoding="utf-8")


def loaded(text: str) -> Any:
    """Return the loop of a text."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "loop.fz"
        path.write_text(text, encoding="utf-8")
        return fuzzyctl.load(path, block=fuzzyctl.Loop)


def cost_loop() -> Any:
    """Return the loop of the shipped tank with one measure, over 300 steps of its controller."""
    kept = [line for line in TANK.split("\n") if not line.startswith(("measure", "require", "run"))]
    return loaded("\n".join([*kept, "measure iae = iae(tank.y, reference)", "run 15 s step 50 ms", ""]))


def fuzzy_loop() -> Any:
    """Return the loop that fuzzy_loop.c is: the controller at each sample, a sensor without noise."""
    text = TANK.replace("every 50 ms", "every 10 ms").replace(
        "fuzzy_pi(reference, level)", "fuzzy_pi(reference, tank.y)"
    )
    text = text.partition("let reference")[0]
    text += "let reference = steps(0: 1.0, 30 s: 0.6)\nlet leak = 0.3 * pulse(10 s, 15 s)\n"
    return loaded(f"{text}run {(SAMPLES - 1) * 0.01:g} s\n")


def best(run: Callable[[], Any], rounds: int) -> float:
    """Return the shortest time of some calls [s]."""
    found = float("inf")
    for _ in range(rounds):
        began = perf_counter()
        run()
        found = min(found, perf_counter() - began)
    return found


def in_c(folder: Path) -> ctypes.CDLL | None:
    """Compile the hand-written loop; None without a C compiler."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        return None
    built = folder / "fuzzy_loop.so"
    source = str(HERE / "fuzzy_loop.c")
    subprocess.run([compiler, *FLAGS, "-shared", "-fPIC", source, "-o", str(built), "-lm"], check=True)
    library = ctypes.CDLL(str(built))
    library.fuzzy_loop.restype = ctypes.c_long
    library.fuzzy_loop_prepare()
    return library


def beside_c(rounds: int = 20) -> tuple[float, float, float] | None:
    """Return seconds of the run and of the C, round by round the best, and their largest difference; None without C."""
    experiment = fuzzyctl.Experiment(fuzzy_loop(), "numba")
    run = experiment.run()
    record = np.empty((SAMPLES, len(SIGNALS)))
    with tempfile.TemporaryDirectory() as folder:
        library = in_c(Path(folder))
        if library is None:
            return None
        own, other = float("inf"), float("inf")
        for _ in range(rounds):
            own = min(own, best(experiment.run, 1))
            other = min(other, best(lambda: library.fuzzy_loop(pointer(record), ctypes.c_long(SAMPLES)), 1))
        found = np.column_stack([run[name] for name in SIGNALS])
        return own, other, float(np.abs(found - record).max())


def shipped(name: str, rounds: int = 20) -> tuple[int, float, float]:
    """Return the samples of a shipped loop, seconds of a compiled run, and of one in generated Python."""
    loop = fuzzyctl.load(rules_folder() / "loops" / f"{name}.fz", block=fuzzyctl.Loop)
    compiled, plain = fuzzyctl.Experiment(loop, "numba"), fuzzyctl.Experiment(loop, "python")
    compiled.run()
    plain.run()
    return compiled.samples, best(compiled.run, rounds), best(plain.run, 3)


def cost(rounds: int = 50) -> tuple[int, float]:
    """Return the samples of a cost with new numbers, and seconds of one evaluation."""
    experiment = fuzzyctl.Experiment(cost_loop(), "numba", free=["law.GE", "law.GCE", "law.GU"])
    numbers = [2.0, 4.0, 8.0]

    def evaluate() -> float:
        numbers[0] += 1e-6
        return experiment.run(numbers).measures["iae"]

    evaluate()
    return experiment.samples, best(evaluate, rounds)


def main() -> None:
    """Print all times."""
    for name in ("pendulum", "water_tank"):
        samples, compiled, plain = shipped(name)
        print(f"{name}: {samples:,} samples, compiled {compiled * 1e3:.3g} ms, generated Python {plain * 1e3:.3g} ms")
    samples, seconds = cost()
    print(f"cost with new numbers: {samples} samples, {seconds * 1e3:.3g} ms")
    found = beside_c()
    if found is not None:
        own, other, difference = found
        print(
            f"7 x 7 fuzzy PI and tank: {own / SAMPLES * 1e9:.3g} ns a sample, C {other / SAMPLES * 1e9:.3g} ns, ",
            end="",
        )
        print(f"ratio {own / other:.3g}, largest difference {difference:.2g}")


if __name__ == "__main__":
    main()
