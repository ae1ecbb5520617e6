"""Comments in generated text: arguments, tables, and the rule that a value belongs to."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from fuzzyctl.codegen.unit import Unit
from fuzzyctl.expr import Expr, Name, walk
from fuzzyctl.formats.fz import rule_text
from fuzzyctl.kernels.algorithms.interpolation import coefficients
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.program.program import Assign, Item, Locate, Place, Program, Quadrature
from fuzzyctl.kernels.program.traversal import expressions, read, reads
from fuzzyctl.model.variable import LinguisticVariable


def argument_notes(unit: Unit) -> list[str]:
    """Return for each input what it is: its label, range and unit."""
    return [
        _note(variable, planned.lower, planned.upper) + (", extrapolated" if planned.extrapolate else "")
        for variable, planned in zip(unit.system.inputs, unit.plan.inputs, strict=True)
    ]


def result_notes(unit: Unit) -> list[str]:
    """Return the same for each output."""
    outputs = zip(unit.system.outputs, unit.plan.outputs, strict=True)
    return [_note(declared, planned.lower, planned.upper) for declared, planned in outputs]


def _note(variable: LinguisticVariable, lower: float, upper: float) -> str:
    label = variable.label or (variable.name if not variable.name.isascii() else "")
    ends = f"[{lower!r}, {upper!r}]{f' {variable.unit}' if variable.unit else ''}"
    return f"{label}, {ends}" if label else ends


def value_notes(unit: Unit) -> dict[str, list[str]]:
    """Return what values of the evaluation of all rules are, by name: degrees of terms, and activations of rules.

    The program of the activity has the same values under the same names, and says which is which.
    """
    if unit.algorithm.name != "rules":
        return {}
    traced, flat = inference.activity(unit.plan), unit.plan
    own = {s.name: s for s in unit.algorithm.printed.body if isinstance(s, Assign)}
    same = {s.name for s in traced.body if isinstance(s, Assign) and own.get(s.name) == s}
    texts = [f"degree of {flat.variable(d.variable).name} is {d.term}" for d in flat.degrees]
    texts += [rule_text(rule) for rule in unit.system.rules]
    found: dict[str, list[str]] = {}
    for result, text in zip(traced.results, texts, strict=False):  # effects follow
        if isinstance(result, Name) and result.name in same:
            found.setdefault(result.name, []).append(text)
    return found


def table_notes(unit: Unit, program: Program) -> dict[str, list[str]]:
    """Return what each table of a program holds, by its name.

    Tables are known by their numbers, since one table stands for all that hold the same.
    """
    arguments = dict(zip(program.arguments, (i.name for i in unit.plan.inputs), strict=True))
    found: dict[str, list[str]] = {name: [] for name, _ in program.tables}
    for statement in program.body:
        if isinstance(statement, Locate):
            own = sorted(arguments[a] for a in _arguments(program, statement.x) if a in arguments)
            what = "points of the table along" if unit.table is not None else "corners of the terms of"
            what = what if len(own) == 1 else "corners of terms of a value that is computed from"
            found[statement.table].append(f"{what} {' and '.join(own)}")
        if isinstance(statement, Quadrature):
            found[statement.places].append("places between which a set is smooth, from the middle of the range")
    known: dict[tuple[float, ...], list[str]] = {}
    for values, text in _known(unit):
        known.setdefault(values, []).append(text)
    looked_up = _looked_up(program)
    for name, values in program.tables:
        found[name] += known.get(tuple(values), [])
        usual = "for each piece between corners" if name in looked_up else "for each point at which a set is sampled"
        found[name] = list(dict.fromkeys(found[name])) or [usual]
    return found


def _looked_up(program: Program) -> set[str]:
    """Return the tables that a program reads at a computed position, not entry by entry in a loop."""
    items = [e for x in expressions(program) for e in walk(x) if isinstance(e, Item)]
    return {e.array for e in items if isinstance(e.index, Place)}


def _known(unit: Unit) -> Iterator[tuple[tuple[float, ...], str]]:
    """Yield the tables that an algorithm may have, with what they hold."""
    grid, active = unit.algorithm.grid, unit.algorithm.active
    if grid is not None:
        names = [unit.plan.inputs[i].name for i in grid.inputs]
        where = " x ".join(names)
        for name, knots in zip(names, grid.knots, strict=True):
            yield tuple(1.0 / (b - a) for a, b in pairwise(knots)), f"1 / width of each cell of {name}"
        for output, table in zip(unit.plan.outputs, grid.outputs, strict=True):
            what = f"{output.name}" if not table.weight else f"the sum of activation * consequent of {output.name}"
            for values, whose in ((table.value, what), (table.weight, f"the sum of activations of {output.name}")):
                if values:
                    yield tuple(coefficients(grid, values)), f"coefficients of {whose} in each cell of {where}"
                    yield tuple(values), f"{whose} at each corner of the cells of {where}"
    if active is not None:
        names = [unit.plan.inputs[a.position].name for a in active.axes]
        where = " x ".join(names)
        for name, axis in zip(names, active.axes, strict=True):
            for side, which in zip(axis.sides, ("first", "second"), strict=True):
                for values, what in ((side.foot, "foot"), (side.slope, "slope"), (side.base, "degree at the foot")):
                    yield values, f"{what} of the {which} term in each cell of {name}"
        for output, sums in zip(unit.plan.outputs, active.outputs, strict=True):
            kinds = [(sums.weights, "weight"), (sums.constants, "weight * constant")]
            kinds += [(values, f"weight * factor of {name}") for name, values in sums.factors.items()]
            for tables, what in kinds:
                for k, values in enumerate(tables):
                    yield values, f"{what} of the rule of pair {k} of terms in each cell of {where}, for {output.name}"


def _arguments(program: Program, x: Expr) -> set[str]:
    """Return the names that a value is computed from, arguments among them."""
    found = read(x)
    for statement in reversed(program.body):
        if isinstance(statement, Assign) and statement.name in found:
            found |= reads(statement)
    return found
