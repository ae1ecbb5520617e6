"""Print what each optimisation of kernels gains: it alone is switched off, and both forms are timed in turns.

    python tests/bench/optimisations.py [NAME ...]

A system is measured where the optimisation changes what is printed of it: W1 to W4, sizes for which optimisations were
made, and the robots' loop; of files (shipped, of the gallery, published, of other tools), and of a system for each
method, the median is printed. Numbers are times without the optimisation, in times with it: 1.3 or more is a gain.
"""

from __future__ import annotations

import gc
import os
import statistics
import sys
import tempfile
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from functools import cache, partial
from pathlib import Path
from time import thread_time
from typing import Any
from unittest.mock import patch

import numba
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

import fuzzyctl
from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.backends import numpy_backend
from fuzzyctl.kernels.backends.numba import source as numba_backend
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.program import scalar
from tests.bench import params
from tests.bench.trials import OPTIMISATIONS, SIZES, Optimisation, files
from tests.bench.workloads import WORKLOADS
from tests.frozen.systems import SYSTEMS

#: Points of a trial, seconds of a run, most points of one, and rounds.
FEW, SECONDS, MANY, ROUNDS = 200, 4e-3, 400_000, 9
#: Systems of the corpus that are measured, at most.
MOST_OF_CORPUS = 8
#: What is printed for each use.
TEXTS: Mapping[str, Callable[[Any], str]] = {
    "Python": lambda own: scalar.evaluation_source(own.interpreted),
    "loop": lambda own: numba_backend.evaluation_source(own.point),
    "batch": lambda own: numba_backend.batch_source(own.many),
    "numpy": lambda own: numpy_backend.block_source(own.arrays),
}
#: All columns: the uses, and what comes before them.
COLUMNS = (*TEXTS, "to callable", "compiling", "robots", "next value")
#: Evaluates some number of points.
Run = Callable[[int], Any]


@cache
def system_of(text: str) -> Any:
    """Return a system from `.fz` text, or from the name of one of a file."""
    return fuzzyctl.loads(text) if "\n" in text else files()[text]


@contextmanager
def switched_off(optimisation: Optimisation) -> Iterator[None]:
    """Switch an optimisation off."""
    with ExitStack() as stack:
        for owner, name, value in optimisation.patches:
            stack.enter_context(patch.object(owner, name, value))
        yield


def texts(text: str) -> dict[str, str]:
    """Return what is printed of a system, by use."""
    own = algorithm_of(plan(system_of(text)))
    return {use: write(own) for use, write in TEXTS.items()}


@contextmanager
def fresh_cache() -> Iterator[None]:
    """Compile anew: no machine code from before, in memory or on disk."""
    with tempfile.TemporaryDirectory() as folder, patch.dict(os.environ, FUZZYCTL_CACHE_DIR=folder):
        for name in [n for n in sys.modules if n.startswith("fuzzyctl_kernel_")]:
            del sys.modules[name]
        yield


def compiled(text: str, uses: Collection[str]) -> tuple[dict[str, Run], float]:
    """Return what runs a system, for some uses, and how long numba compiled [s]."""
    system = system_of(text)
    low, high = ([float(system.number(getattr(v, end))) for v in system.inputs] for end in ("lower", "upper"))
    points = np.random.default_rng(1).uniform(low, high, (MANY, len(low)))
    python = fuzzyctl.compile(system, "python")
    state = [python.start()] if python.n_states else []
    out = np.empty((MANY, len(python.output_names)))
    out = out[:, 0] if out.shape[1] == 1 else out
    runs: dict[str, Run] = {}
    seconds = 0.0
    if "Python" in uses:
        function, few, lists = python.jit, points[:20_000].tolist(), [s.tolist() for s in state]
        runs["Python"] = lambda count: [function(*p, *lists) for p in few[:count]]
        runs["to callable"] = lambda _: fuzzyctl.compile(system, "python").jit
    if "numpy" in uses:
        arrays = fuzzyctl.compile(system, "numpy")
        arrays.batch(points[:10], *state)
        runs["numpy"] = _filled(partial(arrays.batch, parallel=False), points, state, out)
    if {"loop", "batch"} & set(uses):
        kernel = fuzzyctl.compile(system, "numba")
        with fresh_cache():
            began = thread_time()
            native = kernel.jit
            kernel.batch(points[:10], *state, parallel=False)
            seconds = thread_time() - began
        loop = _loop(native, len(low), with_state=bool(state))
        loop(points[:10], *state)
        runs["loop"] = _filled(lambda p, *s, out: loop(p, *s), points, state, out)
        runs["batch"] = _filled(partial(kernel.batch, parallel=False), points, state, out)
    return runs, seconds


def _filled(function: Callable[..., Any], points: Any, state: list[Any], out: Any) -> Callable[[int], Any]:
    """Return what evaluates some of the points."""
    return lambda count: function(points[:count], *state, out=np.ascontiguousarray(out[:count]))


