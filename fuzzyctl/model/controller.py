"""Controllers and plants: equations over inputs, params, states and calls of systems."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.displayed import Printed
from fuzzyctl.expr import Expr, evaluate
from fuzzyctl.model.guarantee import Bounds, Guarantee, Param
from fuzzyctl.model.node import Node
from fuzzyctl.model.params import ParamValues
from fuzzyctl.model.system import FuzzySystem


@dataclass(frozen=True, kw_only=True)
class Signal(Node):
    """What inputs, states and outputs share: a name, a label for plots, a unit and a range."""

    name: str
    label: str = ""
    unit: str = ""
    bounds: Bounds | None = None


@dataclass(frozen=True, kw_only=True)
class State(Signal):
    """A number that is kept from one step to the next; `start` may use params only."""

    start: Expr


@dataclass(frozen=True, kw_only=True)
class Definition(Node):
    """A name for the value of an expression: a `let`, or the next value or the derivative of a state."""

    name: str
    value: Expr


@dataclass(frozen=True, kw_only=True)
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
class Controller(Node, Printed):
    """A sampled controller: synchronous equations, each name defined once, in any order.

    Args:
        name: Its identifier.
        title: What it is, for people.
        citation: Where it comes from.
        params: Named constants, as expressions.
        functions: Named expressions.
        inputs: In the order of declaration.
        states: In the order of declaration.
        definitions: The `let` lines.
        results: The outputs in the order of declaration.
        updates: The next value of each state.
        instances: Controllers inside this one.
        period: The sample time [s]; None where `dt` is an argument of each step.
        systems: The fuzzy systems that it calls.
        controllers: The controllers that its instances are of.
        path: The file it was read from, or an empty string.
        guarantees: Claims about each reachable step.
    """

    name: str
    title: str = ""
    citation: str = ""
    params: tuple[Param, ...] = ()
    functions: tuple[Function, ...] = ()
    inputs: tuple[Signal, ...] = ()
    states: tuple[State, ...] = ()
    definitions: tuple[Definition, ...] = ()
    results: tuple[Result, ...] = ()
    updates: tuple[Definition, ...] = ()
    instances: tuple[Instance, ...] = ()
    period: Expr | None = None
    systems: tuple[FuzzySystem, ...] = ()
    controllers: tuple[Controller, ...] = ()
    path: str = field(default="", compare=False, repr=False)
    guarantees: tuple[Guarantee, ...] = ()

    def __repr__(self) -> str:
        inputs, outputs = ", ".join(i.name for i in self.inputs), ", ".join(r.name for r in self.results)
        return f"Controller({self.name}: {inputs} -> {outputs}; {counted(len(self.states), 'state')})"

    @cached_property
    def param_values(self) -> ParamValues:
        """Values of the params as far as they can be computed, and why others cannot."""
        return ParamValues(self.params)

    def number(self, expr: Expr) -> float:
        """Compute an expression over the params."""
        return evaluate(expr, self.param_values.values)
