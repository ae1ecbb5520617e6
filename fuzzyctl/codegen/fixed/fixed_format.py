"""Fixed-point formats, and the scaled integers of knots and outputs."""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True)
class Format:
    """Qm.n: a sign, m bits before the point and n after it, in 16 or 32 bits."""

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

    @property
    def lower(self) -> float:
        """The least number of the format."""
        return (-self.most - 1) / (1 << self.fraction)

    @property
    def upper(self) -> float:
        """The largest number of the format."""
        return self.most / (1 << self.fraction)

    def __str__(self) -> str:
        return f"Q{self.integer}.{self.fraction}"


def to_format(text: str) -> Format:
    """Read `Qm.n`.

    Raises:
        ValueError: For anything else, and for more than 31 bits.
    """
    match = re.fullmatch(r"[Qq](\d{1,2})\.(\d{1,2})", text)
    if match is None:
        raise ValueError(f"'{text}' is not of the form Qm.n, such as Q3.12")
    form = Format(int(match[1]), int(match[2]))
    if not 1 <= form.integer + form.fraction <= 31:
        raise ValueError(f"'{text}' has {form.integer + form.fraction} bits beside the sign; 1 to 31 are possible")
    return form


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

    @property
    def ends(self) -> tuple[int, int]:
        """The least and the largest integer that interpolation returns: it rounds, and never leaves its ends."""
        rounding = (1 << self.guard) >> 1
        least, most = ((v + rounding) >> self.guard for v in (min(self.values), max(self.values)))
        return self.base + least, self.base + most
