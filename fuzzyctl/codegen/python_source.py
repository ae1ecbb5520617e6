"""A unit as one Python module without imports beyond the standard library."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from inspect import getsource, isfunction
from typing import Final

from fuzzyctl.codegen.errors import CodegenError, unprintable
from fuzzyctl.codegen.names import PYTHON_FUNCTION_RESERVED, PYTHON_RESERVED, Names
from fuzzyctl.codegen.simplify import functions, renamed
from fuzzyctl.codegen.unit import Unit, described
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.program.ieee import FUNCTIONS
from fuzzyctl.kernels.program.printer import IEEE_SCALAR, INDENT, INTERPRETED, Dialect, block, index_text, text
from fuzzyctl.kernels.program.program import STATE, Locate, Place, Program, Quadrature

#: Functions that the printer writes as comparisons.
_PRINTED: Final = {"min", "max", "clip", "sign"}

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
    """Return the name of the module, which is that of its function."""
    return Names(PYTHON_FUNCTION_RESERVED).claim(unit.system.name)


def module(unit: Unit) -> str:
    """Return the text of NAME.py.

    It has the function NAME(inputs) that returns a number, or a tuple for several outputs; with a state
    NAME(inputs, state), `init()` that gives the first one, and `rates(inputs, state)` where something adapts. Where no
    rule fires for an output that says `else error`, it raises ArithmeticError.
    """
    name, flat = module_name(unit), unit.plan
    names = Names([*PYTHON_RESERVED, name])
    arguments = [names.claim(i.name) for i in flat.inputs]
    rates = inference.rates(flat) if flat.states else None
    require_no_integral(unit.algorithm.printed)
    programs = [("", unit.algorithm.printed), *([("R", rates)] if rates else [])]
    lines = [f"# {line}".rstrip() for line in described(unit)]
    lines += ["", "import math", "import sys", "from math import inf, nan", ""]
    lines += [f"INPUTS = {[i.name for i in flat.inputs]!r}", f"OUTPUTS = {[o.name for o in flat.outputs]!r}"]
    lines += [f"{prefix}{table} = {values!r}" for prefix, program in programs for table, values in program.tables]
    # Quotients of rates are those of the user, which may be 0/0.
    used = {f for _, p in programs for f in functions(p)} | ({"divide"} if rates else set())
    lines += ["", *helpers(used)]
    lines += ["", *_evaluation(unit, name, arguments)]
    if flat.initial_state:
        lines += ["", "", "def init():", f"{INDENT}return {list(flat.initial_state)!r}"]
    if rates is not None:
        lines += ["", "", *_rates(rates, arguments)]
    state = ", init()" if flat.initial_state else ""
    results = "result" if len(flat.outputs) > 1 else "[result]"
    lines += ["", _MAIN.format(function=name, state=state, results=results).rstrip("\n")]
    return "\n".join(lines) + "\n"


def require_no_integral(program: Program) -> None:
    """Refuse a program with an adaptive integral.

    Raises:
        CodegenError: For the first of them.
    """
    for statement in program.body:
        if isinstance(statement, Quadrature):
            raise unprintable(statement)


def helpers(used: set[str]) -> Iterator[str]:
    """Yield the text of the primitives that are called, and of what these call."""
    wanted = used - _PRINTED
    unknown = wanted - set(FUNCTIONS)
    if unknown:
        raise CodegenError(f"the function {min(unknown)!r} has no text in Python")
    wanted |= ({"divide"} if "power" in wanted else set()) | ({"decay"} if "exp" in wanted else set())
    for name in sorted(wanted - {"abs"}):
        yield (
            _plain(FUNCTIONS[name]) if isfunction(FUNCTIONS[name]) else f"\n{name} = math.{FUNCTIONS[name].__name__}\n"
        )


def _plain(function: Callable[..., float]) -> str:
    """Return the text of a function without types and docstring, which a module of numbers does not need."""
    tree = ast.parse(getsource(function))
    (own,) = tree.body
    assert isinstance(own, ast.FunctionDef), "primitives are functions"
    own.body, own.returns = own.body[1:], None
    for argument in own.args.args:
        argument.annotation = None
    return f"\n{ast.unparse(tree)}\n"


def _evaluation(unit: Unit, name: str, arguments: Sequence[str]) -> Iterator[str]:
    program = renamed(unit.algorithm.printed, arguments)
    dialect = _dialect(INTERPRETED, "")
    parameters = ", ".join([*arguments, *(["state"] if program.state else [])])
    yield f"def {name}({parameters}):"
    yield from _floats(arguments)
    yield from block(program.body, dialect, refusal)
    results = [text(r, dialect) for r in program.results]
    if not unit.plan.held:
        yield f"{INDENT}return {', '.join(results)}"
        return
    # What is held is kept in the state, as the kernels leave it to their caller.
    for k, result in enumerate(results):
        yield f"{INDENT}result{k} = {result}"
    for entry, o in enumerate(unit.plan.held, start=len(unit.plan.states)):
        yield f"{INDENT}state[{entry}] = result{o} if result{o} == result{o} else state[{entry}]"
    yield f"{INDENT}return {', '.join(f'result{k}' for k in range(len(results)))}"


def _rates(program: Program, arguments: Sequence[str]) -> Iterator[str]:
    dialect = _dialect(IEEE_SCALAR, "R")
    own = renamed(program, arguments)
    yield f"def rates({', '.join([*arguments, 'state'])}):"
    yield from _floats(arguments)
    yield from block(own.body, dialect, refusal)
    yield f"{INDENT}return [{', '.join(text(r, dialect) for r in own.results)}]"


def _floats(arguments: Sequence[str]) -> Iterator[str]:
    yield from (f"{INDENT}{a} = float({a})" for a in arguments)


def refusal(condition: str, output: str) -> list[str]:
    """Return lines that raise where no rule fires for an output."""
    return [f"if {condition}:", f"{INDENT}raise ArithmeticError({f'no rule fires for output {output!r}'!r})"]


def _dialect(base: Dialect, prefix: str) -> Dialect:
    """Return a dialect in which tables have a prefix, so that two programs stand in one module."""

    def item(array: str, index: int | str | Place) -> str:
        return f"{'state' if array == STATE else prefix + array}[{index_text(index)}]"

    def located(statement: Locate, x: str) -> list[str]:
        own = f"{statement.table}["
        return [line.replace(own, prefix + own) for line in base.locate(statement, x)]

    return replace(base, item=item, locate=located)
