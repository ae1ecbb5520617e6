"""Lowering of comparisons and roundings to the primitives that all targets have."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from fuzzyctl.expr import COMPARISONS, ONE, ZERO, Call, Compare, Expr, Logic, Number, Where

_HALF: Final = Number(0.5)


def step(function: str, arguments: Sequence[Expr], let: Callable[[Expr], Expr]) -> Expr:
    """Return a function of `expr.SOFT` as a choice over `floor` and `fmod`.

    Args:
        function: Its name.
        arguments: What it is applied to.
        let: Names a value, so that it is computed once.
    """
    a, *others = (let(x) for x in arguments)
    match function, others:
        case "ceil", []:
            return -Call("floor", (-a,))
        case "round", []:
            return _rounded(a, let)
        case "mod", [b]:
            rest = let(Call("fmod", (a, b)))
            below = Logic("and", (Compare("<", rest, ZERO), Compare(">", b, ZERO)))
            above = Logic("and", (Compare(">", rest, ZERO), Compare("<", b, ZERO)))
            return Where(Logic("or", (below, above)), rest + b, rest)
        case "ne", [b]:  # without "!=", which some targets cannot tell from a test for NaN
            return Where(Compare("==", a, b), ZERO, ONE)
        case _, [b] if function in COMPARISONS:
            return Where(Compare(COMPARISONS[function], a, b), ONE, ZERO)
    return Call(function, (a, *others))


def _rounded(x: Expr, let: Callable[[Expr], Expr]) -> Expr:
    """Return the nearest whole number; halfway between two the even one, which is twice another."""
    below = let(Call("floor", (x,)))
    rest = let(x - below)
    half = let(_HALF * below)
    ties = Logic("and", (Compare("==", rest, _HALF), Compare("==", Call("floor", (half,)), half)))
    stays = Logic("or", (Compare("<", rest, _HALF), ties))
    # Where there is nothing beyond a whole number, it is that one, or x is infinite or NaN.
    up = Where(Compare(">", rest, ZERO), below + 1.0, below)
    return Where(Logic("and", (Compare(">", rest, ZERO), stays)), below, up)
