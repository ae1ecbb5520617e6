"""Plants: ordinary differential equations, algebraic outputs and dead time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.displayed import Printed
from fuzzyctl.model.controller import Definition, Function, Result, Signal, State
from fuzzyctl.model.guarantee import Param
from fuzzyctl.model.node import Node
from fuzzyctl.model.params import ParamValues
from fuzzyctl.model.system import FuzzySystem


@dataclass(frozen=True, kw_only=True, repr=False)
class Plant(Node, Printed):
    """A plant in continuous time; its inputs are held while it is integrated over a period.

    A plant that was written as a transfer function, zeros and poles, or matrices is one of linear equations.
    Expressions may use the time `t` [s]; `delay(x, time, start=0)` is x of `time` seconds before.

    Args:
        name: Its identifier.
        title: What it is, for people.
        citation: Where it comes from.
        params: Named constants, as expressions.
        functions: Named expressions.
        inputs: In the order of declaration.
        states: In the order of declaration; a run stops where one leaves its range.
        definitions: The `let` lines.
        results: The outputs in the order of declaration.
        derivatives: The derivative of each state by time.
        systems: The fuzzy systems that it calls.
        python: The file of a plant in Python, an empty string for one in text. Its `inputs`, `states` and `outputs`
            are those of the file, read without running it; `derivatives` are empty, and the value of each output is its
            own name.
        fmu: The file of a plant that is an FMU, else an empty string. The same holds for it; it has no states here.
        calls: Of a plant whose code is functions in place of a file: its derivatives from time, states and inputs, and
            its outputs from time and states. `python` then says what they are.
        path: The file it was read from, or an empty string.
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
    derivatives: tuple[Definition, ...] = ()
    systems: tuple[FuzzySystem, ...] = ()
    python: str = ""
    fmu: str = ""
    calls: tuple[Callable[..., Any], ...] = ()
    path: str = field(default="", compare=False, repr=False)

    def __repr__(self) -> str:
        inputs, outputs = ", ".join(i.name for i in self.inputs), ", ".join(r.name for r in self.results)
        return f"Plant({self.name}: {inputs} -> {outputs}; {counted(len(self.states), 'state')})"

    @property
    def external(self) -> str:
        """The file of code that computes the plant: in Python, or an FMU; an empty string for a plant in text."""
        return self.python or self.fmu

    @cached_property
    def param_values(self) -> ParamValues:
        """Values of the params as far as they can be computed, and why others cannot."""
        return ParamValues(self.params)
