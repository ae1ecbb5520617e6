"""Bounds of the outputs and states of a controller over every reachable step."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from typing import Final

import numpy as np

from fuzzyctl.analysis.bounds import SPENT, OutputBound
from fuzzyctl.analysis.branch_and_bound.minimum import least
from fuzzyctl.analysis.claims import ALWAYS, Bound, Claim, Every
from fuzzyctl.analysis.induction.claims import NEXT
from fuzzyctl.analysis.induction.prover import ControllerProver
from fuzzyctl.analysis.induction.replay import Judge
from fuzzyctl.analysis.induction.step_model import ABSORBED, FAR, BoxedStep
from fuzzyctl.analysis.work import SECOND, Work, clock
from fuzzyctl.diagnostics.suggestions import listed
from fuzzyctl.expr import Name, Number
from fuzzyctl.model.controller import Controller

#: How near a bound should come to a value that is attained, as a part of the gap after the first look.
_GAP: Final = 0.002
#: Two magnitudes of arguments without an end; an output that grows by a larger part between them has none, either.
_NEARER, _SAME = 1e24, 0.05
#: Most arguments without an end whose signs are tried in all combinations.
_SIGNS: Final = 6
#: Most states of a controller that is compiled, since that takes 10 KB for each.
_COMPILED: Final = 20_000
#: Most units of work for outputs that are enclosed once even if the time is spent, of all of them together.
_QUICK: Final = 100_000
#: An end this near 0, on the side of the other end, is 0.
_NOTHING: Final = 1e-20


def controller_bounds(controller: Controller, timeout: float) -> dict[str, OutputBound]:
    """Bound the outputs and the declared states of a controller, for inputs in their ranges.

    Args:
        controller: The controller.
        timeout: Seconds that all bounds may take together.

    Returns:
        A bound for each output, then for each state, by name; infinite if unknown.
    """
    return bounds_by(ControllerProver(controller, timeout, until=clock.now() + timeout), timeout)


def bounds_by(prover: ControllerProver, seconds: float) -> dict[str, OutputBound]:
    """Return what `controller_bounds` does.

    Args:
        prover: Of the controller.
        seconds: How long all ends may take; 0 for no subdivision.
    """
    prover.until = min(prover.until, clock.now() + seconds) if seconds else math.inf
    quick = Work(_QUICK)
    outputs = [_Output(prover, r.name, quick, bool(seconds)) for r in prover.controller.results]
    waiting = [(o, side) for o in outputs for side in (0, 1) if seconds and not (o.is_endless[side] or o.is_spent)]
    work = Work(SECOND * seconds)
    while waiting:
        output, side = waiting[0]
        output.search(side, work.part(work.left / len(waiting)))
        waiting = waiting[1:]
    bounds = {o.name: o.bound() for o in outputs}
    for state in prover.controller.states:
        low, high = prover.ranges[state.name]
        ends = (-math.inf if not low > -ABSORBED else low), (math.inf if not high < ABSORBED else high)
        note = _assumption(prover, NEXT + state.name, ends)
        bounds[state.name] = OutputBound(state.name, *ends, exact=False, note=note)
    return bounds


@dataclass
class _Output:
    """An output whose ends are searched.

    Args:
        prover: Of its controller.
        name: The output.
        quick: The work that is allowed although the time is spent.
        over_cells: Whether its first ends are those over cells, not over all arguments at once.

    Attributes:
        ends: The ends that are proved so far.
        is_endless: Whether values that are attained show that an end is infinite.
        is_spent: Whether a search has ended for lack of time.
    """

    prover: ControllerProver
    name: str
    quick: Work
    over_cells: bool
    ends: list[float] = field(init=False)
    is_endless: list[bool] = field(init=False)
    is_spent: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        self.boxed = BoxedStep(self.prover.model, self.prover.ranges, [self.name])
        self.judge = Judge(self.prover.replay, self.boxed.inputs)
        self.ends, self.is_endless = [-math.inf, math.inf], [False, False]
        self.is_spent = clock.now() > self.prover.until and not self.quick.takes(self.boxed.units(0, 1))
        self.open = [k for k, ends in enumerate(self.boxed.ends) if np.abs(ends).max() >= ABSORBED]
        if self.is_spent:
            return
        cells = self.boxed.cells([]) if self.over_cells else None
        with np.errstate(all="ignore"):
            (enclosure,), _ = self.boxed.enclose([Name(self.name)], *(cells or self.boxed.box), sloped=False)
        self.ends = [float(enclosure.lo.min()), float(enclosure.hi.max())]
        far, nearer = (list(self._values(size)) for size in (FAR, _NEARER)) if self.open else ([], [])
        self.is_endless = [_grows([s * v for v in far], [s * v for v in nearer]) for s in (-1.0, 1.0)]

    def _values(self, size: float) -> Iterator[float]:
        """Yield values of the output for arguments without an end of some size, and the others in their middles."""
        low, high = self.boxed.ends.T
        with np.errstate(all="ignore"):
            point = low + 0.5 * (high - low)
        for signs in product((-1.0, 1.0), repeat=min(len(self.open), _SIGNS)):
            point[self.open] = 0.0
            point[self.open[: len(signs)]] = [size * sign for sign in signs]
            yield self._value(np.clip(point, low, high).tolist())

    def _value(self, point: list[float]) -> float:
        """Return the output at a point; NaN for more states than a kernel is compiled for here."""
        if len(self.prover.replay.states) > _COMPILED:
            return math.nan
        values = self.judge.values(point)
        return math.nan if values is None else values[self.name]

    def search(self, side: int, work: Work) -> None:
        """Improve an end by subdivision, as far as there is time."""
        sign, (low, high) = 1 - 2 * side, self.ends
        gap = _GAP * (high - low) if math.isfinite(high - low) and high > low else _GAP

        def value(point: list[float]) -> float:
            return sign * self._value(point)

        bound, _ = least(self.boxed, 0, sign, gap, value, work, deadline=self.prover.until)
        self.ends[side] = sign * max(sign * self.ends[side], bound)
        self.is_spent = self.is_spent or work.left <= 0.0 or clock.now() > self.prover.until

    def bound(self) -> OutputBound:
        """Return both ends; an end that only the size of arguments keeps from being 0 or infinite is that."""
        low, high = self.ends
        low = -math.inf if self.is_endless[0] or low <= -ABSORBED else 0.0 if 0.0 < low <= _NOTHING else low
        high = math.inf if self.is_endless[1] or high >= ABSORBED else 0.0 if 0.0 > high >= -_NOTHING else high
        notes = [self._why_open() if math.isinf(low) or math.isinf(high) else ""]
        notes += [SPENT if self.is_spent else "", _assumption(self.prover, self.name, (low, high))]
        return OutputBound(self.name, low, high, exact=False, note="; ".join(filter(None, notes)))

    def _why_open(self) -> str:
        """Return why an end is infinite."""
        names = listed([self.boxed.inputs[k] for k in self.open])
        if any(self.is_endless) and names:
            return f"it grows with {names}"
        if self.boxed.lost:
            return f"no range of {listed(self.boxed.lost)} is proved"
        return f"no bound is proved for large {names}" if names else "no bound is proved"


def _grows(far: list[float], nearer: list[float]) -> bool:
    """Return whether the largest of some values is infinite, or larger than those of nearer arguments."""
    most, less = (max((v for v in values if not math.isnan(v)), default=-math.inf) for values in (far, nearer))
    return most >= ABSORBED or (most > 0.0 and most - less > _SAME * most)


def _assumption(prover: ControllerProver, name: str, ends: tuple[float, float]) -> str:
    """Return up to which inputs the finite ones of two ends are proved; an empty text for all."""
    sides = ((Number(ends[0]), Name(name)), (Name(name), Number(ends[1])))
    parts = [Bound(b, a, Fraction(0), False, Name(name)) for a, b in sides]
    finite = tuple(p for p, end in zip(parts, ends, strict=True) if math.isfinite(end))
    return prover.assumption(Claim(name, Every(finite), ALWAYS)) if finite else ""
