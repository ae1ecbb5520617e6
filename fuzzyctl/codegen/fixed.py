"""Fixed-point arithmetic for systems that interpolate: integers only, with a proved bound of the error.

An input x is the integer X = x · 2^n. Along each input the cell is found among integer knots, and the share of the way
through it, rounded to p bits, weighs the entries at its ends: (a (2^p - s) + b s + 2^(p-1)) / 2^p, all in unsigned
integers, so that nothing depends on how a compiler shifts negative numbers.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise, product
from typing import Final

from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.kernels.grid import Grid, Table
from fuzzyctl.kernels.plan import Plan

#: Most entries of a table.
MOST_ENTRIES: Final = 1 << 16
#: Most extra bits of knots and of entries.
_EXTRA: Final = 20
#: Corners closer than this part of the range count as one knot (`kernels.grid`).
_SAME: Final = Fraction(1, 10**14)


@dataclass(frozen=True)
class Format:
    """Qm.n: a sign, m bits before the point and n behind it, in 16 or 32 bits."""

    integer: int
    fraction: int

    @property
    def bits(self) -> int:
        """Bits of the integer type that holds it."""
        return 16 if self.integer + self.fraction < 16 else 32

    @property
    def wide(self) -> int:
        """Bits of the type that is computed with."""
        return 2 * self.bits

    @property
    def most(self) -> int:
        """The largest integer of the format; the least is -most - 1."""
        return (1 << (self.integer + self.fraction)) - 1

    def __str__(self) -> str:
        return f"Q{self.integer}.{self.fraction}"


def to_format(text: str) -> Format:
    """Read `Qm.n`.

    Raises:
        ValueError: For anything else, and for more than 31 bits.
    """
    found = re.fullmatch(r"[Qq](\d{1,2})\.(\d{1,2})", text)
    if found is None:
        raise ValueError(f"'{text}' is not of the form Qm.n, such as Q3.12")
    own = Format(int(found[1]), int(found[2]))
    if not 1 <= own.integer + own.fraction <= 31:
        raise ValueError(f"'{text}' has {own.integer + own.fraction} bits beside the sign; 1 to 31 are possible")
    return own


@dataclass(frozen=True)
class Axis:
    """The knots of an input in integers.

    Args:
        input: Its position.
        least: An integer at or below the first knot; positions are counted from there.
        most: An integer at or above the last knot.
        shift: Extra bits of the knots.
        knots: Rising, in units of 2^-(n + shift) from `least` on.
        off: How far a knot may be from its true place.
    """

    input: int
    least: int
    most: int
    shift: int
    knots: tuple[int, ...]
    off: Fraction


@dataclass(frozen=True)
class Entries:
    """An output at the knots: `base` + entry / 2^guard, in units of 2^-n."""

    base: int
    guard: int
    values: tuple[int, ...]


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
    """Return how far apart neighbours along each input stand among the entries."""
    return [math.prod(len(a.knots) for a in axes[i + 1 :]) for i in range(len(axes))]


def fixed_point(unit: Unit, form: Format) -> Fixed:
    """Turn a system that interpolates into integers.

    Raises:
        CodegenError: For a system that does not interpolate, or whose output is a quotient; for knots or outputs that
            the format does not reach or does not tell apart.
    """
    grid = unit.algorithm.grid
    if grid is None:
        reason = unit.algorithm.reason
        raise CodegenError(f"fixed point needs a system that interpolates: {reason}; --table makes one that does")
    if any(t.weight for t in grid.outputs):
        raise CodegenError("fixed point needs activations that sum to 1, and those of this system do not; use --table")
    if grid.size > MOST_ENTRIES:
        raise CodegenError(f"the system has {grid.size:,} knots, more than {MOST_ENTRIES:,}")
    inner = [d for d, k in enumerate(grid.knots) if len(k) > 1]
    _require_fit(unit.plan, grid, form)
    # The bound falls with bits of the share and with bits of the entries, and both share the bits of a product.
    best: Fixed | None = None
    for share_bits in range(1, min(form.wide - 2, 30)):
        found = _attempt(unit, grid, inner, form, share_bits)
        if found is not None and (best is None or max(found.errors) < max(best.errors)):
            best = found
    if best is None:
        raise CodegenError(f"{form} does not tell the knots of the inputs apart; take more bits behind the point")
    if unit.table is not None:
        errors = tuple(a + b for a, b in zip(best.errors, unit.table.errors, strict=True))
        return replace(best, errors=errors)
    return best


def _require_fit(flat: Plan, grid: Grid, form: Format) -> None:
    one = 1 << form.fraction
    reach = form.most / one
    for i, knots in zip(grid.inputs, grid.knots, strict=True):
        if max(abs(k) for k in knots) > reach:
            raise CodegenError(
                f"{form} reaches to {reach:.6g}, and '{flat.inputs[i].name}' to {max(map(abs, knots)):.6g}"
            )
    for output, table in zip(flat.outputs, grid.outputs, strict=True):
        most = max(abs(v) for v in table.value)
        if most > reach:
            raise CodegenError(f"{form} reaches to {reach:.6g}, and '{output.name}' to {most:.6g}")


def _attempt(unit: Unit, grid: Grid, inner: Sequence[int], form: Format, share_bits: int) -> Fixed | None:
    """Return the integers for a number of bits of the share, None if a product would not fit."""
    axes = [_axis(grid.inputs[d], grid.knots[d], form, share_bits) for d in inner]
    outputs = [_entries(table, form, share_bits) for table in grid.outputs]
    if None in axes or None in outputs:
        return None
    whole = tuple(a for a in axes if a is not None)
    entries = tuple(e for e in outputs if e is not None)
    errors = tuple(
        _bound(unit, grid, inner, whole, table, own, form, share_bits)
        for table, own in zip(grid.outputs, entries, strict=True)
    )
    return Fixed(form, share_bits, whole, entries, errors)


def _axis(position: int, knots: Sequence[float], form: Format, share_bits: int) -> Axis | None:
    scaled = [Fraction(k) * (1 << form.fraction) for k in knots]
    least, most = math.floor(scaled[0]), math.ceil(scaled[-1])
    for shift in range(_EXTRA, -1, -1):
        own = [round((k - least) * (1 << shift)) for k in scaled]
        widths = [b - a for a, b in pairwise(own)]
        if ((most - least) << shift).bit_length() >= form.wide or min(widths) < 1:
            continue
        if max(widths).bit_length() + share_bits >= form.wide:
            continue
        unit = Fraction(1, 1 << (form.fraction + shift))
        off = max(abs((k - least) * (1 << shift) - o) for k, o in zip(scaled, own, strict=True)) * unit
        return Axis(position, least, most, shift, tuple(own), off)
    return None


def _entries(table: Table, form: Format, share_bits: int) -> Entries | None:
    scaled = [Fraction(v) * (1 << form.fraction) for v in table.value]
    base = math.floor(min(scaled))
    for guard in range(_EXTRA, -1, -1):
        own = [round((v - base) * (1 << guard)) for v in scaled]
        # Two bits to spare: for the sum of the weighted ends, and for its rounding.
        if max(own).bit_length() + share_bits <= form.wide - 2:
            return Entries(base, guard, tuple(own))
    return None


def _bound(
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
        rise, slope = steepest(grid, table, d)
        error += Fraction(1, 1 << (share_bits + 1)) * (rise + 2 * error) + step / 2
        span = Fraction(grid.knots[d][-1]) - Fraction(grid.knots[d][0])
        slopes += slope * (axis.off + _SAME * span)
    if entries.guard:
        error += Fraction(1, 1 << (form.fraction + 1))
    # What the table itself is off by, computed in floating point from all rules.
    largest = max(abs(Fraction(v)) for v in table.value)
    error += slopes + (len(unit.plan.rules) + 64) * Fraction(1, 1 << 52) * largest
    return float(error) * (1.0 + 2.0**-50)


def steepest(grid: Grid, table: Table, axis: int) -> tuple[Fraction, Fraction]:
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
