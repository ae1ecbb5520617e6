"""How long a compiler takes over a program: in proportion to the operations that its text names."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from fuzzyctl.expr import Expr, walk
from fuzzyctl.kernels.program.printer import MOST_COUNTED
from fuzzyctl.kernels.program.program import (
    Accumulate,
    Assign,
    Between,
    Fold,
    Locate,
    Program,
    Quadrature,
    Refuse,
    Statement,
)

#: More operations than this take numba longer than most programs run: it compiles about a thousand in a second, and as
#: many again for arrays.
MOST_OPERATIONS: Final = 20_000
#: Operations for each knot that is compared: it is read, compared and counted.
_COUNTED: Final = 12
#: Operations of a search among more knots, and of a loop that integrates.
_LOOP: Final = 200


def operations(program: Program) -> int:
    """Return how many operations a compiler sees in a program, one second for about a thousand with numba.

    Loops count once, however often they run; so do constant tables, which stand in memory.
    """
    return sum(map(_of, program.body)) + _nodes(program.results)


def _of(statement: Statement) -> int:
    match statement:
        case Assign(value=value) | Refuse(condition=value):
            return _nodes([value])
        case Locate(knots=knots):
            return _COUNTED * len(knots) if len(knots) <= MOST_COUNTED else _LOOP
        case Accumulate(body=body, sums=sums):
            return _LOOP + sum(map(_of, (*body, *sums)))
        case Fold(first=first, body=body, then=then):
            return _LOOP + sum(map(_of, (*first, *body, *then)))
        case Between(share=share, body=body, value=value):
            return _LOOP + sum(map(_of, body)) + _nodes([share, value])
        case Quadrature(body=body, value=value, marks=marks):
            return _LOOP + sum(map(_of, body)) + _nodes([value, *marks])
    return 1


def _nodes(values: Iterable[Expr]) -> int:
    return sum(1 for value in values for _ in walk(value))
