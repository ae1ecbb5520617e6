"""Bits after the point of each operation of a fixed-point step, and the error that its rounding adds.

Every value is an integer of 32 bits with its point, every product one of 64 bits. A value that such an integer
holds whole is not rounded at all: sums, choices and delays of inputs are equal in both programs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Final

from fuzzyctl.codegen.fixed.fixed_format import Format
from fuzzyctl.codegen.fixed.fixed_program import Operation, Operations
from fuzzyctl.codegen.fixed.fixed_ranges import CalledSystem, Ends

#: Most bits behind the point of a value, so that two values are aligned in 64 bits; most of a factor.
MOST_FRACTION: Final = 30
_MOST_FACTOR: Final = 60
#: Most bits that a product is moved right by.
_MOST_SHIFT: Final = 62
#: The largest integer of a value.
_LARGEST: Final = 2**31 - 1
#: How far ranges may grow once roundings are known, relative to their magnitude.
_ROOM: Final = 2.0**-12


@dataclass
class Formats:
    """Formats of all operations.

    Args:
        operations: The operations.
        systems: The systems that they call, by number.
        form: The format of inputs and outputs.
        ends: Ranges of the operations.
        starts: The start of each slot.
    """

    operations: Operations
    systems: Mapping[int, CalledSystem]
    form: Format
    ends: Sequence[Ends]
    starts: Sequence[float]
    fractions: list[int] = field(default_factory=list, init=False)
    roundings: list[float] = field(default_factory=list, init=False)
    #: The factor of each `scale`: an integer, and the bits behind its point.
    factors: dict[int, tuple[int, int]] = field(default_factory=dict, init=False)
    #: Bits behind the point of each slot.
    slots: list[int] = field(default_factory=list, init=False)
    #: Whether each operation has the same value in both programs.
    equal: list[bool] = field(default_factory=list, init=False)
    #: Operations whose values no integer of 32 bits reaches.
    beyond: list[int] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        whole = self._whole()
        places = {i.place: k for k, i in enumerate(self.operations.items) if i.kind == "slot"}
        self.slots = [bits if bits is not None else self._most(places[s]) for s, bits in enumerate(whole)]
        naturals = self._naturals(whole)
        for k, item in enumerate(self.operations.items):
            self._lay_out(k, item, naturals[k])

    def _whole(self) -> list[int | None]:
        """Return the bits behind the point of slots that both programs hold alike, None for the others."""
        results: list[int | None] = [dyadic(Fraction(x)) if math.isfinite(x) else None for x in self.starts]
        for _ in range((MOST_FRACTION + 2) * len(results) + 1):  # each slot gains bits, or is rounded from then on
            naturals = self._naturals(results)
            changed = False
            for s, store in enumerate(self.operations.stores):
                bits, new = results[s], naturals[store]
                if bits is None or (new is not None and new <= bits):
                    continue
                results[s], changed = new, True
            if not changed:
                break
        return results

    def _naturals(self, slots: Sequence[int | None]) -> list[int | None]:
        """Return the bits behind the point of each value that is not rounded; None for one that is."""
        naturals: list[int | None] = []
        for k, item in enumerate(self.operations.items):
            natural = self._natural(item, [naturals[p] for p in item.operands], slots)
            if natural is not None and not (natural <= MOST_FRACTION and fits(natural, self.ends[k])):
                natural = None
            naturals.append(natural)
        return naturals

    def _natural(self, item: Operation, given: Sequence[int | None], slots: Sequence[int | None]) -> int | None:
        fractions = [g for g in given if g is not None]
        if len(fractions) < len(given):
            return None
        match item.kind:
            case "input":
                return self.form.fraction
            case "slot":
                return slots[item.place]
            case "constant":
                return dyadic(item.factor)
            case "scale":
                factor = dyadic(item.factor)
                return None if factor is None or factor > _bits_of(item.factor) else fractions[0] + factor
            case "*":
                return sum(fractions)
            case "system":
                return None
            case "argument":
                most = self.systems[item.system].fixed.format.fraction
                return fractions[0] if fractions[0] <= most else None
            case "output":
                low, high = self.ends[item.operands[0]]
                is_held = low < self.form.lower or high > self.form.upper
                return None if is_held or fractions[0] > self.form.fraction else fractions[0]
        return 0 if item.is_condition else max(fractions)

    def _most(self, position: int) -> int:
        """Return the largest number of bits after the point of an operation, with room for roundings in its range."""
        low, high = self.ends[position]
        room = _ROOM * max(abs(low), abs(high)) if math.isfinite(high - low) else math.inf
        for fraction in range(MOST_FRACTION, -1, -1):
            if fits(fraction, (low - room, high + room)):
                return fraction
        self.beyond.append(position)
        return 0

    def _lay_out(self, k: int, item: Operation, natural: int | None) -> None:
        """Choose the format of an operation; those of its operands are known."""
        fractions = [self.fractions[p] for p in item.operands]
        self.equal.append(natural is not None)
        if item.is_condition:
            self.fractions.append(0)
            self.roundings.append(0.0)
            return
        if item.kind in ("input", "slot", "store", "output", "argument", "system"):
            fraction = self._of_interface(item)
        elif natural is not None:
            fraction = natural
        else:
            fraction = min(self._most(k), self._finest(item, fractions))
        self.fractions.append(fraction)
        if item.kind == "scale":
            self._factor(k, item, fractions[0], fraction)
        self.roundings.append(0.0 if natural is not None else self._rounding(k, item, fractions, fraction))

    def _of_interface(self, item: Operation) -> int:
        if item.kind in ("slot", "store"):
            return self.slots[item.place]
        return (
            self.form.fraction if item.kind in ("input", "output") else self.systems[item.system].fixed.format.fraction
        )

    @staticmethod
    def _finest(item: Operation, given: Sequence[int]) -> int:
        """Return the largest useful number of bits after the point."""
        match item.kind:
            case "*":
                return sum(given)
            case "constant":
                return MOST_FRACTION
            case "scale":
                return max(0, given[0] + _bits_of(item.factor))
        return max(given[1:] if item.kind == "where" else given)

    def _rounding(self, k: int, item: Operation, given: Sequence[int], fraction: int) -> float:
        """Return the largest error that the rounding of an operation adds."""
        half = 2.0 ** -(fraction + 1)
        match item.kind:
            case "constant":
                return float(abs(item.factor - scaled(item.factor, fraction) / Fraction(1 << fraction))) * (
                    1 + 2.0**-50
                )
            case "system":
                return self.systems[item.system].fixed.errors[item.place]
            case "scale":
                return self._of_scale(k, item, given[0], fraction)
            case "slot":
                return 0.0
            case "*":
                return half if sum(given) > fraction else 0.0
            case "output":
                low, high = self.ends[item.operands[0]]
                return (half if given[0] > fraction else 0.0) + max(0.0, high - self.form.upper, self.form.lower - low)
        return half if self._finest(item, given) > fraction else 0.0

    def _factor(self, k: int, item: Operation, given: int, fraction: int) -> None:
        """Choose the integer of a factor: as exact as a product of 64 bits allows."""
        natural = dyadic(item.factor, _MOST_FACTOR)
        bits = min(_bits_of(item.factor), _MOST_SHIFT + fraction - given)
        bits = max(bits if natural is None else min(bits, natural), fraction - given)
        self.factors[k] = (scaled(item.factor, bits), bits)

    def _of_scale(self, k: int, item: Operation, given: int, fraction: int) -> float:
        """Return the errors by the rounding of a factor and of its product."""
        factor, bits = self.factors[k]
        off = abs(item.factor - factor / Fraction(2) ** bits)
        size = max(map(abs, self.ends[item.operands[0]]))
        room = 1 + 2.0 * _ROOM
        return float(off) * size * room + (2.0 ** -(fraction + 1) if given + bits > fraction else 0.0)


def dyadic(value: Fraction, most: int = MOST_FRACTION) -> int | None:
    """Return the bits behind the point of a number, None for more than some."""
    bits = value.denominator.bit_length() - 1
    return bits if value.denominator == 1 << bits and bits <= most else None


def scaled(value: Fraction, bits: int) -> int:
    """Return the nearest integer to a number times 2^bits."""
    return round(value * (Fraction(2) ** bits))


def fits(fraction: int, ends: Ends) -> bool:
    """Return whether all values of a range are integers of 32 bits, with some bits behind the point."""
    return ends[0] * 2.0**fraction >= -_LARGEST - 1 and ends[1] * 2.0**fraction <= _LARGEST


def _bits_of(factor: Fraction) -> int:
    """Return most bits behind the point of a factor."""
    return next(
        (b for b in range(_MOST_FACTOR, -_MOST_FACTOR, -1) if abs(scaled(factor, b)) <= _LARGEST), -_MOST_FACTOR
    )
