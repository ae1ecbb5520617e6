"""Ranges that the states of a controller never leave: the least fixed point of its step over intervals.

A range begins at the start and grows by what a step makes of it, until no step leaves it. Ends that keep growing jump
ahead: to where they seem to converge, then to the numbers that the equations name, then by a factor. Ends that
jumped too far are pulled back. A range counts only
when a last step has been seen not to leave it, so that a jump may go wrong without harm.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from fuzzyctl.analysis.induction.boxed_step import ANYTHING, Ends
from fuzzyctl.analysis.induction.step_model import FAR, StepModel, parted
from fuzzyctl.expr import Number, names_in, walk
from fuzzyctl.kernels.interval.vector import Enclosure, constant
from fuzzyctl.kernels.plan.equations import DT, Equation
from fuzzyctl.model.guarantee import Bounds

#: The shortest time between two steps of a controller without period [s].
SHORTEST: Final = 1e-30
#: Steps before an end jumps; jumps by extrapolation; jumps before an end has none.
_PATIENCE, _GUESSES, _JUMPS = 3, 4, 32
#: Ends that grow beyond it have none, although sums of floats stay where they are from about 1e16 on.
_LARGE: Final = 1e9
#: Halvings of the way that an end has jumped; most states whose ends are pulled back.
_PULLS, _PULLED = 12, 40
#: Steps after which ends that grow have none.
_MOST: Final = 150


@dataclass
class _End:
    """One end of a range that grows."""

    value: float
    moves: list[float] = field(default_factory=list)
    jumps: int = 0
    #: Where it was before it jumped; not far enough out.
    inside: float = math.nan

    def move(self, value: float, sign: float, marks: list[float], cap: float) -> None:
        """Move to a value that lies further out, or jump beyond it."""
        marks = [sign * m for m in marks]
        passed = any(sign * self.value < m <= sign * value for m in marks)
        # What passes a number of the equations may come to rest behind it.
        self.moves = [] if passed else [*self.moves, abs(value - self.value)]
        self.value = self.inside = value
        if len(self.moves) >= _PATIENCE:
            self.value = sign * min(self._jump(sign * value, marks), sign * cap)
            self.moves, self.jumps = [], self.jumps + 1

    def _jump(self, value: float, marks: list[float]) -> float:
        """Return where to go from a value; outwards is upwards here."""
        before, last = self.moves[-2:]
        if self.jumps < _GUESSES and last < 0.999 * before:
            rest = last * last / (before - last)
            return value + rest + 1e-9 * (abs(value) + rest)
        if self.jumps >= _JUMPS:
            return math.inf
        further = max(4.0 * value, 0.25 * value)
        return min([m for m in marks if m > value], default=further if abs(further) < _LARGE else math.inf)


def ends_of(bounds: Bounds | None) -> Ends:
    """Return the least and the largest number of a range whose ends are numbers."""
    if bounds is None:
        return -FAR, FAR
    low, high = (e.value if isinstance(e, Number) else math.nan for e in (bounds.lower, bounds.upper))
    low = math.nextafter(low, math.inf) if bounds.without_lower and math.isfinite(low) else low
    high = math.nextafter(high, -math.inf) if bounds.without_upper and math.isfinite(high) else high
    return max(low, -FAR), min(high, FAR)


def ranges_of(model: StepModel, inputs: Mapping[str, Ends], caps: Mapping[str, Ends]) -> dict[str, Ends]:
    """Return ranges of all arguments of a step; (-inf, inf) for a state that may be no number.

    Args:
        model: The step.
        inputs: Ranges of the inputs.
        caps: Ranges that are known of some states.
    """
    given = dict(inputs)
    if model.equations.period is None:
        given[DT] = (SHORTEST, FAR)
    with np.errstate(all="ignore"):
        return given | _Growth(model, given, caps).run()


class _Growth:
    def __init__(self, model: StepModel, inputs: Mapping[str, Ends], caps: Mapping[str, Ends]) -> None:
        self.model, self.caps = model, caps
        self.states = model.equations.states
        self.ends = {s.name: (_End(s.start), _End(s.start)) for s in self.states}
        self.lost: set[str] = set()
        updates = model.equations.updates
        part = model.slice(n.name for u in updates for n in names_in(u))
        still, self.part = parted(part, self.ends)
        #: What no state changes.
        self.fixed = model.evaluate(still, {n: _box(e) for n, e in inputs.items()}).names
        exprs = [*updates, *(i.value for i in part.body if isinstance(i, Equation))]
        numbers = {n.value for e in exprs for n in walk(e) if isinstance(n, Number) and math.isfinite(n.value)}
        numbers |= {x for e in (*inputs.values(), *caps.values()) for x in e if abs(x) < FAR}
        self.marks = sorted({0.0, *numbers, *(-x for x in numbers)})

    def run(self) -> dict[str, Ends]:
        steps = 0
        while self._step(is_last=steps >= _MOST):
            steps += 1
        if len(self.states) <= _PULLED:
            self._pull()
        return {n: (-math.inf, math.inf) if n in self.lost else (e[0].value, e[1].value) for n, e in self.ends.items()}

    def _pull(self) -> None:
        """Pull ends that jumped back, as far as no step leaves the ranges then."""
        for low, high in self.ends.values():
            for end in (low, high):
                if math.isnan(end.inside) or end.inside == end.value or abs(end.inside) >= _LARGE:
                    continue
                for _ in range(_PULLS):
                    before = end.value
                    end.value = 0.5 * (before + end.inside) if abs(before) < FAR else 4.0 * end.inside
                    if abs(end.value) >= _LARGE or not self._is_kept():
                        end.inside, end.value = end.value, before

    def _is_kept(self) -> bool:
        """Return whether no step leaves the ranges."""
        names = self.model.evaluate(self.part, self.fixed | self._known())
        for state, update in zip(self.states, self.model.equations.updates, strict=True):
            if state.name in self.lost:
                continue
            found, (low, high) = names.enclose(update), self.ends[state.name]
            cap = self.caps.get(state.name, (-FAR, FAR))
            if max(float(found.lo.min()), cap[0]) < low.value or min(float(found.hi.max()), cap[1]) > high.value:
                return False
        return True

    def _known(self) -> dict[str, Enclosure]:
        return {n: ANYTHING if n in self.lost else _box((e[0].value, e[1].value)) for n, e in self.ends.items()}

    def _step(self, *, is_last: bool) -> bool:
        """Let ranges grow by a step; return whether some did."""
        names = self.model.evaluate(self.part, self.fixed | self._known())
        grew = False
        for state, update in zip(self.states, self.model.equations.updates, strict=True):
            found = names.enclose(update)
            low, high = float(found.lo.min()), float(found.hi.max())
            if self._grow(state.name, low, high, is_last=is_last):
                grew = True
                own = self.ends[state.name]
                names.names[state.name] = ANYTHING if state.name in self.lost else _box((own[0].value, own[1].value))
        return grew

    def _grow(self, name: str, low: float, high: float, *, is_last: bool) -> bool:
        if name in self.lost:
            return False
        cap = self.caps.get(name, (-FAR, FAR))
        if low == -math.inf and high == math.inf and name not in self.caps:
            self.lost.add(name)
            return True
        grew = False
        for end, value, sign, most in zip(self.ends[name], (low, high), (-1.0, 1.0), cap, strict=True):
            value = sign * min(sign * value, sign * most)
            if sign * value > sign * end.value:
                grew = True
                end.move(most if is_last else value, sign, self.marks, most)
        return grew


def _box(ends: Ends) -> Enclosure:
    return constant(*ends)
