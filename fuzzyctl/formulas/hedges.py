"""Every hedge, written once as an expression; operands may be mentioned several times, so callers pass names."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Number, Where
from fuzzyctl.formulas.norms import one_minus

Hedge = Callable[[Expr], Expr]


def _very(x: Expr) -> Expr:
    return x * x


def _somewhat(x: Expr) -> Expr:
    return Call("sqrt", (x,))


def _extremely(x: Expr) -> Expr:
    """Intensify the contrast: 2x² up to ½, 1 - 2(1 - x)² above."""
    rest = one_minus(x)
    top = 1.0 - 2.0 * (rest * rest)
    return Where(Compare("<=", x, Number(0.5)), 2.0 * (x * x), top)


def _seldom(x: Expr) -> Expr:
    """Undo `extremely`: √(x/2) up to ½, 1 - √((1 - x)/2) above."""
    half = Number(0.5)
    top = 1.0 - Call("sqrt", (half * one_minus(x),))
    return Where(Compare("<=", x, half), Call("sqrt", (half * x,)), top)


def _slightly(x: Expr) -> Expr:
    """Dilate more than `somewhat`: the cube root, 0 for 0."""
    return Where(Compare(">", x, ZERO), x ** (1.0 / 3.0), ZERO)


def _any(x: Expr) -> Expr:
    return ONE


def _cube(x: Expr) -> Expr:
    return x * (x * x)


#: Hedges by name; of several in a row the one nearest to the term applies first.
HEDGES: Final[dict[str, Hedge]] = {
    "very": _very,
    "somewhat": _somewhat,
    "extremely": _extremely,
    "slightly": _slightly,
    "seldom": _seldom,
    "any": _any,
    "not": one_minus,
}

#: What each hedge makes of a degree x, for the reference.
HEDGE_SUMMARIES: Final[dict[str, str]] = {
    "very": "x²",
    "somewhat": "√x",
    "extremely": "2x² for x ≤ ½, else 1 - 2(1 - x)²",
    "slightly": "x^(1/3)",
    "seldom": "√(x/2) for x ≤ ½, else 1 - √((1 - x)/2)",
    "any": "1",
    "not": "1 - x",
}


#: The hedges whose effect the inverse of another undoes, for semantics that undo them.
INVERSES: Final[dict[str, Hedge]] = {
    "very": _somewhat,
    "somewhat": _very,
    "extremely": _seldom,
    "seldom": _extremely,
    "slightly": _cube,
    "not": one_minus,
}


def hedge(name: str, *, cube: bool = False) -> Hedge:
    """Return a hedge; `cube` says that `extremely` is x³ rather than a contrast."""
    return _cube if cube and name == "extremely" else HEDGES[name]


def inverse_hedge(name: str, *, cube: bool = False) -> Hedge | None:
    """Return the inverse of a hedge, None where it has none."""
    return _slightly if cube and name == "extremely" else INVERSES.get(name)
