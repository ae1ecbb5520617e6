"""Embedding of a program in another one: its arguments become values of the outer program, its names stay its own."""

from __future__ import annotations

from collections.abc import Sequence

from fuzzyctl.expr import Expr
from fuzzyctl.kernels.program.builder import Builder
from fuzzyctl.kernels.program.program import STATE, Assign, Item, Program
from fuzzyctl.kernels.program.traversal import map_expressions, map_names


def embed(builder: Builder, program: Program, arguments: Sequence[Expr], *, state: int = 0) -> list[Expr]:
    """Write the statements of a program into another one and return its results as atoms.

    Args:
        builder: Writes the outer program.
        program: A program that reads entries of its state at fixed positions only.
        arguments: What its arguments are.
        state: Position of its first state in that of the outer program.
    """
    names: dict[str, str] = {STATE: STATE}
    tables = dict(program.tables)

    def renamed(name: str) -> str:
        if name not in names:
            names[name] = builder.table(tables[name]) if name in tables else builder.fresh()
        return names[name]

    def moved(node: Expr) -> Expr:
        match node:
            case Item(array=array, index=int(index)) if array == STATE:
                return Item(STATE, state + index)
        return node

    own = map_names(map_expressions(program, moved) if state else program, renamed)
    for name, value in zip(own.arguments, arguments, strict=True):
        builder.statements.append(Assign(name, value))
    builder.statements.extend(own.body)
    return [builder.let(r) for r in own.results]
