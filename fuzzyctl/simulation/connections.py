"""Roles of the signals of a loop: which outputs follow which references, and what depends on the time alone."""

from __future__ import annotations

from fuzzyctl.expr import Call, Name, names_in, walk
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.measures import MEASURES

#: How the signal that another one should follow is called among the arguments of measures.
_REFERENCE = "reference"


def inputs_of_time(loop: Loop) -> list[str]:
    """Return the lets that depend on no block: references and disturbances, but not noise."""
    reads = {d.name: {n.name for n in names_in(d.value)} for d in loop.definitions}
    drawn = {d.name for d in loop.definitions for c in walk(d.value) if isinstance(c, Call) and c.function == "noise"}
    blocks = {i.name for i in loop.instances}
    free = {n for n in reads if n not in drawn}
    while left := {
        n for n in free if any(r.partition(".")[0] in blocks or (r in reads and r not in free) for r in reads[n])
    }:
        free -= left
    return [n for n in reads if n in free]


def references(loop: Loop) -> dict[str, str]:
    """Return the reference of each signal that follows one, by name.

    Measures say so, such as `overshoot(tank.y, reference)`. Where none does, a loop with one plant of one output and
    one let that depends on the time alone and goes into a controller follows that let.
    """
    found: dict[str, str] = {}
    for measure in loop.measures:
        for call in walk(measure.value):
            if isinstance(call, Call) and call.function in MEASURES and _REFERENCE in MEASURES[call.function].signals:
                pair = call.arguments[:2]
                if len(pair) == 2 and all(isinstance(a, Name) for a in pair):
                    y, reference = (a.name for a in pair if isinstance(a, Name))
                    found.setdefault(y, reference)
    return found or _only(loop)


def _only(loop: Loop) -> dict[str, str]:
    plants = {p.name: p for p in loop.plants}
    outputs = [
        f"{i.name}.{r.name}" for i in loop.instances if i.controller in plants for r in plants[i.controller].results
    ]
    given = {n.name for i in loop.instances if i.controller not in plants for a in i.arguments for n in names_in(a)}
    followed = [n for n in inputs_of_time(loop) if n in given]
    return {outputs[0]: followed[0]} if len(outputs) == len(followed) == 1 else {}
