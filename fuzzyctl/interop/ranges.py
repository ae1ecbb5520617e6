"""Ranges of signals as numbers."""

from __future__ import annotations

import math
from typing import Any

from fuzzyctl.expr import evaluate
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.plant import Plant
from fuzzyctl.model.system import FuzzySystem


def range_of(block: FuzzySystem | Controller | Plant, signal: Any) -> tuple[float, float]:
    """Return the ends of the range of an input or output of a block; infinite where it has none."""
    if isinstance(block, FuzzySystem):
        return block.number(signal.lower), block.number(signal.upper)
    if signal.bounds is None:
        return -math.inf, math.inf
    values = block.param_values.values
    return evaluate(signal.bounds.lower, values), evaluate(signal.bounds.upper, values)
