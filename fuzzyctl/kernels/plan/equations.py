"""Equations of a controller and their order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field
from typing import Final

from fuzzyctl.diagnostics.diagnostic import Diagnostic, DiagnosticError
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Expr, names_in
from fuzzyctl.model.block import Bounds
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


def ordered(body: list[Equation | Evaluation]) -> tuple[Equation | Evaluation, ...]:
    """Return equations each after those that it reads.

    Raises:
        DiagnosticError: For an algebraic loop.
    """
    makers: dict[str, Equation | Evaluation] = {}
    for item in body:
        makers |= dict.fromkeys(item.defined if isinstance(item, Evaluation) else (item.name,), item)
    ordered: dict[int, Equation | Evaluation] = {}
    for item in body:
        if id(item) not in ordered:
            _visit(item, makers, ordered)
    return tuple(ordered.values())


def feedthrough(equations: Equations) -> dict[str, tuple[str, ...]]:
    """Return the inputs that each output depends on within the same step."""
    depends = {name: frozenset((name,)) for name in equations.inputs}
    for item in equations.body:
        read = frozenset[str]().union(*(depends[n] for n in _reads(item) if n in depends))
        depends |= dict.fromkeys(item.defined if isinstance(item, Evaluation) else (item.name,), read)
    values = {o: frozenset[str]().union(*(depends.get(n.name, ()) for n in names_in(v))) for o, v in equations.outputs}
    return {output: tuple(i for i in equations.inputs if i in inputs) for output, inputs in values.items()}


def _reads(item: Equation | Evaluation) -> list[str]:
    values = (*item.arguments, *(v for _, v in item.free)) if isinstance(item, Evaluation) else (item.value,)
    return [n.name for value in values for n in names_in(value)]


def _visit(
    start: Equation | Evaluation,
    makers: Mapping[str, Equation | Evaluation],
    ordered: dict[int, Equation | Evaluation],
) -> None:
    """Put an equation behind those that it reads, without recursion: chains of equations may be long."""
    open_items = {id(start): start}
    path = [(start, _needed(start, makers))]
    while path:
        item, needed = path[-1]
        following = next((n for n in needed if id(n) not in ordered), None)
        if following is None:
            ordered.setdefault(id(item), item)
            del open_items[id(item)]
            path.pop()
        elif id(following) in open_items:
            members = [open_one for open_one, _ in path]
            raise DiagnosticError([_loop(members[members.index(following) :])])
        else:
            open_items[id(following)] = following
            path.append((following, _needed(following, makers)))


def _needed(
    item: Equation | Evaluation, makers: Mapping[str, Equation | Evaluation]
) -> Iterator[Equation | Evaluation]:
    return iter([makers[n] for n in _reads(item) if n in makers])


def _loop(items: list[Equation | Evaluation]) -> Diagnostic:
    """Return the diagnostic of equations that read each other in a circle."""
    written = [item for item in items if _shown(item)] or items
    named = list(dict.fromkeys(map(_shown, written)))
    span = next((item.span for item in (*written, *items) if item.span is not None), None)
    chain = " → ".join([*named, named[0]])
    message = f"algebraic loop: '{named[0]}' depends on itself within one step"
    help_text = f"let a value of the step before break it, such as previous({named[0]})"
    return Diagnostic("FZ220", message, span, facts=(chain,), help=help_text)


def _shown(item: Equation | Evaluation) -> str:
    """Return the name of an equation as its author wrote it; empty for one that the expansion made."""
    if isinstance(item, Evaluation):
        return item.system.name
    return "" if "#" in item.name else item.name
