"""Plants: ordinary differential equations, algebraic outputs and dead time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from fuzzyctl.model.controller import Definition, Function, Result, Signal, State
from fuzzyctl.model.guarantee import Param
from fuzzyctl.model.node import Node
from fuzzyctl.model.params import ParamValues
from fuzzyctl.model.system import FuzzySystem


@dataclass(frozen=True, kw_only=True)
class Plant(Node):
    """A plant in continuous time; its inputs are held while it is integrated over a period.

    A plant that was written as a transfer function, zeros and poles, or matrices is one of linear equations.

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
        python: The file of a plant in Python, which has the states and outputs in place of `derivatives` and the values
            of `results`; an empty string for one in text.
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
    path: str = ""

    @cached_property
    def param_values(self) -> ParamValues:
        """Values of the params as far as they can be computed, and why others cannot."""
        return ParamValues(self.params)
