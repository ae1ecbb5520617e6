"""Every hedge, written once as an expression; operands may be mentioned several times, so callers pass names."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Number, Where
from fuzzyctl.formulas.norms import one_minus
from fuzzyctl.records import dataclass

#: The degree that a hedge makes of a degree.
Change = Callable[[Expr], Expr]


@dataclass(frozen=True)
class HedgeFormula:
    """Define a hedge.

    Args:
        change: The changed degree as an expression of a degree.
        summary: The same as a line for the reference, of a degree x.
        inverse: The change that undoes it, for semantics that undo hedges, or None.
    """

    change: Change
    summary: str
    inverse: Change | None = None

    def __call__(self, x: Expr) -> Expr:
        """Change a degree."""
        return self.change(x)


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
HEDGES: Final[dict[str, HedgeFormula]] = {
    "very": HedgeFormula(_very, "x²", inverse=_somewhat),
    "somewhat": HedgeFormula(_somewhat, "√x", inverse=_very),
    "extremely": HedgeFormula(_extremely, "2x² for x ≤ ½, else 1 - 2(1 - x)²", inverse=_seldom),
    "slightly": HedgeFormula(_slightly, "x^(1/3)", inverse=_cube),
    "seldom": HedgeFormula(_seldom, "√(x/2) for x ≤ ½, else 1 - √((1 - x)/2)", inverse=_extremely),
    "any": HedgeFormula(_any, "1"),
    "not": HedgeFormula(one_minus, "1 - x", inverse=one_minus),
}


def hedge(name: str, *, cube: bool = False) -> Change:
    """Return a hedge; `cube` says that `extremely` is x³ rather than a contrast."""
    return _cube if cube and name == "extremely" else HEDGES[name]


def inverse_hedge(name: str, *, cube: bool = False) -> Change | None:
    """Return the inverse of a hedge, None if it has no inverse or is unknown."""
    if cube and name == "extremely":
        return _slightly
    return HEDGES[name].inverse if name in HEDGES else None
