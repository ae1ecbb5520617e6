"""A step of a controller for interval evaluation: its equations, enclosures of systems, and the step over boxes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import chain
from math import inf
from typing import Final

import numpy as np

from fuzzyctl.analysis.bounds import output_bounds
from fuzzyctl.analysis.branch_and_bound.boxed_system import System, grid_of_cells
from fuzzyctl.analysis.claims import Bound, Truth, bounds_in
from fuzzyctl.analysis.coverage.coverage import uncovered_of
from fuzzyctl.analysis.induction.claims import NEXT
from fuzzyctl.analysis.work import SpentError, clock
from fuzzyctl.expr import (
    Binary,
    Call,
    Compare,
    Expr,
    ExprError,
    Logic,
    Name,
    Negate,
    Number,
    Where,
    evaluate,
    names_in,
    walk,
)
from fuzzyctl.kernels.interval.narrowing import NarrowingInterpreter, may_be_nan
from fuzzyctl.kernels.interval.program import Interpreter
from fuzzyctl.kernels.interval.vector import Array, Enclosure, Mask, boxes, jumping
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.plan.equations import DT, Equation, Equations, Evaluation
from fuzzyctl.kernels.step_form import numeric
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.records import record

#: Inputs without an end are first limited to this magnitude, so that their products do not overflow.
FAR: Final = 1e30
#: The least magnitude at which only rounding keeps an end of a range, since sums of floats stay where they are there.
ABSORBED: Final = 1e20

Item = Equation | Evaluation


@record(frozen=True)
class Slice:
    """The part of a step that some names depend on.

    Args:
        body: Equations and calls of systems, each after those that it reads.
        arguments: The inputs, states and `dt` that they read.
    """

    body: tuple[Item, ...]
    arguments: tuple[str, ...]

    @property
    def shown(self) -> tuple[str, ...]:
        """The arguments and the states of systems that it calls, which are enclosed by their ranges."""
        return (*self.arguments, *(n for item in self.body if isinstance(item, Evaluation) for n in item.states))


class CalledSystem:
    """A fuzzy system that a step calls."""

    def __init__(self, system: FuzzySystem) -> None:
        self.system = system
        self.boxed = System(system, plan(system))
        self.bounds = list(output_bounds(system).values())
        outputs = self.boxed.plan.outputs
        uncovered = uncovered_of(self.boxed.plan)
        #: Whether each output is NaN where no rule fires, and that is not known to be nowhere.
        self.may_lack = [uncovered[o.name] is not None and _is_nan(o.otherwise) for o in outputs]
        #: Whether each output is computed by formulas, which may have no value.
        self.computed = [
            bool(system.lets or o.value is not None or o.reads or any(t.reads_inputs for t in o.terms)) for o in outputs
        ]

    @cached_property
    def updates(self) -> list[Enclosure]:
        """Enclosures of the next values of its states: adaptive consequents, then outputs that hold."""
        flat = self.boxed.plan
        adaptive = [jumping(np.array(flat.outputs[o].lower), np.array(flat.outputs[o].upper)) for o, _ in flat.states]
        return adaptive + [jumping(np.array(self.bounds[o].lo), np.array(self.bounds[o].hi)) for o in flat.held]

    def enclose(self, arguments: list[Enclosure], wanted: list[int]) -> list[Enclosure]:
        """Enclose some outputs."""
        lacks: Mask = np.array(False)
        for argument in arguments:
            lacks = lacks | may_be_nan(argument)
        result, _ = self.boxed.evaluate(arguments, wanted)
        return [self._held(e, k, lacks) for e, k in zip(result, wanted, strict=True)]

    def _held(self, e: Enclosure, output: int, lacks: Mask) -> Enclosure:
        bound, lacks = self.bounds[output], lacks | np.array(self.may_lack[output])
        if self.computed[output]:
            lacks = lacks | may_be_nan(e)
        lo, hi = np.maximum(e.lo, bound.lo), np.minimum(e.hi, bound.hi)
        if not lacks.any():
            return Enclosure(lo, hi, e.slopes, e.error)
        return jumping(np.where(lacks, -np.inf, lo), np.where(lacks, np.inf, hi))


class StepModel:
    """The equations of a step, the next values of its states among them.

    Args:
        equations: The controller's.
    """

    def __init__(self, equations: Equations) -> None:
        self.equations = equations
        updates = zip(equations.states, equations.updates, strict=True)
        self.body: tuple[Item, ...] = (*equations.body, *(Equation(NEXT + s.name, u) for s, u in updates))
        self.definitions = {item.name: numeric(item.value) for item in self.body if isinstance(item, Equation)}
        self.arguments = [*equations.inputs, *(s.name for s in equations.states)]
        if equations.period is None:
            self.arguments.append(DT)
        #: Names as lines, see `line`, each after those that it reads.
        self._lines: dict[str, tuple[str, float, float] | None] = {}
        for item in self.body:
            for name in defined(item):
                self._lines[name] = self.line(self.definitions[name]) if name in self.definitions else None
        self._called: dict[int, CalledSystem] = {}

    @cached_property
    def _makers(self) -> dict[str, int]:
        """Positions of the equations by the names that they define."""
        return {name: k for k, item in enumerate(self.body) for name in defined(item)}

    def slice(self, names: Iterable[str]) -> Slice:
        """Return the part of the step that some names depend on."""
        positions: set[int] = set()
        seen: set[str] = set()
        waiting = list(names)
        while waiting:
            name = waiting.pop()
            if name in seen:
                continue
            seen.add(name)
            position = self._makers.get(name)
            if position is not None and position not in positions:
                positions.add(position)
                waiting += read(self.body[position])
        return Slice(tuple(self.body[k] for k in sorted(positions)), tuple(a for a in self.arguments if a in seen))

    def origins(self, names: Iterable[str]) -> set[str]:
        """Return all names that some names depend on, in this step or in earlier ones."""
        results: set[str] = set()
        waiting = list(names)
        while waiting:
            name = waiting.pop()
            if name not in results:
                results.add(name)
                position = self._makers.get(name, self._makers.get(NEXT + name))
                waiting += [] if position is None else read(self.body[position])
        return results

    def is_limit(self, bound: Bound) -> bool:
        """Return whether one side of a comparison is the same in all steps."""
        sides = [e.name for e in (bound.left, bound.right) if isinstance(e, Name)]
        return len(sides) < 2 or any(not self.slice([s]).arguments for s in sides)

    def called(self, system: FuzzySystem) -> CalledSystem:
        """Return a system that is called."""
        if id(system) not in self._called:
            self._called[id(system)] = CalledSystem(system)
        return self._called[id(system)]

    def evaluate(
        self, part: Slice, arguments: Mapping[str, Enclosure], *, nearest: bool = True
    ) -> NarrowingInterpreter:
        """Enclose all names of a slice.

        Args:
            part: The slice.
            arguments: Enclosures of the names that it reads.
            nearest: Whether only the values that kernels compute are enclosed, not the real values.

        Raises:
            SpentError: When the time of the ranges is over.
        """
        result = NarrowingInterpreter(arguments, self.definitions, nearest=nearest)
        for item in part.body:
            if clock.is_over():
                raise SpentError
            if isinstance(item, Equation):
                result.names[item.name] = result.enclose(self.definitions[item.name])
            else:
                enclosures = [result.enclose(numeric(a)) for a in item.arguments]
                values = self.called(item.system).enclose(enclosures, [*range(len(item.names))])
                result.names |= dict(zip(item.defined, [*values, *self.called(item.system).updates], strict=True))
        return result

    def constant(self, expr: Expr) -> float | None:
        """Return the value of an expression that reads no name, None for any other."""
        if isinstance(expr, Name) and expr.name in self.definitions:
            expr = self.definitions[expr.name]
        if names_in(expr) or any(isinstance(n, Compare | Logic | Where) for n in walk(expr)):
            return None
        try:
            return evaluate(expr, {})
        except ExprError:
            return None

    def line(self, expr: Expr) -> tuple[str, float, float] | None:
        """Return an expression as factor · argument + shift: the argument, factor and shift; None for any other."""
        match expr:
            case Name(name=name):
                return self._lines.get(name, (name, 1.0, 0.0))
            case Negate(operand=operand):
                return _scaled(self.line(operand), -1.0, 0.0)
            case Binary(op="+" | "-" as op, left=left, right=Number(value=value)):
                return _scaled(self.line(left), 1.0, value if op == "+" else -value)
            case Binary(op="+", left=Number(value=value), right=right):
                return _scaled(self.line(right), 1.0, value)
            case Binary(op="-", left=Number(value=value), right=right):
                return _scaled(self.line(right), -1.0, value)
            case Binary(op="*", left=Number(value=value), right=right):
                return _scaled(self.line(right), value, 0.0)
            case Binary(op="*" | "/" as op, left=left, right=Number(value=value)) if value:
                return _scaled(self.line(left), value if op == "*" else 1.0 / value, 0.0)
        return None


def _is_nan(otherwise: object) -> bool:
    return isinstance(otherwise, float) and np.isnan(otherwise)


def defined(item: Item) -> tuple[str, ...]:
    """Return the names that an equation or a call of a system defines."""
    return item.defined if isinstance(item, Evaluation) else (item.name,)


def read(item: Item) -> list[str]:
    """Return the names that an equation or a call of a system reads."""
    values = item.arguments if isinstance(item, Evaluation) else (item.value,)
    return [n.name for value in values for n in names_in(value)]


def parted(whole: Slice, names: Iterable[str]) -> tuple[Slice, Slice]:
    """Return the part of a slice that depends on none of some names, and the part that does."""
    changing = set(names)
    parts: tuple[list[Item], list[Item]] = [], []
    for item in whole.body:
        depends = not changing.isdisjoint(read(item))
        parts[depends].append(item)
        if depends:
            changing.update(defined(item))
    return Slice(tuple(parts[0]), whole.arguments), Slice(tuple(parts[1]), whole.arguments)


def _scaled(line: tuple[str, float, float] | None, factor: float, shift: float) -> tuple[str, float, float] | None:
    if line is None or not factor:
        return None
    name, slope, offset = line
    return name, factor * slope, factor * offset + shift


#: Most arguments along which slopes are computed.
_MOST_SLOPES: Final = 60
#: Most states without ends whose values below and above 0 are enclosed apart.
_SPLIT: Final = 4
#: Units of work for a node of an expression over many boxes, and for each number of its arrays.
_NODE, _NUMBER = 8, 0.0023

#: Slopes that are not known.
_UNKNOWN: Final = (np.full((1, 1), -inf), np.full((1, 1), inf))
#: Names that may be NaN.
ANYTHING: Final = jumping(np.array(-inf), np.array(inf))

#: The least and the largest value.
Ends = tuple[float, float]


class BoxedStep:
    """A part of a step over boxes.

    Args:
        model: The step.
        ranges: The least and the largest value of each input, state and `dt`.
        names: The names to enclose; the sides of boxes are the arguments that these depend on.
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

        With slopes the ends enclose the values that kernels compute, without them the real values as well.
        """
        least, most = self.ends[:, :1], self.ends[:, 1:]
        lo, hi = np.clip(lo, least, most), np.clip(hi, least, most)
        flat = [Enclosure(a, b, None, np.array(0.0)) for a, b in zip(lo, hi, strict=True)]
        if len(flat) > _MOST_SLOPES:
            sides = [Enclosure(e.lo, e.hi, _UNKNOWN, e.error) for e in flat]
        else:
            sides = boxes(lo, hi)
        results = self._enclosed(exprs, sides if sloped else flat, nearest=False)
        if sloped:
            floats = self._enclosed(exprs, flat, nearest=True)
            results = [
                Enclosure(np.maximum(e.lo, f.lo), np.minimum(e.hi, f.hi), e.slopes, e.error)
                for e, f in zip(results, floats, strict=True)
            ]
        return results, np.array(False)

    def _enclosed(self, exprs: Sequence[Expr], sides: list[Enclosure], *, nearest: bool) -> list[Enclosure]:
        enclosures = dict(zip(self.inputs, sides, strict=True)) | dict.fromkeys(self.lost, ANYTHING)
        names = Interpreter(self.model.evaluate(self.slice, enclosures, nearest=nearest).names)
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
        """Return expressions with the values at which the functions that read them bend or jump."""
        if isinstance(item, Evaluation):
            boxed = self.model.called(item.system).boxed
            return [(a, [*boxed.breakpoints(i), *boxed.whole(i)]) for i, a in enumerate(item.arguments)]
        bends: list[tuple[Expr, Sequence[float]]] = []
        for node in walk(item.value):
            match node:
                case Compare(left=left, right=right) | Call(function="min" | "max", arguments=(left, right)):
                    bends += self._pairs(left, right)
                case Call(function="abs", arguments=(operand,)):
                    bends.append((operand, [0.0]))
        return bends

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
        units = self._nodes * (_NODE + _NUMBER * boxes * (1 + 2 * len(self.inputs)))
        return units + sum(s.units(k, boxes) for s in systems for k in range(len(s.outputs)))
