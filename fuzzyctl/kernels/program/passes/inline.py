"""Pass that inlines expressions used once, since interpreted code pays for each name."""

from __future__ import annotations

from dataclasses import replace

from fuzzyctl.expr import Binary, Expr, Name, Where, children
from fuzzyctl.kernels.program.builder import DEEPEST
from fuzzyctl.kernels.program.program import Assign, Locate, Offset, Program, Refuse, Statement
from fuzzyctl.kernels.program.traversal import uses

#: Statements that run at most once; in loops a number may have another value where it is needed.
ONCE = (Assign, Locate, Offset, Refuse)


def inlined(program: Program) -> Program:
    """Return a program that computes the same, in the same steps, with fewer names."""
    if not all(isinstance(s, ONCE) for s in program.body):
        return program
    used = uses(program)
    waiting: dict[str, tuple[Expr, int]] = {}
    body: list[Statement] = []
    for statement in program.body:
        if isinstance(statement, Assign):
            value, depth = _filled(statement.value, waiting)
            if used[statement.name] == 1:
                waiting[statement.name] = value, depth
            statement = Assign(statement.name, value)
        body.append(statement)
    results = tuple(_filled(r, waiting)[0] for r in program.results)
    # What has been written elsewhere was taken off the list.
    gone = {n for n in used if used[n] == 1} - waiting.keys()
    kept = tuple(s for s in body if not (isinstance(s, Assign) and s.name in gone))
    return replace(program, body=kept, results=results)


def _filled(value: Expr, waiting: dict[str, tuple[Expr, int]]) -> tuple[Expr, int]:
    """Return a value with those that wait written into it, and how deep it is nested then.

    Only operands of arithmetic and the two values of a choice are written once in the text.
    """
    match value:
        case Name(name=name):
            if name in waiting and waiting[name][1] < DEEPEST:
                return waiting.pop(name)
            return value, 0
        case Binary(op="+" | "-" | "*" | "/" as op, left=left, right=right):
            (a, m), (b, n) = _filled(left, waiting), _filled(right, waiting)
            return (value if a is left and b is right else Binary(op, a, b)), max(m, n) + 1
        case Where(condition=condition, then=then, otherwise=otherwise):
            (a, m), (b, n) = _filled(then, waiting), _filled(otherwise, waiting)
            return Where(condition, a, b), max(m, n, _depth(condition)) + 1
    return value, _depth(value)


def _depth(value: Expr) -> int:
    return 1 + max((_depth(part) for part in children(value)), default=-1)
