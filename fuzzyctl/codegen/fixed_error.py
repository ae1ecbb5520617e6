"""Proved error bounds of fixed-point programs, in rational arithmetic."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Final

from fuzzyctl.codegen.fixed_format import Axis, Entries, Format
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.kernels.algorithms.grid import Grid, Table

#: Corners closer than this part of the range count as one knot (`kernels.grid`).
_SAME: Final = Fraction(1, 10**14)


def proved(
    unit: Unit,
    grid: Grid,
    inner: Sequence[int],
    axes: Sequence[Axis],
    table: Table,
    entries: Entries,
    form: Format,
    share_bits: int,
) -> float:
    """Bound the error of an output for every input of the format, in exact arithmetic.

    With the knots moved the system is a multilinear function of inputs moved by `off` at most, so it changes by the
    slope times that. Each interpolation keeps the error of its ends, adds the error of the share times their
    difference, and rounds once.
    """
    step = Fraction(1, 1 << (form.fraction + entries.guard))
    error = step / 2
    slopes = Fraction(0)
    for d, axis in sorted(zip(inner, axes, strict=True), reverse=True):
        rise, slope = _steepest(grid, table, d)
        error += Fraction(1, 1 << (share_bits + 1)) * (rise + 2 * error) + step / 2
        span = Fraction(grid.knots[d][-1]) - Fraction(grid.knots[d][0])
        slopes += slope * (axis.off + _SAME * span)
    if entries.guard:
        error += Fraction(1, 1 << (form.fraction + 1))
    # What the table itself is off by, computed in floating point from all rules.
    largest = max(abs(Fraction(v)) for v in table.value)
    error += slopes + (len(unit.plan.rules) + 64) * Fraction(1, 1 << 52) * largest
    return float(error) * (1.0 + 2.0**-50)


def _steepest(grid: Grid, table: Table, axis: int) -> tuple[Fraction, Fraction]:
    """Return the largest difference of neighbours along an input, and the largest slope."""
    stride = math.prod(len(k) for k in grid.knots[axis + 1 :])
    knots = grid.knots[axis]
    rise = slope = Fraction(0)
    widths = [Fraction(b) - Fraction(a) for a, b in pairwise(knots)]
    largest = [0.0] * len(widths)
    for position in range(len(table.value) - stride):
        k = position // stride % len(knots)
        if k < len(widths):
            own = abs(table.value[position + stride] - table.value[position])
            # Differences of floats are rounded; one unit more is an upper bound.
            largest[k] = max(largest[k], math.nextafter(own, math.inf))
    for most, width in zip(largest, widths, strict=True):
        rise, slope = max(rise, Fraction(most)), max(slope, Fraction(most) / width)
    return rise, slope
