"""Dependencies between the equations of plants and loops: algebraic loops, and how large expressions become.

A plant is treated as a controller with the derivatives as next values: a state or a delayed value does not depend on
other values of the same time. A loop is treated as one whose inputs are the outputs of its blocks.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, TypeVar, cast

from fuzzyctl import expr as ex
from fuzzyctl.diagnostics.diagnostic import (
    ArgumentError,
    Diagnostic,
    DiagnosticError,
    UnknownNameError,
    ValueOutOfBoundsError,
)
from fuzzyctl.expr import ZERO, Call, Expr, Keyword, Name
from fuzzyctl.kernels.plan.equations import Equation, Equations, Evaluation, feedthrough, ordered
from fuzzyctl.kernels.plan.expansion import equations_of
from fuzzyctl.model.checks.blocks import numbers_of_all
from fuzzyctl.model.controller import Controller, Definition, EquationBlock, Instance, Result, Signal
from fuzzyctl.model.forms import bound
from fuzzyctl.model.instance_params import with_instance_params
from fuzzyctl.model.loop import MEASURES, SIGNALS, TIME, Loop
from fuzzyctl.model.plant import PLANT_FUNCTIONS, Plant
from fuzzyctl.model.shared_params import with_values
from fuzzyctl.support.arguments import is_finite

WithEquations = TypeVar("WithEquations", bound=EquationBlock)


def with_params(block: WithEquations, values: Mapping[str, float]) -> WithEquations:
    """Return a block with some params set to numbers, those of a controller's instances by `INSTANCE.PARAM`.

    Raises:
        DiagnosticError: For numbers that the block does not take, such as one outside of the range of its param.
    """
    changed: Any = block
    changed = with_values(with_instance_params(changed, values), values)
    mistakes = list(numbers_of_all(changed))
    if mistakes:
        raise DiagnosticError(mistakes)
    parts_of(changed)
    return cast("WithEquations", changed)


def with_numbers(block: WithEquations, values: Mapping[str, Any]) -> WithEquations:
    """Return a block with some of its numbers changed in place.

    Args:
        block: A controller, plant or loop.
        values: By name: params, `BLOCK.PARAM` of the blocks inside, `SYSTEM.NAME` of the systems that it calls.

    Raises:
        UnknownNameError: For another name.
        ArgumentError: For a system that a block inside calls, too, which would be two of one name.
        ValueOutOfBoundsError: For a value that is not finite.
        DiagnosticError: For numbers that the block does not take.
    """
    of_systems: dict[str, dict[str, Any]] = {}
    changes: dict[str, Any] = {}
    named = {s.name for s in block.systems}
    for name, value in values.items():
        first, _, rest = name.partition(".")
        if first in named and rest:
            of_systems.setdefault(first, {})[rest] = value
        else:
            changes[name] = value
    for inner in (*block.controllers, *block.plants):
        for name in of_systems.keys() & {s.name for s in inner.systems}:
            raise ArgumentError(f"system '{name}' is called inside of {inner.kind} '{inner.name}', too")
    systems = tuple(_with_values(s, of_systems[s.name]) if s.name in of_systems else s for s in block.systems)
    block = dataclasses.replace(block, systems=systems)
    if isinstance(block, Loop):
        from fuzzyctl.simulation.loop_params import with_settings

        return cast("WithEquations", with_settings(block, changes))
    names = [p.name for p in block.params]
    names += [f"{i.name}.{p.name}" for i in block.instances for p in block.callee(i).params]
    for name, value in changes.items():
        if name not in names:
            raise UnknownNameError("free number", name, [*names, *(f"{s}.NAME" for s in sorted(named))])
        if not is_finite(value):
            raise ValueOutOfBoundsError(f"free number {name!r}", value, "a finite number")
    instances = tuple(i.with_values(changes) for i in block.instances)
    # Params of instances are arguments of these lines now; `with_params` would add params, whose names no file holds.
    params = {p.name: changes[p.name] for p in block.params if p.name in changes}
    return with_params(dataclasses.replace(block, instances=instances), params)


def _with_values(system: Any, values: Mapping[str, Any]) -> Any:
    """Return a system with other values of its numbers; errors name it."""
    try:
        return system.with_values(values)
    except UnknownNameError as error:
        names = [f"{system.name}.{name}" for name in error.known]
        raise UnknownNameError(error.kind, f"{system.name}.{error.name}", names) from None
    except ArgumentError as error:
        raise ArgumentError(f"system '{system.name}': {error}") from None
    except ValueOutOfBoundsError as error:
        name = f"system '{system.name}': {error.name}"
        raise ValueOutOfBoundsError(name, error.value, error.bound, error.unit) from None


def in_order(block: Any) -> list[Definition | Result]:
    """Return the definitions and outputs of a block without mistakes in the order in which they are computed."""
    equations = equations_of(block) if block.is_sampled else _equations(block)
    place: dict[object, int] = {}
    for k, item in enumerate(equations.body):
        place.setdefault(item.span if isinstance(item, Evaluation) else item.name, k)
    items: list[Definition | Result] = [*block.definitions, *block.results]
    return sorted(items, key=lambda d: place.get(d.name, place.get(ex.span_of(d.value), 0)))


def parts_of(block: EquationBlock) -> int:
    """Return how many parts the expressions of a block expand to.

    Raises:
        DiagnosticError: For an algebraic loop, a function that calls itself, or an expansion that is too large.
    """
    if isinstance(block, Plant):
        if block.external:
            return 0
        try:
            return _equations(block).parts
        except DiagnosticError as error:
            raise DiagnosticError([_in_plant(d, block) for d in error.diagnostics]) from None
    if isinstance(block, Loop):
        return _loop_parts(block)
    return equations_of(cast("Controller", block)).parts


def _in_plant(d: Diagnostic, plant: Plant) -> Diagnostic:
    help_text = "let a state break it, or delay(x, 0.1 s)" if d.code == "FZ220" else d.help
    return dataclasses.replace(d, span=d.span or plant.span, help=help_text)


def _equations(plant: EquationBlock) -> Equations:
    """Return the equations of a plant or loop in the form of a controller."""
    params = plant.param_values

    def known(expr: Expr) -> Expr:
        """Put a value of the step before in place of a delayed one."""
        if not (isinstance(expr, Call) and expr.function in PLANT_FUNCTIONS):
            return expr
        arguments = bound(PLANT_FUNCTIONS[expr.function], expr)
        return Call("previous", (arguments["x"],)) if params.of(arguments["time"]) else arguments["x"]

    def without_delays(expr: Expr) -> Expr:
        delayed = any(isinstance(e, Call) and e.function in PLANT_FUNCTIONS for e in ex.walk(expr))
        return ex.replace(expr, known) if delayed else expr

    changed = {
        kind: tuple(dataclasses.replace(d, value=without_delays(d.value)) for d in getattr(plant, kind))
        for kind in ("definitions", "results", "changes")
    }
    view = Controller(
        name=plant.name,
        params=plant.params,
        functions=plant.functions,
        inputs=(*plant.inputs, Signal(name=TIME)),
        states=plant.states,
        definitions=changed["definitions"],
        results=changed["results"],
        updates=changed["changes"],
        systems=plant.systems,
        span=plant.span,
    )
    return equations_of(view)


def _loop_parts(loop: Loop) -> int:
    """Return how many parts the expressions of a loop expand to.

    Raises:
        DiagnosticError: For an algebraic loop through its blocks, for sample times that do not fit together, and as
            `parts_of`.
    """
    callees: list[Controller | Plant] = [*loop.controllers, *loop.plants]
    inputs = {b.name: [i.name for i in b.inputs] for b in callees}
    direct = {c.name: feedthrough(equations_of(c)) for c in loop.controllers}
    direct |= {p.name: feedthrough(_equations(p)) for p in loop.plants if not p.external}
    outputs = {b.name: [r.name for r in b.results] for b in callees}
    arguments = [d for i in loop.instances for d in _arguments(i, inputs[i.controller])]
    members = [f"{i.name}.{o}" for i in loop.instances for o in outputs[i.controller]]
    members += [f"{i.name}.{s.name}" for i in loop.instances for s in loop.callee(i).states]
    measured = [
        Definition(name=f"{m.name}#{k}", value=argument, span=m.span)
        for m in loop.measures
        for k, argument in enumerate(_measured(m.value))
    ]
    claimed = [Definition(name=f"#{k}", value=g.claim, span=g.span) for k, g in enumerate(loop.always)]
    lets = [*loop.signals, *arguments, *measured, *claimed]
    view = Controller(
        name=loop.name,
        params=loop.params,
        functions=loop.functions,
        inputs=tuple(Signal(name=n) for n in (TIME, *members)),
        definitions=tuple(dataclasses.replace(d, value=_without_signals(d.value)) for d in lets),
        systems=loop.systems,
        span=loop.span,
    )
    try:
        equations = equations_of(view)
    except DiagnosticError as error:
        raise DiagnosticError([_of_lets(d) for d in error.diagnostics]) from None
    through = [e for i in loop.instances for e in _through(i, direct.get(i.controller, {}))]
    try:
        ordered([*equations.body, *through])
    except DiagnosticError as error:
        raise DiagnosticError([_in_loop(d) for d in error.diagnostics]) from None
    try:
        ordered([Equation(m.name, m.value, m.span) for m in loop.measures])
    except DiagnosticError as error:
        raise DiagnosticError([_of_measures(d) for d in error.diagnostics]) from None
    if loop.step is not None or any(c.period is not None for c in loop.controllers):
        # Which controllers need not.
        from fuzzyctl.simulation.judgement import Judgement
        from fuzzyctl.simulation.sample_times import require_room

        sizes = {b.name: len(b.inputs) + len(b.states) + len(b.results) for b in callees}
        recorded = len(loop.signals) + sum(sizes[i.controller] for i in loop.instances)
        require_room(loop, recorded + len(Judgement(loop).signals))
    return equations.parts


def _in_loop(d: Diagnostic) -> Diagnostic:
    facts = (*d.facts, "each of these outputs depends on the inputs of its block at the same time")
    help_text = "give the plant a state between input and output, or use previous(...) in the controller"
    return dataclasses.replace(d, message=d.message.replace("step", "sample"), facts=facts, help=help_text)


def _of_lets(d: Diagnostic) -> Diagnostic:
    if d.code != "FZ220":
        return d
    help_text = "compute one of them from the outputs of blocks or the time; a controller or plant keeps earlier values"
    return dataclasses.replace(d, message=d.message.replace("step", "sample"), help=help_text)


def _of_measures(d: Diagnostic) -> Diagnostic:
    message = d.message.replace("algebraic loop:", "measure").removesuffix(" within one step")
    return dataclasses.replace(d, message=message, help="compute one of them from signals, such as: maximum(y)")


def _arguments(instance: Instance, inputs: list[str]) -> list[Definition]:
    """Return the inputs of a block of a loop as definitions `NAME.INPUT`."""
    positional = [a for a in instance.arguments if not isinstance(a, Keyword)]
    named = {a.name: a.value for a in instance.arguments if isinstance(a, Keyword) and a.name in inputs}
    values = dict(zip(inputs, positional, strict=False)) | named
    return [Definition(name=f"{instance.name}.{n}", value=v, span=instance.span) for n, v in values.items()]


def _measured(value: Expr) -> list[Expr]:
    """Return the signals that the calls of measures in an expression take."""
    results = []
    for call in ex.walk(value):
        if isinstance(call, Call) and call.function in MEASURES:
            form = MEASURES[call.function]
            results += [e for name, e in bound(form, call).items() if name in form.signals]
    return results


def _without_signals(expr: Expr) -> Expr:
    """Return an expression with numbers in place of calls of signals, which depend on the time only."""
    if not any(isinstance(e, Call) and e.function in SIGNALS for e in ex.walk(expr)):
        return expr
    return ex.replace(expr, lambda e: ZERO if isinstance(e, Call) and e.function in SIGNALS else e)


def _through(instance: Instance, direct: Mapping[str, tuple[str, ...]]) -> list[Equation | Evaluation]:
    """Return the outputs of a block that depend on its inputs at the same time, as equations."""
    return [
        Equation(f"{instance.name}.{o}", Call("min", tuple(Name(f"{instance.name}.{i}") for i in names)), instance.span)
        for o, names in direct.items()
        if names
    ]
