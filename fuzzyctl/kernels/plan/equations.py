"""Equations of a controller: what they are made of."""

from __future__ import annotations

from dataclasses import field
from typing import Final

from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Expr, names_in
from fuzzyctl.model.guarantee import Bounds
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.records import record

#: Name of the time since the step before [s].
DT: Final = "dt"


@record(frozen=True)
class Equation:
    """A name for the value of an expression over names that come before."""

    name: str
    value: Expr
    span: Span | None = field(default=None, compare=False, repr=False)


@record(frozen=True)
class Evaluation:
    """A call of a fuzzy system.

    Args:
        system: The system, its params set.
        arguments: One for each of its inputs.
        names: Names for its outputs.
        states: Names of its states, in the order of its plan and one after the other in `Equations.states`.
        updates: Names for their next values.
        free: Its free numbers with their values.
    """

    system: FuzzySystem
    arguments: tuple[Expr, ...]
    names: tuple[str, ...]
    span: Span | None = field(default=None, compare=False, repr=False)
    states: tuple[str, ...] = ()
    updates: tuple[str, ...] = ()
    free: tuple[tuple[str, Expr], ...] = ()

    @property
    def defined(self) -> tuple[str, ...]:
        """The names that it gives a value."""
        return (*self.names, *self.updates)


@record(frozen=True)
class KeptState:
    """A number that is kept from one step to the next.

    Args:
        name: Its name, with those of the instances it belongs to.
        start: Its value before the first step.
        bounds: The range that the controller declares, its ends numbers; None for none.
        span: Where it is declared, or the operator that keeps it.
    """

    name: str
    start: float
    bounds: Bounds | None = None
    span: Span | None = field(default=None, compare=False, repr=False)


@record(frozen=True)
class Equations:
    """A controller as equations in an order in which they can be computed.

    Args:
        inputs: Names of the inputs.
        states: The states.
        body: Equations and calls of systems, each after those that it reads.
        outputs: Names of the outputs with the names of their values.
        updates: The next value of each state.
        period: The sample time [s]; None where it is an argument.
        parts: How many parts of expressions were expanded, a measure of its size.
        free: Names of numbers that are the last states, so that each copy has its own.
        starts_vary: Whether other states before the first step depend on them.
    """

    inputs: tuple[str, ...]
    states: tuple[KeptState, ...]
    body: tuple[Equation | Evaluation, ...]
    outputs: tuple[tuple[str, Expr], ...]
    updates: tuple[Expr, ...]
    period: float | None
    parts: int = field(default=0, compare=False, repr=False)
    free: tuple[str, ...] = ()
    starts_vary: bool = False

    @property
    def reads_time(self) -> bool:
        """Whether a step depends on the time since the step before."""
        expressions = [*self.updates, *(value for _, value in self.outputs)]
        for item in self.body:
            if isinstance(item, Evaluation):
                if item.states and any(o.adaptive is not None for o in item.system.outputs):  # consequents that adapt
                    return True
                expressions += [*item.arguments, *(value for _, value in item.free)]
            else:
                expressions.append(item.value)
        return any(name.name == DT for e in expressions for name in names_in(e))
