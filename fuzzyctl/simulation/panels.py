"""Panels of pictures of a run: which outputs follow which references, controls, disturbances."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Final

from fuzzyctl.expr import Call, Expr, Keyword, Name, names_in, walk
from fuzzyctl.model.controller import Signal
from fuzzyctl.model.forms import bound
from fuzzyctl.model.loop import MEASURES, Loop
from fuzzyctl.simulation.equations import block_signals

#: How the signal that another one should follow is called among the arguments of measures.
_REFERENCE = "reference"


def inputs_of_time(loop: Loop) -> list[str]:
    """Return the lets that depend on no block: references and disturbances, but not noise."""
    reads = {d.name: {n.name for n in names_in(d.value)} for d in loop.definitions}
    drawn = {d.name for d in loop.definitions for c in walk(d.value) if isinstance(c, Call) and c.function == "noise"}
    blocks = {i.name for i in loop.instances}
    readers: dict[str, list[str]] = {}
    for name, read in reads.items():
        for other in read:
            readers.setdefault(other, []).append(name)
    tied: set[str] = set()
    waiting = [n for n in reads if n in drawn or any(r.partition(".")[0] in blocks for r in reads[n])]
    while waiting:
        name = waiting.pop()
        if name not in tied:
            tied.add(name)
            waiting += readers.get(name, ())
    return [n for n in reads if n not in tied]


def references(loop: Loop) -> dict[str, Expr]:
    """Return the reference of each signal that follows one, by name: a signal or a constant.

    Measures say so, such as `overshoot(tank.y, reference)`. Where none does, a loop with one plant of one output and
    one let that depends on the time alone, or one constant, that goes into a controller follows that.
    """
    followers: dict[str, Expr] = {}
    for measure in loop.measures:
        for call in walk(measure.value):
            if isinstance(call, Call) and call.function in MEASURES and _REFERENCE in MEASURES[call.function].signals:
                arguments = bound(MEASURES[call.function], call)
                y = arguments[MEASURES[call.function].signals[0]]
                if isinstance(y, Name):
                    followers.setdefault(y.name, arguments[_REFERENCE])
    return followers or _only(loop)


def _only(loop: Loop) -> dict[str, Expr]:
    plants = {p.name: p for p in loop.plants}
    outputs = [
        f"{i.name}.{r.name}" for i in loop.instances if i.controller in plants for r in plants[i.controller].results
    ]
    of_time = inputs_of_time(loop)
    params = loop.param_values.values
    followed = dict.fromkeys(
        e
        for e in _into_controllers(loop)
        if (isinstance(e, Name) and e.name in of_time) or all(n.name in params for n in names_in(e))
    )
    return {outputs[0]: next(iter(followed))} if len(outputs) == len(followed) == 1 else {}


def _into_controllers(loop: Loop) -> Iterator[Expr]:
    """Yield the expressions that inputs of controllers are connected to."""
    inputs = {c.name: [s.name for s in c.inputs] for c in loop.controllers}
    for instance in loop.instances:
        for argument in instance.arguments if instance.controller in inputs else ():
            if not isinstance(argument, Keyword):
                yield argument
            elif argument.name in inputs[instance.controller]:
                yield argument.value


#: Most letters of a label without its unit.
LONGEST: Final = 20


@dataclass(frozen=True)
class Panel:
    """One quantity over time.

    Args:
        signal: Its name in the runs.
        label: Label of the axis.
        reference: Signal or constant that it should follow, or None.
        held: Whether it changes at samples only.
        given: Whether it is a signal of time alone.
    """

    signal: str
    label: str
    reference: Expr | None = None
    held: bool = False
    given: bool = False


def panels(loop: Loop, recorded: Collection[str]) -> list[Panel]:
    """Return the panels of a run: outputs of plants, of controllers, then signals of time that are not references.

    Args:
        loop: The loop.
        recorded: Names of the signals that a run has.
    """
    followed = references(loop)
    rows = [Panel(n, _label(n, s), followed.get(n)) for n, s in _outputs(loop, recorded, plants=True)]
    rows += [Panel(n, _label(n, s), held=True) for n, s in _outputs(loop, recorded, plants=False)]
    used = {p.reference.name for p in rows if isinstance(p.reference, Name)}
    rows += [Panel(n, n, given=True) for n in inputs_of_time(loop) if n not in used]
    return rows


def _outputs(loop: Loop, recorded: Collection[str], *, plants: bool) -> Iterator[tuple[str, Signal]]:
    """Yield the outputs of plants or of controllers, with their names in a run."""
    blocks = loop.plants if plants else loop.controllers
    outputs = {(b.name, r.name) for b in blocks for r in b.results}
    kinds = {i.name: i.controller for i in loop.instances}
    for block, signal in block_signals(loop):
        if (kinds[block], signal.name) in outputs and f"{block}.{signal.name}" in recorded:
            yield f"{block}.{signal.name}", signal


def _label(name: str, signal: Signal) -> str:
    text, unit = signal.label or name, f" [{signal.unit}]" if signal.unit else ""
    return f"{text if len(text) <= LONGEST else f'{text[: LONGEST - 1]}…'}{unit}"
