"""Shared parts of membership functions: names of parameters, arguments of formulas, and cores."""

from __future__ import annotations

import math
from typing import Final

from fuzzyctl.expr import Compare, CompareOp, Expr, Number, minus, plus
from fuzzyctl.formulas.formula import Cut, Parameters

#: Parameters of an edge, which rises from its start to its end.
EDGE: Final = ("start", "end")
TRAPEZOID: Final = ("left", "left_top", "right_top", "right")
#: Parameters that may be infinite, which makes a shoulder.
FEET: Final = frozenset({"left", "right"})


def scaled(x: Expr, origin: float, width: float) -> Expr:
    """Return (x - origin) / width."""
    return (x - origin) / width


def is_infinite(place: float) -> bool:
    """Return whether a parameter is infinite; one that is known only at run time is finite."""
    return abs(place) == math.inf


def square(x: Expr) -> Expr:
    """Return x², for an x that may be mentioned twice."""
    return x * x


def compare(op: CompareOp, x: Expr, place: float) -> Expr:
    """Compare x with a place."""
    return Compare(op, x, Number(place))


def first(p: Parameters) -> tuple[float, float]:
    """Return the first parameter as a core of one point."""
    return p[0], p[0]


def second(p: Parameters) -> tuple[float, float]:
    """Return the second parameter as a core of one point."""
    return p[1], p[1]


def tops(p: Parameters) -> tuple[float, float]:
    """Return the core of a trapezoid."""
    return p[1], p[2]


def around(left: float, before: Expr, right: float, after: Expr) -> Cut:
    """Return the alpha-cut from some distance before one place to some distance after another."""
    return minus(Number(left), before), plus(Number(right), after)


def one_sided(place: Expr, *, rises: bool) -> Cut:
    """Return the alpha-cut of a monotone function from where it has a degree."""
    return (place, Number(math.inf)) if rises else (Number(-math.inf), place)


def union(*ends: tuple[float, float]) -> tuple[float, float]:
    """Return the smallest interval that holds all others."""
    return min(e[0] for e in ends), max(e[1] for e in ends)
