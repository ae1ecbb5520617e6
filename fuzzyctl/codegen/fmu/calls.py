"""Models of FMUs from generated C: a system, or the step of a controller."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from fuzzyctl.codegen import c_source
from fuzzyctl.codegen.c_layout import CLayout
from fuzzyctl.codegen.comments import described
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.fmu.model import USUAL_STEP, Model, Variable, c_text, closed_range, near_zero
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.expr import Expr, Name, names_in
from fuzzyctl.kernels.plan.equations import Evaluation
from fuzzyctl.kernels.plan.expansion import equations_of
from fuzzyctl.model.block import Param
from fuzzyctl.model.controller import Controller, Signal


def block_model(unit: Unit) -> Model:
    """Return the model of a system or controller as it is written in C.

    Free numbers are its params; adaptive consequents take one Euler step for each communication step.

    Raises:
        CodegenError: For a name that begins as those of the standard, and a free param that the period depends on.
    """
    layout, block, values = CLayout(unit), unit.block, unit.block.param_values.values
    if unit.is_step:
        fixed = _of_period(unit.controller)
        for number in (n for n in unit.numbers if n.name in fixed):
            raise CodegenError(f"the period depends on '{number.name}', which so cannot be free")
        inputs = [signal_variable(s, values) for s in unit.controller.inputs]
        outputs = [signal_variable(s, values) for s in unit.controller.results]
    else:
        planned = zip(unit.system.inputs, unit.plan.inputs, strict=True)
        inputs = [Variable(v.name, near_zero(p.lower, p.upper), p.lower, p.upper, v.unit, v.label) for v, p in planned]
        bounds = [(v, unit.bounds[v.name]) for v in unit.system.outputs]
        outputs = [Variable(v.name, 0.0, b.lo, b.hi, v.unit, v.label) for v, b in bounds]
    params, constants = params_of(unit)
    numbers = [f"{_cast(layout)}{value}" for value in _values(1, inputs)]
    arguments = layout.call(
        "&model->memory", "&params", [*numbers, *([f"{_cast(layout)}dt"] if unit.takes_time else [])]
    )
    lines = param_lines(layout, 1 + len(inputs) + len(outputs))
    lines += call_lines(layout, arguments, _values(1 + len(inputs), outputs))
    if unit.rates is not None:
        lines.append(f"{layout.name}_adapt(&model->memory, {', '.join(numbers)}, {_cast(layout)}dt);")
    elif not unit.takes_time:
        lines.append("(void)dt;")
    return Model(
        name=layout.name,
        block=block.name,
        title=block.title,
        about=described(unit),
        inputs=inputs,
        outputs=outputs,
        params=params,
        constants=constants,
        sources={f"{layout.name}.h": c_source.header(unit), f"{layout.name}.c": c_source.source(unit)},
        memory=f"{layout.name}_state memory;" if unit.has_state else "",
        begin=[f"{layout.name}_init(&model->memory);"] if unit.has_state else ["(void)model;"],
        make=[*lines, "return NULL;"],
        preview=unit.period or (USUAL_STEP if unit.takes_time else 0.0),
        period=unit.period,
    )


def params_of(unit: Unit) -> tuple[list[Variable], list[Variable]]:
    """Return the free params, and those that are constants; params that are computed from free ones are neither."""
    block, free = unit.block, {n.name for n in unit.numbers}
    values, declarations = block.param_values.values, {p.name: p for p in block.params}
    params = [
        _param(declarations[n.name], values) if n.name in declarations else Variable(n.name, n.start)
        for n in unit.numbers
    ]
    fixed = [p for p in block.params if p.name in values and not read_by([Name(p.name)], block.params) & free]
    return params, [_param(p, values) for p in fixed]


def param_lines(layout: CLayout, first: int) -> list[str]:
    """Return the lines of C that gather the free numbers.

    Args:
        layout: That of the step.
        first: Reference of the first of them.
    """
    numbers = ", ".join(f"{_cast(layout)}model->value[{first + k}]" for k in range(len(layout.numbers)))
    return [f"const {layout.name}_params params = {{{numbers}}};"] if numbers else []


def tunable(controller: Controller) -> tuple[str, ...]:
    """Return the params of a controller that its equations read as they are, so that an importer can set them.

    A param that is computed from others follows these. A param that a fuzzy system reads, or on which the start of a
    state or the period depends, is a constant; `--free` can still name those of systems.
    """
    results: list[str] = []
    for param in controller.params:
        if names_in(param.expression) or param.name in _of_period(controller):
            continue
        try:
            equations = equations_of(controller, [*results, param.name])
        except ArgumentError:
            continue
        if not equations.starts_vary and not any(isinstance(i, Evaluation) and i.free for i in equations.body):
            results.append(param.name)
    return tuple(results)


def _of_period(controller: Controller) -> set[str]:
    return read_by([controller.period] if controller.period is not None else [], controller.params)


def read_by(expressions: Iterable[Expr], params: Sequence[Param]) -> set[str]:
    """Return the params that expressions read, those included that their params are computed from."""
    definitions = {p.name: p.expression for p in params}
    waiting, result = [n.name for e in expressions for n in names_in(e)], set[str]()
    while waiting:
        name = waiting.pop()
        if name in definitions and name not in result:
            result.add(name)
            waiting += [n.name for n in names_in(definitions[name])]
    return result


def _param(param: Param, values: Mapping[str, float]) -> Variable:
    return Variable(param.name, values[param.name], *closed_range(param.bounds, values), param.unit)


def signal_variable(signal: Signal, values: Mapping[str, float]) -> Variable:
    """Return an input or output as a variable."""
    lower, upper = closed_range(signal.bounds, values)
    return Variable(signal.name, near_zero(lower, upper), lower, upper, signal.unit, signal.label)


def call_lines(layout: CLayout, arguments: Sequence[str], targets: Sequence[str]) -> Iterator[str]:
    """Yield the lines of C that call a function, take its results, or return the reason of a failure.

    Args:
        layout: That of the function.
        arguments: Texts of its arguments without those for its results.
        targets: The text of the target of each result.
    """
    arguments, refusals = [*arguments], layout.unit.refusals
    if layout.many:
        yield f"{layout.name}_outputs outputs;"
        arguments.append("&outputs")
    if refusals:
        yield f"{layout.name}_status status = {layout.status()};"
        arguments.append("&status")
    call = f"{layout.function}({', '.join(arguments)})"
    yield f"{call};" if layout.many else f"{targets[0]} = {call};"
    if layout.many:
        yield from (f"{target} = outputs.{o};" for target, o in zip(targets, layout.outputs, strict=True))
    for output in refusals:
        yield f"if (status == {layout.status(output)}) {{"
        yield f"    return {c_text(f'no rule fires for output {output!r}')};"
        yield "}"


def _values(first: int, variables: Sequence[Variable]) -> list[str]:
    return [f"model->value[{first + k}]" for k in range(len(variables))]


def _cast(layout: CLayout) -> str:
    return "(float)" if layout.real == "float" else ""
