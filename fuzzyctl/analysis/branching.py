"""Claims decided by subdivision: boxes are halved until the claim is seen to hold in each, or a point breaks it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Final

import numpy as np

from fuzzyctl.analysis.boxes import System, surely_false, surely_true
from fuzzyctl.analysis.claims import Bound, Claim, Slope, bounds_in, is_limit
from fuzzyctl.analysis.enclosures import Array, Mask
from fuzzyctl.analysis.holes import Side
from fuzzyctl.analysis.sampling import with_signs
from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdict, Witness
from fuzzyctl.analysis.witnesses import Judge
from fuzzyctl.expr import Binary, Compare

#: Sides below this part of the range are not halved any more.
_NARROW: Final = 1e-13
#: What is this much beyond its bound is not so for rounding.
_NEAR: Final = 1e-9
#: Points tried as witnesses among the boxes of one step.
_TRIED: Final = 4
#: Points tried before any box is halved.
_FIRST: Final = 400
#: Most boxes that wait.
_MOST: Final = 2_000_000
#: Open boxes that a verdict shows.
_SHOWN: Final = 10

#: Told the boxes that are settled and those that are open.
Told = Callable[[int, int], None]


class Search:
    """One search: open boxes, taken in batches from the end.

    Args:
        system: The system.
        lo, hi: Ends of the boxes to begin with, shape (inputs, boxes).
        deadline: When to stop.
        told: Called after each batch.
    """

    def __init__(self, system: System, lo: Array, hi: Array, deadline: float, told: Told | None) -> None:
        self.system, self.lo, self.hi = system, lo, hi
        self.deadline, self.told, self.settled = deadline, told, 0
        self.stuck: list[tuple[Array, Array]] = []
        finite = np.isfinite(lo) & np.isfinite(hi)
        with np.errstate(invalid="ignore"):
            low, high = np.where(finite, lo, np.inf).min(axis=1), np.where(finite, hi, -np.inf).max(axis=1)
            self.ranges = np.maximum(np.where(high > low, high - low, 1.0), 1e-300)[:, None]

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
            steepness: How steep what is asked may be along each input, shape (inputs, boxes); infinite where unknown.

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
        if self.told is not None:
            self.told(self.settled, self.lo.shape[1])
        return ready

    @property
    def is_over(self) -> bool:
        """Whether time or room is used up."""
        return time.monotonic() > self.deadline or self.lo.shape[1] > _MOST

    def halted(
        self, claim: str, step: Callable[[], Witness | None], why_stuck: Callable[[], str], *, wider: str = ""
    ) -> Verdict | None:
        """Take batches until all boxes are settled.

        Args:
            claim: Its text.
            step: Takes a batch; returns a witness against the claim where it finds one.
            why_stuck: Why boxes that are too small to be halved are not settled.
            wider: What else than time would decide it.

        Returns:
            What ended the search before; None where every box is settled.
        """
        while self.lo.shape[1]:
            if self.is_over:
                return Undecided(claim, f"more time would decide it{wider}", *self.open_boxes)
            witness = step()
            if witness is not None:
                return Refuted(claim, witness)
            if sum(s[0].shape[1] for s in self.stuck) > _SHOWN:
                break
        return Undecided(claim, why_stuck(), *self.open_boxes) if self.stuck else None

    @property
    def open_boxes(self) -> tuple[tuple[dict[str, Side], ...], int]:
        """Some of the open boxes, and how many there are."""
        lo = np.hstack([*(s[0] for s in self.stuck), self.lo])
        hi = np.hstack([*(s[1] for s in self.stuck), self.hi])
        shown = [
            {n: _side(float(lo[i, k]), float(hi[i, k])) for i, n in enumerate(self.system.inputs)}
            for k in range(min(_SHOWN, lo.shape[1]))
        ]
        return tuple(shown), lo.shape[1]


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


def decide(system: System, claim: Claim, judge: Judge, timeout: float, told: Told | None) -> Verdict:
    """Decide a claim about points by subdivision."""
    deadline = time.monotonic() + timeout
    cells = system.cells([claim.truth, claim.region])
    if cells is None:
        return Undecided(claim.text, "its terms cut the inputs into too many cells")
    witness = first_witness(claim, judge, *cells, deadline)
    if witness is not None:
        return Refuted(claim.text, witness)
    with np.errstate(all="ignore"):
        return _Pointwise(system, claim, judge, Search(system, *cells, deadline, told)).verdict()


def first_witness(claim: Claim, judge: Judge, lo: Array, hi: Array, deadline: float) -> Witness | None:
    """Look for a witness among middles of cells, of which points are corners, while there is time.

    Args:
        claim: What is to be broken.
        judge: What evaluates points.
        lo, hi: Ends of the cells, shape (inputs, cells).
        deadline: When to stop, on the monotonic clock [s].
    """
    step = max(1, lo.shape[1] // _FIRST)
    for k in range(0, lo.shape[1], step):
        if time.monotonic() > deadline:
            return None
        witness = _witness_of(claim, judge, middles(lo[:, k], hi[:, k]), lo[:, k], hi[:, k])
        if witness is not None:
            return witness
    return None


def _witness_of(claim: Claim, judge: Judge, point: Array, lo: Array, hi: Array) -> Witness | None:
    """Return a point of a box as a witness, or the same with -0.0 where the box holds 0."""
    for signed in signed_points(point, lo, hi):
        witness = judge.broken(claim.truth, claim.region, signed)
        if witness is not None:
            return witness
    return None


def signed_points(point: Array, lo: Array, hi: Array) -> Iterator[list[float]]:
    """Yield a point of a box as a list, and the same with -0.0 where the box holds 0; all of shape (inputs,)."""
    return with_signs(point.tolist(), list(zip(lo.tolist(), hi.tolist(), strict=True)))


def middles(lo: Array, hi: Array) -> Array:
    """Return the middles of boxes, finite also where a side is not; all of one shape."""
    return np.minimum(np.maximum(np.where(lo == hi, lo, _between(lo, np.maximum(hi, lo))), lo), hi)


class _Pointwise:
    def __init__(self, system: System, claim: Claim, judge: Judge, search: Search) -> None:
        self.system, self.claim, self.judge, self.search = system, claim, judge, search
        self.compared = list(dict.fromkeys(bounds_in(claim.truth)))
        self.conditions = list(dict.fromkeys(bounds_in(claim.region)))
        self.only_exact = not any(b.tolerance or is_limit(system.system, b) for b in self.compared)
        self.is_rounded = False

    def verdict(self) -> Verdict:
        wider = ", or a wider tolerance" if self._is_loosened else ""
        found = self.search.halted(self.claim.text, self._step, self._why_stuck, wider=wider)
        if found is not None:
            return found
        note = "in exact arithmetic; kernels round" if self.is_rounded else ""
        return Proved(self.claim.text, note=note)

    def _why_stuck(self) -> str:
        exprs = [Binary("-", b.left, b.right) for b in self.compared]
        found, _ = self.system.enclose(exprs, *self.search.stuck[0], sloped=False)
        if any(np.isinf(e.lo).any() for e in found):
            return "values may be infinite there, or none at all; 'when' can leave such places out"
        if any(
            (e.lo + float(b.tolerance) < -_NEAR * (1.0 + e.size)).any()
            for b, e in zip(self.compared, found, strict=True)
        ):
            return "too little is known of values there, as where rules hardly fire; 'when' can leave such places out"
        advice = "; a tolerance, such as 'within 1e-9', would decide it" if self._is_loosened else ""
        return f"it comes as close to its bound as rounding{advice}"

    @property
    def _is_loosened(self) -> bool:
        """Whether a tolerance makes the claim any weaker, as it does not where two things are to differ."""
        equalities = [b for b in self.compared if isinstance(b.origin, Compare) and b.origin.op in ("==", "!=")]
        return not any(b.strict for b in equalities)

    def _step(self) -> Witness | None:
        """Settle what can be settled of a batch, and halve the rest."""
        lo, hi = self.search.take()
        count = lo.shape[1]
        exprs = [Binary("-", b.left, b.right) for b in (*self.conditions, *self.compared)]
        found, void = self.system.enclose(exprs, lo, hi, sloped=True)
        number = len(self.conditions)
        upper = {b: np.broadcast_to(e.hi, count) for b, e in zip(self.conditions, found, strict=False)}
        outside = np.broadcast_to(surely_false(self.claim.region, upper) | void, count)
        lower: dict[Bound, Array] = {}
        exact: dict[Bound, Array] = {}
        steepness, points, lowest = np.zeros_like(lo), middles(lo, hi), np.full(count, np.inf)
        for b, e, expr in zip(self.compared, found[number:], exprs[number:], strict=True):
            natural = np.broadcast_to(e.lo, count) + float(b.tolerance)
            lower[b] = exact[b] = natural
            if e.slopes is None:
                continue
            slopes = [np.broadcast_to(s, lo.shape) for s in e.slopes]
            start, slack = start_of(lo, hi, *slopes)
            (there,), _ = self.system.enclose([expr], start, start, sloped=False)
            straight = np.broadcast_to(there.lo, count) - slack * (1.0 + 1e-12) + float(b.tolerance)
            straight = straight - np.abs(straight) * 1e-15
            exact[b] = np.fmax(natural, straight)
            lower[b] = np.fmax(natural, straight - np.broadcast_to(e.error, count))
            steepness = np.fmax(steepness, np.maximum(np.abs(slopes[0]), np.abs(slopes[1])))
            at = np.broadcast_to(there.lo, count) + float(b.tolerance)
            points = np.where(at < lowest, start, points)
            lowest = np.fmin(lowest, at)
        done = outside | surely_true(self.claim.truth, lower)
        if self.only_exact:
            rounded = ~done & surely_true(self.claim.truth, exact)
            self.is_rounded = self.is_rounded or bool(rounded.any())
            done = done | rounded
        done = np.broadcast_to(done, count)
        self.search.settled += int(done.sum())
        open_ = ~done
        if not open_.any():
            return None
        order = np.argsort(lowest[open_])[:_TRIED]
        for k in np.flatnonzero(open_)[order]:
            for point in (points[:, k], middles(lo[:, k], hi[:, k])):
                witness = _witness_of(self.claim, self.judge, point, lo[:, k], hi[:, k])
                if witness is not None:
                    return witness
        self.search.put_halves(lo[:, open_], hi[:, open_], steepness[:, open_])
        return None


def start_of(lo: Array, hi: Array, down: Array, up: Array) -> tuple[Array, Array]:
    """Return where to expand for a lower bound, and how far values may fall from there.

    Along an input in which the value rises or falls throughout it is the lower end; else the middle.

    Args:
        lo, hi: Ends of the boxes, shape (inputs, boxes).
        down, up: Between what the slopes along the inputs lie, shape (inputs, boxes).

    Returns:
        Points of shape (inputs, boxes), and what values fall by at most, shape (boxes,).
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


