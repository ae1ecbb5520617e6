"""Program slice: the statements that some of the results depend on.

What one output does where another has no value is thereby none of the other's business, and is not computed for it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence

from fuzzyctl.expr import Expr, names_in
from fuzzyctl.kernels.program.program import Accumulate, Assign, Fold, Program, Quadrature, Statement


def needed(program: Program, wanted: Sequence[int]) -> Program:
    """Return a program with the statements that some results depend on; all results keep their indices."""
    names = _used(program.results[k] for k in wanted)
    kept: list[Statement] = []
    for statement in reversed(program.body):
        made, used = _flow(statement)
        if made & names:
            kept.append(statement)
            names |= used
    return dataclasses.replace(program, body=tuple(reversed(kept)))


def _flow(statement: Statement) -> tuple[set[str], set[str]]:
    """Return the names that a statement gives a value and those that it reads."""
    match statement:
        case Assign(name=name, value=value):
            return {name}, _used([value])
        case Accumulate(body=body, sums=sums):
            return {s.name for s in sums}, _used(a.value for a in (*body, *sums))
        case Fold(first=first, body=body, then=then):
            return {s.name for s in then}, _used(a.value for a in (*first, *body, *then))
        case Quadrature(found=found, area=area, given=given, marks=marks):
            return {found, area}, {*given} | _used(marks)
    return set(), set()


def _used(values: Iterable[Expr]) -> set[str]:
    return {n.name for value in values for n in names_in(value)}
