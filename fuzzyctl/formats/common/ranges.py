"""Ranges of variables estimated from their terms if a file has none, and formulas that leave [0, 1] in a range."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Expr, ExprError, Number, evaluate
from fuzzyctl.formats.common.report import Reporter
from fuzzyctl.formulas.formula import between
from fuzzyctl.formulas.shared import union
from fuzzyctl.model.variable import Membership, Term

Ends = tuple[float, float]

#: Most points at which a function of the inputs is evaluated.
_MOST_POINTS: Final = 729

#: Steps from end to end of a range at which formulas are evaluated.
_STEPS: Final = 100

#: Rounding may bring a degree so far beyond [0, 1].
_SLACK: Final = 1e-12


def of_terms(supports: Iterable[Ends]) -> Ends | None:
    """Return the smallest range that holds all terms, None if there is none; a single place gets some room."""
    finite = [s for s in supports if all(map(math.isfinite, s))]
    if not finite:
        return None
    low, high = union(*finite)
    if low < high:
        return low, high
    room = max(1.0, abs(low) * 0.5)
    return low - room, high + room


def of_function(expression: Expr, inputs: Mapping[str, Ends], values: Mapping[str, float]) -> Ends | None:
    """Return the least and the largest value of a function at the ends and middles of its inputs."""
    places: list[tuple[float, ...]] = [(low, low / 2 + high / 2, high) for low, high in inputs.values()]
    while places and math.prod(map(len, places)) > _MOST_POINTS:
        widest = max(range(len(places)), key=lambda i: len(places[i]))
        places[widest] = places[widest][1:2]
    points = (dict(zip(inputs, point, strict=True)) for point in product(*places))
    results = tuple(y for point in points if (y := _value(expression, {**values, **point})) is not None)
    return between(results) if results else None


def _value(expression: Expr, names: Mapping[str, float]) -> float | None:
    """Return the value of a formula; None if it has none."""
    try:
        return evaluate(expression, names)
    except ExprError:
        return None


def linear_range(parameters: Sequence[float], inputs: Iterable[Ends]) -> Ends:
    """Return the least and largest value of a linear consequent.

    Args:
        parameters: A coefficient for each input, and the constant; a constant consequent has that alone.
        inputs: The ranges of the inputs.
    """
    *coefficients, low = parameters
    high = low
    for factor, (first, last) in zip(coefficients, inputs, strict=False):
        low += min(factor * first, factor * last)
        high += max(factor * first, factor * last)
    return low, high


def finite_range(
    name: str,
    ends: tuple[Number, Number],
    needed: Iterable[float],
    place: Span,
    findings: Reporter,
    kind: str = "infinite",
) -> tuple[Number, Number]:
    """Return a finite range: some ends, or the places needed in the direction of an infinite one, with a warning."""
    lower, upper = ends
    if math.isfinite(lower.value) and math.isfinite(upper.value):
        return lower, upper
    finite = [e for e in needed if math.isfinite(e)]
    low = lower.value if math.isfinite(lower.value) else min(finite, default=0.0)
    high = upper.value if math.isfinite(upper.value) else max(finite, default=1.0)
    if low >= high:
        low, high = (low, low + 1.0) if math.isfinite(lower.value) else (high - 1.0, high)
    message = f"the range of '{name}' is {kind}; [{low:.6g}, {high:.6g}] is what its terms need"
    findings.warning("FZ603", message, lower.span or place, help="give it a finite range")
    return Number(low), Number(high)


def corners(memberships: Iterable[Membership]) -> list[float]:
    """Return the numbers of some memberships, which lie about the places that matter."""
    return [a.value for m in memberships for a in m.arguments if isinstance(a, Number)]


def reached(membership: Membership, ranges: Sequence[Ends]) -> Ends:
    """Return the least and largest value of a constant or linear consequent over the ranges of the inputs."""
    parameters = corners([membership])
    if membership.kind not in ("constant", "linear") or not parameters:
        return math.inf, -math.inf
    return linear_range(parameters, ranges)


def warn_of_degrees_beyond(
    terms: Iterable[Term],
    variable: str,
    ends: Ends,
    findings: Reporter,
    *,
    below: bool = True,
    params: Mapping[str, float] | None = None,
) -> None:
    """Warn once of each term whose formula of the variable leaves [0, 1] in the range, as other tools allow.

    Args:
        terms: The terms of the variable.
        variable: Its name.
        ends: Its range; without a finite one there is no warning.
        findings: Takes the warnings.
        below: Whether degrees below 0 matter; they do not in the maximum of sets, which begins at 0.
        params: Values of the other names in the formulas.
    """
    low, high = ends
    if not math.isfinite(high - low):
        return
    places = [low + (high - low) * k / _STEPS for k in range(_STEPS + 1)]
    least = -_SLACK if below else -math.inf
    for term in terms:
        if term.membership.kind not in ("function", "formula"):
            continue
        formula = term.membership.arguments[0]
        degrees = ((x, _value(formula, {**(params or {}), variable: x})) for x in places)
        outside = [(max(-y, y - 1.0), x, y) for x, y in degrees if y is not None and not least <= y <= 1.0 + _SLACK]
        if outside:
            _, x, y = max(outside)
            message = f"the degree of '{term.name}' is {y:.6g} at {variable} = {x:.6g}, and held within [0, 1] here"
            help_text = "other tools go on with it as it is; scale the formula, or clip it there, too"
            findings.warning("FZ609", message, term.membership.span or term.span, help=help_text)
