"""Fixed-point programs of multilinear systems: integers only, with a proved error bound.

An input x is the integer X = x · 2^n. Along each input the cell is found among integer knots, and the share of the way
through it, rounded to p bits, weighs the entries at its ends: (a (2^p - s) + b s + 2^(p-1)) / 2^p, all in unsigned
integers, so that no result depends on how a compiler shifts negative numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import islice, pairwise, product
from typing import Final

from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.fixed.fixed_format import Axis, Entries, Format
from fuzzyctl.codegen.table import USEFUL, at_most, tabulated
from fuzzyctl.codegen.unit import Evaluated, Unit
from fuzzyctl.kernels.algorithms.grid import Grid, Table, grid_of
from fuzzyctl.kernels.algorithms.select import Algorithm
from fuzzyctl.kernels.plan.build import Plan

#: Most entries of a table.
MOST_ENTRIES: Final = 1 << 16
#: Most inputs of a table that is made and proved only to say that it does: with more that takes a quarter of a minute.
_TRIED: Final = 2
#: Points of the table for a system that does not interpolate; the first that makes it small enough is used.
_POINTS: Final = (33, 17, 9, 5)
#: Most extra bits of knots and of entries.
_EXTRA: Final = 20
#: Corners closer than this part of the range count as one knot (`kernels.grid`).
_SAME: Final = Fraction(1, 10**14)
#: A number that is so far beyond the ends, in parts of the last place, is rounded to them.
_ROUNDED: Final = Fraction(1, 8)


@dataclass(frozen=True)
class Fixed:
    """Integers that take the place of a system.

    Args:
        format: The format of inputs and outputs.
        share_bits: Bits of the share of the way through a cell.
        axes: The inputs that matter, in order.
        outputs: The entries of each output.
        errors: Proved bound of |output - exact output| for every input that the format can express.
    """

    format: Format
    share_bits: int
    axes: tuple[Axis, ...]
    outputs: tuple[Entries, ...]
    errors: tuple[float, ...]

    def evaluate(self, point: Sequence[int]) -> tuple[int, ...]:
        """Compute the outputs, bit for bit as the generated code does."""
        cells = [self._located(axis, point[axis.input]) for axis in self.axes]
        return tuple(self._interpolated(entries, cells) for entries in self.outputs)

    def _located(self, axis: Axis, x: int) -> tuple[int, int]:
        u = (min(max(x, axis.least), axis.most) - axis.least) << axis.shift
        k = max((k for k in range(len(axis.knots) - 1) if axis.knots[k] <= u), default=0)
        left, right = axis.knots[k], axis.knots[k + 1]
        if u <= left or u >= right:
            return k, 0 if u <= left else 1 << self.share_bits
        width = right - left
        return k, (((u - left) << self.share_bits) + width // 2) // width

    def _interpolated(self, entries: Entries, cells: Sequence[tuple[int, int]]) -> int:
        p = self.share_bits
        items = [entries.values[k] for k in corners(self.axes, [k for k, _ in cells])]
        for _, share in reversed(cells):
            pairs = zip(items[::2], items[1::2], strict=True)
            items = [(a * ((1 << p) - share) + b * share + (1 << (p - 1))) >> p for a, b in pairs]
        rounding = (1 << entries.guard) >> 1
        return entries.base + ((items[0] + rounding) >> entries.guard)


def corners(axes: Sequence[Axis], cell: Sequence[int]) -> Iterator[int]:
    """Yield the positions of a cell's corners among the entries, the last input varying fastest."""
    strides = strides_of(axes)
    start = sum(k * s for k, s in zip(cell, strides, strict=True))
    for steps in product(*((0, s) for s in strides)):
        yield start + sum(steps)


def strides_of(axes: Sequence[Axis]) -> list[int]:
    """Return the distance of neighbours along each input in the list of entries."""
    return [math.prod(len(a.knots) for a in axes[i + 1 :]) for i in range(len(axes))]


