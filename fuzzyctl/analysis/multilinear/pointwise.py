"""Proof of guarantees of multilinear systems at the corners of cells, in rational arithmetic.

The inputs are cut where an output, at any of the arguments the claim takes it at, bends, and where a condition changes.
In a cell the difference is multilinear, so that it is least and largest at corners; cells are taken without their
edges, which are separate cells, so that strict comparisons and conditions are decided too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import IntEnum
from fractions import Fraction
from functools import cached_property
from itertools import pairwise, product
from typing import Final

from fuzzyctl.analysis.affine import Affine, Line, Reader, Taken
from fuzzyctl.analysis.claims import Bound, Claim, Every, Some, Truth, bounds_in, is_limit
from fuzzyctl.analysis.multilinear.slopes import steepest
from fuzzyctl.analysis.multilinear.surface import Surface
from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdict, Witness
from fuzzyctl.analysis.witnesses import Judge
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.records import record

#: Units of work for a cell.
_CELL: Final = 25
#: Most cells of one claim: about a second.
MOST_CELLS: Final = 40_000
#: Cells that break a claim in which a witness is looked for.
TRIES: Final = 40
#: How far from a corner towards the middle of its cell a witness is looked for.
_INWARD: Final = (Fraction(0), Fraction(1, 1 << 40), Fraction(1, 1 << 20), Fraction(1, 64), Fraction(1, 4), Fraction(1))


class Level(IntEnum):
    """How far a claim holds in a cell."""

    BROKEN = 0
    EXACT = 1
    FOR_KERNELS = 2


@record(frozen=True)
class _Cell:
    """A product of points (k, k) and open intervals (k, k + 1) between cuts."""

    ends: tuple[tuple[int, int], ...]

    def vertices(self) -> Iterator[tuple[int, ...]]:
        return product(*((a,) if a == b else (a, b) for a, b in self.ends))


class _UnsuitedError(Exception):
    """Raised for a claim that is not decided at corners."""


def decide(system: FuzzySystem, surfaces: Sequence[Surface | None], claim: Claim, judge: Judge) -> Verdict | None:
    """Decide a claim that compares sums of outputs and inputs; None for one that corners do not decide.

    Args:
        system: The system.
        surfaces: Its own, and those of the systems it is compared with; None for one that does not interpolate.
        claim: The claim.
        judge: Evaluates witnesses.
    """
    try:
        return _Decision(system, surfaces, claim, judge).verdict()
    except _UnsuitedError:
        return None


class _Decision:
    def __init__(self, system: FuzzySystem, surfaces: Sequence[Surface | None], claim: Claim, judge: Judge) -> None:
        self.system, self.surfaces, self.claim, self.judge = system, surfaces, claim, judge
        self.reader = Reader(system)
        self.region = {b: self._sum(b) for b in bounds_in(claim.region)}
        self.compared = {b: self._sum(b) for b in bounds_in(claim.truth)}
        if any(s.outputs or s.line() is None for s in self.region.values()):
            raise _UnsuitedError
        for difference in self.compared.values():
            self._require_multilinear(difference)
        self.known: dict[tuple[Bound, tuple[int, ...]], Fraction] = {}

    def _sum(self, bound: Bound) -> Affine:
        left, right = self.reader.read(bound.left), self.reader.read(bound.right)
        if left is None or right is None:
            raise _UnsuitedError
        return left.plus(right, Fraction(-1))

    def _surface(self, operand: Taken) -> Surface:
        surface = self.surfaces[operand.system]
        if surface is None:
            raise _UnsuitedError
        return surface

    def _require_multilinear(self, difference: Affine) -> None:
        for operand in difference.outputs:
            surface = self._surface(operand)
            read = [operand.arguments[i].input for i in surface.inputs if operand.arguments[i].input is not None]
            if len(set(read)) < len(read):
                raise _UnsuitedError
            if not surface.is_unity[operand.output] and (len(difference.outputs) > 1 or difference.inputs):
                raise _UnsuitedError
        if any(self.system.inputs[i].extrapolate for i in difference.inputs):
            raise _UnsuitedError

    @cached_property
    def cuts(self) -> list[list[Fraction]]:
        """Where each input is cut; beyond the outer cuts of an input without a range nothing changes."""
        results: list[set[Fraction]] = [set() for _ in self.system.inputs]
        for difference in self.compared.values():
            for operand in difference.outputs:
                surface = self._surface(operand)
                for k, i in enumerate(surface.inputs):
                    _add_breakpoints(results, operand.arguments[i], surface.corners[k])
        for difference in self.region.values():
            line = difference.line()
            assert line is not None
            _add_breakpoints(results, line, [Fraction(0)])
        return [self._within(i, difference) for i, difference in enumerate(results)]

    def _within(self, position: int, found: set[Fraction]) -> list[Fraction]:
        variable = self.system.inputs[position]
        if variable.extrapolate:
            inner = sorted(found) or [Fraction(0)]
            return [inner[0] - 1, *inner, inner[-1] + 1]
        lower, upper = (Fraction(self.system.number(e)) for e in (variable.lower, variable.upper))
        return sorted({lower, upper} | {x for x in found if lower < x < upper})

    def _cells(self) -> Iterator[_Cell]:
        sides = [[*((k, k) for k in range(len(c))), *pairwise(range(len(c)))] for c in self.cuts]
        return (_Cell(ends) for ends in product(*sides))

    def verdict(self) -> Verdict | None:
        count = 1
        for cuts in self.cuts:
            count *= 2 * len(cuts) - 1
        work = self.judge.work
        if count > MOST_CELLS or (work is not None and not work.takes(_CELL * count)):
            return None
        lowest, broken = Level.FOR_KERNELS, []
        for cell in self._cells():
            if not self._is_in_region(cell):
                continue
            level = self._level(self.claim.truth, cell)
            if level is None:
                return None
            lowest = min(lowest, level)
            if level is Level.BROKEN:
                broken.append(cell)
        if broken:
            return self._refuted(broken)
        return self._proved(lowest)

    def _point(self, vertex: Sequence[int]) -> tuple[Fraction, ...]:
        return tuple(c[k] for c, k in zip(self.cuts, vertex, strict=True))

    def _middle(self, cell: _Cell) -> tuple[Fraction, ...]:
        return tuple((c[a] + c[b]) / 2 for c, (a, b) in zip(self.cuts, cell.ends, strict=True))

    def _is_in_region(self, cell: _Cell) -> bool:
        middle = self._middle(cell)

        def holds(truth: Truth) -> bool:
            if isinstance(truth, Bound):
                line = self.region[truth].line()
                assert line is not None
                value = line.at(middle)
                return value > 0 if truth.strict else value >= 0
            assert isinstance(truth, Every | Some)
            return (all if isinstance(truth, Every) else any)(holds(p) for p in truth.parts)

        return holds(self.claim.region)

    def _level(self, truth: Truth, cell: _Cell) -> Level | None:
        """Return how far a claim holds in a cell, None where one of several holds here and another there."""
        if isinstance(truth, Bound):
            return self._level_of(truth, cell)
        assert isinstance(truth, Every | Some)
        levels = [self._level(p, cell) for p in truth.parts]
        results = [v for v in levels if v is not None]
        if isinstance(truth, Every):
            return None if len(results) < len(levels) else min(results, default=Level.FOR_KERNELS)
        best = max(results, default=None)
        if best is Level.BROKEN or best is None:
            # Broken parts may cover the cell together; only where all are broken everywhere is there no doubt.
            whole = all(isinstance(p, Bound) and self._is_broken_all_over(p, cell) for p in truth.parts)
            return Level.BROKEN if whole else None
        return best

    def _values(self, bound: Bound, cell: _Cell) -> list[Fraction]:
        return [self._value(bound, v) + bound.tolerance for v in cell.vertices()]

    def _is_broken_all_over(self, bound: Bound, cell: _Cell) -> bool:
        values = self._values(bound, cell)
        return max(values) < 0 or (max(values) <= 0 and (bound.strict or min(values) < 0))

    def _level_of(self, bound: Bound, cell: _Cell) -> Level:
        values = self._values(bound, cell)
        least = min(values)
        if least < 0 or (bound.strict and not any(values)):
            return Level.BROKEN
        margin = self.margins[bound]
        if least > margin or (least == margin and not bound.strict) or self._is_held(bound):
            return Level.FOR_KERNELS
        return Level.EXACT

    def _value(self, bound: Bound, vertex: tuple[int, ...]) -> Fraction:
        """Return left less right at a corner, for a quotient of two sums times the lower one."""
        key = (bound, vertex)
        if key not in self.known:
            difference, point = self.compared[bound], self._point(vertex)
            total = difference.number + sum((c * point[i] for i, c in difference.inputs.items()), Fraction(0))
            for operand, factor in difference.outputs.items():
                above, below = self._surface(operand).sums(operand.output, [a.at(point) for a in operand.arguments])
                # The tolerance is added to the quotient later, so that the sign is all that may change here.
                total += factor * above / below
            self.known[key] = total
        return self.known[key]

    @cached_property
    def margins(self) -> dict[Bound, Fraction]:
        """How far rounding in kernels may move the difference."""
        return {
            b: sum((self._error(t) * abs(c) for t, c in s.outputs.items()), Fraction(0))
            for b, s in self.compared.items()
        }

    def _error(self, operand: Taken) -> Fraction:
        """Return the error of an output, and of its arguments if floats cannot hold them."""
        surface = self._surface(operand)
        total = surface.errors[operand.output]
        for k, i in enumerate(surface.inputs):
            line = operand.arguments[i]
            if not line.is_exact and line.input is not None:
                farthest = max(abs(c * line.factor) for c in self.cuts[line.input]) + abs(line.shift)
                total += farthest * Fraction(4, 1 << 53) * steepest(surface, operand.output, k)
        return total

    def _is_held(self, bound: Bound) -> bool:
        """Return whether the comparison holds because kernels keep the output within the hull of its consequents."""
        difference = self.compared[bound]
        if difference.inputs or len(difference.outputs) != 1:
            return False
        ((operand, factor),) = difference.outputs.items()
        ends = [
            difference.number + bound.tolerance + factor * Fraction(e)
            for e in self._surface(operand).hull(operand.output)
        ]
        return min(ends) > 0 or (min(ends) == 0 and not bound.strict)

    def _proved(self, level: Level) -> Verdict:
        text = self.claim.text
        if level is Level.FOR_KERNELS:
            return Proved(text)
        margin = float(max(self.margins.values()))
        if any(b.tolerance or is_limit(self.system, b) for b in self.compared if self.margins[b] > b.tolerance):
            reason = (
                "it holds in exact arithmetic and touches its bound; numbers that kernels return may be off by "
                f"{margin:.1e}, so that a wider tolerance, such as 'within {_wider(margin)}', would decide it"
            )
            return Undecided(text, reason)
        return Proved(text, note=f"in exact arithmetic; kernels round by up to {margin:.1e}")

    def _refuted(self, broken: list[_Cell]) -> Verdict:
        def worst(cell: _Cell) -> Fraction:
            return min((min(self._values(b, cell)) for b in self.compared), default=Fraction(0))

        for cell in sorted(broken, key=worst)[:TRIES]:
            witness = self._witness_in(cell)
            if witness is not None:
                return Refuted(self.claim.text, witness)
        reason = "it is broken by less than rounding in kernels can show; a tolerance would decide it"
        return Undecided(self.claim.text, reason)

    def _witness_in(self, cell: _Cell) -> Witness | None:
        middle = self._middle(cell)
        corners = [self._point(v) for v in cell.vertices()]
        order = sorted(cell.vertices(), key=lambda v: min(self._value(b, v) for b in self.compared))
        corners = [self._point(v) for v in order]
        for inward in _INWARD:
            for corner in corners:
                point = [float(c + inward * (m - c)) for c, m in zip(corner, middle, strict=True)]
                witness = self.judge.broken(self.claim.truth, self.claim.region, point)
                if witness is not None:
                    return witness
        return None


def _add_breakpoints(found: list[set[Fraction]], line: Line, corners: Sequence[Fraction]) -> None:
    """Add where a line of an input reaches some corners."""
    if line.input is not None and line.factor:
        found[line.input] |= {(c - line.shift) / line.factor for c in corners}


def _wider(margin: float) -> str:
    exponent = 0
    while 10.0**exponent > 2 * margin and exponent > -300:
        exponent -= 1
    return f"1e{exponent + 1}"
