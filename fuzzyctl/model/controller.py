"""Controllers, and what they share with plants and loops: signals, definitions, params and calls of systems."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.displayed import Printed
from fuzzyctl.expr import FUNCTIONS, Call, Compare, Expr, Logic, Name, evaluate, is_condition, walk
from fuzzyctl.model.guarantee import Bounds, Guarantee, Param
from fuzzyctl.model.node import Node
from fuzzyctl.model.params import ParamValues
from fuzzyctl.model.system import FuzzySystem


@dataclass(frozen=True, kw_only=True, repr=False)
class Signal(Node):
    """What inputs, states and outputs share: a name, a label for plots, a unit and a range."""

    name: str
    label: str = ""
    unit: str = ""
    bounds: Bounds | None = None


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


@dataclass(frozen=True, kw_only=True, repr=False)
class Block(Node, Printed):
    """What controllers, plants and loops share.

    Args:
        name: Its identifier.
        title: What it is, for people.
        citation: Where it comes from.
        params: Named constants, as expressions.
        functions: Named expressions.
        definitions: The `let` lines.
        systems: The fuzzy systems that it calls.
        path: The file it was read from, or an empty string.
    """

    name: str
    title: str = ""
    citation: str = ""
    params: tuple[Param, ...] = ()
    functions: tuple[Function, ...] = ()
    definitions: tuple[Definition, ...] = ()
    systems: tuple[FuzzySystem, ...] = ()
    path: str = field(default="", compare=False, repr=False)

    @cached_property
    def param_values(self) -> ParamValues:
        """Values of the params as far as they can be computed, and why others cannot."""
        return ParamValues(self.params)


@dataclass(frozen=True, kw_only=True, repr=False)
class DynamicBlock(Block):
    """What controllers and plants share.

    Args:
        inputs: In the order of declaration.
        states: In the order of declaration; a run stops where a state of a plant leaves its range.
        results: The outputs in the order of declaration.
    """

    inputs: tuple[Signal, ...] = ()
    states: tuple[State, ...] = ()
    results: tuple[Result, ...] = ()

    def __repr__(self) -> str:
        inputs, outputs = ", ".join(i.name for i in self.inputs), ", ".join(r.name for r in self.results)
        return printable(
            f"{type(self).__name__}({self.name}: {inputs} -> {outputs}; {counted(len(self.states), 'state')})"
        )


@dataclass(frozen=True, kw_only=True, repr=False)
class Controller(DynamicBlock):
    """A sampled controller: synchronous equations, each name defined once, in any order.

    Args:
        updates: The next value of each state.
        instances: Controllers inside this one.
        period: The sample time [s]; None where `dt` is an argument of each step.
        controllers: The controllers that its instances are of.
        guarantees: Claims about each reachable step.
    """

    updates: tuple[Definition, ...] = ()
    instances: tuple[Instance, ...] = ()
    period: Expr | None = None
    controllers: tuple[Controller, ...] = ()
    guarantees: tuple[Guarantee, ...] = ()

    @cached_property
    def conditions(self) -> dict[str, Expr]:
        """Return the lets and outputs that are conditions over names, without calls that may keep a state."""
        items: list[Definition | Result] = [*self.definitions, *self.results]
        named = {d.name: d.value for d in items if isinstance(d.value, Compare | Logic)}
        return {name: value for name, value in named.items() if all(map(_is_plain, walk(value)))}

    def number(self, expr: Expr) -> float:
        """Compute an expression over the params."""
        return evaluate(expr, self.param_values.values)


def _is_plain(part: Expr) -> bool:
    return not isinstance(part, Call) or part.function in FUNCTIONS


def true_or_false(block: DynamicBlock) -> list[str]:
    """Return the outputs of a block that are conditions, which are 1 or 0."""
    functions = {f.name: f.expression for f in block.functions}
    values = {d.name: d.value for d in block.definitions} | {r.name: r.value for r in block.results}

    def value_of(part: Name | Call) -> Expr | None:
        return values.get(part.name) if isinstance(part, Name) else functions.get(part.function)

    return [r.name for r in block.results if is_condition(r.value, value_of)]
