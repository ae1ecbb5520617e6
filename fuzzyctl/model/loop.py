"""Loops: which controllers drive which plants, with references, disturbances, measures and a duration."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.displayed import Printed
from fuzzyctl.expr import Expr
from fuzzyctl.model.controller import Controller, Definition, Function, Instance
from fuzzyctl.model.guarantee import Guarantee, Param
from fuzzyctl.model.node import Node
from fuzzyctl.model.params import ParamValues
from fuzzyctl.model.plant import Plant
from fuzzyctl.model.system import FuzzySystem


@dataclass(frozen=True, kw_only=True)
class Measure(Definition):
    """A number that a run is judged by: `measure NAME "label" unit "..." = MEASURE(signal, ...)`."""

    label: str = ""
    unit: str = ""


@dataclass(frozen=True, kw_only=True, repr=False)
class Loop(Node, Printed):
    """An experiment: blocks, what connects them, and what is measured.

    Args:
        name: Its identifier.
        title: What it is, for people.
        citation: Where it comes from.
        params: Named constants, as expressions.
        functions: Named expressions.
        instances: Controllers and plants, each with its arguments; the outputs are `NAME.OUTPUT`.
        definitions: The `let` lines: references, disturbances and other signals, which may use the time `t` [s] and
            call the functions of `model/signals.py`; files of `csv` are named relative to the folder of `path`.
        measures: What the run is judged by: expressions over params, other measures and calls of the functions of
            `model/measures.py`, whose first arguments are expressions over signals.
        requirements: Claims about measures, checked on the run.
        duration: How long a run lasts [s].
        step: Time between two samples of the record [s]; None for the shortest period of the controllers.
        controllers: The controllers that instances are of.
        plants: The plants that instances are of.
        systems: The fuzzy systems that `let` lines call.
        path: The file it was read from, or an empty string.
    """

    name: str
    title: str = ""
    citation: str = ""
    params: tuple[Param, ...] = ()
    functions: tuple[Function, ...] = ()
    instances: tuple[Instance, ...] = ()
    definitions: tuple[Definition, ...] = ()
    measures: tuple[Measure, ...] = ()
    requirements: tuple[Guarantee, ...] = ()
    duration: Expr
    step: Expr | None = None
    controllers: tuple[Controller, ...] = ()
    plants: tuple[Plant, ...] = ()
    systems: tuple[FuzzySystem, ...] = ()
    path: str = field(default="", compare=False, repr=False)

    def __repr__(self) -> str:
        blocks = ", ".join(f"{i.name} = {i.controller}" for i in self.instances)
        judged = f"{counted(len(self.measures), 'measure')}, {counted(len(self.requirements), 'requirement')}"
        return f"Loop({self.name}: {blocks}; {judged})"

    @cached_property
    def param_values(self) -> ParamValues:
        """Values of the params as far as they can be computed, and why others cannot."""
        return ParamValues(self.params)
