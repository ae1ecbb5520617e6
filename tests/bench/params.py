"""Print what a sweep over a param of a rule file costs for each value: read, plan, compile, evaluate once.

python tests/bench/params.py
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).parents[2]))

import fuzzyctl
from tests.bench.workloads import RULES

#: Rule files, a param of each, and values of it.
SWEPT = (("fcafsmc.fz", "half_width", (0.35, 0.36, 0.37, 0.38, 0.39)), ("fcafsmc.fz", "gamma", (2, 3, 4, 5, 6)))


def with_param(text: str, name: str, value: float) -> str:
    """Return a rule file with another value of a param."""
    changed, count = re.subn(rf"(?m)^(param\s+{name}\s*=)[^#\n]*", rf"\g<1> {value!r} ", text)
    assert count == 1, f"no param {name}"
    return changed


def seconds(text: str, backend: str) -> float:
    """Return how long it takes from a text to its first number, with numba to what compiled loops are given."""
    began = perf_counter()
    kernel = fuzzyctl.compile(fuzzyctl.loads(text), backend)
    if backend == "numba":
        assert kernel.value is not None
        return perf_counter() - began
    state = [list(kernel.plan.initial_state)] if kernel.n_states else []
    kernel(*[0.01] * len(kernel.input_names), *state)
    return perf_counter() - began


def main() -> None:
    """Measure and print; what is compiled goes to a folder of its own, so that nothing comes from a cache."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["FUZZYCTL_CACHE_DIR"] = folder
        for file, name, values in SWEPT:
            text = (RULES / file).read_text(encoding="utf-8")
            for backend in ("python", "numba"):
                seconds(text, backend)  # loads the compiler
                best = min(seconds(with_param(text, name, v), backend) for v in values)
                print(f"{file}, {name}: {best * 1e3:8.1f} ms a value with {backend}")


if __name__ == "__main__":
    main()
