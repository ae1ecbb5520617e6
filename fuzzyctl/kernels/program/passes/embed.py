"""Embedding of a program in another one: its arguments become values of the outer program, its names stay its own."""

from __future__ import annotations

from collections.abc import Sequence

from fuzzyctl.expr import Expr
from fuzzyctl.kernels.program.builder import Builder
from fuzzyctl.kernels.program.program import Assign, Program
from fuzzyctl.kernels.program.traversal import map_names


def embed(builder: Builder, program: Program, arguments: Sequence[Expr]) -> list[Expr]:
    """Write the statements of a program into another one and return its results as atoms.

    Args:
        builder: Writes the outer program.
        program: A program without state.
        arguments: What its arguments are.
    """
    names: dict[str, str] = {}
    tables = dict(program.tables)

    def renamed(name: str) -> str:
        if name not in names:
            names[name] = builder.table(tables[name]) if name in tables else builder.fresh()
        return names[name]

    own = map_names(program, renamed)
    for name, value in zip(own.arguments, arguments, strict=True):
        builder.statements.append(Assign(name, value))
    builder.statements.extend(own.body)
    return [builder.let(r) for r in own.results]
