"""Python backend: programs printed as plain functions, without compiler and numpy."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final

from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.kernels.program.printer import IEEE_SCALAR, INDENT, INTERPRETED, SCALAR, Dialect, block, text
from fuzzyctl.kernels.program.program import STATE, Program
from fuzzyctl.kernels.program.scalar import RUNTIME, execute

#: Name of the array argument that a storing function writes to.
RESULT: Final = "result"


def evaluation_source(program: Program) -> str:
    """Return the text of the function `kernel(x0, ..., C)` that returns the outputs."""
    results = ", ".join(text(r, SCALAR) for r in program.results)
    end = f"return {results}" if len(program.results) == 1 else f"return ({results})"
    return _function("kernel", program, [], [end], INTERPRETED)


def storing_source(program: Program) -> str:
    """Return the text of the function `store(x0, ..., C, result)` that writes its results into `result`."""
    end = [f"{RESULT}[{k}] = {text(r, IEEE_SCALAR)}" for k, r in enumerate(program.results)]
    return _function("store", program, [RESULT], end, IEEE_SCALAR)


def _function(name: str, program: Program, extra: list[str], end: list[str], dialect: Dialect) -> str:
    arguments = [*program.arguments, *([STATE] if program.state else []), *extra]
    lines = [f"def {name}({', '.join(arguments)}):", *_conversions(program), *_body(program, dialect)]
    return "\n".join([*lines, *(INDENT + line for line in end)]) + "\n"


def _conversions(program: Program) -> list[str]:
    # The check is a tenth of the price of a conversion, and nearly all arguments are floats already.
    return [f"{INDENT}if type({x}) is not float: {x} = as_number({x})" for x in program.arguments]


def _body(program: Program, dialect: Dialect) -> Iterator[str]:
    point = ", ".join(program.arguments)
    return block(
        program.body, dialect, lambda condition, o: [f"if {condition}: raise no_rule_fires({o!r}, ({point},))"]
    )


def compile_source(source: str, program: Program, input_names: Sequence[str]) -> Callable[..., Any]:
    """Turn the text of a function into the function."""
    namespace: dict[str, Any] = {**RUNTIME, **dict(program.tables)}

    def no_rule_fires(output: str, point: Sequence[float]) -> NoRuleFiresError:
        return NoRuleFiresError(output, point_text(input_names, point))

    namespace["no_rule_fires"] = no_rule_fires
    return execute(source, namespace)


def point_text(names: Sequence[str], point: Sequence[float]) -> str:
    """Return a point for people: `sigma = 0.1, dsigma = -2`."""
    return ", ".join(f"{n} = {float(x):.6g}" for n, x in zip(names, point, strict=True))
