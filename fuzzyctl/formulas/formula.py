"""Type of a membership function: everything known of a kind is a field of its entry; parts that several kinds share."""

from __future__ import annotations

import math
from collections.abc import Callable
from math import isfinite
from typing import Final, Literal

from fuzzyctl.expr import ONE, Compare, CompareOp, Expr, Number, minus, plus
from fuzzyctl.records import dataclass

#: A place x and the degree there.
Vertex = tuple[float, float]
#: Numbers of one term, in the order of its kind's `parameters`.
Parameters = tuple[float, ...]
#: Left and right end of an alpha-cut.
Cut = tuple[Expr, Expr]
#: A place around which a curved function changes, over which width, and how it decays there.
Scale = tuple[float, float, Literal["normal", "exponential", "power"]]


def _no_vertices(_: Parameters) -> tuple[Vertex, ...]:
    return ()


def _never(_w: Expr, _p: Parameters) -> Expr | None:
    return None


def _no_scales(_: Parameters) -> tuple[Scale, ...]:
    return ()


def between(p: Parameters) -> tuple[float, float]:
    """Return the ends of the finite ones of some places; 0 and 1 without any."""
    places = [x for x in p if isfinite(x)]
    return (min(places), max(places)) if places else (0.0, 1.0)


@dataclass(frozen=True)
class MembershipFormula:
    """Define one kind of membership function.

    Args:
        name: As rule files write it.
        parameters: Names of its parameters, in order; of a variadic one the names of the first group.
        summary: One line for the reference.
        degree: The degree of x as an expression, for given parameters; within [0, 1] for every x but NaN.
        mistake: Returns the mistake in parameters, or None.
        core: The interval where the degree is largest; averages take its middle (Eq. (18)). Where the largest
            degree stays up to infinity it is the finite end of that stretch, and infinite where the degree only tends
            to 1 (a sigmoid): such a term has no place in an average.
        vertices: Corners of a piecewise-linear function from left to right, an empty tuple for a curved one. Beyond
            the outer corners the degree stays as there. A corner given twice is a jump; the larger degree holds there.
        inverse: Where a monotone function has the degree w, an expression of w; None for parameters of a function that
            is not monotone. Where the function jumps it is the place of the jump, at a shoulder its finite end.
        infinite: Which parameters may be infinite: feet, and the means of one-sided Gaussians.
        variadic: Whether the group of parameters may be repeated.
        pieces: Points besides the corners of the core where the formula changes or bends.
        fuzzy: Whether it is a fuzzy set with an area.
        straight: Whether it is a fuzzy set with straight sides, given by its vertices.
        peaked: Whether it has one top in its middle, so that neighbouring terms have an order.
        continuous: Whether a curved function is continuous for all parameters.
        endless: Whether its degree changes up to infinity on one side at least.
        cut: The alpha-cut of a degree above 0, an interval with infinite ends where it has none; None if
            it is unknown for the parameters. The field is None if the kind has no closed form.
        scales: Where and how a curved function decays, for the subdivision of integrals.
        extent: The interval that is taken for its support where a file gives no range, as jFuzzyLogic does.
    """

    name: str
    parameters: tuple[str, ...]
    summary: str
    degree: Callable[[Expr, Parameters], Expr]
    mistake: Callable[[Parameters], str | None]
    core: Callable[[Parameters], tuple[float, float]]
    vertices: Callable[[Parameters], tuple[Vertex, ...]] = _no_vertices
    inverse: Callable[[Expr, Parameters], Expr | None] = _never
    infinite: frozenset[str] = frozenset()
    variadic: bool = False
    pieces: Callable[[Parameters], tuple[float, ...]] = lambda p: p
    fuzzy: bool = True
    straight: bool = False
    peaked: bool = False
    continuous: bool = False
    endless: bool = False
    cut: Callable[[Expr, Parameters], Cut | None] | None = None
    scales: Callable[[Parameters], tuple[Scale, ...]] = _no_scales
    extent: Callable[[Parameters], tuple[float, float]] = between

    def monotone(self, p: Parameters) -> bool:
        """Return whether the function with these parameters is monotone, so that `tsukamoto` can invert it."""
        return self.inverse(ONE, p) is not None


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


#: Returns the mistake in parameters, or None.
Check = Callable[[Parameters], str | None]


def ordered(names: tuple[str, ...]) -> Check:
    """Check that parameters do not decrease."""

    def mistake(p: Parameters) -> str | None:
        for i in range(len(p) - 1):
            if not p[i] <= p[i + 1]:
                return f"{names[i]} = {p[i]:.6g} is greater than {names[i + 1]} = {p[i + 1]:.6g}"
        return None

    return mistake


def rising(names: tuple[str, str]) -> Check:
    """Check that the first parameter is less than the second."""

    def mistake(p: Parameters) -> str | None:
        return None if p[0] < p[1] else f"{names[0]} = {p[0]:.6g} must be less than {names[1]} = {p[1]:.6g}"

    return mistake


def different(names: tuple[str, str]) -> Check:
    """Check that two parameters differ."""

    def mistake(p: Parameters) -> str | None:
        return None if p[0] != p[1] else f"{names[0]} and {names[1]} are both {p[0]:.6g}"

    return mistake


def positive(**places: int) -> Check:
    """Check that the parameters at some places are above 0; not so NaN."""

    def mistake(p: Parameters) -> str | None:
        return next((f"{name} = {p[i]:.6g} must be > 0" for name, i in places.items() if not p[i] > 0), None)

    return mistake


def not_zero(**places: int) -> Check:
    """Check that the parameters at some places differ from 0."""

    def mistake(p: Parameters) -> str | None:
        return next((f"{name} must not be 0" for name, i in places.items() if p[i] == 0), None)

    return mistake
