"""Branch-and-bound queue of input boxes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Final, Protocol

import numpy as np

from fuzzyctl.analysis.coverage.box_search import Side
from fuzzyctl.analysis.sampling import with_signs
from fuzzyctl.analysis.verdicts import Refuted, Undecided, Verdict, Witness
from fuzzyctl.analysis.work import clock
from fuzzyctl.kernels.interval.vector import Array, Mask

#: A value this far beyond its bound is beyond it in exact arithmetic, too.
NEAR: Final = 1e-9
#: Points tried as witnesses among the boxes of one step.
TRIED: Final = 4
#: Points tried before any box is halved.
FIRST: Final = 400
#: Sides below this part of the range are not halved any more.
_NARROW: Final = 1e-13
#: Most boxes that wait.
_MOST: Final = 2_000_000
#: Open boxes that a verdict shows.
_SHOWN: Final = 10

#: Progress callback of a search: the numbers of settled and of open boxes.
BoxProgress = Callable[[int, int], None]


class Boxed(Protocol):
    """A system or a step over boxes, which is searched."""

    @property
    def inputs(self) -> list[str]:
        """Names of the sides of a box."""

    @property
    def batch(self) -> int:
        """How many boxes to take at once."""


class Search:
    """One search: open boxes, taken in batches from the end.

    Args:
        system: The system whose boxes are searched.
        lo, hi: Ends of the boxes to begin with, shape (inputs, boxes).
        deadline: When to stop.
        progress: Called after each batch.
    """

    def __init__(self, system: Boxed, lo: Array, hi: Array, deadline: float, progress: BoxProgress | None) -> None:
        self.system, self.lo, self.hi = system, lo, hi
        self.deadline, self.progress, self.settled = deadline, progress, 0
        self.stuck: list[tuple[Array, Array]] = []
        finite = np.isfinite(lo) & np.isfinite(hi)
        with np.errstate(invalid="ignore"):
            low, high = np.where(finite, lo, np.inf).min(axis=1), np.where(finite, hi, -np.inf).max(axis=1)
            self.ranges = np.maximum(np.where(high > low, high - low, 1.0), 1e-300)[:, None]
            self.volume = self._volume(lo, hi)

    def take(self) -> tuple[Array, Array]:
        """Take the next batch."""
        count = self.system.batch
        lo, hi = self.lo[:, -count:], self.hi[:, -count:]
        self.lo, self.hi = self.lo[:, :-count], self.hi[:, :-count]
        return lo, hi

    def put_halves(self, lo: Array, hi: Array, steepness: Array) -> Mask:
        """Halve boxes across the side along which most is not known; keep apart those too small for it.

        Args:
            lo, hi: Ends of the boxes, shape (inputs, boxes).
            steepness: Bounds of the slope of the claim along each input, shape (inputs, boxes); infinite where unknown.

        Returns:
            Which boxes were halved, shape (boxes,): first all left halves have been put, then all right ones.
        """
        with np.errstate(invalid="ignore", over="ignore"):
            width = (hi - lo) / self.ranges
            weight = np.where(np.isfinite(steepness), steepness * (hi - lo), np.inf)
            # Of a side without an end, the end that it has says how near its floats are.
            sizes = [np.where(np.isfinite(ends), np.abs(ends), 0.0) for ends in (lo, hi)]
            floor = np.maximum(_NARROW, 8.0 * 2.0**-52 * np.maximum(*sizes) / self.ranges)
        can = width > floor
        # Steep sides first; where slopes are not known, or none matters, long ones.
        unknown = ~np.isfinite(weight).all(axis=0) | (weight <= 0.0).all(axis=0)
        score = np.where(can, np.where(unknown, width, np.where(np.isfinite(weight), weight, 0.0) + 1e-9 * width), -1.0)
        axis = score.argmax(axis=0)
        ready: Mask = np.asarray(can.any(axis=0))
        if not ready.all():
            self.stuck.append((lo[:, ~ready], hi[:, ~ready]))
        lo, hi, axis = lo[:, ready], hi[:, ready], axis[ready]
        boxes = np.arange(lo.shape[1])
        middle = _between(lo[axis, boxes], hi[axis, boxes])
        left, right = hi.copy(), lo.copy()
        left[axis, boxes] = middle
        right[axis, boxes] = np.nextafter(middle, np.inf)
        self.lo, self.hi = np.hstack([self.lo, lo, right]), np.hstack([self.hi, left, hi])
        if self.progress is not None:
            self.progress(self.settled, self.lo.shape[1])
        return ready

    @property
    def is_over(self) -> bool:
        """Whether time or room is used up."""
        return clock.now() > self.deadline or self.is_full

    @property
    def is_full(self) -> bool:
        """Whether room is used up."""
        return int(self.lo.shape[1]) > _MOST

    def halted(
        self, claim: str, step: Callable[[], Witness | None], why_stuck: Callable[[], str], *, wider: str = ""
    ) -> Verdict | None:
        """Take batches until all boxes are settled.

        Args:
            claim: Its text.
            step: Takes a batch; returns a witness against the claim where it finds one.
            why_stuck: Why boxes that are too small to be halved are not settled.
            wider: What else than more time helps.

        Returns:
            What ended the search before; None where every box is settled.
        """
        while self.lo.shape[1]:
            if self.is_over:
                return Undecided(
                    claim, f"{self._progress}, and no point is found that breaks it{wider}", *self.open_boxes
                )
            witness = step()
            if witness is not None:
                return Refuted(claim, witness)
            if sum(s[0].shape[1] for s in self.stuck) > _SHOWN:
                break
        return Undecided(claim, why_stuck(), *self.open_boxes) if self.stuck else None

    @property
    def _progress(self) -> str:
        """How far the search has come; open boxes are the ones that are hardest to settle, or not yet looked at."""
        waiting = self._volume(self.lo, self.hi) + sum(self._volume(*s) for s in self.stuck)
        if not 0.0 < self.volume < np.inf:
            return f"{self.settled} boxes are settled in the time given"
        share = max(0.0, 1.0 - waiting / self.volume)
        amount = f"{math.floor(100.0 * share)} %" if share >= 0.01 else "less than 1 %"
        return f"{amount} of the input space is settled in the time given"

    def _volume(self, lo: Array, hi: Array) -> float:
        return float(np.prod((hi - lo) / self.ranges, axis=0).sum())

    @property
    def open_boxes(self) -> tuple[tuple[dict[str, Side], ...], int]:
        """Some of the open boxes, and how many there are."""
        lo = np.hstack([*(s[0] for s in self.stuck), self.lo])
        hi = np.hstack([*(s[1] for s in self.stuck), self.hi])
        boxes = [
            {n: _side(float(lo[i, k]), float(hi[i, k])) for i, n in enumerate(self.system.inputs)}
            for k in range(min(_SHOWN, lo.shape[1]))
        ]
        return tuple(boxes), lo.shape[1]


def _side(lo: float, hi: float) -> Side:
    """Return a side; of neighbouring floats no one wants to see the last digits."""
    if lo == hi:
        return Side(lo, hi)
    return Side(float(np.nextafter(lo, -np.inf)), float(np.nextafter(hi, np.inf)), False, False)


def _between(lo: Array, hi: Array) -> Array:
    with np.errstate(invalid="ignore"):
        middle = 0.5 * lo + 0.5 * hi
    below, above = np.isinf(lo), np.isinf(hi)
    middle = np.where(below, np.minimum(2.0 * hi, hi - 1.0), middle)
    middle = np.where(above, np.maximum(2.0 * lo, lo + 1.0), middle)
    middle = np.where(below & above, 0.0, middle)
    return np.minimum(np.maximum(middle, np.maximum(lo, -1e308)), np.nextafter(hi, -np.inf))


def signed_points(point: Array, lo: Array, hi: Array) -> Iterator[list[float]]:
    """Yield a point of a box as a list, and the same with -0.0 where the box holds 0; all of shape (inputs,)."""
    return with_signs(point.tolist(), list(zip(lo.tolist(), hi.tolist(), strict=True)))


def middles(lo: Array, hi: Array) -> Array:
    """Return the middles of boxes, finite also if a side is not; all of one shape."""
    return np.minimum(np.maximum(np.where(lo == hi, lo, _between(lo, np.maximum(hi, lo))), lo), hi)


def start_of(lo: Array, hi: Array, down: Array, up: Array) -> tuple[Array, Array]:
    """Return where to expand for a lower bound, and how far values may fall from there.

    Along an input in which the value rises or falls throughout it is the lower end; else the middle.

    Args:
        lo, hi: Ends of the boxes, shape (inputs, boxes).
        down, up: Bounds of the slopes along the inputs, shape (inputs, boxes).

    Returns:
        Points of shape (inputs, boxes), and how far values fall at most, shape (boxes,).
    """
    middle = middles(lo, hi)
    start = np.where(down >= 0.0, lo, np.where(up <= 0.0, hi, middle))
    start = np.where(np.isfinite(start), start, middle)
    reach = np.maximum(hi - start, start - lo)
    free = (down >= 0.0) & np.isfinite(lo) | (up <= 0.0) & np.isfinite(hi)
    steep = np.maximum(np.abs(down), np.abs(up))
    with np.errstate(invalid="ignore"):
        fall = np.where(free | (reach == 0.0), 0.0, steep * reach)
    slack: Array = np.where(np.isnan(fall), np.inf, fall).sum(axis=0)
    return start, slack
