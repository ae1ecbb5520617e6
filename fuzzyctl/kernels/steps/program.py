"""A step of a controller as a program: outputs and the next state from inputs and the state."""

from __future__ import annotations

from fuzzyctl.expr import Compare, Expr, Logic, Name, Number, Where, replace_names
from fuzzyctl.kernels.algorithms.select import algorithm_of
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.plan.equations import DT, Equations, Evaluation
from fuzzyctl.kernels.program.builder import Builder, any_nan
from fuzzyctl.kernels.program.passes.embed import embed
from fuzzyctl.kernels.program.program import NAN, STATE, Item, Program


def step_program(equations: Equations, algorithm: str = "auto") -> Program:
    """Write the program of a step.

    Args:
        equations: What it computes.
        algorithm: How systems are computed, see `select.ALGORITHMS`.

    Its arguments are the inputs, and dt where the controller has no period; its results are the outputs, then the next
    state. Where an input is NaN the outputs are NaN, and the state stays as it is.
    """
    builder = Builder()
    arguments = [Name(f"x{k}") for k in range(len(equations.inputs) + (equations.period is None))]
    env: dict[str, Expr] = dict(zip(equations.inputs, arguments, strict=False))
    if equations.period is None:
        env[DT] = arguments[-1]
    kept = [Item(STATE, k) for k in range(len(equations.states))]
    env |= {s.name: item for s, item in zip(equations.states, kept, strict=True)}
    for item in equations.body:
        if isinstance(item, Evaluation):
            values = [builder.let(numeric(replace_names(a, env))) for a in item.arguments]
            outputs = embed(builder, algorithm_of(plan(item.system), algorithm).point, values)
            env |= dict(zip(item.names, outputs, strict=True))
        else:
            env[item.name] = builder.let(numeric(replace_names(item.value, env)))
    outputs = [env[value.name] if isinstance(value, Name) else value for _, value in equations.outputs]
    updates = [builder.let(numeric(replace_names(u, env))) for u in equations.updates]
    results = [*outputs, *updates]
    if arguments:
        lacks = any_nan(arguments)
        before: list[Expr] = [*([NAN] * len(outputs)), *kept]
        results = [Where(lacks, old, new) for old, new in zip(before, results, strict=True)]
    return Program(
        arguments=tuple(a.name for a in arguments),
        state=len(kept),
        tables=tuple(builder.tables.items()),
        body=tuple(builder.statements),
        results=tuple(results),
    )


def numeric(value: Expr) -> Expr:
    """Return a value, 1 or 0 for a condition."""
    return Where(value, Number(1.0), Number(0.0)) if isinstance(value, Compare | Logic) else value
