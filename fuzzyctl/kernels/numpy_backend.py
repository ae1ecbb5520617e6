"""Programs as numpy functions over blocks of points: for arrays where no compiler is at hand."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from fuzzyctl.errors import NoRuleFiresError
from fuzzyctl.expr import Expr, names_in
from fuzzyctl.kernels.printer import ARRAYS, INDENT, block, text
from fuzzyctl.kernels.program import STATE, Program
from fuzzyctl.kernels.python_backend import point_text

FloatArray = npt.NDArray[np.float64]

#: Points of a block: its temporaries stay in the processor's cache, which is 1.3 to 3 times faster than whole arrays.
BLOCK: Final = 8192


class _QuietError(Exception):
    """Carries the first point of a block where no rule fires."""

    def __init__(self, index: int, output: str) -> None:
        super().__init__()
        self.index, self.output = index, output


def block_source(program: Program) -> str:
    """Return the text of the function `block(x0, ..., C, result)` over arrays; `result` is (n, results)."""
    arguments = [*program.arguments, *([STATE] if program.state else []), "result"]
    lines = [f"def block({', '.join(arguments)}):"]
    lines += block(program.body, ARRAYS, lambda condition, output: [f"refuse({condition}, {output!r})"])
    lines += [f"{INDENT}result[:, {k}] = {text(r, ARRAYS)}" for k, r in enumerate(program.results)]
    return "\n".join(lines) + "\n"


def compile_batch(program: Program, input_names: Sequence[str]) -> Callable[..., FloatArray]:
    """Return the function (points (n, inputs), state (rules, n) or None) -> results (n, outputs)."""
    namespace: dict[str, Any] = {**_RUNTIME, **{name: np.array(values) for name, values in program.tables}}
    exec(compile(block_source(program), "<fuzzyctl kernel>", "exec"), namespace)  # noqa: S102 - printed from a plan
    of_block: Callable[..., None] = namespace["block"]

    def batch(points: FloatArray, state: FloatArray | None) -> FloatArray:
        results = np.empty((len(points), len(program.results)))
        with np.errstate(all="ignore"):
            for start in range(0, len(points), BLOCK):
                part = points[start : start + BLOCK]
                arguments = [*np.ascontiguousarray(part.T)]
                if state is not None:
                    arguments.append(state[:, start : start + BLOCK])
                try:
                    of_block(*arguments, results[start : start + BLOCK])
                except _QuietError as quiet:
                    raise NoRuleFiresError(quiet.output, point_text(input_names, part[quiet.index])) from None
        return results

    return batch


def array_function(expr: Expr) -> Callable[..., FloatArray]:
    """Return the function of arrays that an expression is, its names in order of appearance as arguments."""
    names = ", ".join(dict.fromkeys(n.name for n in names_in(expr)))
    namespace: dict[str, Any] = dict(_RUNTIME)
    source = f"def function({names}):\n{INDENT}return {text(expr, ARRAYS)}\n"
    exec(compile(source, "<fuzzyctl expression>", "exec"), namespace)  # noqa: S102 - printed from a formula
    function: Callable[..., FloatArray] = namespace["function"]

    def quietly(*arrays: FloatArray) -> FloatArray:
        with np.errstate(all="ignore"):
            return function(*arrays)

    return quietly


def _refuse(condition: Any, output: str) -> None:
    if np.any(condition):
        raise _QuietError(int(np.argmax(np.atleast_1d(condition))), output)


def _locate(x: FloatArray, knots: FloatArray, stride: int) -> tuple[Any, FloatArray]:
    """Return the position of the knot at or below each value times a stride, and how far the value lies beyond it."""
    held = np.minimum(np.maximum(x, knots[0]), knots[-1])
    if len(knots) > 16:
        position = np.searchsorted(knots[1:], held, side="right")
        position[np.isnan(held)] = 0
    else:
        counted = np.zeros(len(held), dtype=np.uint8)
        for knot in knots[1:]:
            counted += held >= knot
        position = counted.astype(np.intp)
    rest: FloatArray = held - knots.take(position)
    return position * stride if stride != 1 else position, rest


_RUNTIME: Final[dict[str, Any]] = {
    "__builtins__": {"range": range, "abs": abs},
    "nan": np.nan,
    "inf": np.inf,
    "refuse": _refuse,
    "locate": _locate,
    "where": np.where,
    "logical_not": np.logical_not,
    "divide": np.divide,
    "minimum": np.minimum,
    "maximum": np.maximum,
    "smaller": lambda a, b: np.where(a < b, a, b),
    "larger": lambda a, b: np.where(a > b, a, b),
    "held": lambda x: np.where(x > 0.0, np.where(x < 1.0, x, 1.0), 0.0),
    "power": np.power,
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "atan2": np.arctan2,
}
