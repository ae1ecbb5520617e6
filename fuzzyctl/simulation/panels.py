"""What pictures of a run show: references and outputs, controls and disturbances, one below the other."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Final

from fuzzyctl.expr import Expr, Name
from fuzzyctl.model.controller import Signal
from fuzzyctl.model.loop import Loop
from fuzzyctl.simulation.connections import inputs_of_time, references
from fuzzyctl.simulation.equations import block_signals

#: Most letters of a label without its unit.
LONGEST: Final = 20


@dataclass(frozen=True)
class Panel:
    """One quantity over time.

    Args:
        signal: Its name in the runs.
        label: Label of the axis.
        reference: What it should follow, a signal or a constant; None for nothing.
        held: Whether it changes at samples only.
        given: Whether it is a signal of time alone.
    """

    signal: str
    label: str
    reference: Expr | None = None
    held: bool = False
    given: bool = False


def panels(loop: Loop, recorded: Collection[str]) -> list[Panel]:
    """Return what runs show: outputs of plants, of controllers, then signals of time that are no reference.

    Args:
        loop: What is run.
        recorded: Names of the signals that a run has.
    """
    followed = references(loop)
    found = [Panel(n, _label(n, s), followed.get(n)) for n, s in _outputs(loop, recorded, plants=True)]
    found += [Panel(n, _label(n, s), held=True) for n, s in _outputs(loop, recorded, plants=False)]
    used = {p.reference.name for p in found if isinstance(p.reference, Name)}
    found += [Panel(n, n, given=True) for n in inputs_of_time(loop) if n not in used]
    return found


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
