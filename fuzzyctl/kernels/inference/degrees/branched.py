"""Degrees of all terms of a variable by a branch on its interval: in a partition all but two are 0."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from fuzzyctl.expr import Compare, Expr, Number, Where, replace
from fuzzyctl.kernels.plan.build import SetPlan
from fuzzyctl.kernels.program.program import Branches


def branched(names: tuple[str, ...], x: Expr, sets: Sequence[SetPlan]) -> Branches:
    """Return the degrees of some triangles and trapezoids without jumps.

    At a corner the lines on both sides of it have the same value, exactly, so that it does not matter which one counts.

    Args:
        names: One for each set.
        x: An atom.
        sets: Sets that have sides.
    """
    cuts = tuple(sorted({corner for s in sets for corner, _ in s.vertices}))
    stretches = pairwise((-math.inf, *cuts, math.inf))
    values = tuple(tuple(_within(s.degree(x), x, low, high) for s in sets) for low, high in stretches)
    return Branches(names, x, cuts, values)


def _within(degree: Expr, x: Expr, low: float, high: float) -> Expr:
    """Return a degree where x lies strictly between two numbers."""

    def change(node: Expr) -> Expr:
        match node:
            case Where(condition=Compare(op=op, left=left, right=Number(value=bound))) if left == x:
                if bound <= low or bound >= high:
                    return node.then if (bound <= low) == (op in (">", ">=")) else node.otherwise
        return node

    return replace(degree, change)
