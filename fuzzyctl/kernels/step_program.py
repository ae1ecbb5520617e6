"""A step of a controller as a program: outputs and the next state from inputs and the state."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from fuzzyctl.expr import Compare, Expr, Logic, Name, Number, Where, replace_names
from fuzzyctl.kernels.algorithms.select import COMPILED, algorithm_of
from fuzzyctl.kernels.inference.free import free_program
from fuzzyctl.kernels.inference.inference import evaluation_with_rates
from fuzzyctl.kernels.plan.build import Plan, plan
from fuzzyctl.kernels.plan.equations import DT, Equations, Evaluation
from fuzzyctl.kernels.plan.free import free_plan
from fuzzyctl.kernels.program.builder import Builder, any_nan, clip
from fuzzyctl.kernels.program.program import NAN, STATE, Item, Program
from fuzzyctl.kernels.program.traversal import embed, uses


def step_program(equations: Equations, algorithm: str = "auto") -> Program:
    """Write the program of a step.

    Args:
        equations: What it computes.
        algorithm: How systems are computed, see `select.ALGORITHMS`.

    Its arguments are the inputs, and dt where the controller has no period; its results are the outputs, then the next
    state. Where an input is NaN the outputs are NaN, and the state stays as it is.
    """
    return named_step(equations, lambda call: system_program(call, algorithm))[0]


def system_program(call: Evaluation, algorithm: str) -> Program:
    """Write the program of a system that a step calls: the outputs, then the rates of a system with states."""
    if call.states:
        return evaluation_with_rates(plan(call.system), most_pairs=COMPILED)
    if call.free:
        program = free_program(free_plan(call.system, [name for name, _ in call.free]))
        free = program.arguments[len(call.arguments) :]
        if set(free) & set(uses(program)):
            return program
        # Where only ranges depend on free numbers, all algorithms are open.
        known = algorithm_of(plan(call.system), algorithm).point
        return replace(known, arguments=(*known.arguments, *free))
    return algorithm_of(plan(call.system), algorithm).point


def named_step(equations: Equations, point: Callable[[Evaluation], Program]) -> tuple[Program, dict[str, Expr]]:
    """Write the program of a step, and return what the names of the equations are in it.

    Args:
        equations: What it computes.
        point: Writes the program of a system that the step calls, as `system_program` does.
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
            given = (*item.arguments, *(value for _, value in item.free))
            values = [builder.let(numeric(replace_names(a, env))) for a in given]
            before = [env[s] for s in item.states]
            dt = env[DT] if equations.period is None else Number(equations.period)
            found = evaluated(builder, plan(item.system), point(item), values, before, dt)
            env |= dict(zip(item.defined, found, strict=True))
        else:
            env[item.name] = builder.let(numeric(replace_names(item.value, env)))
    outputs = [env[value.name] if isinstance(value, Name) else value for _, value in equations.outputs]
    updates = [builder.let(numeric(replace_names(u, env))) for u in equations.updates]
    results = [*outputs, *updates]
    if arguments:
        lacks = any_nan(arguments)
        missing: list[Expr] = [*([NAN] * len(outputs)), *kept]
        results = [Where(lacks, old, new) for old, new in zip(missing, results, strict=True)]
    return builder.program(arguments, results, state=len(kept)), env


def evaluated(
    builder: Builder, system: Plan, program: Program, values: Sequence[Expr], before: Sequence[Expr], dt: Expr
) -> list[Expr]:
    """Write an evaluation of a system and return its outputs, then the next values of its states.

    A consequent that adapts moves by dt times its rate within the range of its output; an output that holds keeps its
    value. A state stays as it is where its rate or its output is NaN.
    """
    if not before:
        return embed(builder, program, values)
    (first, *_) = before
    assert isinstance(first, Item)
    assert isinstance(first.index, int)
    found = embed(builder, program, values, state=first.index)
    outputs, rates = found[: len(system.outputs)], found[len(system.outputs) :]
    following: list[Expr] = []
    for (o, _), old, rate in zip(system.states, before, rates, strict=False):
        moved = builder.let(old + dt * rate)
        following.append(clip(moved, system.outputs[o].lower, system.outputs[o].upper))
    following += [outputs[o] for o in system.held]
    kept = [Where(any_nan([new]), old, new) for old, new in zip(before, map(builder.let, following), strict=True)]
    return [*outputs, *map(builder.let, kept)]


def numeric(value: Expr) -> Expr:
    """Return a value, 1 or 0 for a condition."""
    return Where(value, Number(1.0), Number(0.0)) if isinstance(value, Compare | Logic) else value
