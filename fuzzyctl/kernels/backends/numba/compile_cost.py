"""How long a compiler takes over a program: in proportion to the operations that its text names."""

from __future__ import annotations

from typing import Final

from fuzzyctl.expr import Logic, Where, walk
from fuzzyctl.kernels.program.printer import MOST_COUNTED
from fuzzyctl.kernels.program.program import (
    Accumulate,
    Between,
    Fold,
    Locate,
    Program,
    Quadrature,
    Refuse,
    Statement,
)
from fuzzyctl.kernels.program.traversal import expressions, parts, statements

#: More operations than this take numba longer than most programs run: it compiles about a thousand in a second, and as
#: many again for arrays.
MOST_OPERATIONS: Final = 20_000
#: More branches than this take numba longer, too: 120 about 10 seconds, 240 45, and more than about 300 none at all.
MOST_BRANCHES: Final = 100
#: Operations for each knot that is compared: it is read, compared and counted.
_COUNTED: Final = 12
#: Operations of a search among more knots, and of a loop that integrates.
_LOOP: Final = 200


def operations(program: Program) -> int:
    """Return how many operations a compiler sees in a program, one second for about a thousand with numba.

    Loops count once, however often they run; so do constant tables, which stand in memory.
    """
    return sum(map(_own, statements(program.body))) + sum(1 for value in program.results for _ in walk(value))


def branches(program: Program) -> int:
    """Return how many branches a compiler sees in a program."""
    choices = sum(isinstance(node, Where | Logic) for value in expressions(program) for node in walk(value))
    return choices + sum(isinstance(statement, Refuse) for statement in statements(program.body))


def _own(statement: Statement) -> int:
    """Return the operations of a statement without those of statements inside it."""
    if isinstance(statement, Locate):
        return _COUNTED * len(statement.knots) if len(statement.knots) <= MOST_COUNTED else _LOOP
    nodes = sum(1 for value in parts(statement).values for _ in walk(value))
    return nodes + (_LOOP if isinstance(statement, Accumulate | Fold | Between | Quadrature) else 0)
