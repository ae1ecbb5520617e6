"""Bounds of the outputs and states of a controller over every reachable step."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from fuzzyctl.analysis.bounds import OutputBound
from fuzzyctl.analysis.branch_and_bound.minimum import least
from fuzzyctl.analysis.induction.boxed_step import BoxedStep
from fuzzyctl.analysis.induction.prover import ControllerProver
from fuzzyctl.analysis.induction.replay import Judge
from fuzzyctl.analysis.induction.step_model import FAR
from fuzzyctl.analysis.work import SECOND, Work
from fuzzyctl.expr import Name
from fuzzyctl.model.controller import Controller

#: How near a bound should come to a value that is attained, as a part of what a first look leaves open.
_GAP: Final = 0.002
#: Another magnitude up to which numbers without an end are taken: an end that it moves by a larger part is none.
_NEARER: Final = 1e24
_SAME: Final = 0.05


def controller_bounds(controller: Controller, timeout: float) -> dict[str, OutputBound]:
    """Bound the outputs and the declared states of a controller, for inputs in their ranges.

    Args:
        controller: The controller.
        timeout: Seconds that the proof of the range of a state, and each end of an output, may take.

    Returns:
        A bound for each output, then for each state, by name; infinite where none is known.
    """
    return bounds_by(ControllerProver(controller, timeout), timeout)


def bounds_by(prover: ControllerProver, seconds: float) -> dict[str, OutputBound]:
    """Return what `controller_bounds` does.

    Args:
        prover: Of the controller.
        seconds: How long each end of an output may take; 0 for no subdivision.
    """
    controller = prover.controller
    found = {r.name: _bound(prover, r.name, seconds) for r in controller.results}
    for state in controller.states:
        low, high = prover.ranges[state.name]
        found[state.name] = OutputBound(state.name, *_ends(low, high), exact=False)
    return found


def _bound(prover: ControllerProver, name: str, seconds: float) -> OutputBound:
    first, nearer = (BoxedStep(prover.model, prover.ranges, [name], far) for far in (FAR, _NEARER))
    found = _ends(*_ends_of(prover, first, seconds))
    if any(map(math.isfinite, found)) and not _same(*(_at_first(b, seconds) for b in (first, nearer))):
        pairs = zip(found, _ends_of(prover, nearer, seconds), (-1.0, 1.0), strict=True)
        low, high = (_settled(*ends) for ends in pairs)
        found = low, high
    return OutputBound(name, *found, exact=False)


def _same(ends: tuple[float, float], others: tuple[float, float]) -> bool:
    return all(a == b or abs(a - b) <= _SAME * max(abs(a), abs(b)) for a, b in zip(ends, others, strict=True))


def _settled(end: float, nearer: float, side: float) -> float:
    """Return an end that does not depend on how far numbers without an end are taken: it, 0, or an infinite one.

    Args:
        end: What is proved with numbers up to `FAR`.
        nearer: The same with numbers up to `_NEARER`.
        side: -1 of a lower end, 1 of an upper one.
    """
    if math.isinf(end) or _same((end, end), (nearer, nearer)):
        return end
    return 0.0 if abs(end) < abs(nearer) and end * side < 0.0 else side * math.inf


def _ends_of(prover: ControllerProver, boxed: BoxedStep, seconds: float) -> tuple[float, float]:
    """Return both ends of an output, for what its boxed step takes in place of numbers without an end."""
    (name,) = boxed.outputs
    judge = Judge(prover.replay, boxed.inputs)
    low, high = _at_first(boxed, seconds)
    gap = _GAP * (high - low) if math.isfinite(high - low) and high > low else _GAP
    ends = []
    for sign, known in ((1, low), (-1, -high)):

        def value(point: list[float], sign: int = sign) -> float:
            found = judge.values(point)
            return math.nan if found is None else sign * found[name]

        ends.append(sign * max(known, least(boxed, 0, sign, gap, value, Work(SECOND * seconds))[0]))
    return ends[0], ends[1]


def _at_first(boxed: BoxedStep, seconds: float) -> tuple[float, float]:
    """Return bounds of the output of a boxed step without subdivision; over cells if there is time."""
    cells = boxed.cells([]) if seconds else boxed.box
    if cells is None:
        return -math.inf, math.inf
    with np.errstate(all="ignore"):
        (found,), _ = boxed.enclose([Name(boxed.outputs[0])], *cells, sloped=False)
    return float(found.lo.min()), float(found.hi.max())


def _ends(low: float, high: float) -> tuple[float, float]:
    """Return two ends; what is as far as numbers without an end are taken is no bound."""
    return (-math.inf if low <= -FAR else low), (math.inf if high >= FAR else high)
