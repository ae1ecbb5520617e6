"""Proved errors of lookup tables: enclosures of system and slopes, in boxes; the one with the largest bound is halved.

In a box both functions lie within their enclosures, and so does their difference; it also lies within its value in
the middle and its slopes times half the width of the box (the mean value form: R. E. Moore, R. B. Kearfott and M. J.
Cloud, *Introduction to Interval Analysis*, SIAM, 2009). The smaller bound counts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Final

import numpy as np
import numpy.typing as npt

from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.expr import walk
from fuzzyctl.kernels.algorithms.grid import Grid
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.interval.program import Interpreter
from fuzzyctl.kernels.interval.vector import Array, boxes, constant
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.program.program import Accumulate, Assign, Program

#: Most operations for all boxes, a few seconds.
MOST_OPERATIONS: Final = 40_000_000
#: Boxes at a time.
_AT_ONCE: Final = 1024
#: A bound that exceeds an attained value by this is near enough.
_NEAR: Final = 1.1
#: In boxes below this part of the range, a quotient whose denominator may be 0 will have no bound either.
_LEAST_WIDTH: Final = 1e-3


@dataclass(frozen=True)
class Boxes:
    """Boxes of the inputs of a table: their ends, shape (inputs, boxes)."""

    lo: Array
    hi: Array

    @property
    def count(self) -> int:
        """How many there are."""
        return int(self.lo.shape[1])

    def chosen(self, which: npt.NDArray[np.int_] | slice) -> Boxes:
        """Return some of them."""
        return Boxes(self.lo[:, which], self.hi[:, which])

    def joined(self, other: Boxes) -> Boxes:
        """Return these boxes and others."""
        return Boxes(np.concatenate((self.lo, other.lo), axis=1), np.concatenate((self.hi, other.hi), axis=1))

    def halved(self, scale: Array) -> Boxes:
        """Return both halves of each box, cut across its longest side, as part of a scale of shape (inputs, 1)."""
        axis = np.argmax((self.hi - self.lo) / scale, axis=0)
        cut = np.arange(len(self.lo))[:, None] == axis
        middle = 0.5 * self.lo + 0.5 * self.hi
        left = Boxes(self.lo, np.where(cut, middle, self.hi))
        return left.joined(Boxes(np.where(cut, middle, self.lo), self.hi))


def enclosed(flat: Plan, table: Grid) -> tuple[float, ...]:
    """Bound the error of a table for all inputs.

    Args:
        flat: The system, whose outputs have a value everywhere.
        table: Its values at the knots, multilinear between.

    Returns:
        A bound for each output, infinite if the search finds none.

    Raises:
        CodegenError: Where there are more boxes than can be enclosed in some seconds.
    """
    with np.errstate(all="ignore"):  # a value that overflows has no useful bound
        return _enclosed(flat, table)


def _enclosed(flat: Plan, table: Grid) -> tuple[float, ...]:
    program = inference.evaluation(flat)
    left = MOST_OPERATIONS // _cost(program)
    sides = [_sides(flat, i, k) for i, k in zip(table.inputs, table.knots, strict=True)]
    if math.prod(map(len, sides)) > left:
        raise CodegenError("the error of the table is not bounded: the system is too large for interval analysis")
    ends = np.array(list(product(*sides)), dtype=np.float64).reshape(-1, len(sides), 2)
    pending = Boxes(np.ascontiguousarray(ends[:, :, 0].T), np.ascontiguousarray(ends[:, :, 1].T))
    scale = np.array([[k[-1] - k[0]] for k in table.knots])
    most, least = _errors(program, table, pending)
    left -= pending.count
    attained = least.max(axis=1, keepdims=True)
    while True:
        excess = (most / np.maximum(_NEAR * attained, np.finfo(float).tiny)).max(axis=0)
        order = np.argsort(-excess, kind="stable")
        count = min(int((excess > 1.0).sum()), left // 2, max(_AT_ONCE // 2, pending.count // 16))
        if not count or _has_pole(most, pending, scale):
            break
        halves = pending.chosen(order[:count]).halved(scale)
        upper, least = _errors(program, table, halves)
        left -= halves.count
        attained = np.maximum(attained, least.max(axis=1, keepdims=True))
        pending = pending.chosen(order[count:]).joined(halves)
        most = np.concatenate((most[:, order[count:]], upper), axis=1)
    worst = most.max(axis=1)
    slack = [1e-12 * max(map(abs, t.value)) for t in table.outputs]
    return tuple(float(w) + s for w, s in zip(worst, slack, strict=True))


def _has_pole(most: Array, own: Boxes, scale: Array) -> bool:
    """Return whether some box that has been halved often is without a bound still."""
    small = ((own.hi - own.lo) / scale).max(axis=0) < _LEAST_WIDTH
    return bool((np.isinf(most).any(axis=0) & small).any())


def _cost(program: Program) -> int:
    """Return the operations for one box."""
    total = 1
    for statement in program.body:
        match statement:
            case Assign(value=value):
                total += sum(1 for _ in walk(value))
            case Accumulate(count=count, body=body, sums=sums):
                total += count * sum(1 for step in (*body, *sums) for _ in walk(step.value))
    return total


def _sides(flat: Plan, position: int, knots: Sequence[float]) -> list[tuple[float, float]]:
    """Return stretches between knots and corners of terms, and the corners: slopes jump there, and terms may."""
    sets = [d.set for d in flat.degrees if d.variable == position]
    places = {x for s in sets for x in ([v[0] for v in s.vertices] or s.pieces)}
    corners = {x for x in places if knots[0] <= x <= knots[-1]}
    sides = [(x, x) for x in sorted(corners)]
    for a, b in pairwise(sorted({*knots, *corners})):
        start = math.nextafter(a, math.inf) if a in corners else a
        stop = math.nextafter(b, -math.inf) if b in corners else b
        if start <= stop:
            sides.append((start, stop))
    return sides


def _errors(program: Program, table: Grid, own: Boxes) -> tuple[Array, Array]:
    """Return bounds of the error in each box from above and below, shape (outputs, boxes)."""
    parts = [slice(k, k + _AT_ONCE) for k in range(0, own.count, _AT_ONCE)]
    results = [_errors_of_some(program, table, own.chosen(part)) for part in parts]
    return np.concatenate([f[0] for f in results], axis=1), np.concatenate([f[1] for f in results], axis=1)


def _errors_of_some(program: Program, table: Grid, own: Boxes) -> tuple[Array, Array]:
    middle = 0.5 * own.lo + 0.5 * own.hi
    there = _system(program, table, own)
    inside = _system(program, table, Boxes(middle, middle))
    rows = []
    for k, output in enumerate(table.outputs):
        values = np.array(output.value).reshape([len(x) for x in table.knots])
        corners = _at_corners(values, table.knots, own)
        center = _at(values, table.knots, middle)
        (lo, hi, slopes), (low, high, _) = there[k], inside[k]
        whole = np.maximum(hi - corners.min(axis=0), corners.max(axis=0) - lo)
        steep = np.maximum(high - center, center - low) + _swing(slopes, corners, own)
        most = np.fmin(whole, steep)
        least = np.maximum(np.maximum(low - center, center - high), 0.0)
        rows.append((np.where(np.isnan(most), np.inf, most), np.where(np.isnan(least), 0.0, least)))
    return np.array([r[0] for r in rows]), np.array([r[1] for r in rows])


def _system(program: Program, table: Grid, own: Boxes) -> list[tuple[Array, Array, tuple[Array, Array]]]:
    """Enclose each output and its slopes in each box."""
    names = {name: constant(0.0) for name in program.arguments}
    enclosures = boxes(own.lo, own.hi)
    names |= {program.arguments[i]: e for i, e in zip(table.inputs, enclosures, strict=True)}
    shape = own.lo.shape
    system = []
    for e in Interpreter(names).run(program, range(len(program.results))):
        flat = e.slopes if e.slopes is not None else (np.zeros(shape), np.zeros(shape))
        slopes = np.broadcast_to(flat[0], shape), np.broadcast_to(flat[1], shape)
        system.append((np.broadcast_to(e.lo, shape[1:]), np.broadcast_to(e.hi, shape[1:]), slopes))
    return system


def _swing(slopes: tuple[Array, Array], corners: Array, own: Boxes) -> Array:
    """Return how far the difference may be from its value in the middle: half of its change along each input."""
    total = np.zeros(own.count)
    for i, width in enumerate(own.hi - own.lo):
        pairs = corners.reshape(1 << i, 2, -1, own.count)
        change = (pairs[:, 1] - pairs[:, 0]).reshape(-1, own.count)
        low, high = width * slopes[0][i], width * slopes[1][i]
        most = np.maximum(high - change.min(axis=0), change.max(axis=0) - low)
        total += np.where(width > 0.0, 0.5 * most, 0.0)
    return total


def _at_corners(values: Array, knots: Sequence[Sequence[float]], own: Boxes) -> Array:
    """Return a table at the corners of boxes, shape (corners, boxes), the last input's end varying fastest."""
    ends = product(*zip(own.lo, own.hi, strict=True))
    return np.array([_at(values, knots, np.array(corner)) for corner in ends])


def _at(values: Array, knots: Sequence[Sequence[float]], points: Array) -> Array:
    """Return a table at points of shape (inputs, points)."""
    cells, shares = [], []
    for axis, x in zip(knots, points, strict=True):
        places = np.array(axis)
        cell = np.clip(np.searchsorted(places, x, side="right") - 1, 0, len(axis) - 2)
        cells.append(cell)
        shares.append((x - places[cell]) / (places[cell + 1] - places[cell]))
    total = np.zeros(points.shape[1])
    for corner in product((0, 1), repeat=len(knots)):
        weight = np.ones(points.shape[1])
        for bit, share in zip(corner, shares, strict=True):
            weight = weight * (share if bit else 1.0 - share)
        total += weight * values[tuple(c + bit for c, bit in zip(cells, corner, strict=True))]
    return total
