"""A unit as one Python module without imports beyond the standard library."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from inspect import getsource, isfunction
from typing import Final

from fuzzyctl.codegen.c_layout import member_name
from fuzzyctl.codegen.comments import described
from fuzzyctl.codegen.errors import CodegenError, unprintable
from fuzzyctl.codegen.names import PYTHON_FUNCTION_RESERVED, PYTHON_RESERVED, Names
from fuzzyctl.codegen.simplify import functions, renamed
from fuzzyctl.codegen.unit import Unit
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.equations import DT
from fuzzyctl.kernels.program.printer import IEEE_SCALAR, INDENT, INTERPRETED, Dialect, block, index_text, text
from fuzzyctl.kernels.program.program import STATE, Locate, Place, Program, Quadrature
from fuzzyctl.kernels.program.scalar import IEEE_FUNCTIONS

#: Functions that the printer writes as comparisons.
_PRINTED: Final = {"min", "max", "clip", "sign"}

#: More names of the module of a controller.
_OWN: Final = ("start", "step", "state", DT, "PERIOD", "STATES")

_MAIN: Final = '''
def main(arguments=None):
    """Evaluate at the values that stand on the command line, in the order of the inputs."""
    values = sys.argv[1:] if arguments is None else arguments
    if len(values) != len(INPUTS):
        print("usage:", " ".join(INPUTS), file=sys.stderr)
        return 2
    try:
        point = [float(value) for value in values]
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    try:
        result = {function}(*point{state})
    except ArithmeticError as error:
        print(error, file=sys.stderr)
        return 1
    for name, value in zip(OUTPUTS, {results}):
        print(name, "=", value)
    return 0


if __name__ == "__main__":
    sys.exit(main())
'''


def module_name(unit: Unit) -> str:
    """Return the name of the module, which is that of the function of a system."""
    return Names(PYTHON_FUNCTION_RESERVED).claim(unit.block.name)


def module(unit: Unit) -> str:
    """Return the text of NAME.py.

    For a system it has the function NAME(inputs) that returns a number, or a tuple for several outputs; with a state
    NAME(inputs, state), `init()` that gives the first one, and `rates(inputs, state)` where something adapts. For a
    controller it has `start()`, the state before the first step as a list, and `step(inputs, state)`, with `dt` last
    where there is no period: the outputs, a number or a tuple, and the next state. Where no rule fires for an output
    that says `else error`, ArithmeticError is raised.

    Raises:
        CodegenError: For an adaptive integral, or a function that has no text in Python.
    """
    name, program = module_name(unit), unit.written
    names = Names([*PYTHON_RESERVED, *(_OWN if unit.is_step else [name])])
    inputs = [names.claim(i) for i in unit.inputs]
    rates = inference.rates(unit.plan) if unit.consequents else None
    for statement in program.body:
        if isinstance(statement, Quadrature):
            raise unprintable(statement)
    programs = [("", program), *([("R", rates)] if rates else [])]
    lines = [f"# {line}".rstrip() for line in described(unit)]
    lines += ["", "import math", *([] if unit.is_step else ["import sys"]), "from math import inf, nan", ""]
    lines += [f"INPUTS = {list(unit.inputs)!r}", f"OUTPUTS = {list(unit.outputs)!r}"]
    lines += [f"STATES = [{', '.join(_state_names(unit))}]"] if unit.is_step else []
    lines += [f"PERIOD = {unit.period!r}  # [s]"] if unit.period is not None else []
    lines += [f"{prefix}{table} = {values!r}" for prefix, part in programs for table, values in part.tables]
    # Quotients of equations and rates are those of the user, which may be 0/0.
    used = {f for _, part in programs for f in functions(part)} | ({"divide"} if rates or unit.is_step else set())
    lines += ["", *_helpers(used), ""]
    if unit.is_step:
        return "\n".join([*lines, *_start(unit), "", "", *_step(unit, inputs)]) + "\n"
    lines += _evaluation(unit, name, inputs)
    if unit.has_state:
        lines += ["", "", "def init():", f"{INDENT}return {list(unit.plan.initial_state)!r}"]
    if rates is not None:
        lines += ["", "", *_rates(rates, inputs)]
    state, results = ", init()" if unit.has_state else "", "result" if len(unit.outputs) > 1 else "[result]"
    return "\n".join([*lines, "", _MAIN.format(function=name, state=state, results=results).rstrip("\n")]) + "\n"


def _helpers(used: set[str]) -> Iterator[str]:
    """Yield the text of the primitives that are called, and of what these call."""
    wanted = used - _PRINTED
    unknown = wanted - set(IEEE_FUNCTIONS)
    if unknown:
        raise CodegenError(f"the function {min(unknown)!r} has no text in Python")
    wanted |= {"divide"} if "power" in wanted else set()
    for name in sorted(wanted - {"abs"}):
        yield (
            _plain(IEEE_FUNCTIONS[name])
            if isfunction(IEEE_FUNCTIONS[name])
            else f"\n{name} = math.{IEEE_FUNCTIONS[name].__name__}\n"
        )


def _plain(function: Callable[..., float]) -> str:
    """Return the text of a function without types and docstring, which a module of numbers does not need."""
    tree = ast.parse(getsource(function))
    (definition,) = tree.body
    assert isinstance(definition, ast.FunctionDef), "primitives are functions"
    definition.body, definition.returns = definition.body[1:], None
    for argument in definition.args.args:
        argument.annotation = None
    return f"\n{ast.unparse(tree)}\n"


def _evaluation(unit: Unit, name: str, arguments: Sequence[str]) -> Iterator[str]:
    program = renamed(unit.written, arguments)
    dialect = _dialect(INTERPRETED, "")
    parameters = ", ".join([*arguments, *(["state"] if program.state else [])])
    yield f"def {name}({parameters}):"
    yield from _floats(arguments)
    yield from block(program.body, dialect, _refusal)
    results = [text(r, dialect) for r in program.results]
    if not unit.plan.held:
        yield f"{INDENT}return {', '.join(results)}"
        return
    # Held outputs are kept in the state, as the kernels leave them to their caller.
    for k, result in enumerate(results):
        yield f"{INDENT}result{k} = {result}"
    for entry, o in enumerate(unit.plan.held, start=len(unit.plan.states)):
        yield f"{INDENT}state[{entry}] = result{o} if result{o} == result{o} else state[{entry}]"
    yield f"{INDENT}return {', '.join(f'result{k}' for k in range(len(results)))}"


def _rates(program: Program, arguments: Sequence[str]) -> Iterator[str]:
    dialect = _dialect(IEEE_SCALAR, "R")
    equations = renamed(program, arguments)
    yield f"def rates({', '.join([*arguments, 'state'])}):"
    yield from _floats(arguments)
    yield from block(equations.body, dialect, _refusal)
    yield f"{INDENT}return [{', '.join(text(r, dialect) for r in equations.results)}]"


def _floats(arguments: Sequence[str]) -> Iterator[str]:
    yield from (f"{INDENT}{a} = float({a})" for a in arguments)


def _refusal(condition: str, output: str) -> list[str]:
    """Return lines that raise where no rule fires for an output."""
    return [f"if {condition}:", f"{INDENT}raise ArithmeticError({f'no rule fires for output {output!r}'!r})"]


def _dialect(base: Dialect, prefix: str) -> Dialect:
    """Return a dialect in which tables have a prefix, so that two programs fit in one module."""

    def item(array: str, index: int | str | Place) -> str:
        return f"{'state' if array == STATE else prefix + array}[{index_text(index)}]"

    def located(statement: Locate, x: str) -> list[str]:
        start = f"{statement.table}["
        return [line.replace(start, prefix + start) for line in base.locate(statement, x)]

    return replace(base, item=item, locate=located)


def _start(unit: Unit) -> Iterator[str]:
    names = Names([*PYTHON_RESERVED, *_OWN])
    numbers = [names.claim(member_name(n.name)) for n in unit.numbers]
    starts = [f"*[{s.start!r}] * {s.length}" if s.length > 1 else repr(s.start) for s in unit.slots]
    defaults = [f"{name}={n.start!r}" for name, n in zip(numbers, unit.numbers, strict=True)]
    yield f"def start({', '.join(defaults)}):"
    yield f'{INDENT}"""Return the state before the first step."""'
    yield f"{INDENT}return [{', '.join([*starts, *numbers])}]"


def _state_names(unit: Unit) -> Iterator[str]:
    """Yield the texts of the names of the states, those of a delay as one."""
    place = 0
    for slot in (*unit.slots, *unit.numbers):
        names = [s.name for s in unit.equations.states[place : place + slot.length]]
        place += slot.length
        if names == [f"{slot.name}.{k}" for k in range(slot.length)]:
            yield f'*(f"{slot.name}.{{k}}" for k in range({slot.length}))'
        else:
            yield from map(repr, names)


def _step(unit: Unit, inputs: list[str]) -> Iterator[str]:
    time = [DT] if unit.takes_time else []
    arguments = [*inputs, *time]
    yield f"def step({', '.join([*inputs, 'state', *time])}):"
    yield f'{INDENT}"""Make a step; return the outputs, and the next state."""'
    yield from _floats(arguments)
    tests = [f"{a} != {a}" for a in inputs] + [f"not {t} > 0.0" for t in time]
    nothing = ", ".join(["nan"] * len(unit.outputs))
    if tests:
        yield f"{INDENT}if {' or '.join(tests)}:"
        yield f"{INDENT * 2}return {f'({nothing})' if len(unit.outputs) > 1 else nothing}, list(state)"
    yield from _read(unit)
    program = renamed(unit.program, [*arguments, *unit.program.arguments[len(arguments) :]])
    for line in block(program.body, IEEE_SCALAR, _refusal):
        yield from _noted(unit, line)
    results = [text(r, IEEE_SCALAR) for r in program.results]
    outputs, values = results[: len(unit.outputs)], results[len(unit.outputs) :]
    first = f"({', '.join(outputs)})" if len(outputs) > 1 else outputs[0]
    yield f"{INDENT}return {first}, [{', '.join(_taken(unit, values))}]"


def _noted(unit: Unit, line: str) -> Iterator[str]:
    """Yield a line of a value behind a comment with the name of its equation."""
    value = line.strip().split(" = ", 1)[0]
    if value in unit.values:
        yield f"{INDENT}# {unit.values[value]}"
    yield line


def _read(unit: Unit) -> Iterator[str]:
    """Yield lines that name the values of the slots: the oldest number of each, which comes last."""
    place = 0
    for k, slot in enumerate((*unit.slots, *unit.numbers)):
        place += slot.length
        yield f"{INDENT}s{k} = state[{place - 1}]"


def _taken(unit: Unit, values: list[str]) -> Iterator[str]:
    """Yield the next state: the new value of each slot, then its earlier ones without the oldest."""
    place = 0
    for slot, value in zip(unit.slots, values, strict=True):
        yield value
        if slot.length > 1:
            yield f"*state[{place}:{place + slot.length - 1}]"
        place += slot.length
    if unit.numbers:
        yield f"*state[{place}:]"
