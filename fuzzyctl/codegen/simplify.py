"""Simplification of programs for targets: repeated tests for NaN and dead code are removed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace as replace_fields
from typing import Final

from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.expr import Compare, Expr, Logic, Name, Where, replace, walk
from fuzzyctl.kernels.program.program import (
    STATE,
    Accumulate,
    Assign,
    Fold,
    Item,
    Locate,
    Offset,
    Place,
    Program,
    Quadrature,
    Refuse,
    Statement,
)

FALSE: Final = Logic("or", ())
TRUE: Final = Logic("and", ())


def lean(program: Program) -> Program:
    """Return a program for inputs that are no NaN: every target tests that once, at the start.

    Raises:
        CodegenError: For a statement that no target can print.
    """

    change = folding(lambda name: name in program.arguments)
    body = [_mapped(s, change) for s in program.body]
    results = tuple(replace(r, change) for r in program.results)
    return _without_unread(program, [s for s in body if not (isinstance(s, Refuse) and s.condition == FALSE)], results)


def folding(has_value: Callable[[str], bool]) -> Callable[[Expr], Expr]:
    """Return what `expr.replace` takes to drop tests for NaN of the names that are none, and what follows from them."""

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


def _mapped(statement: Statement, change: Callable[[Expr], Expr]) -> Statement:
    match statement:
        case Assign(name=name, value=value):
            return Assign(name, replace(value, change))
        case Accumulate(count=count, counter=counter, body=body, sums=sums):
            return Accumulate(
                count,
                counter,
                tuple(Assign(s.name, replace(s.value, change)) for s in body),
                tuple(Assign(s.name, replace(s.value, change)) for s in sums),
            )
        case Fold(count=count, counter=counter):
            parts = (statement.first, statement.body, statement.then)
            return Fold(count, counter, *(tuple(Assign(s.name, replace(s.value, change)) for s in p) for p in parts))
        case Refuse(condition=condition, output=output):
            return Refuse(replace(condition, change), output)
        case Locate() | Offset():
            return statement
        case Quadrature(kind=kind):
            exact = "bisector" if kind == "half" else "centroid"
            raise CodegenError(
                f"the exact {exact} of these sets is an adaptive integral, which generated code has not; sample it, "
                f"such as 'defuzzifier {exact}(resolution=1000)'"
            )
    raise CodegenError(f"a statement {type(statement).__name__} cannot be printed")


def mapped(program: Program, change: Callable[[Expr], Expr]) -> Program:
    """Return a program with every expression passed through `expr.replace`."""
    results = tuple(replace(r, change) for r in program.results)
    body = tuple(_mapped(s, change) for s in program.body)
    return Program(program.arguments, program.state, program.tables, body, results)


def _without_unread(program: Program, body: list[Statement], results: tuple[Expr, ...]) -> Program:
    live = set().union(*(read(r) for r in results))
    kept: list[Statement] = []
    for statement in reversed(body):
        writes = written(statement)
        if isinstance(statement, Refuse) or writes & live:
            if isinstance(statement, Locate) and statement.rest not in live:
                statement = replace_fields(statement, wants_rest=False)
            live |= reads(statement)
            kept.append(statement)
    tables = tuple((name, values) for name, values in program.tables if name in live)
    return Program(program.arguments, program.state, tables, tuple(reversed(kept)), results)


def renamed(program: Program, arguments: Sequence[str]) -> Program:
    """Return a program whose arguments have other names, none of them one of its own."""
    names: dict[str, Expr] = {old: Name(new) for old, new in zip(program.arguments, arguments, strict=True)}

    def change(node: Expr) -> Expr:
        return names.get(node.name, node) if isinstance(node, Name) else node

    body = tuple(
        replace_fields(s, x=replace(s.x, change)) if isinstance(s, Locate) else _mapped(s, change) for s in program.body
    )
    results = tuple(replace(r, change) for r in program.results)
    return Program(tuple(arguments), program.state, program.tables, body, results)


def with_prefix(program: Program, prefix: str) -> Program:
    """Return a program whose own values and tables have a prefix, so that it stands beside another one."""
    kept = {*program.arguments, STATE}

    def own(name: str) -> str:
        return name if name in kept else prefix + name

    def change(node: Expr) -> Expr:
        match node:
            case Name(name=name):
                return Name(own(name))
            case Item(array=array, index=Place(name=name, steps=steps)):
                return Item(own(array), Place(own(name), steps))
            case Item(array=array, index=index):
                return Item(own(array), own(index) if isinstance(index, str) else index)
        return node

    def moved(statement: Statement) -> Statement:
        match _mapped(statement, change):
            case Assign(name=name, value=value):
                return Assign(own(name), value)
            case Locate(name=name, rest=rest, x=x, table=table) as found:
                return replace_fields(found, name=own(name), rest=own(rest), x=replace(x, change), table=own(table))
            case Offset(name=name, parts=parts):
                return Offset(own(name), tuple((own(n), s) for n, s in parts))
            case Accumulate(count=count, counter=counter, body=body, sums=sums):
                inner, totals = (tuple(Assign(own(s.name), s.value) for s in part) for part in (body, sums))
                return Accumulate(count, own(counter), inner, totals)
            case Fold(count=count, counter=counter, first=first, body=body, then=then):
                folded = [tuple(Assign(own(s.name), s.value) for s in part) for part in (first, body, then)]
                return Fold(count, own(counter), *folded)
            case other:
                return other

    tables = tuple((own(name), values) for name, values in program.tables)
    results = tuple(replace(r, change) for r in program.results)
    return Program(program.arguments, program.state, tables, tuple(map(moved, program.body)), results)


def written(statement: Statement) -> set[str]:
    """Return the names that a statement gives."""
    match statement:
        case Assign(name=name) | Offset(name=name):
            return {name}
        case Locate(name=name, rest=rest):
            return {name, rest}
        case Accumulate(sums=sums):
            return {s.name for s in sums}
        case Fold(then=then):
            return {s.name for s in then}
    return set()


def reads(statement: Statement) -> set[str]:
    """Return the names and arrays that a statement reads."""
    match statement:
        case Assign(value=value):
            return read(value)
        case Locate(x=x, table=table):
            return read(x) | {table}
        case Offset(parts=parts):
            return {name for name, _ in parts}
        case Accumulate(body=body, sums=sums):
            return set().union(*(read(s.value) for s in (*body, *sums)))
        case Fold(first=first, body=body, then=then):
            return set().union(*(read(s.value) for s in (*first, *body, *then)))
        case Refuse(condition=condition):
            return read(condition)
    raise CodegenError(f"a statement {type(statement).__name__} cannot be printed")


def read(expr: Expr) -> set[str]:
    """Return the names and arrays that an expression reads."""
    found: set[str] = set()
    for node in walk(expr):
        match node:
            case Name(name=name):
                found.add(name)
            case Item(array=array, index=index):
                found.add(array)
                if not isinstance(index, int):
                    found.add(index.name if isinstance(index, Place) else index)
    return found


def functions(program: Program) -> set[str]:
    """Return the functions that a program calls, `power` for `^`."""
    found: set[str] = set()
    for expr in expressions(program):
        for node in walk(expr):
            name = getattr(node, "function", "power" if getattr(node, "op", "") == "^" else "")
            found.add(name)
    return found - {""}


def expressions(program: Program) -> list[Expr]:
    """Return all expressions of a program."""
    found: list[Expr] = list(program.results)
    for statement in program.body:
        match statement:
            case Assign(value=value):
                found.append(value)
            case Locate(x=x):
                found.append(x)
            case Accumulate(body=body, sums=sums):
                found += [s.value for s in (*body, *sums)]
            case Fold(first=first, body=body, then=then):
                found += [s.value for s in (*first, *body, *then)]
            case Refuse(condition=condition):
                found.append(condition)
    return found
