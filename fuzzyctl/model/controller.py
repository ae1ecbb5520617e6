"""Controllers, with the parts that plants and loops have as well: signals, definitions, params and calls of systems."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any, ClassVar, Self

from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.expr import FUNCTIONS, Call, Compare, Expr, Keyword, Logic, Name, Number, is_condition, walk
from fuzzyctl.model.block import Block, Bounds, Guarantee, Node
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.operations import operation
from fuzzyctl.records import dataclass


@dataclass(frozen=True, kw_only=True, repr=False)
class Signal(Node):
    """Base of inputs, states and outputs: a name, a label for plots, a unit and a range."""

    name: str
    label: str = ""
    unit: str = ""
    bounds: Bounds | None = None
    #: Signals have no terms, as the variables of systems have.
    terms: ClassVar[tuple[()]] = ()

    @property
    def title(self) -> str:
        """The label, or the name of a signal without one."""
        return self.label or self.name

    @property
    def axis_label(self) -> str:
        """The text at the axis of a plot: label and unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title


@dataclass(frozen=True, kw_only=True, repr=False)
class State(Signal):
    """A number that is kept from one step to the next; `start` may use params only."""

    start: Expr


@dataclass(frozen=True, kw_only=True, repr=False)
class Definition(Node):
    """A name for the value of an expression: a `let`, or the next value or the derivative of a state."""

    name: str
    value: Expr


@dataclass(frozen=True, kw_only=True, repr=False)
class Result(Signal):
    """An output with the expression that defines it."""

    value: Expr


@dataclass(frozen=True, kw_only=True)
class Function(Node):
    """A named expression over its parameters and params: `function NAME(a, b) = expression`."""

    name: str
    parameters: tuple[str, ...]
    expression: Expr


@dataclass(frozen=True, kw_only=True)
class Instance(Node):
    """A controller inside another one: `block NAME = CONTROLLER(arguments)`.

    Args:
        name: Its outputs are `NAME.output`.
        controller: Name of the controller.
        arguments: Its inputs in order or by name, its params by name.
    """

    name: str
    controller: str
    arguments: tuple[Expr, ...]

    def with_values(self, values: Mapping[str, float]) -> Instance:
        """Return the block with the values of its params that are given as `NAME.PARAM`; other names do not count."""
        changes = {n.partition(".")[2]: v for n, v in values.items() if n.partition(".")[0] == self.name and "." in n}
        rest = [a for a in self.arguments if not (isinstance(a, Keyword) and a.name in changes)]
        keywords = [Keyword(name, Number(float(value))) for name, value in changes.items()]
        return replace(self, arguments=(*rest, *keywords)) if changes else self


