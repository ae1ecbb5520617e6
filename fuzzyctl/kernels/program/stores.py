"""Lines that store results: those that are alike but for their positions in the state, such as a delay, are a loop."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Final

from fuzzyctl.expr import Expr, replace, walk
from fuzzyctl.kernels.program.printer import INDENT, Dialect, text
from fuzzyctl.kernels.program.program import STATE, Item, Place
from fuzzyctl.records import record

#: Fewest results of a loop.
LEAST_LOOP: Final = 4
#: Name of the counter of a loop.
COUNTER: Final = "place"


@record(frozen=True)
class Run:
    """Results one after the other, each that of the one before with the next numbers of the state.

    Args:
        first: Position of the first one.
        count: How many there are.
        value: The first one.
    """

    first: int
    count: int
    value: Expr

    @property
    def is_loop(self) -> bool:
        """Whether it is long enough for a loop."""
        return self.count >= LEAST_LOOP

    @property
    def is_shifted(self) -> bool:
        """Whether each next state is its own number of the state, or the one before, as in a delay."""
        return self.is_loop and all(item.index in (self.first, self.first - 1) for item in _items(self.value))

    def in_loop(self) -> Expr:
        """Return the value with positions that the counter of a loop moves."""
        return _moved(self.value, lambda index: Place(COUNTER, index))


def runs(results: Sequence[Expr]) -> list[Run]:
    """Return some results as runs, in order."""
    breaks = [
        k
        for k, (a, b) in enumerate(pairwise(results), start=1)
        if not (_items(b) and _moved(a, lambda index: index + 1) == b)
    ]
    ends = [0, *breaks, len(results)]
    long = [(a, b) for a, b in pairwise(ends) if b - a >= LEAST_LOOP]
    found: list[Run] = []
    place = 0
    for a, b in [*long, (len(results), len(results))]:
        found += [Run(k, 1, results[k]) for k in range(place, a)]
        found += [Run(a, b - a, results[a])] if b > a else []
        place = b
    return found


def store_lines(results: Sequence[Expr], dialect: Dialect, target: Callable[[str], str]) -> Iterator[str]:
    """Yield lines that store results.

    Args:
        results: What is stored; nothing of it reads what is stored before.
        dialect: For which target.
        target: Text of where a result goes, from the text of its position.
    """
    for run in runs(results):
        if run.is_loop:
            yield f"for {COUNTER} in range({run.count}):"
            yield f"{INDENT}{target(f'{COUNTER} + {run.first}')} = {text(run.in_loop(), dialect)}"
        else:
            yield f"{target(str(run.first))} = {text(run.value, dialect)}"


def _items(value: Expr) -> list[Item]:
    return [n for n in walk(value) if isinstance(n, Item) and n.array == STATE and isinstance(n.index, int)]


def _moved(value: Expr, change: Callable[[int], int | Place]) -> Expr:
    """Return a value that reads numbers of the state at other positions."""

    def moved(node: Expr) -> Expr:
        if isinstance(node, Item) and node.array == STATE and isinstance(node.index, int):
            return Item(STATE, change(node.index))
        return node

    return replace(value, moved)
