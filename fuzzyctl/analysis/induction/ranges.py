"""Ranges that the states of a controller never leave: the least fixed point of its step over intervals.

A range begins at the start and grows with each step, until no step leaves it. Ends that keep growing jump
ahead: to where they seem to converge, then to the numbers that the equations name, then by a factor. Ends that
jumped too far are pulled back. A range counts only
when a last step has been seen not to leave it, so that a jump may go wrong without harm. An end that no jump settles is
infinite, and overflow leads there: to an infinite value, and to NaN where two such values cancel.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from fuzzyctl.analysis.induction.step_model import ABSORBED, ANYTHING, Ends, StepModel, parted
from fuzzyctl.analysis.work import SpentError, clock
from fuzzyctl.expr import Expr, Name, Number, names_in, walk
from fuzzyctl.kernels.interval.narrowing import may_be_nan
from fuzzyctl.kernels.interval.vector import Enclosure, constant
from fuzzyctl.kernels.plan.equations import Equation
from fuzzyctl.model.block import Bounds

#: Steps before an end jumps; jumps by extrapolation; jumps before an end has none.
_PATIENCE, _GUESSES, _JUMPS = 3, 4, 32
#: Ends that grow beyond it jump from rung to rung: from about 1e16 times a step on, sums of floats stay where they are.
_LARGE: Final = 1e9
_RUNGS: Final = (ABSORBED, 1e40, 1e80, 1e120, 1e160, 1e200, math.inf)
#: Most states without ends whose values below and above 0 are enclosed apart.
_SPLIT: Final = 4
#: Halvings of the way that an end has jumped; most states whose ends are pulled back.
_PULLS, _PULLED = 12, 40
#: Steps after which ends that grow have none.
_MOST: Final = 150
#: Seconds that a step under way may take beyond the time.
_LATE: Final = 0.75

_ENDLESS: Final = (-math.inf, math.inf)
#: Stands for the range of a state that may be no number.
LOST: Final = (math.nan, math.nan)


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
        # An end that passes a number of the equations may come to rest behind it.
        self.moves = [] if passed else [*self.moves, abs(value - self.value)]
        self.value = self.inside = value
        if len(self.moves) >= (_PATIENCE if abs(value) < _LARGE else 1):
            self.value = sign * min(self._jump(sign * value, marks), sign * cap)
            self.moves, self.jumps = [], self.jumps + 1

    def _jump(self, value: float, marks: list[float]) -> float:
        """Return where to go from a value; outwards is upwards here."""
        before, last = self.moves[-2] if len(self.moves) > 1 else 0.0, self.moves[-1]
        if self.jumps < _GUESSES and last < 0.999 * before:
            rest = last * last / (before - last)
            return value + rest + 1e-9 * (abs(value) + rest)
        if self.jumps >= _JUMPS:
            return math.inf
        further = max(4.0 * value, 0.25 * value)
        further = further if abs(further) < _LARGE else next(r for r in _RUNGS if r > value or r == math.inf)
        return min([m for m in marks if m > value], default=further)


def ends_of(bounds: Bounds | None, far: float) -> Ends:
    """Return the least and the largest number of a range whose ends are numbers; `far` in place of infinite ends."""
    if bounds is None:
        return -far, far
    low, high = (e.value if isinstance(e, Number) else math.nan for e in (bounds.lower, bounds.upper))
    low = math.nextafter(low, math.inf) if bounds.without_lower and math.isfinite(low) else low
    high = math.nextafter(high, -math.inf) if bounds.without_upper and math.isfinite(high) else high
    return (-far if low == -math.inf else low), (far if high == math.inf else high)


def ranges_of(
    model: StepModel, inputs: Mapping[str, Ends], caps: Mapping[str, Ends], deadline: float = math.inf
) -> dict[str, Ends]:
    """Return ranges of all arguments of a step.

    Args:
        model: The step.
        inputs: Ranges of the inputs, and of `dt` for a controller without period.
        caps: Ranges that are known of some states.
        deadline: When to stop, on the clock of proofs [s].

    Returns:
        The inputs' ranges and the states'; (NaN, NaN) for a state that may be no number.
    """
    left = deadline - clock.now()
    if left > 0.0:
        with suppress(SpentError), np.errstate(all="ignore"), clock.limited(left + _LATE):
            return dict(inputs) | _Growth(model, inputs, caps).run(deadline)
    return dict(inputs) | {s.name: caps.get(s.name, LOST) for s in model.equations.states}


class _Growth:
    def __init__(self, model: StepModel, inputs: Mapping[str, Ends], caps: Mapping[str, Ends]) -> None:
        self.model, self.caps = model, caps
        self.states = model.equations.states
        self.ends = {s.name: (_End(s.start), _End(s.start)) for s in self.states}
        self.lost: set[str] = set()
        updates = model.equations.updates
        part = model.slice(n.name for u in updates for n in names_in(u))
        still, self.part = parted(part, self.ends)
        #: The names that no state changes.
        self.fixed = model.evaluate(still, {n: _box(e) for n, e in inputs.items()}).names
        exprs = [*updates, *(i.value for i in part.body if isinstance(i, Equation))]
        numbers = {n.value for e in exprs for n in walk(e) if isinstance(n, Number) and math.isfinite(n.value)}
        numbers |= {x for e in (*inputs.values(), *caps.values()) for x in e if math.isfinite(x)}
        self.marks = sorted({0.0, *numbers, *(-x for x in numbers)})

    def run(self, deadline: float) -> dict[str, Ends]:
        steps = 0
        while self._step(is_last=steps >= _MOST):
            steps += 1
            if clock.now() > deadline:
                raise SpentError
        if len(self.states) <= _PULLED:
            self._pull()
        return {n: LOST if n in self.lost else (low.value, high.value) for n, (low, high) in self.ends.items()}

    def _pull(self) -> None:
        """Pull ends that jumped back, as far as no step leaves the ranges then."""
        for low, high in self.ends.values():
            for end in (low, high):
                if math.isnan(end.inside) or end.inside == end.value or abs(end.inside) >= _LARGE:
                    continue
                for _ in range(_PULLS):
                    before = end.value
                    end.value = 0.5 * (before + end.inside) if abs(before) < _LARGE else 4.0 * end.inside
                    if abs(end.value) >= _LARGE or not self._is_kept():
                        end.inside, end.value = end.value, before

    def _is_kept(self) -> bool:
        """Return whether no step leaves the ranges."""
        names = self.model.evaluate(self.part, self.fixed | self._known())
        for state, update in zip(self.states, self.model.equations.updates, strict=True):
            if state.name in self.lost:
                continue
            enclosure, (low, high) = names.enclose(update), self.ends[state.name]
            cap = self.caps.get(state.name, _ENDLESS)
            if (
                max(float(enclosure.lo.min()), cap[0]) < low.value
                or min(float(enclosure.hi.max()), cap[1]) > high.value
            ):
                return False
        return True

    def _known(self) -> dict[str, Enclosure]:
        """Enclose the states; those without ends are below 0 in some boxes, above it in others."""
        enclosures = {n: ANYTHING if n in self.lost else _box((e[0].value, e[1].value)) for n, e in self.ends.items()}
        endless = [n for n in enclosures if self._is_endless(n)][:_SPLIT]
        boxes = np.arange(1 << len(endless))
        for k, name in enumerate(endless):
            above = (boxes >> k & 1).astype(np.bool_)
            ends = np.where(above, 0.0, -math.inf), np.where(above, math.inf, 0.0)
            enclosures[name] = Enclosure(*ends, None, np.array(0.0))
        return enclosures

    def _is_endless(self, name: str) -> bool:
        low, high = self.ends[name]
        return name not in self.lost and (low.value, high.value) == _ENDLESS

    def _step(self, *, is_last: bool) -> bool:
        """Let ranges grow by a step; return whether some did."""
        names = self.model.evaluate(self.part, self.fixed | self._known())
        grew = False
        for state, update in zip(self.states, self.model.equations.updates, strict=True):
            if clock.is_over():
                raise SpentError
            ends = self._copied(update) or self._ends_of(state.name, names.enclose(update))
            if state.name not in self.lost and self._grow(state.name, ends, is_last=is_last):
                grew = True
                now = self.ends[state.name]
                if state.name in self.lost:
                    names.names[state.name] = ANYTHING
                elif not self._is_endless(state.name):
                    names.names[state.name] = _box((now[0].value, now[1].value))
        return grew

    def _copied(self, update: Expr) -> Ends | None:
        """Return the ends of the state that a next value copies, as in a delay line; None for other values."""
        if not isinstance(update, Name) or update.name in self.lost or update.name not in self.ends:
            return None
        low, high = self.ends[update.name]
        return low.value, high.value

    def _ends_of(self, name: str, value: Enclosure) -> Ends:
        """Return the ends of a state's next value; (NaN, NaN) if it may be no number."""
        is_lost = name not in self.caps and may_be_nan(value).any()
        return LOST if is_lost else (float(value.lo.min()), float(value.hi.max()))

    def _grow(self, name: str, ends: Ends, *, is_last: bool) -> bool:
        if ends is LOST:
            self.lost.add(name)
            return True
        grew = False
        caps = self.caps.get(name, _ENDLESS)
        for end, value, sign, cap in zip(self.ends[name], ends, (-1.0, 1.0), caps, strict=True):
            value = sign * min(sign * value, sign * cap)
            if sign * value > sign * end.value:
                grew = True
                end.move(cap if is_last else value, sign, self.marks, cap)
        return grew


def _box(ends: Ends) -> Enclosure:
    return constant(*ends)
