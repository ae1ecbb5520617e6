"""Compare the search for points without a firing rule with branch and bound over boxes, in verdicts and time.

    python tests/bench/coverage_methods.py

Of the kept systems, the shipped ones, 200 drawn ones and complete rule bases of many inputs.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from itertools import product
from math import inf
from pathlib import Path
from time import process_time

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from fuzzyctl import DiagnosticError, FuzzySystem, load, loads
from fuzzyctl.analysis.branch_and_bound.boxed_system import System
from fuzzyctl.analysis.branch_and_bound.queue import Search
from fuzzyctl.analysis.coverage.box_search import Hole
from fuzzyctl.analysis.coverage.coverage import uncovered_of
from fuzzyctl.kernels.plan.build import plan
from tests.frozen.systems import SYSTEMS
from tests.frozen.test_verdicts import DRAWN, drawn
from tests.shipped import SYSTEMS as SHIPPED

#: Degrees from which on a rule surely fires, as coverage takes it.
CERTAIN = 1e-200
#: Boxes after which branch and bound gives up.
MOST = 10_000
#: Inputs and terms of complete rule bases.
COMPLETE = ((2, 7), (3, 5), (4, 3), (6, 3), (8, 2), (10, 2))


def complete(inputs: int, terms: int) -> FuzzySystem:
    """Return a system with a rule for each combination of terms."""
    names = [f"t{k}" for k in range(terms)]
    variables = "".join(f"input x{k} in [0, 1]\n  terms {' '.join(names)}\n" for k in range(inputs))
    rules = "".join(
        f"if {' and '.join(f'x{k} is {t}' for k, t in enumerate(each))} then y is a\n"
        for each in product(names, repeat=inputs)
    )
    method = "and product\ndefuzzifier weighted_average\n"
    return loads(f"system complete\n{method}{variables}output y in [0, 1]\n  terms a=0 b=1\n{rules}")


def by_branch_and_bound(system: System, output: int) -> str:
    """Return what halving boxes shows of the largest activation of an output."""
    cells = system.cells([])
    if cells is None:
        return "undecided"
    search, looked = Search(system, *cells, inf, None), 0
    while search.lo.shape[1]:
        lo, hi = search.take()
        count = lo.shape[1]
        looked += count
        found = system.strength(list(system.inputs_of(lo, hi, sloped=False).values()), output)
        if (found.hi <= 0.0).any():
            return "hole"
        open_ = ~(np.broadcast_to(found.lo, count) >= CERTAIN)
        search.put_halves(lo[:, open_], hi[:, open_], np.zeros_like(lo[:, open_]))
        if search.stuck or looked > MOST:
            return "undecided"
    return "covered"


def compared(system: FuzzySystem) -> tuple[list[tuple[str, str]], float, float]:
    """Return the verdicts of both of each output, and the seconds that each took."""
    flat = plan(system)
    begun = process_time()
    verdicts = uncovered_of(flat).values()
    between = process_time()
    with np.errstate(all="ignore"):
        boxed = System(system, flat)
        others = [by_branch_and_bound(boxed, k) for k in range(len(flat.outputs))]
    seconds = between - begun, process_time() - between
    names = ["covered" if v is None else "hole" if isinstance(v, Hole) else "undecided" for v in verdicts]
    return list(zip(names, others, strict=True)), *seconds


def systems() -> Iterator[FuzzySystem]:
    """Yield the kept, shipped and drawn systems that can be read."""
    yield from map(load, SHIPPED)
    for text in (*SYSTEMS.values(), *map(drawn, DRAWN)):
        try:
            yield loads(text)
        except DiagnosticError:
            continue


def main() -> None:
    """Measure and print."""
    pairs: Counter[tuple[str, str]] = Counter()
    times = np.zeros(2)
    for system in systems():
        found, *seconds = compared(system)
        pairs.update(found)
        times += seconds
    print(f"search {times[0]:.1f} s, branch and bound {times[1]:.1f} s")
    for (one, other), count in sorted(pairs.items()):
        print(f"{count:4d} outputs: search {one}, branch and bound {other}")
    for inputs, terms in COMPLETE:
        ((pair,), *seconds) = compared(complete(inputs, terms))
        print(f"{inputs} inputs of {terms} terms: {pair[0]} in {seconds[0]:.3f} s, {pair[1]} in {seconds[1]:.3f} s")


if __name__ == "__main__":
    main()
