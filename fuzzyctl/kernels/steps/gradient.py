"""Derivatives of a step: outputs and next states by inputs, states and free numbers."""

from __future__ import annotations

from dataclasses import replace

from fuzzyctl.expr import Expr, Name
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.inference.free import with_values_as_array
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.plan.equations import Equations, Evaluation
from fuzzyctl.kernels.program.passes.differentiate import differentiated
from fuzzyctl.kernels.program.program import STATE, Item, Program
from fuzzyctl.kernels.program.traversal import map_expressions
from fuzzyctl.kernels.steps.program import named_step, system_program


def step_gradient(equations: Equations) -> Program:
    """Differentiate the step of a controller by its inputs and states, in forward mode.

    Args:
        equations: What the step computes; free numbers are the last states.

    Returns:
        The program of all derivatives, (outputs + states) rows of (inputs + states); it takes what a step takes.
    """

    def point(call: Evaluation) -> Program:
        # Of the programs of a system, the one with all rules has a derivative.
        plain = not (call.states or call.free)
        return inference.evaluation(plan(call.system)) if plain else system_program(call, "rules")

    step, _ = named_step(equations, point)
    states = [Name(f"s{k}") for k in range(len(equations.states))]

    def change(node: Expr) -> Expr:
        if isinstance(node, Item) and node.array == STATE:
            assert isinstance(node.index, int), "states are read one by one"
            return states[node.index]
        return node

    given = replace(map_expressions(step, change), arguments=(*step.arguments, *(s.name for s in states)), state=0)
    by = (*step.arguments[: len(equations.inputs)], *(s.name for s in states))
    return with_values_as_array(differentiated(given, by), states)
