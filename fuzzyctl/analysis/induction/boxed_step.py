"""Enclosures of a step over boxes of its inputs, states and `dt`: what branch and bound searches."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import chain
from math import inf
from typing import Final

import numpy as np

from fuzzyctl.analysis.branch_and_bound.boxed_system import grid_of_cells
from fuzzyctl.analysis.claims import Bound, Truth, bounds_in
from fuzzyctl.analysis.induction.step_model import FAR, Slice, StepModel
from fuzzyctl.expr import Call, Compare, Expr, walk
from fuzzyctl.kernels.interval.program import Interpreter
from fuzzyctl.kernels.interval.vector import Array, Enclosure, Mask, boxes, jumping
from fuzzyctl.kernels.plan.equations import Equation, Evaluation

#: Most arguments along which slopes are computed.
_MOST_SLOPES: Final = 60
#: Most states without ends whose values below and above 0 are enclosed apart.
_SPLIT: Final = 4
#: Units of work for a node of an expression over many boxes, and for each number of its arrays.
_NODE, _NUMBER = 8, 0.0023

#: Slopes that are not known.
_UNKNOWN: Final = (np.full((1, 1), -inf), np.full((1, 1), inf))
#: What may be no number.
ANYTHING: Final = jumping(np.array(-inf), np.array(inf))

#: The least and the largest value.
Ends = tuple[float, float]


class BoxedStep:
    """A part of a step over boxes.

    Args:
        model: The step.
        ranges: The least and the largest value of each input, state and `dt`.
        names: What is asked of; the sides of boxes are the arguments that these depend on.
        far: Boxes reach up to this magnitude.
    """

    def __init__(self, model: StepModel, ranges: Mapping[str, Ends], names: Sequence[str], far: float = inf) -> None:
        self.model, self.ranges, self.outputs = model, ranges, list(names)
        self.slice: Slice = model.slice(names)
        #: States that may be no number.
        self.lost = [a for a in self.slice.arguments if math.isnan(ranges[a][0])]
        # A box has one side at least.
        self.inputs = [a for a in self.slice.arguments if a not in self.lost] or ["#"]
        ends = np.array([ranges.get(n, (0.0, 0.0)) for n in self.inputs])
        self.ends = np.clip(ends, -far, far)

    @property
    def batch(self) -> int:
        """How many boxes to take at once."""
        called = [self.model.called(i.system).boxed.batch for i in self.slice.body if isinstance(i, Evaluation)]
        return min([256, *called])

    def enclose(self, exprs: Sequence[Expr], lo: Array, hi: Array, *, sloped: bool) -> tuple[list[Enclosure], Mask]:
        """Enclose expressions over names of the step; see `System.enclose`.

        With slopes the ends enclose what kernels compute, without them the real values as well.
        """
        least, most = self.ends[:, :1], self.ends[:, 1:]
        lo, hi = np.clip(lo, least, most), np.clip(hi, least, most)
        flat = [Enclosure(a, b, None, np.array(0.0)) for a, b in zip(lo, hi, strict=True)]
        if len(flat) > _MOST_SLOPES:
            sides = [Enclosure(e.lo, e.hi, _UNKNOWN, e.error) for e in flat]
        else:
            sides = boxes(lo, hi)
        found = self._enclosed(exprs, sides if sloped else flat, nearest=False)
        if sloped:
            floats = self._enclosed(exprs, flat, nearest=True)
            found = [
                Enclosure(np.maximum(e.lo, f.lo), np.minimum(e.hi, f.hi), e.slopes, e.error)
                for e, f in zip(found, floats, strict=True)
            ]
        return found, np.array(False)

    def _enclosed(self, exprs: Sequence[Expr], sides: list[Enclosure], *, nearest: bool) -> list[Enclosure]:
        given = dict(zip(self.inputs, sides, strict=True)) | dict.fromkeys(self.lost, ANYTHING)
        names = Interpreter(self.model.evaluate(self.slice, given, nearest=nearest).names)
        return [names.enclose(e) for e in exprs]

    def cells(self, truths: Sequence[Truth]) -> tuple[Array, Array] | None:
        """Cut the arguments where terms bend and where conditions change; None for too many cells."""
        cuts = {name: {0.0} if k in self._endless else set() for k, name in enumerate(self.inputs)}
        bends = [bend for item in self.slice.body for bend in self._bends(item)]
        bends += [bend for t in truths for b in bounds_in(t) for bend in self._pairs(b.left, b.right)]
        for expr, values in bends:
            line = self.model.line(expr)
            if line is not None and line[0] in cuts:
                cuts[line[0]] |= {(x - line[2]) / line[1] for x in values if math.isfinite(x)}
        return grid_of_cells([self.whole(n) for n in self.inputs], [cuts[n] for n in self.inputs])

    @property
    def box(self) -> tuple[Array, Array]:
        """All that the arguments may be, shape (inputs, boxes) each; in one box, but for states without ends."""
        lo, hi = (ends[:, None] for ends in self.ends.T)
        for side in self._endless:
            lo, hi = np.hstack([lo, lo]), np.hstack([hi, hi])
            half = lo.shape[1] // 2
            lo[side, half:] = hi[side, :half] = 0.0
        return lo, hi

    @cached_property
    def _endless(self) -> list[int]:
        """Sides whose values below and above 0 are enclosed apart: a box that holds all numbers may hold NaN."""
        return [k for k, ends in enumerate(self.ends) if np.isinf(ends).all()][:_SPLIT]

    def whole(self, name: str) -> Ends:
        """Return the ends of a side; those that lie far away are infinite, so that boxes are halved near 0 first."""
        low, high = self.ranges.get(name, (0.0, 0.0))
        return (-inf if low <= -FAR else low), (inf if high >= FAR else high)

    def _bends(self, item: Equation | Evaluation) -> list[tuple[Expr, Sequence[float]]]:
        """Return expressions with the values at which what reads them bends or jumps."""
        if isinstance(item, Evaluation):
            boxed = self.model.called(item.system).boxed
            return [(a, [*boxed.breakpoints(i), *boxed.whole(i)]) for i, a in enumerate(item.arguments)]
        found: list[tuple[Expr, Sequence[float]]] = []
        for node in walk(item.value):
            match node:
                case Compare(left=left, right=right) | Call(function="min" | "max", arguments=(left, right)):
                    found += self._pairs(left, right)
                case Call(function="abs", arguments=(operand,)):
                    found.append((operand, [0.0]))
        return found

    def _pairs(self, left: Expr, right: Expr) -> list[tuple[Expr, Sequence[float]]]:
        """Return each of two expressions with the other where that is a number."""
        sides = ((left, self.model.constant(right)), (right, self.model.constant(left)))
        return [(expr, [value]) for expr, value in sides if value is not None]

    def is_limit(self, bound: Bound) -> bool:
        """Return whether one side is the same in all steps."""
        return self.model.is_limit(bound)

    @cached_property
    def _nodes(self) -> int:
        values = chain.from_iterable(i.arguments if isinstance(i, Evaluation) else (i.value,) for i in self.slice.body)
        return sum(len(walk(v)) for v in values)

    def units(self, output: int, boxes: int) -> float:
        """Return the work of enclosing an output and its slopes over some boxes."""
        systems = [self.model.called(i.system).boxed for i in self.slice.body if isinstance(i, Evaluation)]
        own = self._nodes * (_NODE + _NUMBER * boxes * (1 + 2 * len(self.inputs)))
        return own + sum(s.units(k, boxes) for s in systems for k in range(len(s.outputs)))
