"""Comparisons that make a set that is integrated jump."""

from __future__ import annotations

from fuzzyctl.expr import Compare, Where, walk
from fuzzyctl.kernels.program.program import Quadrature
from fuzzyctl.kernels.program.traversal import parts, statements


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
