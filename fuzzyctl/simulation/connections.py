"""Roles of the signals of a loop: which outputs follow which references, and what depends on the time alone."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyctl.expr import Call, Expr, Keyword, Name, names_in, walk
from fuzzyctl.model.forms import bound
from fuzzyctl.model.loop import MEASURES, Loop

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
    found: dict[str, Expr] = {}
    for measure in loop.measures:
        for call in walk(measure.value):
            if isinstance(call, Call) and call.function in MEASURES and _REFERENCE in MEASURES[call.function].signals:
                given = bound(MEASURES[call.function], call)
                y = given[MEASURES[call.function].signals[0]]
                if isinstance(y, Name):
                    found.setdefault(y.name, given[_REFERENCE])
    return found or _only(loop)


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
    """Yield what the inputs of controllers are connected to."""
    inputs = {c.name: [s.name for s in c.inputs] for c in loop.controllers}
    for instance in loop.instances:
        for argument in instance.arguments if instance.controller in inputs else ():
            if not isinstance(argument, Keyword):
                yield argument
            elif argument.name in inputs[instance.controller]:
                yield argument.value
