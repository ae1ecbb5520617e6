"""Jumps of sets that are integrated: the comparisons behind them, and how fast their places move.

A set jumps where a comparison of two continuous values changes between two places. By the implicit function theorem the
place x at which values differ by g(x, p) = 0 has the derivative -(∂g/∂p)/(∂g/∂x).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Number, Where, walk
from fuzzyctl.kernels.program.program import Quadrature
from fuzzyctl.kernels.program.traversal import parts, statements
from fuzzyctl.records import record

#: Between neighbouring places a continuous difference of degrees changes by less; one that jumps itself by more.
_NEAR: Final = Number(1e-6)
_UNKNOWN: Final = Number(math.inf)


@record(frozen=True)
class Crossing:
    """A comparison at one place, as atoms.

    Args:
        condition: The comparison.
        gap: By how much its sides differ.
        by_place: The derivative of the gap by the place.
        by_argument: The derivative of the gap by what is differentiated by.
    """

    condition: Compare
    gap: Expr
    by_place: Expr
    by_argument: Expr


def comparisons(whole: Quadrature) -> list[Compare]:
    """Return the comparisons at which a set may jump, each before those that read what depends on it.

    The choice of the smaller or the larger of two values is none.
    """
    values = [e for s in statements(whole.body) for e in parts(s).values]
    choices = [n for e in (*values, whole.value) for n in walk(e) if isinstance(n, Where) and not _is_extreme(n)]
    return list(dict.fromkeys(n for c in choices for n in walk(c.condition) if isinstance(n, Compare)))


def _is_extreme(choice: Where) -> bool:
    match choice.condition:
        case Compare(op=op, left=a, right=b) if op not in ("==", "!="):
            return {choice.then, choice.otherwise} == {a, b}
    return False


def speed(crossings: Sequence[tuple[Crossing, Crossing]], let: Callable[[Expr], Expr]) -> Expr:
    """Write how fast a jump between two places moves, see `program.Speed`.

    Args:
        crossings: Of each comparison that at the left and at the right place; the first that changes makes the jump,
            and may change others.
        let: Names a value.
    """
    found: Expr = ZERO
    for left, right in reversed(crossings):
        here, there = (let(Where(c.condition, ONE, ZERO)) for c in (left, right))
        # On one side of the jump the gap may be constant, as that of a degree that is held above 0.
        is_level = Compare("==", left.by_place, ZERO)
        by_place, by_argument = (
            let(Where(is_level, b, a))
            for a, b in ((left.by_place, right.by_place), (left.by_argument, right.by_argument))
        )
        apart = let(Call("abs", (let(left.gap - right.gap),)))
        moved = let(Where(Compare("<", apart, _NEAR), let(-let(by_argument / by_place)), _UNKNOWN))
        found = let(Where(Compare("!=", here, there), moved, found))
    return found
