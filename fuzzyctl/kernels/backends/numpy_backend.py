"""numpy backend: programs printed as functions over blocks of points."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.expr import Expr, names_in
from fuzzyctl.kernels.backends import blocks, numpy_integrals
from fuzzyctl.kernels.program.printer import ARRAYS, INDENT, PRIMITIVES, block, set_functions, text
from fuzzyctl.kernels.program.program import (
    STATE,
    Accumulate,
    Between,
    Fold,
    Program,
    Quadrature,
)
from fuzzyctl.kernels.program.scalar import execute_all, point_text
from fuzzyctl.kernels.program.traversal import locals_of, parts, read, reads, writes

FloatArray = npt.NDArray[np.float64]

#: Points of a block: its temporaries stay in the processor's cache, which is 1.3 to 3 times faster than whole arrays.
BLOCK: Final = 16384
#: Arrays that one statement needs besides those that have names.
SPARE: Final = 4
#: Copies of places that are made where marks are sorted in among them.
_SORTED: Final = 4


class _QuietError(Exception):
    """Carries the first point of a block where no rule fires."""

    def __init__(self, index: int, output: str) -> None:
        super().__init__()
        self.index, self.output = index, output


def block_source(program: Program) -> str:
    """Return the text of the function `block(x0, ..., C, result)` over arrays; `result` is (n, results).

    An array is released after its last use, so that a block stays in the cache.
    """
    arguments = [*program.arguments, *([STATE] if program.state else []), "result"]
    lines = [f"def block({', '.join(arguments)}):"]
    for statement, dead in zip(program.body, _last_uses(program), strict=True):
        lines += block((statement,), ARRAYS, lambda condition, output: [f"refuse({condition}, {output!r})"])
        if dead:
            lines.append(f"{INDENT}del {', '.join(sorted(dead))}")
    lines += [f"{INDENT}result[:, {k}] = {text(r, ARRAYS)}" for k, r in enumerate(program.results)]
    return "\n".join(lines) + "\n"


def _last_uses(program: Program) -> list[set[str]]:
    """Return for each statement the names that are not used after it."""
    needed = set(program.arguments).union(*map(read, program.results))
    dead: list[set[str]] = []
    for named in reversed(_names(program)):
        dead.append(named - needed)
        needed |= named
    return dead[::-1]


def _names(program: Program) -> list[set[str]]:
    """Return for each statement the names that it gives or needs."""
    arrays = {STATE, *(name for name, _ in program.tables)}
    # Names inside of a loop over corners take memory up to the end.
    inside = [locals_of(s) if isinstance(s, Between) else set() for s in program.body]
    return [(writes(s) | reads(s) | inner) - arrays for s, inner in zip(program.body, inside, strict=True)]


def _most_alive(program: Program) -> int:
    """Return how many arrays are needed at the same time."""
    alive, most = set(program.arguments), 0
    for statement, named, dead in zip(program.body, _names(program), _last_uses(program), strict=True):
        alive |= named
        inner = len(statement.body) + len(statement.sums) if isinstance(statement, Accumulate) else 0
        if isinstance(statement, Fold):  # new values exist beside the old ones
            inner = 3 * len(parts(statement).inner)
        most = max(most, len(alive) + inner)
        alive -= dead
    return most


def _of_integrals(program: Program, tables: Mapping[str, FloatArray]) -> int:
    """Return how many more numbers of each point integrals need: their arguments, and places with marks."""
    integrals = [s for s in program.body if isinstance(s, Quadrature)]
    sizes = [len(s.given) + _SORTED * (len(tables[s.places]) + len(s.marks) if s.marks else 0) for s in integrals]
    return max(sizes, default=0)


def compile_batch(program: Program, input_names: Sequence[str]) -> Callable[..., None]:
    """Return the function that fills results (n, outputs) from points (n, inputs) and states (n, states) or None."""
    tables = {name: np.array(values) for name, values in program.tables}
    namespace: dict[str, Any] = {**_RUNTIME, **tables, **_sets(program, tables)}
    execute_all(block_source(program), namespace)
    of_block: Callable[..., None] = namespace["block"]
    numbers, integrals = _most_alive(program) + SPARE, _of_integrals(program, tables)
    # The stretches of integrals need four times as much as the block.
    memory = blocks.COMPUTED // 5 if integrals else blocks.COMPUTED
    size = max(min(BLOCK, memory // (8 * (numbers + integrals))), 1)

    def fill(points: FloatArray, states: FloatArray | None, results: FloatArray) -> None:
        with np.errstate(all="ignore"):
            for start in range(0, len(points), size):
                part = points[start : start + size]
                arguments = [*np.ascontiguousarray(part.T)]
                if states is not None:
                    arguments.append(states[start : start + size].T)
                try:
                    of_block(*arguments, results[start : start + size])
                except _QuietError as quiet:
                    raise NoRuleFiresError(quiet.output, point_text(input_names, part[quiet.index])) from None

    return fill


def _sets(program: Program, tables: Mapping[str, FloatArray]) -> dict[str, Any]:
    """Return the functions of arrays that are integrated."""
    functions: dict[str, Any] = {}
    for statement in program.body:
        if isinstance(statement, Quadrature):
            namespace: dict[str, Any] = {**_RUNTIME, **tables}
            source = "\n".join(set_functions(statement, ARRAYS)) + "\n"
            execute_all(source, namespace)
            function = namespace[statement.function]
            functions[statement.function] = numpy_integrals.SetFunction(function, len(statement.body))
            if statement.crossings is not None:
                functions[statement.crossing_function] = namespace[statement.crossing_function]
    return functions


def array_function(expr: Expr) -> Callable[..., FloatArray]:
    """Return the function of arrays that an expression is, its names in order of appearance as arguments."""
    names = ", ".join(dict.fromkeys(n.name for n in names_in(expr)))
    namespace: dict[str, Any] = dict(_RUNTIME)
    source = f"def function({names}):\n{INDENT}return {text(expr, ARRAYS)}\n"
    execute_all(source, namespace)
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
    clipped = np.atleast_1d(np.clip(x, float(knots[0]), float(knots[-1])))  # of a system called with a constant
    if len(knots) > 16:
        position = np.searchsorted(knots[1:], clipped, side="right")
        position[np.isnan(clipped)] = 0
    else:
        counted = np.zeros(len(clipped), dtype=np.uint8)
        for knot in knots[1:].tolist():
            np.add(counted, (clipped >= knot).view(np.uint8), out=counted)
        position = counted.astype(np.intp)
    rest: FloatArray = np.subtract(clipped, knots.take(position), out=clipped)
    return position * stride if stride != 1 else position, rest


def _primitive(name: str) -> Any:
    """Return a primitive for arrays from its text in the table."""
    primitive = PRIMITIVES[name]
    if primitive.numpy.isidentifier():
        return getattr(np, primitive.numpy)
    names: dict[str, Any] = {"where": np.where}
    exec(f"def {name}({', '.join(primitive.arguments.split())}): return {primitive.numpy}", names)  # noqa: S102 - a constant text
    return names[name]


#: The primitives for arrays.
FUNCTIONS: Final[Mapping[str, Any]] = {name: _primitive(name) for name in PRIMITIVES}

_RUNTIME: Final[dict[str, Any]] = {
    "__builtins__": {"range": range},
    "nan": np.nan,
    "inf": np.inf,
    "refuse": _refuse,
    "locate": _locate,
    "moments": numpy_integrals.moments,
    "half": numpy_integrals.half,
    "jumps": numpy_integrals.jumps,
    "marked": numpy_integrals.marked,
    "where": np.where,
    "logical_not": np.logical_not,
    "minimum": np.minimum,
    "maximum": np.maximum,
    **FUNCTIONS,
}
