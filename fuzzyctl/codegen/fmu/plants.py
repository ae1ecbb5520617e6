"""Model of an FMU from a plant: its right side is written in C as a step without state, and integrated in the FMU."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final

from fuzzyctl.codegen import c_source
from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.c_text import INDENT
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.fmu.calls import call_lines, param_lines, params_of, read_by, signal_variable, tunable
from fuzzyctl.codegen.fmu.model import Model, Variable, c_text, closed_range
from fuzzyctl.codegen.prepare import prepare
from fuzzyctl.expr import Call, Expr, evaluate, walk
from fuzzyctl.model.controller import Controller, Definition, Result, Signal
from fuzzyctl.model.loop import TIME
from fuzzyctl.model.plant import PLANT_FUNCTIONS, Plant

#: Longest step of integration, unless the importer sets another [s].
INTEGRATION_STEP: Final = 1e-3
#: Magnitude from which on a state counts as infinite, as in simulations.
_LARGEST: Final = 1e300


def plant_model(plant: Plant, text: str, free: Sequence[str] = ()) -> Model:
    """Return the model of a plant.

    Args:
        plant: A well-formed plant with its params set.
        text: The text of its rule file.
        free: Params that an importer may set; empty for all that can be set.

    Raises:
        CodegenError: For dead time, for a plant that has no equations, and for a param that a start depends on.
    """
    require_equations(plant)
    view = _right_side(plant)
    constant = read_by(_constants(plant), plant.params)
    free = _free(plant, free, constant) if free else [n for n in tunable(view) if n not in constant]
    unit = prepare(view, text, small=True, free=free)
    layout, values = CLayout(unit), plant.param_values.values
    inputs = [signal_variable(s, values) for s in plant.inputs]
    outputs = [signal_variable(s, values) for s in plant.results]
    params, constants = params_of(unit)
    first = 1 + len(inputs)
    arguments = [f"model->value[{1 + k}]" for k in range(len(inputs))]
    arguments += [*(f"state[{k}]" for k in range(len(plant.states))), "t", "1.0"]
    targets = [f"model->value[{first + k}]" for k in range(len(outputs))]
    targets += [f"rate[{k}]" for k in range(len(plant.states))]
    lines = param_lines(layout, first + len(outputs))
    lines += call_lines(layout, layout.call("", "&params", arguments), targets)
    longest = Variable(
        _unused("integration_step", [v.name for v in (*inputs, *outputs, *params, *constants)]),
        *(INTEGRATION_STEP, 1e-12, math.inf, "s", "longest step of integration, by the method of Runge and Kutta"),
    )
    return Model(
        name=layout.name,
        block=plant.name,
        title=plant.title,
        about=[f"{plant.name}: {plant.title}" if plant.title else plant.name, *_about(plant)],
        inputs=inputs,
        outputs=outputs,
        params=[*params, longest],
        constants=constants,
        sources={f"{layout.name}.h": c_source.header(unit), f"{layout.name}.c": c_source.source(unit)},
        memory=f"double state[{max(len(plant.states), 1)}];",
        begin=_begin(plant),
        make=["return fmu_integrate(model, dt);"],
        preview=0.0,
        helpers=[*_states(plant, first + len(outputs) + len(params)), *_rates(lines), '#include "fmu_rk4.h"'],
        shared=["fmu_rk4.h"],
    )


def require_equations(plant: Plant) -> None:
    """Raise `CodegenError` for a plant without equations or states, and for dead time."""
    if plant.external:
        raise CodegenError(f"plant '{plant.name}' is in {plant.external}, so it has no equations to write")
    if not plant.states:
        raise CodegenError(f"plant '{plant.name}' has no states, so there is nothing to integrate")
    equations: list[Definition | Result] = [*plant.definitions, *plant.results, *plant.derivatives]
    values = [equation.value for equation in equations]
    if any(isinstance(e, Call) and e.function in PLANT_FUNCTIONS for value in values for e in walk(value)):
        message = f"plant '{plant.name}' has dead time, which generated code of a plant cannot keep"
        raise CodegenError(f"{message}; put the delay into a controller: delay(x, samples)")


def _right_side(plant: Plant) -> Controller:
    """Return a controller without state that computes outputs and derivatives of given inputs, states and time."""
    names = [r.name for r in plant.results] + [d.name for d in plant.definitions] + [s.name for s in plant.states]
    rates = {d.name: d.value for d in plant.derivatives}
    results = [*plant.results]
    for state in plant.states:
        name = _unused(f"{state.name}_rate", names)
        names.append(name)
        results.append(Result(name=name, label=f"derivative of {state.name} by time", value=rates[state.name]))
    states = [Signal(name=s.name, label=s.label, unit=s.unit, bounds=s.bounds) for s in plant.states]
    return Controller(
        name=plant.name,
        title=f"right side of the equations of plant {plant.name}",
        citation=plant.citation,
        params=plant.params,
        functions=plant.functions,
        inputs=(*plant.inputs, *states, Signal(name=TIME, label="time", unit="s")),
        definitions=plant.definitions,
        results=tuple(results),
        systems=plant.systems,
        path=plant.path,
        span=plant.span,
    )


def _constants(plant: Plant) -> Iterator[Expr]:
    """Yield the numbers that are computed before the FMU is written: starts and ranges of states."""
    for state in plant.states:
        yield state.start
        yield from (state.bounds.lower, state.bounds.upper) if state.bounds is not None else ()


def _free(plant: Plant, free: Sequence[str], constant: set[str]) -> Sequence[str]:
    wrong = next((name for name in free if name in constant), None)
    if wrong is not None:
        raise CodegenError(f"the start or range of a state depends on '{wrong}', which so cannot be free")
    return free


def _unused(name: str, taken: Sequence[str]) -> str:
    while name in taken:
        name += "_"
    return name


def _about(plant: Plant) -> Iterator[str]:
    values = plant.param_values.values
    if plant.citation:
        yield f"Source: {plant.citation}"
    yield "A plant: its states are integrated with inputs held over each communication step."
    yield from (f"State {s.name}, {evaluate(s.start, values)!r} at the start" for s in plant.states)
    yield from (f"Param {name} = {value!r}" for name, value in values.items())


def _begin(plant: Plant) -> list[str]:
    values = plant.param_values.values
    return [f"model->state[{k}] = {float(evaluate(s.start, values))!r};" for k, s in enumerate(plant.states)]


def _states(plant: Plant, longest: int) -> Iterator[str]:
    """Yield the number of states, the ends of their ranges, and the message of a state that leaves its range."""
    yield f"#define FMU_STATES {len(plant.states)}U"
    yield f"#define FMU_INTEGRATION_STEP {longest}U // reference of the param"
    ends = [closed_range(s.bounds, plant.param_values.values) for s in plant.states]
    lowest = ", ".join(repr(float(max(low, -_LARGEST))) for low, _ in ends)
    highest = ", ".join(repr(float(min(high, _LARGEST))) for _, high in ends)
    left = ", ".join(c_text(f"state '{s.name}' is not a number, or left its range") for s in plant.states)
    yield f"static const double fmu_lowest[FMU_STATES] = {{{lowest}}};"
    yield f"static const double fmu_highest[FMU_STATES] = {{{highest}}};"
    yield f"static const char *const fmu_left[FMU_STATES] = {{{left}}};"
    yield ""


def _rates(lines: Sequence[str]) -> Iterator[str]:
    """Yield the function that computes outputs and derivatives."""
    yield "static const char *fmu_rates(fmu_Model *model, double t, const double state[], double rate[])"
    yield from ("{", *(INDENT + line for line in lines), f"{INDENT}return NULL;", "}", "")
