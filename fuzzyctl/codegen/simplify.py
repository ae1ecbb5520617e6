"""Simplification of programs for targets: repeated tests for NaN and dead code are removed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace as replace_fields
from typing import Final

from fuzzyctl.expr import Binary, Call, Compare, Expr, Logic, Name, Number, Where, walk
from fuzzyctl.kernels.program.program import (
    STATE,
    Item,
    Locate,
    Program,
    Refuse,
    Statement,
)
from fuzzyctl.kernels.program.traversal import expressions, map_expressions, map_names, read, reads, writes

FALSE: Final = Logic("or", ())
TRUE: Final = Logic("and", ())


def lean(program: Program) -> Program:
    """Return a program for inputs that are no NaN: every target tests that once, at the start."""
    folded = map_expressions(program, folding(lambda name: name in program.arguments))
    body = [s for s in folded.body if not (isinstance(s, Refuse) and s.condition == FALSE)]
    return _without_unread(folded, body)


def folding(has_value: Callable[[str], bool]) -> Callable[[Expr], Expr]:
    """Return the argument of `expr.replace` that drops tests for NaN of names that are never NaN."""

    def change(node: Expr) -> Expr:
        match node:
            case Compare(op="!=", left=Name(name=a), right=Name(name=b)) if a == b and has_value(a):
                return FALSE
            case Logic(op=op, operands=operands):
                return _logic(op, operands)
            case Where(condition=condition, then=then, otherwise=otherwise) if condition in (TRUE, FALSE):
                return then if condition == TRUE else otherwise
        return node

    return change


def _logic(op: str, operands: tuple[Expr, ...]) -> Expr:
    if op == "not":
        return FALSE if operands[0] == TRUE else TRUE if operands[0] == FALSE else Logic("not", operands)
    settled, neutral = (TRUE, FALSE) if op == "or" else (FALSE, TRUE)
    left = tuple(o for o in operands if o != neutral)
    if settled in left:
        return settled
    if len(left) == 1:
        return left[0]
    return Logic("or" if op == "or" else "and", left) if left else neutral


def _without_unread(program: Program, body: Sequence[Statement]) -> Program:
    """Return a program of some statements without those that no later one needs."""
    live = set().union(*map(read, program.results))
    statements: list[Statement] = []
    for statement in reversed(body):
        if isinstance(statement, Refuse) or writes(statement) & live:
            if isinstance(statement, Locate) and statement.rest not in live:
                statement = replace_fields(statement, wants_rest=False)
            live |= reads(statement)
            statements.append(statement)
    tables = tuple((name, values) for name, values in program.tables if name in live)
    return replace_fields(program, tables=tables, body=tuple(reversed(statements)))


def with_named_state(program: Program) -> Program:
    """Return a program that takes the entries of its state as arguments `s0`, `s1`, ..., behind the others."""
    return with_state(program, {k: Name(f"s{k}") for k in range(program.state)})


def with_state(program: Program, names: Mapping[int, Name]) -> Program:
    """Return a program that takes entries of its state as arguments of some names, behind the others."""

    def change(node: Expr) -> Expr:
        if isinstance(node, Item) and node.array == STATE:
            assert isinstance(node.index, int), "states are read one by one"
            return names[node.index]
        return node

    changed = map_expressions(program, change) if names else program
    return replace_fields(changed, arguments=(*program.arguments, *(n.name for n in names.values())), state=0)


def renamed(program: Program, arguments: Sequence[str]) -> Program:
    """Return a program whose arguments have other names, none of them a name of the program."""
    names = dict(zip(program.arguments, arguments, strict=True))
    return map_names(program, lambda name: names.get(name, name))


def with_prefix(program: Program, prefix: str) -> Program:
    """Return a program whose values and tables have a prefix, so that it can follow another one."""
    names = {*program.arguments, STATE}
    return map_names(program, lambda name: name if name in names else prefix + name)


def quotient(node: Expr) -> Expr:
    """Take quotients of the user's own, such as those of rates, for functions that may have no value."""
    match node:
        case Binary(op="/", left=left, right=right) if not (isinstance(right, Number) and right.value != 0.0):
            return Call("divide", (left, right))
    return node


def functions(program: Program) -> set[str]:
    """Return the functions that a program calls, `power` for `^`."""
    nodes = (node for expr in expressions(program) for node in walk(expr))
    results = {getattr(node, "function", "power" if getattr(node, "op", "") == "^" else "") for node in nodes}
    return results - {""}
