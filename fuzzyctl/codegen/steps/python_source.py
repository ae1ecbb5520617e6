"""A step as one Python module without imports beyond the standard library."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyctl.codegen.names import PYTHON_FUNCTION_RESERVED, PYTHON_RESERVED, Names
from fuzzyctl.codegen.python_source import helpers, refusal, require_no_integral
from fuzzyctl.codegen.simplify import functions, renamed
from fuzzyctl.codegen.steps.c_layout import member_name
from fuzzyctl.codegen.steps.unit import StepUnit, described_step
from fuzzyctl.kernels.plan.equations import DT
from fuzzyctl.kernels.program.printer import IEEE_SCALAR, INDENT, block, text

#: What the module calls its own, besides.
_OWN = ("start", "step", "state", DT, "PERIOD", "STATES")


def module_name(unit: StepUnit) -> str:
    """Return the name of the module."""
    return Names(PYTHON_FUNCTION_RESERVED).claim(unit.controller.name)


def module(unit: StepUnit) -> str:
    """Return the text of NAME.py.

    It has the functions `start()`, the state before the first step as a list, and `step(inputs, state)`, with `dt` last
    where there is no period: the outputs, a number or a tuple, and the next state. Where no rule fires for an output
    that says `else error`, `step` raises ArithmeticError.
    """
    require_no_integral(unit.program)
    names = Names([*PYTHON_RESERVED, *_OWN])
    inputs = [names.claim(i) for i in unit.equations.inputs]
    lines = [f"# {line}".rstrip() for line in described_step(unit)]
    lines += ["", "import math", "from math import inf, nan", ""]
    lines += [f"INPUTS = {list(unit.equations.inputs)!r}", f"OUTPUTS = {list(unit.outputs)!r}"]
    lines += [f"STATES = [{', '.join(_state_names(unit))}]"]
    lines += [f"PERIOD = {unit.equations.period!r}  # [s]"] if unit.equations.period is not None else []
    lines += [f"{table} = {values!r}" for table, values in unit.program.tables]
    lines += ["", *helpers(functions(unit.program) | {"divide"})]
    starts = [f"*[{s.start!r}] * {s.length}" if s.length > 1 else repr(s.start) for s in unit.slots]
    numbers = [Names([*PYTHON_RESERVED, *_OWN]).claim(member_name(n.name)) for n in unit.numbers]
    given = [f"{name}={n.start!r}" for name, n in zip(numbers, unit.numbers, strict=True)]
    lines += ["", f"def start({', '.join(given)}):", f'{INDENT}"""Return the state before the first step."""']
    lines += [f"{INDENT}return [{', '.join([*starts, *numbers])}]"]
    return "\n".join([*lines, "", "", *_step(unit, inputs)]) + "\n"


def _state_names(unit: StepUnit) -> Iterator[str]:
    """Yield the texts of the names of the states, those of a delay as one."""
    place = 0
    for slot in (*unit.slots, *unit.numbers):
        names = [s.name for s in unit.equations.states[place : place + slot.length]]
        place += slot.length
        if names == [f"{slot.name}.{k}" for k in range(slot.length)]:
            yield f'*(f"{slot.name}.{{k}}" for k in range({slot.length}))'
        else:
            yield from map(repr, names)


def _step(unit: StepUnit, inputs: list[str]) -> Iterator[str]:
    time = [] if unit.equations.period is not None else [DT]
    arguments = [*inputs, *time]
    yield f"def step({', '.join([*inputs, 'state', *time])}):"
    yield f'{INDENT}"""Make a step; return the outputs, and the next state."""'
    yield from (f"{INDENT}{a} = float({a})" for a in arguments)
    tests = [f"{a} != {a}" for a in inputs] + [f"not {t} > 0.0" for t in time]
    nothing = ", ".join(["nan"] * len(unit.outputs))
    if tests:
        yield f"{INDENT}if {' or '.join(tests)}:"
        yield f"{INDENT * 2}return {f'({nothing})' if len(unit.outputs) > 1 else nothing}, list(state)"
    yield from _read(unit)
    program = renamed(unit.program, [*arguments, *unit.program.arguments[len(arguments) :]])
    for line in block(program.body, IEEE_SCALAR, refusal):
        yield from _noted(unit, line)
    results = [text(r, IEEE_SCALAR) for r in program.results]
    outputs, taken = results[: len(unit.outputs)], results[len(unit.outputs) :]
    first = f"({', '.join(outputs)})" if len(outputs) > 1 else outputs[0]
    yield f"{INDENT}return {first}, [{', '.join(_taken(unit, taken))}]"


def _noted(unit: StepUnit, line: str) -> Iterator[str]:
    """Yield a line of a value behind a comment with the name of its equation."""
    value = line.strip().split(" = ", 1)[0]
    if value in unit.values:
        yield f"{INDENT}# {unit.values[value]}"
    yield line


def _read(unit: StepUnit) -> Iterator[str]:
    """Yield lines that name what the slots give: the oldest number of each, which comes last."""
    place = 0
    for k, slot in enumerate((*unit.slots, *unit.numbers)):
        place += slot.length
        yield f"{INDENT}s{k} = state[{place - 1}]"


def _taken(unit: StepUnit, values: list[str]) -> Iterator[str]:
    """Yield the next state: what each slot takes, then what it had but for the oldest."""
    place = 0
    for slot, value in zip(unit.slots, values, strict=True):
        yield value
        if slot.length > 1:
            yield f"*state[{place}:{place + slot.length - 1}]"
        place += slot.length
    if unit.numbers:
        yield f"*state[{place}:]"
