"""Trace of any block; of a controller the value of each name, and a trace of each system that it calls."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, overload

from fuzzyctl.diagnostics.diagnostic import ArgumentError, NoRuleFiresError, UnknownNameError
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.explain.trace import Trace, trace
from fuzzyctl.expr import Expr
from fuzzyctl.kernels.backends.arguments import input_number
from fuzzyctl.kernels.forms import value_of
from fuzzyctl.kernels.kernel import Kernel
from fuzzyctl.kernels.plan.equations import DT, Evaluation
from fuzzyctl.kernels.plan.expansion import equations_of
from fuzzyctl.kernels.step_form import StepForm, numeric
from fuzzyctl.model.block import Block
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.operations import Printed
from fuzzyctl.support import arguments

if TYPE_CHECKING:
    from fuzzyctl.annotations import Column


@dataclass(frozen=True)
class TracedCall:
    """A call of a system.

    Args:
        name: That of the definition, or of the system where its outputs have no name.
        trace: Of the system, at its inputs.
    """

    name: str
    trace: Trace


@dataclass(frozen=True, repr=False)
class BlockTrace(Printed):
    """A step of a controller taken apart.

    Args:
        block: The controller.
        inputs: Its inputs; a controller without period also has `dt` [s].
        state: The state before the step, by name.
        lets: Values of its definitions, by name.
        calls: The systems that it calls, in the order in which they are computed.
        outputs: The outputs.
        next_state: The state after the step, by name.
    """

    block: Controller = field(compare=False)
    inputs: dict[str, float]
    state: dict[str, float]
    lets: dict[str, float]
    calls: tuple[TracedCall, ...]
    outputs: dict[str, float]
    next_state: dict[str, float]

    def __repr__(self) -> str:
        values = [", ".join(f"{n} = {x:.6g}" for n, x in part.items()) for part in (self.inputs, self.outputs)]
        calls = counted(len(self.calls), "call")
        return printable(f"BlockTrace({self.block.name} at {values[0]}: {values[1]}; {calls} of systems)")

    def as_dict(self) -> dict[str, Any]:
        """Return the trace as plain data, without the controller."""
        data = {n: getattr(self, n) for n in ("inputs", "state", "lets", "outputs", "next_state")}
        calls = [{"name": c.name, "system": c.trace.system.name, **c.trace.as_dict()} for c in self.calls]
        return {**data, "calls": calls}


@overload
def why(block: FuzzySystem, values: Mapping[str, float] | Column | None = None, /, **named: float) -> Trace: ...
@overload
def why(block: Controller, values: Mapping[str, float] | Column | None = None, /, **named: float) -> BlockTrace: ...
def why(
    block: FuzzySystem | Controller, values: Mapping[str, float] | Column | None = None, /, **named: float
) -> Trace | BlockTrace:
    """Explain the outputs of a system, or of the first step of a controller, at a point.

    A notebook shows the rules that act.

    Args:
        block: A well-formed system or controller; its state is the initial one.
        values: A number for every input by name; a Series of pandas has the names as labels. A controller whose steps
            depend on the time since the step before takes `dt` [s] as well.
        named: The same for names that Python can write.

    Raises:
        UnknownNameError: For a name that is not an input.
        ArgumentError: When an input is missing, given twice, or no number.
        NoRuleFiresError: Where no rule fires for an output that says `else error`.
    """
    numbers = arguments.mapping("'values'", "numbers by name of the input", {} if values is None else values)
    arguments.instance("the block", Block, "a FuzzySystem or a Controller", block)
    declared = {block.as_declared(n): value for n, value in named.items()}
    for name in declared:
        if name in numbers:
            raise ArgumentError(f"{name!r} is given twice")
    point = {**numbers, **declared}
    if isinstance(block, FuzzySystem):
        return trace(block, point)
    return trace_block(arguments.instance("the block", Controller, "a FuzzySystem or a Controller", block), point)


def trace_block(
    controller: Controller, values: Mapping[str, float], state: Mapping[str, float] | None = None
) -> BlockTrace:
    """Take a step of a controller apart.

    Args:
        controller: A well-formed controller.
        values: A number for every input, and `dt` [s] for a controller whose steps depend on it.
        state: The numbers of the state before the step by name; None for those of the start.

    Raises:
        UnknownNameError: For a name that is not an input.
        ArgumentError: When an input is missing or no number, and for a state of other names.
        ValueOutOfBoundsError: For a `dt` that is not positive and finite.
        NoRuleFiresError: Where no rule of a system fires whose output says `else error`.
    """
    equations = equations_of(controller)
    kernel = Kernel(StepForm(equations, checked=True), "python")
    names = (*kernel.input_names, *((DT,) if kernel.form.needs_time or DT in values else ()))
    for name in values:
        if name not in names:
            raise UnknownNameError("input", name, names)
    missing = [n for n in names if n not in values]
    if missing:
        raise ArgumentError(f"a value is missing for: {', '.join(missing)}")
    point = {n: input_number(n, values[n]) for n in names}
    start = dict(zip(kernel.state_names, kernel.start().tolist(), strict=True))
    before = start if state is None else {n: input_number(n, x) for n, x in state.items()}
    inputs = [point[n] for n in kernel.input_names]
    outputs, after = kernel(*inputs, before or [], dt=point.get(DT))
    results = (outputs,) if len(kernel.output_names) == 1 else tuple(outputs)
    symbols = {**point, **before}
    symbols.setdefault(DT, 1.0 if kernel.period is None else kernel.period)
    calls = []
    for item in equations.body:
        if not isinstance(item, Evaluation):
            symbols[item.name] = _value(item.value, symbols)
            continue
        numbers = [_value(a, symbols) for a in item.arguments]
        call_inputs = dict(zip((i.name for i in item.system.inputs), numbers, strict=True))
        call_state = [symbols[s] for s in item.states]
        try:
            call = trace(item.system, call_inputs, call_state or None)
        except NoRuleFiresError:
            symbols |= dict.fromkeys(item.defined, math.nan)
            continue
        symbols |= dict(zip(item.names, call.outputs.values(), strict=True))
        calls.append(TracedCall(item.names[0].partition("#")[0].partition(".")[0], call))
    definitions = [d.name for d in controller.definitions if d.name in symbols]
    return BlockTrace(
        block=controller,
        inputs=point,
        state=before,
        lets={n: symbols[n] for n in definitions},
        calls=tuple(calls),
        outputs=dict(zip(kernel.output_names, results, strict=True)),
        next_state=dict(zip(kernel.state_names, after.tolist(), strict=True)),
    )


def _value(expr: Expr, values: Mapping[str, float]) -> float:
    """Return the value of an expression over known names, 1 or 0 for a condition."""
    return value_of(numeric(expr), values)
