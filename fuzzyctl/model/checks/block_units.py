"""Checks of units in controllers, plants and loops: sums, comparisons and inputs of blocks need equal units."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.expr import Call, Keyword
from fuzzyctl.model.checks.units import Units
from fuzzyctl.model.controller import Definition, EquationBlock, Instance
from fuzzyctl.model.loop import Loop
from fuzzyctl.model.plant import Plant
from fuzzyctl.model.system import FuzzySystem


def unlike_units(block: EquationBlock) -> Iterator[Diagnostic]:
    """Find quantities of different units that a block compares, adds, connects, or gives to a name."""
    units = Units({p.name: p.unit for p in block.params}, {})
    for instance in block.instances:
        units.of |= {f"{instance.name}.{r.name}": r.unit for r in block.callee(instance).outputs}
    units.of |= {s.name: s.unit for s in (*block.inputs, *block.states, *block.outputs)}
    units.arguments = {s.name: [i.unit for i in s.inputs] for s in block.systems}
    _define(units, block.definitions, block.systems)
    for result in block.outputs:
        units.define(result.name, result.value)
    define_change = units.define_rate if isinstance(block, Plant) else units.define
    for change in block.changes:
        define_change(change.name, change.value)
    for state in block.states:
        units.define(state.name, state.start)
    for instance in block.instances:
        _connect(units, instance, block.callee(instance))
    for loop_measure in block.measures if isinstance(block, Loop) else ():
        units.of.setdefault(loop_measure.name, loop_measure.unit)
        units.define(loop_measure.name, loop_measure.value)
    yield from {(d.message, d.span): d for d in units.mistakes}.values()


def _define(units: Units, definitions: Sequence[Definition], systems: Sequence[FuzzySystem]) -> None:
    """Enter the units of definitions; those that come after their use are found in the second pass."""
    outputs = {s.name: {o.name: o.unit for o in s.outputs} for s in systems}
    for _ in range(2):
        for d in definitions:
            given = outputs.get(d.value.function) if isinstance(d.value, Call) else None
            units.of[d.name] = units.unit(d.value) if not given or len(given) > 1 else next(iter(given.values()))
            for output, unit in (given or {}).items():
                units.of[f"{d.name}.{output}"] = unit
    for d in definitions:
        units.unit(d.value)


def _connect(units: Units, instance: Instance, callee: EquationBlock) -> None:
    """Compare the units of arguments with those of the inputs that they are connected to."""
    given = [a for a in instance.arguments if not isinstance(a, Keyword)]
    inputs = {i.name: i.unit for i in callee.inputs}
    named = [(a.value, inputs[a.name]) for a in instance.arguments if isinstance(a, Keyword) and a.name in inputs]
    for argument, unit in (*zip(given, inputs.values(), strict=False), *named):
        units.take(callee.name, [argument], [unit])