def _loop(function: Any, inputs: int, *, with_state: bool) -> Any:
    """Return a compiled loop over points."""
    values = ", ".join([*(f"points[k, {i}]" for i in range(inputs)), *(["C"] if with_state else [])])
    head = f"def loop(points{', C' if with_state else ''}):\n    last = f({values.replace('[k,', '[0,')})\n"
    body = f"{head}    for k in range(len(points)):\n        last = f({values})\n    return last\n"
    names: dict[str, Any] = {"f": function}
    exec(body, names)
    return numba.njit(names["loop"])


def ratios(pairs: Mapping[str, tuple[Run, Run]]) -> dict[str, float]:
    """Return how many times longer the second of two runs takes, the best of some rounds in turns."""
    best = {use: [float("inf")] * 2 for use in pairs}
    counts = {use: _count(runs[0]) for use, runs in pairs.items()}
    for _ in range(ROUNDS):
        for use, runs in pairs.items():
            for k, run in enumerate(runs):
                began = thread_time()
                run(counts[use])
                best[use][k] = min(best[use][k], thread_time() - began)
    return {use: off / on for use, (on, off) in best.items()}


#: The same with every optimisation.
with_all = cache(texts)


def changed_uses(optimisation: Optimisation, text: str) -> list[str]:
    """Return the uses whose printed text differs."""
    on = with_all(text)
    with switched_off(optimisation):
        off = texts(text)
    return [use for use in on if on[use] != off[use]]


def _count(run: Run) -> int:
    """Return how many points take long enough to be timed."""
    run(FEW)
    count = FEW
    while count < MANY:
        began = thread_time()
        run(count)
        if thread_time() - began > SECONDS / 2:
            break
        count *= 2
    return min(count, MANY)


def measured(optimisation: Optimisation, text: str) -> dict[str, float]:
    """Return ratios by column, of those that differ."""
    uses = changed_uses(optimisation, text)
    if not uses:
        return {}
    with_it, seconds = compiled(text, uses)
    with switched_off(optimisation):
        without, longer = compiled(text, uses)
    if "to callable" in without:
        without["to callable"] = partial(_off, optimisation, without["to callable"])
    found = ratios({use: (with_it[use], without[use]) for use in (*uses, "to callable") if use in without})
    return found | ({"compiling": longer / seconds} if seconds else {})


def _off(optimisation: Optimisation, run: Run, count: int) -> None:
    with switched_off(optimisation):
        run(count)


def robots(optimisation: Optimisation) -> dict[str, float]:
    """Return the ratio of the robots' loop."""
    from dwmr import Known, find, read, simulate

    def prepared() -> Run:
        file, known = read(find("paper")), Known(proved=True)
        simulate(file, known=known)
        return lambda _: simulate(file, known=known)

    with_it = prepared()
    with switched_off(optimisation):
        without = prepared()
    return ratios({"robots": (with_it, without)})


def next_value(optimisation: Optimisation) -> dict[str, float]:
    """Return the ratio of what one more value of a param takes to be a `kernel.value`."""
    file, name, values = params.SWEPT[0]
    text = (params.RULES / file).read_text(encoding="utf-8")
    texts = [params.with_param(text, name, value) for value in values]
    with fresh_cache():
        on = [params.seconds(own, "numba") for own in texts]
    with fresh_cache(), switched_off(optimisation):
        off = [params.seconds(own, "numba") for own in texts]
    return {"next value": min(off[1:]) / min(on[1:])}


def rows(optimisation: Optimisation) -> Iterator[tuple[str, dict[str, float]]]:
    """Yield the systems that an optimisation changes, with their ratios."""
    for name, text in [*((w.name, w.text) for w in WORKLOADS), *SIZES.items()]:
        found = measured(optimisation, text)
        if found:
            yield name, found
    uses: set[str] = set()
    for what, corpus in (("files", list(files())), ("methods", list(SYSTEMS.values()))):
        own = [text for text in corpus if changed_uses(optimisation, text)]
        uses.update(*(changed_uses(optimisation, text) for text in own))
        if own:
            changed = [measured(optimisation, text) for text in own[:: -(-len(own) // MOST_OF_CORPUS)]]
            medians = {
                c: statistics.median(f[c] for f in changed if c in f) for c in COLUMNS if any(c in f for f in changed)
            }
            yield f"{what}: {len(own)} of {len(corpus)}", medians
    if optimisation.name == "parameters":
        yield "fcafsmc.fz", next_value(optimisation)
    if optimisation.name == "parameters" or "loop" in uses:
        yield "robots' loop", robots(optimisation)


def main() -> None:
    """Measure and print a Markdown table."""
    wanted = sys.argv[1:]
    compiled(WORKLOADS[0].text, ["loop"])  # loads the compiler
    print(f"| optimisation | system | {' | '.join(COLUMNS)} |\n|---|---|{'---|' * len(COLUMNS)}")
    for optimisation in OPTIMISATIONS:
        if wanted and optimisation.name not in wanted:
            continue
        for name, found in rows(optimisation):
            cells = [f"{found[c]:.2f}" if c in found else "" for c in COLUMNS]
            print(f"| {optimisation.name} | {name} | {' | '.join(cells)} |", flush=True)
            gc.collect()


if __name__ == "__main__":
    main()
