"""A step of a controller for interval evaluation: its equations, what they read, and enclosures of systems."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Final

import numpy as np

from fuzzyctl.analysis import clock
from fuzzyctl.analysis.bounds import output_bounds
from fuzzyctl.analysis.branch_and_bound.boxed_system import System
from fuzzyctl.analysis.claims import Bound
from fuzzyctl.analysis.coverage.coverage import uncovered_of
from fuzzyctl.analysis.induction.claims import NEXT
from fuzzyctl.analysis.work import SpentError
from fuzzyctl.expr import Binary, Compare, Expr, ExprError, Logic, Name, Negate, Number, Where, evaluate, names_in, walk
from fuzzyctl.kernels.interval.narrowing import NarrowingInterpreter, may_be_nan
from fuzzyctl.kernels.interval.vector import Enclosure, Mask, jumping
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.plan.equations import DT, Equation, Equations, Evaluation
from fuzzyctl.kernels.step_program import numeric
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.records import record

#: Inputs without an end are first taken up to this magnitude, so that nothing overflows where they are multiplied.
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
        found, _ = self.boxed.evaluate(arguments, wanted)
        return [self._held(e, k, lacks) for e, k in zip(found, wanted, strict=True)]

    def _held(self, e: Enclosure, output: int, lacks: Mask) -> Enclosure:
        known, lacks = self.bounds[output], lacks | np.array(self.may_lack[output])
        if self.computed[output]:
            lacks = lacks | may_be_nan(e)
        lo, hi = np.maximum(e.lo, known.lo), np.minimum(e.hi, known.hi)
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
        #: What names are as `line` says, each after those that it reads.
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
        """Return what some names depend on."""
        kept: set[int] = set()
        seen: set[str] = set()
        waiting = list(names)
        while waiting:
            name = waiting.pop()
            if name in seen:
                continue
            seen.add(name)
            position = self._makers.get(name)
            if position is not None and position not in kept:
                kept.add(position)
                waiting += read(self.body[position])
        return Slice(tuple(self.body[k] for k in sorted(kept)), tuple(a for a in self.arguments if a in seen))

    def origins(self, names: Iterable[str]) -> set[str]:
        """Return all names that some names depend on, in this step or in earlier ones."""
        found: set[str] = set()
        waiting = list(names)
        while waiting:
            name = waiting.pop()
            if name not in found:
                found.add(name)
                position = self._makers.get(name, self._makers.get(NEXT + name))
                waiting += [] if position is None else read(self.body[position])
        return found

    def is_limit(self, bound: Bound) -> bool:
        """Return whether one side of a comparison is the same in all steps."""
        sides = [e.name for e in (bound.left, bound.right) if isinstance(e, Name)]
        return len(sides) < 2 or any(not self.slice([s]).arguments for s in sides)

    def called(self, system: FuzzySystem) -> CalledSystem:
        """Return a system that is called."""
        if id(system) not in self._called:
            self._called[id(system)] = CalledSystem(system)
        return self._called[id(system)]

    def evaluate(self, own: Slice, arguments: Mapping[str, Enclosure], *, nearest: bool = True) -> NarrowingInterpreter:
        """Enclose all names of a slice.

        Args:
            own: The slice.
            arguments: Enclosures of what it reads.
            nearest: Whether only what kernels compute is enclosed, not the real values.

        Raises:
            SpentError: When the time of the ranges is over.
        """
        found = NarrowingInterpreter(arguments, self.definitions, nearest=nearest)
        for item in own.body:
            if clock.is_over():
                raise SpentError
            if isinstance(item, Equation):
                found.names[item.name] = found.enclose(self.definitions[item.name])
            else:
                given = [found.enclose(numeric(a)) for a in item.arguments]
                values = self.called(item.system).enclose(given, [*range(len(item.names))])
                found.names |= dict(zip(item.defined, [*values, *self.called(item.system).updates], strict=True))
        return found

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


def parted(own: Slice, names: Iterable[str]) -> tuple[Slice, Slice]:
    """Return the part of a slice that depends on none of some names, and the part that does."""
    changing = set(names)
    parts: tuple[list[Item], list[Item]] = [], []
    for item in own.body:
        depends = not changing.isdisjoint(read(item))
        parts[depends].append(item)
        if depends:
            changing.update(defined(item))
    return Slice(tuple(parts[0]), own.arguments), Slice(tuple(parts[1]), own.arguments)


def _scaled(line: tuple[str, float, float] | None, factor: float, shift: float) -> tuple[str, float, float] | None:
    if line is None or not factor:
        return None
    name, own, offset = line
    return name, factor * own, factor * offset + shift