def fixed_point(unit: Unit, form: Format) -> Fixed:
    """Turn a system that interpolates into integers.

    Raises:
        CodegenError: For a system that does not interpolate, or whose output is a quotient; for knots or outputs that
            the format does not reach or does not tell apart, or for which no useful bound is found.
    """
    grid = unit.algorithm.grid
    if grid is None or any(t.weight for t in grid.outputs):
        raise CodegenError(_not_interpolated(unit, form))
    if grid.size > MOST_ENTRIES:
        raise CodegenError(f"the system has {grid.size:,} knots, more than {MOST_ENTRIES:,}")
    result = _held(unit, grid, form)
    if isinstance(result, str):
        raise CodegenError(f"{result}{_instead(unit, grid, form)}")
    return result


def finest(unit: Unit) -> Fixed:
    """Turn a system into integers of 32 bits, as many of them behind the point as its knots and values leave.

    Raises:
        CodegenError: See `fixed_point`.
    """
    grid = unit.algorithm.grid
    forms = [] if grid is None else _finest(unit.plan, grid, Format(0, 1))
    return fixed_point(unit, forms[-1] if forms else Format(15, 16))


def _not_interpolated(unit: Unit, form: Format) -> str:
    """Return why a system is not interpolated, and what would be."""
    grid = grid_of(unit.plan)
    if isinstance(grid, str):
        reason = f"fixed point needs a system that interpolates, and this one does not: {grid}"
    elif any(t.weight for t in grid.outputs):
        reason = "fixed point needs activations that sum to 1, and those of this system do not"
    else:
        return (
            f"fixed point needs interpolation, which algorithm '{unit.algorithm.name}' excludes; take --algorithm "
            "interpolation"
        )
    return f"{reason}; {_with_table(unit, form)}"


def _with_table(unit: Unit, form: Format) -> str:
    """Return the options of a table that does, or the reason why no table does."""
    inputs = len(unit.plan.inputs)
    if inputs > _TRIED:
        return f"whether a table of {inputs} inputs does, --table N --fixed {form} tells"
    points = next((n for n in _POINTS if n**inputs <= MOST_ENTRIES), _POINTS[-1])
    try:
        table = tabulated(unit.algorithm, points)
    except CodegenError as error:
        return f"nor does a table take its place: {error}"
    candidate = replace(unit, systems=(Evaluated(unit.system, Algorithm(unit.plan, table.grid, "a table"), table),))
    for other in (form, *_finest(candidate.plan, table.grid, form)):
        result = _held(candidate, table.grid, other)
        if isinstance(result, Fixed):
            return f"--table {points} --fixed {other} does, off by {at_most(max(result.errors))} at most"
    return f"and no format of 32 bits holds a table of {points} points"


def _instead(unit: Unit, grid: Grid, form: Format) -> str:
    """Return a format that does."""
    for other in _finest(unit.plan, grid, form):
        result = _held(unit, grid, other)
        if isinstance(result, Fixed):
            return f"; {other} does, off by {at_most(max(result.errors))} at most"
    if unit.table is not None and not _beyond(unit.plan, grid, form):
        return "; take more points of the table"
    return "; nor does any other format of up to 32 bits"


def _finest(flat: Plan, grid: Grid, form: Format) -> list[Format]:
    """Return formats with most bits behind the point that hold knots and values: in as many bits, then in 32."""
    results = []
    for bits in dict.fromkeys((form.bits, 32)):
        formats = (Format(m, bits - 1 - m) for m in range(bits))
        results += list(islice((f for f in formats if not _beyond(flat, grid, f)), 1))
    return [f for f in results if f != form]


