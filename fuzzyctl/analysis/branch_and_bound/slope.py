"""Proof of claims about slopes by branch and bound."""

from __future__ import annotations

import numpy as np

from fuzzyctl.analysis.branch_and_bound.boxed_system import System
from fuzzyctl.analysis.branch_and_bound.queue import FIRST, NEAR, TRIED, BoxProgress, Search, middles, signed_points
from fuzzyctl.analysis.claims import Claim, Slope
from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdict, Witness
from fuzzyctl.analysis.witnesses import Judge
from fuzzyctl.analysis.work import clock
from fuzzyctl.kernels.interval.vector import Array


def decide_slope(
    system: System, claim: Claim, slope: Slope, judge: Judge, timeout: float, progress: BoxProgress | None
) -> Verdict:
    """Decide a word about slopes by subdivision."""
    deadline = clock.now() + timeout
    output, axis = system.outputs.index(slope.output), system.inputs.index(slope.input)
    cells = system.cells([])
    if cells is None:
        return Undecided(claim.text, "its terms cut the inputs into too many cells")
    lo, hi = cells
    whole = (lo < hi).all(axis=0)
    for k in range(0, lo.shape[1], max(1, lo.shape[1] // FIRST)):
        if clock.now() > deadline:
            break
        witness = _broken(system, slope, judge, lo[:, k], hi[:, k], axis)
        if witness is not None:
            return Refuted(claim.text, witness)
    if not system.is_continuous(output):
        return Undecided(claim.text, f"'{slope.output}' is not known to be continuous")
    search = Search(system, lo[:, whole], hi[:, whole], deadline, progress)
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
        result = self.search.halted(
            self.claim.text, lambda: self._step(output, axis), lambda: self._why_stuck(output, axis)
        )
        return Proved(self.claim.text, note="in exact arithmetic; kernels round") if result is None else result

    def _excess(self, down: Array, up: Array) -> Array:
        """Return the largest distance of slopes between two ends from the claimed bound."""
        match self.slope.word:
            case "increasing":
                return -down
            case "decreasing":
                return up
        excess: Array = np.maximum(np.abs(down), np.abs(up)) - self.slope.limit
        return excess

    def _why_stuck(self, output: int, axis: int) -> str:
        lo, hi = self.search.stuck[0]
        (enclosure,), _ = self.system.evaluate(list(self.system.inputs_of(lo, hi, sloped=True).values()), [output])
        assert enclosure.slopes is not None
        down, up = (np.broadcast_to(s, lo.shape)[axis] for s in enclosure.slopes)
        if self._excess(down, up).max() > NEAR * max(1.0, self.slope.limit):
            return "there one formula takes over from another, and slopes are known too roughly beside such points"
        return "the slope comes as close to its bound as rounding"

    def _step(self, output: int, axis: int) -> Witness | None:
        lo, hi = self.search.take()
        inputs = list(self.system.inputs_of(lo, hi, sloped=True).values())
        (enclosure,), _ = self.system.evaluate(inputs, [output])
        if enclosure.slopes is None:  # they are 0 throughout
            return None
        down, up = (np.broadcast_to(s, lo.shape)[axis] for s in enclosure.slopes)
        open_ = ~(self._excess(down, up) <= 0.0)
        self.search.settled += int((~open_).sum())
        if not open_.any():
            return None
        for k in np.flatnonzero(open_)[:TRIED]:
            witness = _broken(self.system, self.slope, self.judge, lo[:, k], hi[:, k], axis)
            if witness is not None:
                return witness
        self.search.put_halves(lo[:, open_], hi[:, open_], np.zeros_like(lo[:, open_]))
        return None
