"""Every membership function, norm and implication, each written once as an expression.

`kernels` prints these expressions for numpy, numba and plain Python; analysis reads the same ones.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Binary, Call, Compare, Expr, Number, Where

Vertex = tuple[float, float]


@dataclass(frozen=True)
class MembershipFormula:
    """Define one kind of membership function.

    Args:
        name: As rule files write it.
        parameters: Names of its parameters, in order.
        infinite: Which of them may be infinite (feet only, rulings of the language).
        degree: The degree of x as an expression, for given parameters.
        mistake: What is wrong with given parameters, or None.
        core: The interval of degree 1; its middle is what `center_average` takes.
        vertices: Corners of a piecewise-linear function from left to right, an empty tuple for a curved one. Beyond
            the outer corners the degree stays as there. A corner given twice is a jump; the larger degree holds there.
        summary: One line for the reference.
    """

    name: str
    parameters: tuple[str, ...]
    infinite: frozenset[str]
    degree: Callable[[Expr, tuple[float, ...]], Expr]
    mistake: Callable[[tuple[float, ...]], str | None]
    core: Callable[[tuple[float, ...]], tuple[float, float]]
    vertices: Callable[[tuple[float, ...]], tuple[Vertex, ...]]
    summary: str


def _trapezoid_degree(x: Expr, p: tuple[float, ...]) -> Expr:
    """Rise from left foot to left top, stay at 1, fall from right top to right foot; an infinite foot is a shoulder."""
    left, left_top, right_top, right = p
    expr: Expr = ONE
    if right < math.inf:
        fall: Expr = ZERO
        if right > right_top:
            slope = Binary("/", Binary("-", Number(right), x), Number(right - right_top))
            fall = Where(Compare("<", x, Number(right)), slope, ZERO)
        expr = Where(Compare("<=", x, Number(right_top)), expr, fall)
    if left > -math.inf:
        rise: Expr = ZERO
        if left < left_top:
            slope = Binary("/", Binary("-", x, Number(left)), Number(left_top - left))
            rise = Where(Compare(">", x, Number(left)), slope, ZERO)
        expr = Where(Compare(">=", x, Number(left_top)), expr, rise)
    return expr


def _trapezoid_vertices(p: tuple[float, ...]) -> tuple[Vertex, ...]:
    left, left_top, right_top, right = p
    corners: list[Vertex] = []
    if left > -math.inf:
        corners.append((left, 0.0))
    corners.append((left_top, 1.0))
    if right_top > left_top:
        corners.append((right_top, 1.0))
    if right < math.inf:
        corners.append((right, 0.0))
    return tuple(corners)


def _as_trapezoid(p: tuple[float, ...]) -> tuple[float, ...]:
    left, peak, right = p
    return (left, peak, peak, right)


def _ordered(names: tuple[str, ...]) -> Callable[[tuple[float, ...]], str | None]:
    def mistake(p: tuple[float, ...]) -> str | None:
        for i in range(len(p) - 1):
            if not p[i] <= p[i + 1]:
                return f"{names[i]} = {p[i]:.6g} is greater than {names[i + 1]} = {p[i + 1]:.6g}"
        return None

    return mistake


def _gaussian_degree(x: Expr, p: tuple[float, ...]) -> Expr:
    """Compute exp(-z²/2) with z = (x - mean) / sigma; a product, since a general power is slower and less exact."""
    z = Binary("/", Binary("-", x, Number(p[0])), Number(p[1]))
    return Call("exp", (Binary("*", Number(-0.5), Binary("*", z, z)),))


def _singleton_degree(x: Expr, p: tuple[float, ...]) -> Expr:
    return Where(Compare("==", x, Number(p[0])), ONE, ZERO)


_TRIANGLE: Final = ("left", "peak", "right")
_TRAPEZOID: Final = ("left", "left_top", "right_top", "right")

#: The kinds of membership functions a rule file may use.
MEMBERSHIP: Final[dict[str, MembershipFormula]] = {
    f.name: f
    for f in (
        MembershipFormula(
            "triangle",
            _TRIANGLE,
            frozenset({"left", "right"}),
            lambda x, p: _trapezoid_degree(x, _as_trapezoid(p)),
            _ordered(_TRIANGLE),
            lambda p: (p[1], p[1]),
            lambda p: _trapezoid_vertices(_as_trapezoid(p)),
            "0 at the feet, 1 at the peak; an infinite foot makes a shoulder",
        ),
        MembershipFormula(
            "trapezoid",
            _TRAPEZOID,
            frozenset({"left", "right"}),
            _trapezoid_degree,
            _ordered(_TRAPEZOID),
            lambda p: (p[1], p[2]),
            _trapezoid_vertices,
            "0 at the feet, 1 between the tops; an infinite foot makes a shoulder",
        ),
        MembershipFormula(
            "gaussian",
            ("mean", "sigma"),
            frozenset(),
            _gaussian_degree,
            lambda p: None if p[1] > 0 else f"sigma = {p[1]:.6g} must be > 0",
            lambda p: (p[0], p[0]),
            lambda p: (),
            "exp(-((x - mean) / sigma)² / 2)",
        ),
        MembershipFormula(
            "singleton",
            ("value",),
            frozenset(),
            _singleton_degree,
            lambda p: None,
            lambda p: (p[0], p[0]),
            lambda p: ((p[0], 0.0), (p[0], 1.0), (p[0], 0.0)),
            "1 at the value, 0 elsewhere",
        ),
    )
}


def one_minus(a: Expr) -> Expr:
    """Complement of a degree: the truth of `not`."""
    return Binary("-", ONE, a)


def _minimum(a: Expr, b: Expr) -> Expr:
    return Call("min", (a, b))


def _maximum(a: Expr, b: Expr) -> Expr:
    return Call("max", (a, b))


def _product(a: Expr, b: Expr) -> Expr:
    return Binary("*", a, b)


def _probabilistic_sum(a: Expr, b: Expr) -> Expr:
    """Compute a + b - ab as a + b(1 - a), which stays within [0, 1] in floating point."""
    return Binary("+", a, Binary("*", b, one_minus(a)))


def _bounded_difference(a: Expr, b: Expr) -> Expr:
    """Compute a + b - 1 as a - (1 - b), which is exactly a for b = 1."""
    return Call("max", (ZERO, Binary("-", a, one_minus(b))))


def _bounded_sum(a: Expr, b: Expr) -> Expr:
    return Call("min", (ONE, Binary("+", a, b)))


Norm = Callable[[Expr, Expr], Expr]

#: Triangular norms: what `and` may name.
CONJUNCTIONS: Final[dict[str, Norm]] = {
    "min": _minimum,
    "product": _product,
    "bounded_difference": _bounded_difference,
}

#: Triangular conorms: what `or` may name.
DISJUNCTIONS: Final[dict[str, Norm]] = {
    "max": _maximum,
    "probabilistic_sum": _probabilistic_sum,
    "bounded_sum": _bounded_sum,
}

#: How an activation cuts or scales a consequent set.
IMPLICATIONS: Final = ("min", "product")

#: How the implied sets of all rules are joined.
AGGREGATIONS: Final = ("max", "sum")
