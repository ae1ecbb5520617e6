"""Pass that orders statements for short live ranges: each value right before its first use."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from fuzzyctl.expr import Binary, Expr, Name, names_in
from fuzzyctl.kernels.program.program import Assign, Program


def late(program: Program) -> Program:
    """Return a program of assignments that computes the same, each value as late as can be.

    A program with other statements, whose order may matter, stays as it is.
    """
    if not all(isinstance(s, Assign) for s in program.body):
        return program
    given = {s.name: s for whole in program.body if isinstance(whole, Assign) for s in _one_by_one(whole)}
    needs = {name: [n.name for n in names_in(s.value) if n.name in given] for name, s in given.items()}
    body: list[Assign] = []
    written: set[str] = set()
    wanted = [n.name for r in reversed(program.results) for n in reversed(names_in(r)) if n.name in given]
    while wanted:  # no recursion, since chains may be long
        name = wanted[-1]
        missing = [n for n in reversed(needs[name]) if n not in written] if name not in written else []
        wanted += missing
        if not missing:
            wanted.pop()
            if name not in written:
                written.add(name)
                body.append(given[name])
    return replace(program, body=tuple(body))


def _one_by_one(whole: Assign) -> Iterator[Assign]:
    """Yield the additions of a sum as statements of their own, in order; so no summand waits for the rest."""
    summands: list[Expr] = []
    value = whole.value
    while isinstance(value, Binary) and value.op == "+":
        summands.append(value.right)
        value = value.left
    for k, summand in enumerate(summands[:0:-1]):
        part = Name(f"{whole.name}_{k}")
        yield Assign(part.name, value + summand)
        value = part
    yield replace(whole, value=value + summands[0] if summands else value)
