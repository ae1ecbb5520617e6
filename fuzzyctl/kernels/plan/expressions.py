"""Expressions of a plan, over inputs and numbers, equal on every target."""

from __future__ import annotations

from collections.abc import Collection
from functools import reduce
from typing import cast

from fuzzyctl.diagnostics.diagnostic import UnknownNameError
from fuzzyctl.expr import (
    CONSTANTS,
    Binary,
    Call,
    Expr,
    Number,
    names_in,
    replace,
    replace_names,
)
from fuzzyctl.kernels.plan.traced import Trace
from fuzzyctl.model.system import FuzzySystem

#: Where a system with free numbers keeps what records them, among what is derived from it.
TRACE = "trace"


def guarded(expr: Expr) -> Expr:
    """Return an expression that a user wrote so that every target computes the same, and none raises.

    Quotients follow IEEE 754, and `min` and `max` compare, so that all targets agree where an operand has no value.
    """

    def change(node: Expr) -> Expr:
        match node:
            case Binary(op="/", left=left, right=right):
                return Call("divide", (left, right))
            case Call(function="min" | "max" as function, arguments=arguments):
                pair = "smaller" if function == "min" else "larger"
                return reduce(lambda a, b: Call(pair, (a, b)), arguments)
        return node

    return replace(expr, change)


def number_of(system: FuzzySystem, expr: Expr) -> float:
    """Compute an expression over the params; one that depends on free numbers is a `Traced`."""
    trace: Trace | None = system.derived.get(TRACE)
    if trace is not None and trace.concerns(expr):
        return cast("float", trace.number(expr, system.values, guarded))
    # + 0.0 makes -0.0 a plain zero, so that equal systems have equal plans.
    return float(system.number(expr)) + 0.0


def constants_of(system: FuzzySystem, hidden: set[str]) -> dict[str, Expr]:
    """Return params and named constants as numbers, without those that a variable of the same name hides."""
    trace: Trace | None = system.derived.get(TRACE)
    free = {} if trace is None else cast("dict[str, float]", trace.numbers)
    return {n: Number(v) for n, v in (CONSTANTS | system.values | free).items() if n not in hidden}


def require_known(expr: Expr, variables: set[str], numbers: dict[str, Expr]) -> None:
    """Raise `UnknownNameError` for a name that is neither a variable nor a number."""
    for name in names_in(expr):
        if name.name not in variables and name.name not in numbers:
            raise UnknownNameError("input", name.name, sorted(variables))


def over_inputs(system: FuzzySystem, expr: Expr, *, outputs: bool = False, more: Collection[str] = ()) -> Expr:
    """Return an expression over the names of inputs, lets, and perhaps outputs, params replaced by numbers."""
    inputs = {v.name for v in (*system.inputs, *system.lets, *(system.outputs if outputs else ()))} | set(more)
    numbers = constants_of(system, inputs)
    require_known(expr, inputs, numbers)
    return replace_names(expr, numbers)