def decide_slope(
    system: System, claim: Claim, slope: Slope, judge: Judge, timeout: float, told: Told | None
) -> Verdict:
    """Decide a word about slopes by subdivision."""
    deadline = time.monotonic() + timeout
    output, axis = system.outputs.index(slope.output), system.inputs.index(slope.input)
    cells = system.cells([])
    if cells is None:
        return Undecided(claim.text, "its terms cut the inputs into too many cells")
    lo, hi = cells
    whole = (lo < hi).all(axis=0)
    for k in range(0, lo.shape[1], max(1, lo.shape[1] // _FIRST)):
        if time.monotonic() > deadline:
            break
        witness = _broken(system, slope, judge, lo[:, k], hi[:, k], axis)
        if witness is not None:
            return Refuted(claim.text, witness)
    if not system.is_continuous(output):
        return Undecided(claim.text, f"'{slope.output}' is not known to be continuous")
    search = Search(system, lo[:, whole], hi[:, whole], deadline, told)
    with np.errstate(all="ignore"):
        return _Sloped(system, claim, slope, judge, search).verdict(output, axis)


def _broken(system: System, slope: Slope, judge: Judge, lo: Array, hi: Array, axis: int) -> Witness | None:
    """Return a pair of points at both ends of a box as a witness, of ends that are open rather those beyond them."""
    if not (np.isfinite(lo[axis]) and np.isfinite(hi[axis]) and lo[axis] < hi[axis]):
        return None
    start, ends = middles(lo, hi), hi.copy()
    beyond = np.nextafter(lo[axis], -np.inf), np.nextafter(hi[axis], np.inf)
    for low, high in (np.clip(beyond, *system.whole(axis)), (lo[axis], hi[axis])):
        start[axis] = ends[axis] = low
        far = float(high)
        for point in signed_points(start, lo, ends):
            for end in (far, -0.0) if far == 0.0 else (far,):
                witness = judge.broken_slope(slope, point, end, judge.rounding(slope.output))
                if witness is not None:
                    return witness
    return None


class _Sloped:
    def __init__(self, system: System, claim: Claim, slope: Slope, judge: Judge, search: Search) -> None:
        self.system, self.claim, self.slope, self.judge, self.search = system, claim, slope, judge, search

    def verdict(self, output: int, axis: int) -> Verdict:
        found = self.search.halted(
            self.claim.text, lambda: self._step(output, axis), lambda: self._why_stuck(output, axis)
        )
        return Proved(self.claim.text, note="in exact arithmetic; kernels round") if found is None else found

    def _excess(self, down: Array, up: Array) -> Array:
        """Return by how much slopes between two ends may be beyond what is claimed."""
        match self.slope.word:
            case "increasing":
                return -down
            case "decreasing":
                return up
        found: Array = np.maximum(np.abs(down), np.abs(up)) - self.slope.limit
        return found

    def _why_stuck(self, output: int, axis: int) -> str:
        lo, hi = self.search.stuck[0]
        (found,), _ = self.system.evaluate(list(self.system.inputs_of(lo, hi, sloped=True).values()), [output])
        assert found.slopes is not None
        down, up = (np.broadcast_to(s, lo.shape)[axis] for s in found.slopes)
        if self._excess(down, up).max() > _NEAR * max(1.0, self.slope.limit):
            return "there one formula takes over from another, and slopes are known too roughly beside such places"
        return "the slope comes as close to its bound as rounding"

    def _step(self, output: int, axis: int) -> Witness | None:
        lo, hi = self.search.take()
        own = list(self.system.inputs_of(lo, hi, sloped=True).values())
        (found,), _ = self.system.evaluate(own, [output])
        if found.slopes is None:
            return None
        down, up = (np.broadcast_to(s, lo.shape)[axis] for s in found.slopes)
        open_ = ~(self._excess(down, up) <= 0.0)
        self.search.settled += int((~open_).sum())
        if not open_.any():
            return None
        for k in np.flatnonzero(open_)[:_TRIED]:
            witness = _broken(self.system, self.slope, self.judge, lo[:, k], hi[:, k], axis)
            if witness is not None:
                return witness
        self.search.put_halves(lo[:, open_], hi[:, open_], np.zeros_like(lo[:, open_]))
        return None
