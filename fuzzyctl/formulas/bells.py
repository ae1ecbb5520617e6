"""Bell-shaped membership functions: Gaussians of one width or of two, and the generalized bell."""

from __future__ import annotations

import math
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Number, Where, minus, times
from fuzzyctl.formulas.formula import (
    Cut,
    MembershipFormula,
    Parameters,
    around,
    first,
    is_infinite,
    positive,
    scaled,
    square,
)

#: Deviations at which a Gaussian ends where a file gives no range, and the odds at which a bell does.
_DEVIATIONS: Final = 4.0
_ODDS: Final = 999.0


def _gaussian_degree(x: Expr, p: Parameters) -> Expr:
    """Compute exp(-z²/2) with z = (x - mean) / sigma; a product, since a general power is slower and less exact.

    The division is done beforehand where all numbers, of 32 bits too, can hold what that takes.
    """
    mean, sigma = p
    if 1e-15 < sigma < 1e15:
        return Call("exp", (-0.5 / sigma**2 * square(x - mean),))
    return Call("exp", (-0.5 * square(scaled(x, mean, sigma)),))


def _gaussian2_degree(x: Expr, p: Parameters) -> Expr:
    left = Where(Compare("<", x, Number(p[0])), _gaussian_degree(x, p[:2]), ONE)
    right = Where(Compare(">", x, Number(p[2])), _gaussian_degree(x, p[2:]), ONE)
    if is_infinite(p[0]):
        return right
    return left if is_infinite(p[2]) else left * right


def _gaussian2_inverse(w: Expr, p: Parameters) -> Expr | None:
    """Invert the one side that is left where the other mean is infinite; the degree 0 lies infinitely far away."""
    mean_left, sigma_left, mean_right, sigma_right = p
    if is_infinite(mean_left) == is_infinite(mean_right):
        return None
    odds = Where(Compare(">", w, ZERO), 1.0 / w, Number(math.inf))
    away = Call("sqrt", (2.0 * Call("max", (ZERO, Call("log", (odds,)))),))
    if is_infinite(mean_right):
        return mean_left - sigma_left * away
    return mean_right + sigma_right * away


def _gaussian2_mistake(p: Parameters) -> str | None:
    if p[0] == math.inf or p[2] == -math.inf:
        return "an infinite mean_left is -inf, an infinite mean_right inf"
    if is_infinite(p[0]) and is_infinite(p[2]):
        return "mean_left and mean_right are both infinite"
    return positive(sigma_left=1, sigma_right=3)(p)


def _gaussian2_core(p: Parameters) -> tuple[float, float]:
    """Return the stretch between the means; if they cross, the place of the largest product."""
    mean_left, sigma_left, mean_right, sigma_right = p
    if is_infinite(mean_left):
        return mean_right, mean_right
    if is_infinite(mean_right):
        return mean_left, mean_left
    if mean_left <= mean_right:
        return mean_left, mean_right
    ratio = (sigma_right / sigma_left) ** 2
    peak = mean_right + (mean_left - mean_right) * (ratio / (1.0 + ratio))
    return peak, peak


def _bell_degree(x: Expr, p: Parameters) -> Expr:
    distance = Call("abs", (scaled(x, p[0], p[1]),))
    return 1.0 / (1.0 + distance ** (2.0 * p[2]))


def _spread(sigma: float, degree: Expr) -> Expr:
    return times(Number(sigma), Call("sqrt", (times(Number(-2.0), Call("log", (degree,))),)))


def _gaussian_cut(degree: Expr, p: Parameters) -> Cut:
    return around(p[0], _spread(p[1], degree), p[0], _spread(p[1], degree))


def _gaussian2_cut(degree: Expr, p: Parameters) -> Cut | None:
    return around(p[0], _spread(p[1], degree), p[2], _spread(p[3], degree)) if p[0] <= p[2] else None


def _bell_cut(degree: Expr, p: Parameters) -> Cut:
    reach = times(Number(p[1]), (minus(ONE, degree) / degree) ** (0.5 / p[2]))
    return around(p[0], reach, p[0], reach)


def _bell_extent(p: Parameters) -> tuple[float, float]:
    try:
        reach = _ODDS ** (1.0 / (2.0 * p[2])) * abs(p[1])
    except (ZeroDivisionError, OverflowError):
        reach = abs(p[1])
    return p[0] - reach, p[0] + reach


BELLS: Final[tuple[MembershipFormula, ...]] = (
    MembershipFormula(
        name="gaussian",
        parameters=("mean", "sigma"),
        summary="exp(-((x - mean) / sigma)² / 2)",
        degree=_gaussian_degree,
        mistake=positive(sigma=1),
        core=first,
        pieces=lambda p: p[:1],
        peaked=True,
        continuous=True,
        endless=True,
        cut=_gaussian_cut,
        scales=lambda p: ((p[0], p[1], "normal"),),
        extent=lambda p: (p[0] - _DEVIATIONS * p[1], p[0] + _DEVIATIONS * p[1]),
    ),
    MembershipFormula(
        name="gaussian2",
        parameters=("mean_left", "sigma_left", "mean_right", "sigma_right"),
        summary="a Gaussian left of mean_left times a Gaussian right of mean_right; 1 between them; an infinite "
        "mean makes a shoulder",
        degree=_gaussian2_degree,
        mistake=_gaussian2_mistake,
        core=_gaussian2_core,
        inverse=_gaussian2_inverse,
        infinite=frozenset({"mean_left", "mean_right"}),
        pieces=lambda p: (p[0], p[2]),
        continuous=True,
        endless=True,
        cut=_gaussian2_cut,
        scales=lambda p: ((p[0], p[1], "normal"), (p[2], p[3], "normal")),
        extent=lambda p: (p[0] - _DEVIATIONS * p[1], p[2] + _DEVIATIONS * p[3]),
    ),
    MembershipFormula(
        name="bell",
        parameters=("center", "width", "slope"),
        summary="1 / (1 + |(x - center) / width|^(2 slope))",
        degree=_bell_degree,
        mistake=positive(width=1, slope=2),
        core=first,
        pieces=lambda p: p[:1],
        peaked=True,
        continuous=True,
        endless=True,
        cut=_bell_cut,
        scales=lambda p: ((p[0], p[1], "power"),),
        extent=_bell_extent,
    ),
)
