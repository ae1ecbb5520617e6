"""Plants: ordinary differential equations, algebraic outputs and dead time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

from fuzzyctl.model.controller import Definition, EquationBlock


@dataclass(frozen=True, kw_only=True, repr=False)
class Plant(EquationBlock):
    """A plant in continuous time; its inputs are held while it is integrated over a period.

    A plant that was written as a transfer function, zeros and poles, or matrices is one of linear equations.
    Expressions may use the time `t` [s]; `delay(x, time, start=0)` is x of `time` seconds before.

    Args:
        derivatives: The derivative of each state by time.
        python: The file of a plant in Python, an empty string for one in text. Its `inputs`, `states` and `outputs`
            are those of the file, read without running it; `derivatives` are empty, and the value of each output is its
            own name.
        fmu: The file of a plant that is an FMU, else an empty string. The same holds for it; it has no states here.
        calls: Of a plant whose code is functions in place of a file: its derivatives from time, states and inputs, and
            its outputs from time and states. `python` then says what they are.
    """

    kind: ClassVar[str] = "plant"
    unclaimed: ClassVar[str] = "plants make no claims"

    derivatives: tuple[Definition, ...] = ()
    python: str = ""
    fmu: str = ""
    calls: tuple[Callable[..., Any], ...] = ()

    @property
    def changes(self) -> tuple[Definition, ...]:
        """The derivatives."""
        return self.derivatives

    @property
    def external(self) -> str:
        """The file of code that computes the plant: in Python, or an FMU; an empty string for a plant in text."""
        return self.python or self.fmu
