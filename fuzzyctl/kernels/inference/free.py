"""Programs over free numbers: what is computed from them comes first, then what the plan computes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import cast

from fuzzyctl.expr import ONE, ZERO, Expr, Name, Number, Where, names_in, replace_names
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.free import FreePlan
from fuzzyctl.kernels.plan.plan import Plan
from fuzzyctl.kernels.plan.traced import NeedsNumberError, Trace, Traced, atom, is_free
from fuzzyctl.kernels.program.builder import Builder
from fuzzyctl.kernels.program.program import STATE, Item, Program, Quadrature, Statement
from fuzzyctl.kernels.program.traversal import embed, map_expressions, reads, uses


def free_program(free: FreePlan, write: Callable[[Plan], Program] = inference.evaluation) -> Program:
    """Write a program whose arguments are the inputs, then the free numbers.

    Args:
        free: What to compute.
        write: Writes the program of a plan.

    Raises:
        ArgumentError: For a number that must be known before the program is written.
    """
    try:
        own = _with_given(map_expressions(write(free.plan), _named), free.trace)
        _require_plain_tables(own)
    except NeedsNumberError as needs:
        raise free.trace.refusal(needs) from None
    builder = Builder()
    used = [n for n in uses(own) if n in free.trace.definitions or Name(n) in free.trace.arguments]
    known = _defined(builder, free, used)
    inputs = [Name(x) for x in own.arguments]
    body = embed(builder, replace(own, arguments=(*own.arguments, *used)), [*inputs, *(known[n] for n in used)])
    return builder.program([*inputs, *free.trace.arguments], body)


def condition_program(free: FreePlan) -> Program:
    """Write the program of the free numbers whose results are 1 for each condition that holds, else 0."""
    conditions = list(free.trace.conditions)
    builder = Builder()
    known = _defined(builder, free, [n.name for c in conditions for n in names_in(c)])
    results: list[Expr] = [Where(replace_names(c, known), ONE, ZERO) for c in conditions]
    return builder.program(free.trace.arguments, results)


def with_values_as_array(program: Program, values: Sequence[str]) -> Program:
    """Return a program that takes some of its arguments as an array, its state."""
    items: dict[str, Expr] = {name: Item(STATE, k) for k, name in enumerate(values)}

    def change(node: Expr) -> Expr:
        return items.get(node.name, node) if isinstance(node, Name) else node

    arguments = tuple(a for a in program.arguments if a not in items)
    return replace(map_expressions(program, change), arguments=arguments, state=len(values))


def with_named_state(program: Program) -> tuple[Program, tuple[str, ...]]:
    """Return a program that takes its state as its last arguments, and their names; see `with_values_as_array`."""
    names = tuple(f"s{k}" for k in range(program.state))

    def change(node: Expr) -> Expr:
        if isinstance(node, Item) and node.array == STATE:
            assert isinstance(node.index, int), "states are read one by one"
            return Name(names[node.index])
        return node

    return replace(map_expressions(program, change), arguments=(*program.arguments, *names), state=0), names


def _named(node: Expr) -> Expr:
    """Return the name of a number that is not known yet."""
    return atom(node.value) if isinstance(node, Number) and is_free(node.value) else node


def _with_given(program: Program, trace: Trace) -> Program:
    """Return a program whose integrals are given the free numbers that they read."""
    free = {*trace.definitions, *(a.name for a in trace.arguments)}

    def changed(statement: Statement) -> Statement:
        if not isinstance(statement, Quadrature):
            return statement
        added = sorted(reads(statement) & free - set(statement.given))
        return replace(statement, given=(*statement.given, *added))

    return replace(program, body=tuple(map(changed, program.body)))


def _require_plain_tables(program: Program) -> None:
    found = next((v for _, values in program.tables for v in values if is_free(v)), None)
    if found is not None:
        raise NeedsNumberError(cast("Traced", found))


def _defined(builder: Builder, free: FreePlan, wanted: Sequence[str]) -> dict[str, Expr]:
    """Write the definitions that some names need, and return what all names stand for."""
    trace = free.trace
    needed, waiting = set[str](), list(wanted)
    while waiting:
        name = waiting.pop()
        if name not in needed:
            needed.add(name)
            waiting += [n.name for n in names_in(trace.definitions.get(name, ZERO))]
    known: dict[str, Expr] = {a.name: a for a in trace.arguments}
    for name, value in trace.definitions.items():
        if name in needed:
            known[name] = builder.let(replace_names(value, known))
    return known
