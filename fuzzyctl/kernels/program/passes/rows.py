"""Pass that unpacks rows of constant tables, cheaper in Python than single look-ups."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from fuzzyctl.expr import Expr, Name, walk
from fuzzyctl.expr import replace as rebuilt
from fuzzyctl.kernels.program.program import Assign, Item, Locate, Offset, Place, Program, Row, Statement

Tables = dict[str, Any]


def with_rows(program: Program) -> tuple[Program, Tables]:
    """Return a program that takes rows of tables where it looked up each of their numbers, and its tables.

    A table is one of rows where all positions in it are a multiple of its rows' length and some steps less than that.
    """
    tables: Tables = dict(program.tables)
    widths = _widths(program)
    if not widths:
        return program, tables
    body: list[Statement] = []
    taken: dict[tuple[str, str], tuple[str, ...]] = {}
    width = math.lcm(*(w for w, _ in widths.values()))
    if any(w != width for w, _ in widths.values()) or not _all_multiples(program, width):
        return program, tables
    for name, (_, place) in widths.items():
        flat = tables[name]
        tables[name] = tuple(flat[k : k + width] for k in range(0, len(flat), width))
        taken[name, place] = tuple(f"{name}_{k}" for k in range(width))

    def change(node: Expr) -> Expr:
        if isinstance(node, Item) and isinstance(node.index, Place) and (node.array, node.index.name) in taken:
            return Name(taken[node.array, node.index.name][node.index.steps])
        return node

    for statement in program.body:
        body.append(_shrunk(statement, width, change))
        given = _given(statement)
        body += [Row(names, table, place) for (table, place), names in taken.items() if place in given]
    results = tuple(rebuilt(r, change) for r in program.results)
    return replace(program, body=tuple(body), results=results), tables


def _given(statement: Statement) -> set[str]:
    return {statement.name} if isinstance(statement, Locate | Offset) else set()


def _shrunk(statement: Statement, width: int, change: Any) -> Statement:
    """Return a statement that counts in rows instead of numbers."""
    if isinstance(statement, Locate):
        return replace(statement, stride=statement.stride // width)
    if isinstance(statement, Assign):
        return Assign(statement.name, rebuilt(statement.value, change))
    return statement


def _items(program: Program) -> list[tuple[str, Place]]:
    values = [s.value for s in program.body if isinstance(s, Assign)] + list(program.results)
    found = [i for v in values for i in walk(v) if isinstance(i, Item)]
    return [(i.array, i.index) for i in found if isinstance(i.index, Place)]


def _widths(program: Program) -> dict[str, tuple[int, str]]:
    """Return for each table that is looked up by one place the length of its rows, and the place."""
    steps: dict[tuple[str, str], set[int]] = {}
    for array, place in _items(program):
        steps.setdefault((array, place.name), set()).add(place.steps)
    places: dict[str, list[str]] = {}
    for array, name in steps:
        places.setdefault(array, []).append(name)
    return {
        array: (len(steps[array, names[0]]), names[0])
        for array, names in places.items()
        if len(names) == 1 and steps[array, names[0]] == set(range(len(steps[array, names[0]])))
    }


def _all_multiples(program: Program, width: int) -> bool:
    """Return whether every position is a multiple of the rows' length, and nothing else is counted."""
    strides = [s.stride for s in program.body if isinstance(s, Locate)]
    offsets = [stride for s in program.body if isinstance(s, Offset) for _, stride in s.parts]
    return width > 1 and all(s % width == 0 for s in strides) and all(s == 1 for s in offsets)
