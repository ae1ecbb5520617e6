"""Enclosures of a system over boxes: cuts of the inputs, values of outputs and of claims in each box."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from itertools import pairwise, product
from math import inf, isfinite, nextafter, prod
from typing import Final

import numpy as np

from fuzzyctl.analysis.affine import Reader
from fuzzyctl.analysis.bounds import OutputBound, output_bounds
from fuzzyctl.analysis.claims import Bound, Every, Some, Truth, bounds_in, is_limit
from fuzzyctl.analysis.coverage.box_search import Verdict
from fuzzyctl.analysis.coverage.coverage import uncovered_of
from fuzzyctl.analysis.kernel_errors import kernel_errors
from fuzzyctl.analysis.multilinear.surface import surface_of
from fuzzyctl.analysis.work import enclosing, sizes_of
from fuzzyctl.expr import CONSTANTS, Call, Expr, Name, walk
from fuzzyctl.formulas import AGGREGATIONS, CONJUNCTIONS, MEMBERSHIP
from fuzzyctl.kernels.algorithms.grid import Grid, grid_of
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.interval.program import Interpreter
from fuzzyctl.kernels.interval.vector import Array, Enclosure, Mask, boxes, constant
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.plan.build import plan as plan_of
from fuzzyctl.kernels.program import traversal
from fuzzyctl.kernels.program.program import Accumulate, Item, Place, Program
from fuzzyctl.model.system import FuzzySystem

#: Most boxes to begin with.
MOST_CELLS: Final = 60_000
#: Numbers of one array: about 10 MiB with its slopes.
_ARRAY: Final = 400_000


class System:
    """A system over boxes."""

    def __init__(self, system: FuzzySystem, plan: Plan) -> None:
        self.system, self.plan = system, plan
        self.compared = {c.name: System(c, plan_of(c)) for c in system.compared}
        self.program: Program = inference.evaluation(plan)
        self._parts: dict[tuple[int, ...], Program] = {}
        self._sizes: dict[int, tuple[int, int, int]] = {}
        self.reader = Reader(system)
        self.inputs = [v.name for v in system.inputs]
        self.outputs = [v.name for v in system.outputs]

    @cached_property
    def bounds(self) -> dict[str, OutputBound]:
        """Bounds of the outputs, for states that hold earlier outputs."""
        return output_bounds(self.system)

    @cached_property
    def errors(self) -> list[float]:
        """The largest distance of kernels that do not evaluate all rules from the value by all rules."""
        if not isinstance(grid_of(self.plan), Grid):
            return kernel_errors(self.plan)
        surface = surface_of(self.plan)
        return [float(e) for e in surface.errors] if surface is not None else [inf for _ in self.outputs]

    @cached_property
    def batch(self) -> int:
        """How many boxes to take at once."""
        counts = [s.count for s in self.program.body if isinstance(s, Accumulate)]
        return max(16, min(1024, _ARRAY // max([1, *counts])))

    def units(self, output: int, boxes: int) -> float:
        """Return the work of enclosing an output and its slopes over some boxes."""
        if output not in self._sizes:
            self._sizes[output] = sizes_of(self._part([output]))
        return enclosing(self._sizes[output], len(self.inputs), boxes)

    def _part(self, wanted: Sequence[int]) -> Program:
        """Return the part of the program that some outputs depend on."""
        key = tuple(wanted)
        if key not in self._parts:
            # Refusals of other outputs are left out, too: they do not concern these.
            body = traversal.needed(self.program.body, [self.program.results[k] for k in wanted])
            self._parts[key] = replace(self.program, body=body)
        return self._parts[key]

    def inputs_of(self, lo: Array, hi: Array, *, sloped: bool) -> dict[str, Enclosure]:
        """Return the enclosures of the inputs by name.

        Args:
            lo, hi: Ends of the boxes, shape (inputs, boxes).
            sloped: Whether slopes along the inputs are wanted.
        """
        results = boxes(lo, hi)
        if not sloped:
            results = [Enclosure(e.lo, e.hi, None, e.error) for e in results]
        return dict(zip(self.inputs, results, strict=True))

    def evaluate(
        self, arguments: Sequence[Enclosure], wanted: Sequence[int], *, gaps: bool = False, sparse: bool = False
    ) -> tuple[list[Enclosure], Mask]:
        """Enclose some outputs at some arguments; and say which boxes give no value, or not at each of their points.

        Args:
            arguments: Enclosures of the inputs.
            wanted: Positions of the outputs.
            gaps: Whether to return the boxes that may have a point without a value, in place of those without any.
            sparse: See `Interpreter`.
        """
        names = dict(zip(self.program.arguments, arguments, strict=True))
        runner = Interpreter(names, self._state, sparse=sparse)
        result = runner.run(self._part(wanted), wanted)
        exact = [self.errors[k] for k in wanted]
        return [_widened(e, off) if off else e for e, off in zip(result, exact, strict=True)], (
            runner.gaps if gaps else runner.void
        )

    @cached_property
    def _strengths(self) -> Program:
        return inference.largest_activations(self.plan)

    def strength(self, arguments: Sequence[Enclosure], output: int) -> Enclosure:
        """Enclose the largest activation among the rules of an output."""
        names = dict(zip(self._strengths.arguments, arguments, strict=True))
        (result,) = Interpreter(names, self._state).run(self._strengths, [output])
        return result

    def _state(self, item: Item) -> Enclosure:
        assert not isinstance(item.index, str | Place)
        return self._states[item.index]

    @cached_property
    def _states(self) -> list[Enclosure]:
        """Enclosures of the adaptive consequents, then of the outputs that are held."""
        outputs = self.plan.outputs
        bounds = [self.bounds[outputs[o].name] for o in self.plan.held]
        return [
            *(constant(outputs[o].lower, outputs[o].upper) for o, _ in self.plan.states),
            *(constant(b.lo, b.hi) for b in bounds),
        ]

    @cached_property
    def _constants(self) -> dict[str, Enclosure]:
        """The params, made once: a file may have thousands."""
        return {n: constant(v) for n, v in self.reader_values.items()}

    def enclose(self, exprs: Sequence[Expr], lo: Array, hi: Array, *, sloped: bool) -> tuple[list[Enclosure], Mask]:
        """Enclose expressions over inputs, params and outputs.

        Args:
            exprs: The expressions.
            lo, hi: Ends of the boxes, shape (inputs, boxes).
            sloped: Whether slopes along the inputs are wanted.

        Returns:
            An enclosure for each, and the boxes where an output that they name has no value, shape (boxes,) or ().
        """
        inputs = self.inputs_of(lo, hi, sloped=sloped)
        names = self._constants | inputs
        void = np.array(False)
        for system, wanted in self._named(exprs).items():
            enclosures, quiet = system.evaluate([inputs[n] for n in system.inputs], [k for k, _ in wanted])
            names |= {name: e for (_, name), e in zip(wanted, enclosures, strict=True)}
            void = void | quiet
        results: dict[Expr, Enclosure] = {}

        def call(expr: Call) -> Enclosure | None:
            nonlocal void
            if expr not in results:
                if expr.function == "total":
                    (output,) = expr.arguments
                    assert isinstance(output, Name)
                    results[expr] = self.strength(list(inputs.values()), self.outputs.index(output.name))
                    return results[expr]
                where = self._output_of(expr.function)
                if where is None:
                    return None
                (results[expr],), quiet = where[0].evaluate(
                    [interpreter.enclose(a) for a in expr.arguments], [where[1]]
                )
                void = void | quiet
            return results[expr]

        interpreter = Interpreter(names, call=call)
        return [interpreter.enclose(e) for e in exprs], void

    def _output_of(self, name: str) -> tuple[System, int] | None:
        """Return the system and the position of an output, of this system or of one it is compared with."""
        if name in self.outputs:
            return self, self.outputs.index(name)
        system, _, output = name.partition(".")
        return (self.compared[system], self.compared[system].outputs.index(output)) if output else None

    def _named(self, exprs: Sequence[Expr]) -> dict[System, list[tuple[int, str]]]:
        """Return the outputs that are named at the point itself, by system, each with its name there."""
        results: dict[System, list[tuple[int, str]]] = {}
        for name in dict.fromkeys(n for e in exprs for n in _names(e)):
            where = self._output_of(name)
            if where is not None:
                results.setdefault(where[0], []).append((where[1], name))
        return results

    @cached_property
    def reader_values(self) -> dict[str, float]:
        """Params and named constants."""
        return {**CONSTANTS, **self.system.values}

    @cached_property
    def _cells(self) -> tuple[Array, Array] | None:
        """The cells where terms bend."""
        sides = range(len(self.inputs))
        return grid_of_cells([self.whole(i) for i in sides], [self.breakpoints(i) for i in sides])

    def cells(self, truths: Sequence[Truth]) -> tuple[Array, Array] | None:
        """Cut the inputs where terms bend and where conditions change; None for too many cells."""
        if not truths:
            return self._cells
        breakpoints = [self.breakpoints(i) for i in range(len(self.inputs))]
        for truth in truths:
            for bound in bounds_in(truth):
                self._add_conditions(bound, breakpoints)
        return grid_of_cells([self.whole(i) for i in range(len(self.inputs))], breakpoints)

    def is_limit(self, bound: Bound) -> bool:
        """Return whether one side is a number: such a claim is about the numbers that kernels return."""
        return is_limit(self.system, bound)

    def breakpoints(self, position: int) -> set[float]:
        """Return where the terms of an input bend."""
        sets = [d.set for d in self.plan.degrees if d.variable == position]
        return {x for s in sets for x in ([v[0] for v in s.vertices] or s.pieces)}

    def _add_conditions(self, bound: Bound, breakpoints: list[set[float]]) -> None:
        """Add where a comparison of one input changes, and where outputs taken elsewhere bend."""
        left, right = self.reader.read(bound.left), self.reader.read(bound.right)
        if left is None or right is None:
            return
        difference = left.plus(right, Fraction(-1))
        line = difference.line()
        if line is not None and line.input is not None:
            breakpoints[line.input].add(float(-line.shift / line.factor))
        systems = [self, *self.compared.values()]
        for operand in difference.outputs:
            other = systems[operand.system]
            for i, argument in enumerate(operand.arguments):
                if argument.input is not None and (other is not self or argument != self.reader.here[0][i]):
                    bends = [Fraction(x) for x in (*other.breakpoints(i), *other.whole(i)) if isfinite(x)]
                    breakpoints[argument.input] |= {float((x - argument.shift) / argument.factor) for x in bends}

    def whole(self, position: int) -> tuple[float, float]:
        """Return the ends of the range of an input."""
        variable = self.plan.inputs[position]
        return (-inf, inf) if variable.extrapolate else (variable.lower, variable.upper)

    def is_continuous(self, output: int) -> bool:
        """Return whether an output jumps nowhere: neither its terms nor its norms do, and some rule always fires."""
        plan, target = self.plan, self.plan.outputs[output]
        methods = self.system.rule_methods
        norms = {target.aggregation} | {n for m in methods for n in (m.conjunction, m.disjunction)}
        norms |= {target.implication_of(target.terms[e.term]) for e in target.implied}
        if not plan.all_act or target.reads or self.system.hedges or plan.has_formulas:
            return False
        if plan.least or target.equal or plan.chains or any(e.change is not None for e in target.implied):
            return False
        if any({**CONJUNCTIONS, **AGGREGATIONS}[n].jumps for n in norms):
            return False
        if any(target.terms[e.term].expression is not None for e in target.implied):
            return False
        if not all(_is_continuous(d.set.kind, d.set.vertices, d.set.expression) for d in plan.degrees):
            return False
        return self._uncovered[target.name] is None

    @cached_property
    def _uncovered(self) -> dict[str, Verdict]:
        """Where no rule fires, found once for the slopes along all inputs."""
        return uncovered_of(self.plan)


def grid_of_cells(
    wholes: Sequence[tuple[float, float]], breakpoints: Sequence[Iterable[float]]
) -> tuple[Array, Array] | None:
    """Cut a box at points along each side; where that gives too many cells, only sides with few; None for too many.

    Args:
        wholes: Ends of the sides.
        breakpoints: Where to cut each of them.

    Returns:
        Ends of the cells, shape (sides, cells) each.
    """
    sides = [_cut(whole, parts) for whole, parts in zip(wholes, breakpoints, strict=True)]
    count = prod(len(parts) for parts in sides)
    if count > MOST_CELLS:
        sides = [[whole] if len(parts) > 3 else parts for whole, parts in zip(wholes, sides, strict=True)]
        count = prod(len(parts) for parts in sides)
        if count > MOST_CELLS:
            return None
    ends = np.array(list(product(*sides)), dtype=np.float64).reshape(-1, len(sides), 2)
    return np.ascontiguousarray(ends[:, :, 0].T), np.ascontiguousarray(ends[:, :, 1].T)


def _cut(whole: tuple[float, float], breakpoints: Iterable[float]) -> list[tuple[float, float]]:
    """Return points and the floats strictly between them."""
    lower, upper = whole
    inner = sorted({x for x in breakpoints if lower < x < upper and isfinite(x)})
    points = [lower, *inner, upper]
    results: list[tuple[float, float]] = [(x, x) for x in points if isfinite(x)]
    for a, b in pairwise(points):
        start, stop = nextafter(a, inf) if isfinite(a) else a, nextafter(b, -inf) if isfinite(b) else b
        if start <= stop:
            results.append((start, stop))
    return results


def _is_continuous(kind: str, vertices: Sequence[tuple[float, float]], expression: Expr | None) -> bool:
    if expression is not None:
        return False
    if vertices:
        return all(a[0] < b[0] for a, b in pairwise(vertices))
    return kind in MEMBERSHIP and MEMBERSHIP[kind].continuous


def _widened(e: Enclosure, off: float) -> Enclosure:
    return Enclosure(e.lo - off, e.hi + off, e.slopes, e.error + off)


def _names(expr: Expr) -> list[str]:
    return [n.name for n in walk(expr) if isinstance(n, Name)]


def surely_false(truth: Truth, upper: dict[Bound, Array]) -> Mask:
    """Return the boxes where a condition is false everywhere, from upper ends of left less right; shape (boxes,)."""
    if isinstance(truth, Bound):
        return (upper[truth] <= 0.0) if truth.strict else (upper[truth] < 0.0)
    assert isinstance(truth, Every | Some)
    result = np.array(isinstance(truth, Some))
    for part in truth.parts:
        is_false = surely_false(part, upper)
        result = (result | is_false) if isinstance(truth, Every) else (result & is_false)
    return result


def surely_true(truth: Truth, lower: dict[Bound, Array]) -> Mask:
    """Return the boxes where a claim holds everywhere, from lower ends of left less right, shape (boxes,) each.

    Tolerances are added to them.
    """
    if isinstance(truth, Bound):
        return (lower[truth] > 0.0) if truth.strict else (lower[truth] >= 0.0)
    assert isinstance(truth, Every | Some)
    result = np.array(isinstance(truth, Every))
    for part in truth.parts:
        is_true = surely_true(part, lower)
        result = (result & is_true) if isinstance(truth, Every) else (result | is_true)
    return result
