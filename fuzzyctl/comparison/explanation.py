"""Which setting makes two systems differ at a point: settings of the second are put into the first, one by one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from fuzzyctl.comparison.differences import Difference, at_point, pairing
from fuzzyctl.comparison.parts import Part, fallbacks, parts
from fuzzyctl.errors import FuzzyctlError
from fuzzyctl.expr import ExprError
from fuzzyctl.model.system import FuzzySystem

#: What is left of a difference counts as nothing below this part of it: rounding of two ways to compute.
NOTHING: Final = 1e-9


@dataclass(frozen=True)
class Cause:
    """A setting that both systems have in different ways.

    Args:
        name: The setting, or what else it is, such as `terms of food`.
        before: How the first system has it.
        after: How the second one does.
        explains: Part of the difference that is gone once the first system has it as the second does, after the causes
            before it in the list; may be negative where two causes work against each other.
    """

    name: str
    before: str
    after: str
    explains: float


def causes(a: FuzzySystem, b: FuzzySystem, difference: Difference) -> tuple[Cause, ...]:
    """Explain a difference: settings of the second system are put into the first, each time the one that helps most.

    Args:
        a: The first system.
        b: The second one.
        difference: What `differences` found for one output.

    Returns:
        Causes, the largest first, until the difference is gone; nothing where there is none or one system has no value.
    """
    inputs, outputs = pairing(a, b)
    output = [o.name for o in a.outputs].index(difference.output)
    point = [difference.point[v.name] for v in a.inputs]
    target, start = difference.second, difference.first
    if difference.largest == 0.0:
        return ()
    if not math.isfinite(target) or not math.isfinite(start):
        return tuple(Cause(p.name, p.before, p.after, 1.0) for p in fallbacks(a, b, output, outputs[output]))
    found: list[Cause] = []
    left, current, value = list(parts(a, b, inputs, outputs)), a, start
    while left and abs(value - target) > NOTHING * difference.largest:
        tried = [(part, *_with(current, part, point, output)) for part in left]
        working = [
            (part.last, abs(v - target), k)
            for k, (part, s, v) in enumerate(tried)
            if s is not None and v != value and not math.isnan(v)
        ]
        if not working:
            break  # what is left takes several parts at once
        *_, best = min(working)
        part, system, new = tried[best]
        assert system is not None
        share = (abs(value - target) - abs(new - target)) / difference.largest
        found.append(Cause(part.name, part.before, part.after, share))
        left.remove(part)
        current, value = system, new
    return tuple(found)


def _with(system: FuzzySystem, part: Part, point: Sequence[float], output: int) -> tuple[FuzzySystem | None, float]:
    """Return the system with one part of the other and its value; None where the part does not go without others."""
    try:
        changed = part.put(system)
        return changed, at_point(changed, point, output)
    except (FuzzyctlError, ExprError):
        return None, math.nan
