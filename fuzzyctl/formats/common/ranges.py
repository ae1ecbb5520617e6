"""Ranges of consequents that are functions of the inputs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def linear_range(parameters: Sequence[float], inputs: Iterable[tuple[float, float]]) -> tuple[float, float]:
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
