"""Loops: which controllers drive which plants, with references, disturbances, measures and a duration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.expr import Expr
from fuzzyctl.model.controller import Definition, EquationBlock
from fuzzyctl.model.guarantee import Guarantee
from fuzzyctl.model.plant import Plant


@dataclass(frozen=True, kw_only=True, repr=False)
class Measure(Definition):
    """A number that a run is judged by: `measure NAME "label" unit "..." = MEASURE(signal, ...)`."""

    label: str = ""
    unit: str = ""


@dataclass(frozen=True, kw_only=True, repr=False)
class Loop(EquationBlock):
    """An experiment: blocks, what connects them, and what is measured.

    Args:
        definitions: References, disturbances and other signals, which may use the time `t` [s] and call the functions
            of `model/signals.py`; files of `csv` are named relative to the folder of `path`.
        measures: What the run is judged by: expressions over params, other measures and calls of the functions of
            `model/measures.py`, whose first arguments are expressions over signals.
        requirements: Claims about measures, checked on the run.
        duration: How long a run lasts [s].
        step: Time between two samples of the record [s]; None for the shortest period of the controllers.
        plants: The plants that instances are of.
    """

    kind: ClassVar[str] = "loop"
    unclaimed: ClassVar[str] = "runs decide the requirements of loops: fuzzyctl simulate"

    measures: tuple[Measure, ...] = ()
    requirements: tuple[Guarantee, ...] = ()
    duration: Expr
    step: Expr | None = None
    plants: tuple[Plant, ...] = ()

    def __repr__(self) -> str:
        blocks = ", ".join(f"{i.name} = {i.controller}" for i in self.instances)
        judged = f"{counted(len(self.measures), 'measure')}, {counted(len(self.requirements), 'requirement')}"
        return printable(f"Loop({self.name}: {blocks}; {judged})")