def _held(unit: Unit, grid: Grid, form: Format) -> Fixed | str:
    """Return the integers, or why the format does not do."""
    beyond = _beyond(unit.plan, grid, form)
    if beyond:
        return f"{form} reaches from {form.lower:.9g} to {form.upper:.9g}, and {', '.join(beyond)}"
    inner = [d for d, k in enumerate(grid.knots) if len(k) > 1]
    # The bound falls with bits of the share and with bits of the entries, and both share the bits of a product.
    best: Fixed | None = None
    for share_bits in range(1, min(form.wide - 2, 30)):
        candidate = _attempt(unit, grid, inner, form, share_bits)
        if candidate is not None and (best is None or max(candidate.errors) < max(best.errors)):
            best = candidate
    if best is None:
        return f"{form} does not tell the knots of the inputs apart"
    if unit.table is not None:
        best = replace(best, errors=tuple(a + b for a, b in zip(best.errors, unit.table.errors, strict=True)))
    for output, table, error in zip(unit.plan.outputs, grid.outputs, best.errors, strict=True):
        span = max(output.upper - output.lower, max(table.value) - min(table.value))
        if not error <= USEFUL * span:
            return (
                f"no useful bound is found for the error of '{output.name}' in {form}: at most {at_most(error)}, of a "
                f"span of {span:.3g}"
            )
    return best


def _beyond(flat: Plan, grid: Grid, form: Format) -> list[str]:
    """Return which inputs have knots, and which outputs values, that a format does not reach."""
    ends = [(flat.inputs[i].name, k[0], k[-1]) for i, k in zip(grid.inputs, grid.knots, strict=True) if len(k) > 1]
    ends += [(o.name, min(t.value), max(t.value)) for o, t in zip(flat.outputs, grid.outputs, strict=True)]
    least, most = -form.most - 1 - _ROUNDED, form.most + _ROUNDED
    scale = 1 << form.fraction
    return [
        f"'{name}' from {low:.9g} to {high:.9g}"
        for name, low, high in ends
        if Fraction(low) * scale < least or Fraction(high) * scale > most
    ]


def _attempt(unit: Unit, grid: Grid, inner: Sequence[int], form: Format, share_bits: int) -> Fixed | None:
    """Return the integers for a number of bits of the share, None if a product would not fit."""
    axes = [_axis(grid.inputs[d], grid.knots[d], form, share_bits) for d in inner]
    outputs = [_entries(table, form, share_bits) for table in grid.outputs]
    if None in axes or None in outputs:
        return None
    whole = tuple(a for a in axes if a is not None)
    entries = tuple(e for e in outputs if e is not None)
    errors = tuple(
        _proved(unit, grid, inner, whole, table, entry, form, share_bits)
        for table, entry in zip(grid.outputs, entries, strict=True)
    )
    return Fixed(form, share_bits, whole, entries, errors)


def _axis(position: int, knots: Sequence[float], form: Format, share_bits: int) -> Axis | None:
    scaled = [Fraction(k) * (1 << form.fraction) for k in knots]
    least, most = math.floor(scaled[0]), math.ceil(scaled[-1])
    for shift in range(_EXTRA, -1, -1):
        integers = [round((k - least) * (1 << shift)) for k in scaled]
        widths = [b - a for a, b in pairwise(integers)]
        if ((most - least) << shift).bit_length() >= form.wide or min(widths) < 1:
            continue
        if max(widths).bit_length() + share_bits >= form.wide:
            continue
        unit = Fraction(1, 1 << (form.fraction + shift))
        off = max(abs((k - least) * (1 << shift) - o) for k, o in zip(scaled, integers, strict=True)) * unit
        return Axis(position, least, most, shift, tuple(integers), off)
    return None


def _entries(table: Table, form: Format, share_bits: int) -> Entries | None:
    scaled = [Fraction(v) * (1 << form.fraction) for v in table.value]
    base = math.floor(min(scaled))
    for guard in range(_EXTRA, -1, -1):
        integers = [round((v - base) * (1 << guard)) for v in scaled]
        # Two bits to spare: for the sum of the weighted ends, and for its rounding.
        if max(integers).bit_length() + share_bits <= form.wide - 2:
            return Entries(base, guard, tuple(integers))
    return None


def _proved(
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
    # The error of the table itself, which is computed in floating point from all rules.
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
            difference = abs(table.value[position + stride] - table.value[position])
            # Differences of floats are rounded; one unit more is an upper bound.
            largest[k] = max(largest[k], math.nextafter(difference, math.inf))
    for most, width in zip(largest, widths, strict=True):
        rise, slope = max(rise, Fraction(most)), max(slope, Fraction(most) / width)
    return rise, slope
