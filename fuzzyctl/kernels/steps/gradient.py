"""Derivatives of a step: outputs and next states by inputs, states and free numbers."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fuzzyctl.expr import Expr, Name, Number
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.inference.free import with_values_as_array
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.plan.equations import Equations, Evaluation
from fuzzyctl.kernels.program.passes.differentiate import differentiated
from fuzzyctl.kernels.program.program import STATE, Item, Program
from fuzzyctl.kernels.program.traversal import map_expressions
from fuzzyctl.kernels.steps.program import named_step, system_program
from fuzzyctl.records import record

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]


@record(frozen=True)
class StepGradient:
    """Derivatives of a step, those that are the same everywhere as numbers.

    Args:
        program: Computes the others; it takes what a step takes.
        known: All derivatives, shape (outputs + states, inputs + states), 0 in the place of those that are computed.
        places: Positions of these among all derivatives, row by row.
    """

    program: Program
    known: FloatArray
    places: npt.NDArray[np.int64]


def step_gradient(equations: Equations) -> StepGradient:
    """Differentiate the step of a controller by its inputs and states, in forward mode.

    Args:
        equations: What the step computes; free numbers are the last states.
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
    found = differentiated(given, by)
    computed = [k for k, value in enumerate(found.results) if not isinstance(value, Number)]
    known = [value.value if isinstance(value, Number) else 0.0 for value in found.results]
    program = replace(found, results=tuple(found.results[k] for k in computed))
    shape = (len(step.results), len(by))
    return StepGradient(
        with_values_as_array(program, states), np.reshape(known, shape), np.array(computed, dtype=np.int64)
    )
