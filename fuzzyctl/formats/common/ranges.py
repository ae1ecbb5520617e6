"""Ranges of variables estimated from their terms, where the file gives none; those of sets as jFuzzyLogic does."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Final

from fuzzyctl.expr import Expr, ExprError, evaluate
from fuzzyctl.formulas.formula import between
from fuzzyctl.formulas.shared import union

Ends = tuple[float, float]

#: Most points at which a function of the inputs is evaluated.
_MOST_POINTS: Final = 729


def of_terms(supports: Iterable[Ends]) -> Ends | None:
    """Return the smallest range that holds all terms, None where there is none; a single place gets some room."""
    found = [s for s in supports if all(map(math.isfinite, s))]
    if not found:
        return None
    low, high = union(*found)
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
    found: list[float] = []
    for point in product(*places):
        try:
            found.append(evaluate(expression, {**values, **dict(zip(inputs, point, strict=True))}))
        except ExprError:
            continue
    return between(tuple(found)) if found else None


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
