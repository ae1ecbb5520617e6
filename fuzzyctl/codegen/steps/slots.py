"""State of a step as slots: one number each, or a delay line, which targets keep as a ring buffer."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from fuzzyctl.expr import Expr, Name, walk
from fuzzyctl.kernels.plan.equations import KeptState
from fuzzyctl.kernels.program.program import STATE, Item, Program
from fuzzyctl.kernels.program.traversal import expressions, map_expressions

#: Fewest numbers of a ring buffer; shorter chains of states are shifted.
LEAST_RING: Final = 4


@dataclass(frozen=True)
class Slot:
    """A part of the state.

    Args:
        name: That of its state, or of the delay.
        start: What it holds before the first step.
        length: The numbers that it holds; more than one for a delay line, whose oldest number is read.
    """

    name: str
    start: float
    length: int = 1


def with_slots(program: Program, states: Sequence[KeptState], outputs: int) -> tuple[Program, tuple[Slot, ...]]:
    """Return a step whose state is in slots, and the slots.

    Args:
        program: A step; its results are the outputs, then the next value of each state.
        states: The states, in order.
        outputs: Number of outputs.

    Returns:
        The program: its last arguments `s0`, `s1`, ... are what the slots give, its results the outputs, then what each
        slot takes.
    """
    runs = _runs(program, states, outputs)
    given = {run[-1]: Name(f"s{k}") for k, run in enumerate(runs)}

    def change(node: Expr) -> Expr:
        if isinstance(node, Item) and node.array == STATE:
            assert isinstance(node.index, int), "states are read one by one"
            return given[node.index]
        return node

    taken = tuple(program.results[outputs + run[0]] for run in runs)
    changed = map_expressions(replace(program, results=(*program.results[:outputs], *taken)), change)
    names = tuple(name.name for name in given.values())
    slots = tuple(Slot(_name(states[run[0]], len(run)), states[run[0]].start, len(run)) for run in runs)
    return replace(changed, arguments=(*program.arguments, *names), state=0), slots


def _runs(program: Program, states: Sequence[KeptState], outputs: int) -> list[range]:
    """Return the states of each slot: each on its own, or a chain in which each takes the value of the one before."""
    reads = Counter(n.index for e in expressions(program) for n in walk(e) if isinstance(n, Item) and n.array == STATE)

    def continues(k: int) -> bool:
        same = repr(states[k].start) == repr(states[k - 1].start)  # repr tells -0.0 from 0.0, and NaN is itself
        return same and reads[k - 1] == 1 and program.results[outputs + k] == Item(STATE, k - 1)

    chains: list[range] = []
    for k in range(len(states)):
        if chains and continues(k):
            chains[-1] = range(chains[-1].start, k + 1)
        else:
            chains.append(range(k, k + 1))
    return [r for c in chains for r in ([c] if len(c) >= LEAST_RING else [range(k, k + 1) for k in c])]


def _name(state: KeptState, length: int) -> str:
    return re.sub(r"\.0$", "", state.name) if length > 1 else state.name
