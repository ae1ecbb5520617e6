"""Traversal of programs: names that statements write and read, their parts, and how they are rebuilt.

`parts` and `rebuilt` know all kinds of statements; the type checker reports a kind that they miss. What passes,
backends and code generators ask of a program follows from these two.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple, assert_never

from fuzzyctl.expr import Expr, Name, names_in, walk
from fuzzyctl.expr import replace as replace_in
from fuzzyctl.kernels.program.builder import Builder
from fuzzyctl.kernels.program.program import (
    STATE,
    Accumulate,
    Assign,
    Between,
    Crossings,
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


class Parts(NamedTuple):
    """Parts of a statement.

    Args:
        writes: Names that have a value after it.
        values: Its expressions.
        inner: Statements inside it, in the order in which they run; their expressions are not among `values`.
        reads: Names, tables and arrays that it reads besides.
        counters: Names that it gives a value for the statements inside it only.
    """

    writes: tuple[str, ...]
    values: tuple[Expr, ...] = ()
    inner: tuple[Statement, ...] = ()
    reads: tuple[str, ...] = ()
    counters: tuple[str, ...] = ()


def parts(statement: Statement) -> Parts:
    """Return the parts of a statement."""
    match statement:
        case Assign(name=name, value=value):
            return Parts((name,), (value,))
        case Locate(name=name, rest=rest, x=x, table=table):
            return Parts((name, rest), (x,), reads=(table,))
        case Offset(name=name, parts=own):
            return Parts((name,), reads=tuple(n for n, _ in own))
        case Accumulate(counter=counter, body=body, sums=sums):
            return Parts(_named(sums), (), (*body, *sums), counters=(counter,))
        case Fold(counter=counter, first=first, body=body, then=then):
            return Parts(_named(then), (), (*first, *body, *then), counters=(counter,))
        case Between(name=name, side=side, share=share, body=body, value=value):
            return Parts((name,), (share, value), body, counters=(side,))
        case Quadrature(found=found, area=area, x=x, body=body, value=value, given=given, places=places, marks=marks):
            crossings = statement.crossings or Crossings((), ())
            values, inner = (value, *marks, *crossings.values), (*body, *crossings.body)
            return Parts((found, area), values, inner, (*given, places), (x,))
        case Refuse(condition=condition):
            return Parts((), (condition,))
    assert_never(statement)


def rebuilt(statement: Statement, value: Callable[[Expr], Expr], name: Callable[[str], str] = str) -> Statement:
    """Return a statement with its expressions, and those of statements inside it, changed.

    Args:
        statement: The statement.
        value: Returns the substitute of an expression.
        name: Returns the substitute of a name or table that is not in an expression.
    """

    def all_of(body: tuple[Statement, ...]) -> tuple[Statement, ...]:
        return tuple(rebuilt(s, value, name) for s in body)

    def assigned(body: tuple[Assign, ...]) -> tuple[Assign, ...]:
        return tuple(Assign(name(s.name), value(s.value)) for s in body)

    match statement:
        case Assign():
            return Assign(name(statement.name), value(statement.value))
        case Locate(name=own, rest=rest, x=x, table=table):
            return replace(statement, name=name(own), rest=name(rest), x=value(x), table=name(table))
        case Offset(name=own, parts=summed):
            return Offset(name(own), tuple((name(n), stride) for n, stride in summed))
        case Accumulate(count=count, counter=own, body=body, sums=sums):
            return Accumulate(count, name(own), assigned(body), assigned(sums))
        case Fold(count=count, counter=own, first=first, body=body, then=then):
            return Fold(count, name(own), assigned(first), assigned(body), assigned(then))
        case Between(name=own, side=side, share=share, body=body, value=end):
            return Between(name(own), name(side), value(share), all_of(body), value(end))
        case Quadrature(body=body, value=end, given=given, marks=marks, crossings=crossings):
            return Quadrature(
                name(statement.found),
                name(statement.area),
                statement.kind,
                name(statement.x),
                all_of(body),
                value(end),
                tuple(map(name, given)),
                name(statement.places),
                tuple(map(value, marks)),
                crossings and Crossings(all_of(crossings.body), tuple(map(value, crossings.values))),
            )
        case Refuse(condition=condition):
            return replace(statement, condition=value(condition))
    assert_never(statement)


def statements(body: Iterable[Statement]) -> Iterator[Statement]:
    """Yield statements and those inside them, each before those inside it."""
    for statement in body:
        yield statement
        yield from statements(parts(statement).inner)


def expressions(program: Program) -> Iterator[Expr]:
    """Yield all expressions of a program."""
    for statement in statements(program.body):
        yield from parts(statement).values
    yield from program.results


def uses(program: Program) -> Counter[str]:
    """Count how often expressions name each value."""
    return Counter(n.name for e in expressions(program) for n in names_in(e))


def writes(statement: Statement) -> set[str]:
    """Return the names that have a value after a statement."""
    return set(parts(statement).writes)


def needed(body: Iterable[Statement], values: Iterable[Expr]) -> tuple[Statement, ...]:
    """Return the statements that some values depend on."""
    wanted, needed_statements = set[str]().union(*map(read, values)), list[Statement]()
    for statement in reversed(tuple(body)):
        if writes(statement) & wanted:
            wanted |= reads(statement)
            needed_statements.append(statement)
    return tuple(reversed(needed_statements))


def locals_of(statement: Statement) -> set[str]:
    """Return the names that have a value inside a statement only, those of its counters among them."""
    here = parts(statement)
    return set(here.counters).union(*(writes(s) | locals_of(s) for s in here.inner)) - set(here.writes)


def reads(statement: Statement) -> set[str]:
    """Return the names, tables and arrays from outside that a statement reads."""
    here = parts(statement)
    names = set(here.reads).union(*map(read, here.values), *map(reads, here.inner))
    return names - locals_of(statement) - (set(here.writes) if here.inner else set())


def read(expr: Expr) -> set[str]:
    """Return the names, tables and arrays that an expression reads."""
    names: set[str] = set()
    for node in walk(expr):
        match node:
            case Name(name=name):
                names.add(name)
            case Item(array=array, index=Place(name=name)):
                names |= {array, name}
            case Item(array=array, index=index):
                names |= {array, index} if isinstance(index, str) else {array}
    return names


def map_expressions(program: Program, change: Callable[[Expr], Expr]) -> Program:
    """Return a program with all its expressions rebuilt, each part passed through `change`; see `expr.replace`."""

    def changed(expr: Expr) -> Expr:
        return replace_in(expr, change)

    body = tuple(rebuilt(s, changed) for s in program.body)
    return replace(program, body=body, results=tuple(map(changed, program.results)))


def map_names(program: Program, name: Callable[[str], str]) -> Program:
    """Return a program in which names, tables and arrays are called otherwise, its arguments included."""

    def changed(expr: Expr) -> Expr:
        return renamed(expr, name)

    return replace(
        program,
        arguments=tuple(map(name, program.arguments)),
        tables=tuple((name(table), values) for table, values in program.tables),
        body=tuple(rebuilt(s, changed, name) for s in program.body),
        results=tuple(map(changed, program.results)),
    )


def renamed(expr: Expr, name: Callable[[str], str]) -> Expr:
    """Return an expression in which names, tables and arrays are called otherwise."""

    def change(node: Expr) -> Expr:
        match node:
            case Name(name=own):
                return Name(name(own))
            case Item(array=array, index=Place(name=own, steps=steps)):
                return Item(name(array), Place(name(own), steps))
            case Item(array=array, index=index):
                return Item(name(array), name(index) if isinstance(index, str) else index)
        return node

    return replace_in(expr, change)


def _named(body: tuple[Assign, ...]) -> tuple[str, ...]:
    return tuple(s.name for s in body)


def embed(builder: Builder, program: Program, arguments: Sequence[Expr], *, state: int = 0) -> list[Expr]:
    """Write the statements of a program into another one and return its results as atoms.

    Args:
        builder: Writes the outer program.
        program: A program that reads entries of its state at fixed positions only.
        arguments: Values of its arguments.
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

    inner = map_names(map_expressions(program, moved) if state else program, renamed)
    for name, value in zip(inner.arguments, arguments, strict=True):
        builder.statements.append(Assign(name, value))
    builder.statements.extend(inner.body)
    return [builder.let(r) for r in inner.results]
