"""Ranges and slopes of the operations of a fixed-point step, along its states and along each of its roundings.

A fixed-point step is the step in real arithmetic with something added to the value of each operation: what rounding
makes of it. So an operation is a function of the states and of these roundings, and its slopes along all of them, over
ranges that both programs keep, bound how far its value is from that of the program in double precision.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

import numpy as np

from fuzzyctl.codegen.fixed.fixed_program import Operation, Operations
from fuzzyctl.codegen.fixed.fixed_system import Fixed
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.kernels.algorithms.grid import Grid, Table
from fuzzyctl.kernels.interval.vector import (
    ULPS,
    Array,
    Enclosure,
    Slopes,
    Truths,
    compared,
    constant,
    either,
    larger,
    minus,
    negative,
    outward,
    plus,
    slope_times,
    smaller,
    times,
)

#: Ranges by position.
Ends = tuple[float, float]


@dataclass(frozen=True)
class CalledSystem:
    """A system of a step: its integers, and the surface that they stand for.

    Args:
        unit: The system.
        grid: The surface.
        fixed: The integers.
    """

    unit: Unit
    grid: Grid
    fixed: Fixed

    def enclose(self, output: int, given: Sequence[Enclosure]) -> Enclosure:
        """Enclose an output; its slopes are between those of all cells, and 0 where inputs lie outside the knots."""
        table = self.grid.outputs[output]
        lo, hi = outward(np.array(min(table.value)), np.array(max(table.value)))
        slopes: Slopes = None
        # The value of the kernel, from rules or from the cell.
        size = max(abs(v) for v in table.value)
        error = np.array((len(self.unit.plan.rules) + 64) * 2.0**-52 * size)
        for d, i in enumerate(self.grid.inputs):
            low, high = _steepest(self.grid, table, d)
            error = error + max(-low, high) * given[i].error
            inner = given[i].slopes
            if inner is not None:
                part = slope_times((np.array(low), np.array(high)), inner)
                slopes = part if slopes is None else outward(slopes[0] + part[0], slopes[1] + part[1])
        return Enclosure(lo, hi, slopes, error)


def _steepest(grid: Grid, table: Table, axis: int) -> Ends:
    """Return the least and the largest slope along an input, with 0 between them."""
    shape = [len(k) for k in grid.knots]
    values = np.array(table.value).reshape(shape)
    if shape[axis] < 2:
        return 0.0, 0.0
    widths = np.array([b - a for a, b in pairwise(grid.knots[axis])])
    rises = np.moveaxis(np.diff(values, axis=axis), axis, -1)
    # Differences are rounded, and the kernel's own coefficients are those of other differences.
    slopes, slack = rises / widths, 8 * ULPS * float(np.abs(values).max()) / float(widths.min())
    return min(0.0, float(slopes.min()) - slack), max(0.0, float(slopes.max()) + slack)


@dataclass
class Ranges:
    """Encloses all operations of a step.

    Args:
        operations: The operations.
        systems: The systems that they call, by number.
        inputs: Ranges of the inputs.
        slots: Ranges of the slots, which the double program never leaves.
        errors: How far each slot may be from that of the double program; None for one that is equal.
        roundings: The largest error that each operation adds.
    """

    operations: Operations
    systems: Mapping[int, CalledSystem]
    inputs: Sequence[Ends]
    slots: Sequence[Ends]
    errors: Sequence[float | None]
    roundings: Sequence[float]
    #: The operands that decide conditions alike in both programs, by position.
    alike: Callable[[int], bool] = lambda _: False
    #: How far values may jump where rounding decides which one is taken, by position.
    jumps: dict[int, float] = field(default_factory=dict)
    _found: list[Enclosure] = field(default_factory=list)
    _truths: dict[int, Truths] = field(default_factory=dict)

    def run(self) -> list[Enclosure]:
        """Return enclosures of all operations; those of conditions are between 0 and 1."""
        with np.errstate(all="ignore"):
            for k, item in enumerate(self.operations.items):
                if item.is_condition:
                    self._truths[k] = self._decided(item)
                    self._found.append(constant(0.0, 1.0))
                else:
                    enclosure = self._rounded(k, self._value(k, item))
                    self._found.append(self._kept(item.place, enclosure) if item.kind == "store" else enclosure)
        return self._found

    def _kept(self, slot: int, enclosure: Enclosure) -> Enclosure:
        """Return the next value of a slot within the range that no step leaves, further by its error."""
        (low, high), off = self.slots[slot], self.errors[slot] or 0.0
        lo, hi = np.maximum(enclosure.lo, low - off), np.minimum(enclosure.hi, high + off)
        return Enclosure(lo, hi, enclosure.slopes, enclosure.error)

    def _rounded(self, k: int, value: Enclosure) -> Enclosure:
        most = self.roundings[k]
        if not most and k not in self.jumps:
            return value
        # A value that jumps is that of one choice or of the other, and so within the same range.
        return plus(value, Enclosure(np.array(-most), np.array(most), self._unit(k), np.array(0.0)))

    def _unit(self, k: int) -> tuple[Array, Array]:
        unit = np.zeros((len(self.operations.items), 1))
        unit[k] = 1.0
        return unit, unit

    def _value(self, k: int, item: Operation) -> Enclosure:
        operands = [self._found[p] for p in item.operands]
        match item.kind:
            case "input":
                return constant(*self.inputs[item.place])
            case "slot":
                (low, high), off = self.slots[item.place], self.errors[item.place]
                if off is None:
                    return constant(low, high)
                return Enclosure(np.array(low - off), np.array(high + off), self._unit(k), np.array(0.0))
            case "constant":
                return constant(float(item.factor))
            case "scale":
                return times(operands[0], constant(*_around(item)))
            case "where":
                return self._chosen(k, item)
            case "system":
                return self.systems[item.system].enclose(item.place, operands)
            case "argument":
                form = self.systems[item.system].fixed.format
                return larger(smaller(operands[0], constant(form.upper)), constant(form.lower))
            case "output" | "store":
                return operands[0]
        return _FUNCTIONS[item.kind](*operands)

    def _chosen(self, k: int, item: Operation) -> Enclosure:
        condition, then, otherwise = item.operands
        a, b = self._found[then], self._found[otherwise]
        yes, no = self._truths[condition]
        if yes.all() or no.all():
            return a if yes.all() else b
        if not self.alike(condition):
            self.jumps[k] = float(minus(a, b).size.max())
        lo, hi = np.minimum(a.lo, b.lo), np.maximum(a.hi, b.hi)
        return Enclosure(lo, hi, either(yes, no, a.slopes, b.slopes), np.maximum(a.error, b.error))

    def _decided(self, item: Operation) -> Truths:
        match item.kind:
            case "compare":
                return compared(item.op, *(self._found[p] for p in item.operands))
            case "compared":
                return compared(item.op, self._found[item.operands[0]], constant(*_around(item)))
        truths = [self._truths[p] for p in item.operands]
        yes, no = truths[0]
        if item.kind == "not":
            return no, yes
        for y, n in truths[1:]:
            yes, no = (yes & y, no | n) if item.kind == "and" else (yes | y, no & n)
        return yes, no


def _around(item: Operation) -> Ends:
    """Return two numbers between which a factor lies: quotients are not doubles."""
    near = float(item.factor)
    return (
        (near, near) if item.factor == near else (float(np.nextafter(near, -np.inf)), float(np.nextafter(near, np.inf)))
    )


def _magnitude(a: Enclosure) -> Enclosure:
    return larger(a, negative(a))


_FUNCTIONS: Final[Mapping[str, Callable[..., Enclosure]]] = {
    "+": plus,
    "-": minus,
    "*": times,
    "min": smaller,
    "max": larger,
    "abs": _magnitude,
}
