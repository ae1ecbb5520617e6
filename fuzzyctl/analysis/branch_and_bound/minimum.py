"""Minimum of an output by branch and bound: boxes that may hold it are halved down to a tolerance."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final, Protocol

import numpy as np

from fuzzyctl.analysis.branch_and_bound.boxed_system import System
from fuzzyctl.analysis.branch_and_bound.pointwise import Enclosed
from fuzzyctl.analysis.branch_and_bound.queue import Search, middles, signed_points, start_of
from fuzzyctl.analysis.work import Work
from fuzzyctl.expr import Name
from fuzzyctl.kernels.interval.vector import Array, negative

#: Boxes of a step that are evaluated by the kernel.
_TRIED: Final = 4
#: A slope is known well enough when its bound exceeds what two points show by this part.
_SLOPE_GAP: Final = 0.05
#: Units of work for a box that waits, in each step.
_WAITING: Final = 0.05


class Measured(Enclosed, Protocol):
    """A system or a step of known work."""

    @property
    def outputs(self) -> list[str]:
        """Names of the outputs."""

    def units(self, output: int, boxes: int) -> float:
        """Return the work of enclosing an output and its slopes over some boxes."""


def least(
    system: Measured,
    output: int,
    sign: int,
    gap: float,
    value: Callable[[list[float]], float],
    work: Work,
    deadline: float = math.inf,
) -> tuple[float, list[float] | None]:
    """Bound sign · output from below.

    Args:
        system: The system whose boxes are searched.
        output: Position of the output.
        sign: 1 or -1.
        gap: How far the bound may be below an attained value.
        value: Sign · output at a point by a kernel; NaN for none.
        work: The work that is allowed.
        deadline: When to stop in any case.

    Returns:
        The bound, and a point that comes near it, None if none was found.
    """
    cells = system.cells([])
    if cells is None:
        return -math.inf, None
    with np.errstate(all="ignore"):
        return _Least(system, output, sign, value).run(*cells, gap, work, deadline)


class _Least:
    def __init__(self, system: Measured, output: int, sign: int, value: Callable[[list[float]], float]) -> None:
        self.expr = Name(system.outputs[output])
        self.system, self.output, self.sign, self.value = system, output, sign, value
        self.best = math.inf
        self.point: list[float] | None = None

    def run(self, lo: Array, hi: Array, gap: float, work: Work, deadline: float) -> tuple[float, list[float] | None]:
        search = Search(self.system, lo, hi, deadline, None)
        bounds = np.full(lo.shape[1], -np.inf)
        settled = math.inf
        while search.lo.shape[1] and not self._is_over(search) and work.takes(_units(self.system, search, self.output)):
            # The lowest bounds are last, and the next batch is taken from the end.
            order = np.argsort(-bounds, kind="stable")
            search.lo, search.hi, bounds = search.lo[:, order], search.hi[:, order], bounds[order]
            count = min(self.system.batch, len(bounds))
            if bounds[-1] >= self.best - gap:
                break
            bounds = bounds[: len(bounds) - count]
            box_lo, box_hi = search.take()
            lower, steepness, points = self._lower(box_lo, box_hi)
            self._try(points, box_lo, box_hi, lower)
            keep = lower < self.best - gap
            settled = min(settled, float(lower[~keep].min(initial=math.inf)))
            halved = search.put_halves(box_lo[:, keep], box_hi[:, keep], steepness[:, keep])
            settled = min(settled, float(lower[keep][~halved].min(initial=math.inf)))
            bounds = np.concatenate([bounds, lower[keep][halved], lower[keep][halved]])
        return min(settled, float(bounds.min(initial=math.inf)), self.best), self.point

    @staticmethod
    def _is_over(search: Search) -> bool:
        """Return whether room or time is used up; without a deadline no clock is read."""
        return search.is_over if search.deadline < math.inf else search.is_full

    def _lower(self, lo: Array, hi: Array) -> tuple[Array, Array, Array]:
        """Return lower bounds over boxes, slopes, and points where the value is low."""
        system, count = self.system, lo.shape[1]
        (enclosure,), void = system.enclose([self.expr], lo, hi, sloped=True)
        e = enclosure if self.sign > 0 else negative(enclosure)
        natural = np.broadcast_to(e.lo, count)
        void = np.broadcast_to(void, count)
        if e.slopes is None:
            return np.where(void, math.inf, natural), np.zeros_like(lo), middles(lo, hi)
        down, up = (np.broadcast_to(s, lo.shape) for s in e.slopes)
        start, slack = start_of(lo, hi, down, up)
        (there,), _ = system.enclose([self.expr], start, start, sloped=False)
        low = there.lo if self.sign > 0 else -there.hi
        straight = low - slack * (1.0 + 1e-12) - e.error
        straight = straight - np.abs(straight) * 1e-15
        bound = np.where(void, math.inf, np.fmax(natural, straight))
        return bound, np.maximum(np.abs(down), np.abs(up)), start

    def _try(self, points: Array, lo: Array, hi: Array, bounds: Array) -> None:
        for k in np.argsort(bounds)[:_TRIED]:
            for point in signed_points(points[:, k], lo[:, k], hi[:, k]):
                value = self.value(point)
                if value < self.best:
                    self.best, self.point = value, point


def steepest(system: System, output: int, position: int, work: Work) -> float:
    """Bound the slope of an output along an input; infinite where it may jump."""
    cells = system.cells([])
    if cells is None or not system.is_continuous(output):
        return math.inf
    lo, hi = cells
    whole = (lo < hi).all(axis=0)
    with np.errstate(all="ignore"):
        return _steepest(system, output, position, Search(system, lo[:, whole], hi[:, whole], math.inf, None), work)


def _steepest(system: System, output: int, position: int, search: Search, work: Work) -> float:
    bounds, floor, settled = np.full(search.lo.shape[1], np.inf), 0.0, 0.0
    while search.lo.shape[1] and not search.is_full:
        order = np.argsort(bounds, kind="stable")
        search.lo, search.hi, bounds = search.lo[:, order], search.hi[:, order], bounds[order]
        if bounds[-1] <= floor * (1.0 + _SLOPE_GAP) or not work.takes(_units(system, search, output)):
            break
        count = min(system.batch, len(bounds))
        bounds = bounds[: len(bounds) - count]
        lo, hi = search.take()
        slopes = _slopes(system, output, position, lo, hi)
        middle = middles(lo, hi)
        floor = max(floor, float(_least_slopes(system, output, position, middle).max(initial=0.0)))
        keep = slopes > floor * (1.0 + _SLOPE_GAP)
        settled = max(settled, float(slopes[~keep].max(initial=0.0)))
        halved = search.put_halves(lo[:, keep], hi[:, keep], np.zeros_like(lo[:, keep]))
        settled = max(settled, float(slopes[keep][~halved].max(initial=0.0)))
        bounds = np.concatenate([bounds, slopes[keep][halved], slopes[keep][halved]])
    return max(settled, float(bounds.max(initial=0.0)))


def _units(system: Measured, search: Search, output: int) -> float:
    """Return the work of the next batch, in which the output is enclosed over boxes and at points in them."""
    waiting = int(search.lo.shape[1])
    return 2.0 * system.units(output, min(system.batch, waiting)) + _WAITING * waiting


def _slopes(system: System, output: int, position: int, lo: Array, hi: Array) -> Array:
    """Return upper bounds of the magnitude of slopes over boxes."""
    (e,), _ = system.evaluate(list(system.inputs_of(lo, hi, sloped=True).values()), [output])
    if e.slopes is None:
        return np.zeros(lo.shape[1])
    down, up = (np.broadcast_to(s, lo.shape)[position] for s in e.slopes)
    slopes: Array = np.maximum(np.abs(down), np.abs(up))
    return slopes


def _least_slopes(system: System, output: int, position: int, points: Array) -> Array:
    """Return a lower bound of the magnitude of the slope at some points."""
    (e,), _ = system.evaluate(list(system.inputs_of(points, points, sloped=True).values()), [output])
    if e.slopes is None:
        return np.zeros(points.shape[1])
    down, up = (np.broadcast_to(s, points.shape)[position] for s in e.slopes)
    least_slopes: Array = np.maximum(np.maximum(down, -up), 0.0)
    return least_slopes
