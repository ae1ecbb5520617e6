"""Proof of a guarantee by branch and bound: boxes are halved until each is decided, or a witness is found."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from fuzzyctl.analysis.branch_and_bound.boxed_system import surely_false, surely_true
from fuzzyctl.analysis.branch_and_bound.queue import (
    FIRST,
    NEAR,
    TRIED,
    Boxed,
    BoxProgress,
    Search,
    middles,
    signed_points,
    start_of,
)
from fuzzyctl.analysis.claims import Bound, Claim, Truth, bounds_in
from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdict, Witness
from fuzzyctl.analysis.work import clock
from fuzzyctl.expr import Compare, Expr
from fuzzyctl.kernels.interval.vector import Array, Enclosure, Mask


class Enclosed(Boxed, Protocol):
    """A system or a step whose expressions can be enclosed over boxes."""

    def cells(self, truths: Sequence[Truth]) -> tuple[Array, Array] | None:
        """Return the boxes to begin with, shape (inputs, boxes) each; None for too many."""

    def enclose(self, exprs: Sequence[Expr], lo: Array, hi: Array, *, sloped: bool) -> tuple[list[Enclosure], Mask]:
        """Enclose expressions, and say in which boxes they have no value."""

    def is_limit(self, bound: Bound) -> bool:
        """Return whether one side is a number."""


class Judge(Protocol):
    """Evaluates points."""

    def broken(self, truth: Truth, region: Truth, point: Sequence[float]) -> Witness | None:
        """Return a point as a witness if it lies in the region and the claim is false there."""


def decide(system: Enclosed, claim: Claim, judge: Judge, timeout: float, progress: BoxProgress | None) -> Verdict:
    """Decide a claim about points by subdivision."""
    deadline = clock.now() + timeout
    cells = system.cells([claim.truth, claim.region])
    if cells is None:
        return Undecided(claim.text, "its terms cut the inputs into too many cells")
    with np.errstate(all="ignore"):
        search = _Pointwise(system, claim, judge, Search(system, *cells, deadline, progress))
        if search.holds_in(*cells):
            return Proved(claim.text)
    witness = first_witness(claim, judge, *cells, deadline)
    if witness is not None:
        return Refuted(claim.text, witness)
    with np.errstate(all="ignore"):
        return search.verdict()


def holds_in(system: Enclosed, claim: Claim, lo: Array, hi: Array) -> bool:
    """Return whether enclosures of the sides of a claim settle some boxes as they are.

    Args:
        system: The system of the claim.
        claim: The claim.
        lo, hi: Ends of the boxes, shape (inputs, boxes).
    """
    compared, conditions = (list(dict.fromkeys(bounds_in(t))) for t in (claim.truth, claim.region))
    with np.errstate(all="ignore"):
        enclosures, void = system.enclose([b.left - b.right for b in (*conditions, *compared)], lo, hi, sloped=False)
        upper = {b: e.hi for b, e in zip(conditions, enclosures, strict=False)}
        lower = {b: e.lo + float(b.tolerance) for b, e in zip(compared, enclosures[len(conditions) :], strict=True)}
        return bool(np.all(surely_false(claim.region, upper) | void | surely_true(claim.truth, lower)))


def first_witness(claim: Claim, judge: Judge, lo: Array, hi: Array, deadline: float) -> Witness | None:
    """Search for a witness among middles of cells (a corner is a cell of one point) until the deadline.

    Args:
        claim: The claim that a point has to break.
        judge: Evaluates points.
        lo, hi: Ends of the cells, shape (inputs, cells).
        deadline: When to stop, on the monotonic clock [s].
    """
    step = max(1, lo.shape[1] // FIRST)
    for k in range(0, lo.shape[1], step):
        if clock.now() > deadline:
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


class _Pointwise:
    def __init__(self, system: Enclosed, claim: Claim, judge: Judge, search: Search) -> None:
        self.system, self.claim, self.judge, self.search = system, claim, judge, search
        self.compared = list(dict.fromkeys(bounds_in(claim.truth)))
        self.conditions = list(dict.fromkeys(bounds_in(claim.region)))
        self.only_exact = not any(b.tolerance or system.is_limit(b) for b in self.compared)
        self.is_rounded = False

    def holds_in(self, lo: Array, hi: Array) -> bool:
        """Return whether enclosures of the sides settle all boxes as they are, so that no point need be tried.

        Args:
            lo, hi: Ends of the boxes, shape (inputs, boxes).
        """
        batch = self.system.batch
        for k in range(0, lo.shape[1], batch):
            if clock.now() > self.search.deadline:
                return False
            if not holds_in(self.system, self.claim, lo[:, k : k + batch], hi[:, k : k + batch]):
                return False
        return True

    def verdict(self) -> Verdict:
        wider = "; a wider tolerance takes less time" if self._is_loosened else ""
        result = self.search.halted(self.claim.text, self._step, self._why_stuck, wider=wider)
        if result is not None:
            return result
        note = "in exact arithmetic; kernels round" if self.is_rounded else ""
        return Proved(self.claim.text, note=note)

    def _why_stuck(self) -> str:
        exprs = [b.left - b.right for b in self.compared]
        enclosures, _ = self.system.enclose(exprs, *self.search.stuck[0], sloped=False)
        if any(np.isinf(e.lo).any() for e in enclosures):
            return "values may be infinite there, or none at all; 'when' can leave such points out"
        if any(
            (e.lo + float(b.tolerance) < -NEAR * (1.0 + e.size)).any()
            for b, e in zip(self.compared, enclosures, strict=True)
        ):
            return "too little is known of values there, as where rules hardly fire; 'when' can leave such points out"
        advice = "; a tolerance, such as 'within 1e-9', settles such points" if self._is_loosened else ""
        return f"it comes as close to its bound as rounding{advice}"

    @property
    def _is_loosened(self) -> bool:
        """Whether a tolerance makes the claim any weaker, as it does not where two things are to differ."""
        equalities = [b for b in self.compared if isinstance(b.origin, Compare) and b.origin.op in ("==", "!=")]
        return not any(b.strict for b in equalities)

    def _step(self) -> Witness | None:
        """Decide the boxes of a batch that can be decided, and halve the rest."""
        lo, hi = self.search.take()
        count = lo.shape[1]
        exprs = [b.left - b.right for b in (*self.conditions, *self.compared)]
        enclosures, void = self.system.enclose(exprs, lo, hi, sloped=True)
        number = len(self.conditions)
        upper = {b: np.broadcast_to(e.hi, count) for b, e in zip(self.conditions, enclosures, strict=False)}
        outside = np.broadcast_to(surely_false(self.claim.region, upper) | void, count)
        lower: dict[Bound, Array] = {}
        exact: dict[Bound, Array] = {}
        steepness, points, lowest = np.zeros_like(lo), middles(lo, hi), np.full(count, np.inf)
        for b, e, expr in zip(self.compared, enclosures[number:], exprs[number:], strict=True):
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
        order = np.argsort(lowest[open_])[:TRIED]
        for k in np.flatnonzero(open_)[order]:
            for point in (points[:, k], middles(lo[:, k], hi[:, k])):
                witness = _witness_of(self.claim, self.judge, point, lo[:, k], hi[:, k])
                if witness is not None:
                    return witness
        self.search.put_halves(lo[:, open_], hi[:, open_], steepness[:, open_])
        return None