@dataclass(frozen=True, kw_only=True, repr=False)
class EquationBlock(Block):
    """Base of controllers, plants and loops.

    Args:
        functions: Named expressions.
        inputs: In the order of declaration.
        states: In the order of declaration; a run stops where a state of a plant leaves its range.
        definitions: The `let` lines.
        results: The outputs in the order of declaration.
        instances: The blocks inside this one.
        systems: The fuzzy systems that it calls.
        controllers: The controllers that its instances are of.
        plants: The plants that they are of; loops only have such.
        guarantees: Claims of a controller about each reachable step.
        period: The sample time of a controller [s]; None if `dt` is an argument of each step.
    """

    functions: tuple[Function, ...] = ()
    inputs: tuple[Signal, ...] = ()
    states: tuple[State, ...] = ()
    definitions: tuple[Definition, ...] = ()
    results: tuple[Result, ...] = ()
    instances: tuple[Instance, ...] = ()
    systems: tuple[FuzzySystem, ...] = ()
    controllers: tuple[Controller, ...] = ()
    plants: tuple[EquationBlock, ...] = ()
    guarantees: tuple[Guarantee, ...] = ()

    period: Expr | None = None

    def __repr__(self) -> str:
        inputs, outputs = ", ".join(i.name for i in self.inputs), ", ".join(r.name for r in self.results)
        return printable(
            f"{type(self).__name__}({self.name}: {inputs} -> {outputs}; {counted(len(self.states), 'state')})"
        )

    @property
    def outputs(self) -> tuple[Result, ...]:
        """The results, by the name that outputs have in every block."""
        return self.results

    @property
    def parts(self) -> tuple[Block, ...]:
        """The blocks that it calls, each behind those that it calls itself, and at last the block."""
        inner = (part for callee in (*self.controllers, *self.plants) for part in callee.parts)
        return (*self.systems, *inner, self)

    @property
    def instance_params(self) -> list[str]:
        """The params of controllers inside, those of the blocks of a loop among them, as `INSTANCE.PARAM`."""
        inner = {c.name: c.settable for c in self.controllers}
        return [f"{i.name}.{name}" for i in self.instances for name in inner.get(i.controller, ())]

    def with_systems(self, change: Callable[[FuzzySystem], FuzzySystem]) -> Self:
        """Return the block with each system that it evaluates changed, those of blocks inside among them."""
        return replace(
            self,
            systems=tuple(map(change, self.systems)),
            controllers=tuple(c.with_systems(change) for c in self.controllers),
            plants=tuple(p.with_systems(change) for p in self.plants),
        )

    def callee(self, instance: Instance) -> EquationBlock:
        """Return the controller or plant that an instance is of."""
        return next(b for b in (*self.controllers, *self.plants) if b.name == instance.controller)

    def with_params(self, **values: float) -> Self:
        """Return the block with some params set to numbers, those of instances by `INSTANCE.PARAM`.

        Raises:
            DiagnosticError: For numbers that the block does not take, such as one outside of the range of its param.
        """
        block: Self = operation("with_params")(self, values)
        return block

    def with_values(self, values: Mapping[str, Any]) -> Self:
        """Return the block with other values of free numbers, see `loading.block_equations.with_numbers`."""
        block: Self = operation("with_values")(self, values)
        return block

    def range_of(self, signal: Any) -> tuple[float, float]:
        """Return the ends of the range of an input, state or output; infinite without a range."""
        if signal.bounds is None:
            return -math.inf, math.inf
        return self.number(signal.bounds.lower), self.number(signal.bounds.upper)


@dataclass(frozen=True, kw_only=True, repr=False)
class Controller(EquationBlock):
    """A sampled controller: synchronous equations, each name defined once, in any order.

    Args:
        updates: The next value of each state.
    """

    kind: ClassVar[str] = "controller"
    is_sampled: ClassVar[bool] = True

    updates: tuple[Definition, ...] = ()

    @cached_property
    def conditions(self) -> dict[str, Expr]:
        """Return the lets and outputs that are conditions over names, without calls that may keep a state."""
        items: list[Definition | Result] = [*self.definitions, *self.results]
        named = {d.name: d.value for d in items if isinstance(d.value, Compare | Logic)}
        return {name: value for name, value in named.items() if all(map(_is_plain, walk(value)))}

    @property
    def changes(self) -> tuple[Definition, ...]:
        """The updates."""
        return self.updates

    @property
    def settable(self) -> list[str]:
        """The names of the params that can be set, those of instances among them."""
        return [*super().settable, *self.instance_params]


def _is_plain(part: Expr) -> bool:
    return not isinstance(part, Call) or part.function in FUNCTIONS


def true_or_false(block: EquationBlock) -> list[str]:
    """Return the outputs of a block that are conditions, which are 1 or 0."""
    functions = {f.name: f.expression for f in block.functions}
    values = {d.name: d.value for d in block.definitions} | {r.name: r.value for r in block.results}

    def value_of(part: Name | Call) -> Expr | None:
        return values.get(part.name) if isinstance(part, Name) else functions.get(part.function)

    return [r.name for r in block.results if is_condition(r.value, value_of)]
