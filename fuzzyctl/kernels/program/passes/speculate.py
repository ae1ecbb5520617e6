"""Pass that computes both sides of every choice beforehand, for compilers that vectorise."""

from __future__ import annotations

from dataclasses import replace as with_fields
from itertools import count

from fuzzyctl.expr import Expr, Name, Where, replace
from fuzzyctl.kernels.program.builder import is_atom
from fuzzyctl.kernels.program.program import Assign, Program, Statement


def speculated(program: Program) -> Program:
    """Return the same program with both sides of every choice computed beforehand.

    Compilers turn choices between values at hand into selections, and only loops without branches are vectorised. For
    targets where a quotient by zero is harmless.
    """
    body: list[Statement] = []
    fresh = count(1)

    def named(value: Expr) -> Expr:
        if is_atom(value):
            return value
        name = f"s{next(fresh)}"
        body.append(Assign(name, value))
        return Name(name)

    def change(node: Expr) -> Expr:
        return Where(node.condition, named(node.then), named(node.otherwise)) if isinstance(node, Where) else node

    for statement in program.body:
        body.append(
            Assign(statement.name, replace(statement.value, change)) if isinstance(statement, Assign) else statement
        )
    results = tuple(replace(r, change) for r in program.results)
    return with_fields(program, body=tuple(body), results=results)
