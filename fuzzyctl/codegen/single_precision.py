"""Interpreter of programs in single precision under several roundings: the results that a correct target may have.

Every result that single precision does not have is rounded to the nearest in the first lane and up or down at random in
the others (the method of Vignes, CESTAC). Where lanes are apart, rounding decides, and targets may differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.simplify import FALSE, TRUE
from fuzzyctl.expr import Binary, Call, Compare, Expr, Logic, Name, Negate, Number, Where
from fuzzyctl.kernels.backends.numpy_backend import FUNCTIONS
from fuzzyctl.kernels.program.printer import ALIASES
from fuzzyctl.kernels.program.program import (
    Accumulate,
    Assign,
    Fold,
    Item,
    Locate,
    Offset,
    Place,
    Program,
    Refuse,
    Statement,
)

Numbers = NDArray[np.float64]

#: Roundings per value: one to the nearest, the others at random.
LANES: Final = 6
#: Numbers at once, points times lanes times entries of the longest loop.
_AT_ONCE: Final = 1 << 20

_OPERATORS: Final[dict[str, Any]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "^": FUNCTIONS["power"],
}
_SIGNS: Final[dict[str, Any]] = {
    "<": np.less,
    ">": np.greater,
    "<=": np.less_equal,
    ">=": np.greater_equal,
    "==": np.equal,
    "!=": np.not_equal,
}


class Roundings:
    """Run one program in every lane.

    Args:
        program: Without tests for NaN of its arguments; see `lean`.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        self._random = np.random.RandomState(1)  # whose stream never changes, as that of newer generators may
        self._tables = {name: nearest(values) for name, values in program.tables}
        self._values: dict[str, Any] = {}
        self._refused: NDArray[np.str_] = np.array("")

    def run(self, points: Numbers, state: Sequence[Numbers] = ()) -> tuple[list[Numbers], NDArray[np.str_]]:
        """Return each result, and the outputs that refuse, in every lane.

        Args:
            points: Of shape (points, arguments) without those of the state, as single precision has them.
            state: Arguments of the state, each of shape (points, lanes).

        Returns:
            Results of shape (points, lanes), and names of the same shape, empty for accepted values.
        """
        loops = [s.count for s in self.program.body if isinstance(s, Accumulate | Fold)]
        size = max(1, _AT_ONCE // (LANES * max([1, *loops])))
        starts = range(0, len(points), size)
        with np.errstate(all="ignore"):
            parts = [self._part(points[s : s + size], [e[s : s + size] for e in state]) for s in starts]
        results = [np.concatenate([p[0][k] for p in parts]) for k in range(len(self.program.results))]
        return results, np.concatenate([p[1] for p in parts])

    def _part(self, points: Numbers, state: list[Numbers]) -> tuple[list[Numbers], NDArray[np.str_]]:
        columns = [np.repeat(points[:, i : i + 1], LANES, axis=1) for i in range(points.shape[1])]
        self._values = {**self._tables, **dict(zip(self.program.arguments, [*columns, *state], strict=True))}
        self._refused = np.full((len(points), LANES), "", dtype="U200")
        for statement in self.program.body:
            self._do(statement)
        shape = self._refused.shape
        return [np.broadcast_to(self._value(r), shape) for r in self.program.results], self._refused

    def _do(self, statement: Statement) -> None:
        match statement:
            case Assign(name=name, value=value):
                self._values[name] = self._value(value)
            case Locate():
                self._locate(statement)
            case Offset(name=name, parts=parts):
                self._values[name] = sum(s * self._values[n] for n, s in parts)
            case Accumulate():
                self._add_up(statement)
            case Fold(count=count, counter=counter, first=first, body=body, then=then):
                for s in first:
                    self._do(s)
                for k in range(count):
                    self._values[counter] = k
                    for s in (*body, *then):
                        self._do(s)
            case Refuse(condition=condition, output=output):
                new = np.broadcast_to(self._truth(condition), self._refused.shape) & (self._refused == "")
                self._refused[new] = output
            case _:
                raise CodegenError(f"a statement {type(statement).__name__} has no single precision")

    def _locate(self, statement: Locate) -> None:
        knots, x = nearest(statement.knots), self._value(statement.x)
        position = np.where(x < knots[0], knots[0], np.where(x > knots[-1], knots[-1], x))
        place = np.searchsorted(knots, position, side="right") - 1
        self._values[statement.name] = statement.stride * place
        self._values[statement.rest] = self._rounded(position - knots[place])

    def _add_up(self, statement: Accumulate) -> None:
        """Compute the summands of all entries at once, and add them one after the other."""
        self._values[statement.counter] = np.arange(statement.count)[:, None, None]
        for s in statement.body:
            self._do(s)
        for s in statement.sums:
            rows = np.broadcast_to(self._value(s.value), (statement.count, *self._refused.shape))
            total = np.zeros(self._refused.shape)
            for row in rows:
                total = self._rounded(total + row)
            self._values[s.name] = total

    def _value(self, expr: Expr) -> Any:
        match expr:
            case Number(value=value):
                return nearest(value)
            case Name(name=name):
                return self._values[name]
            case Item(array=array, index=index):
                return self._item(array, index)
            case Negate(operand=operand):
                return -self._value(operand)
            case Binary(op=op, left=left, right=right):
                return self._rounded(_OPERATORS[op](self._value(left), self._value(right)))
            case Where(condition=condition, then=then, otherwise=otherwise):
                return np.where(self._truth(condition), self._value(then), self._value(otherwise))
            case Call(function=function, arguments=arguments) if ALIASES.get(function, function) in FUNCTIONS:
                return self._rounded(FUNCTIONS[ALIASES.get(function, function)](*map(self._value, arguments)))
        raise CodegenError(f"a {type(expr).__name__} has no single precision")

    def _item(self, array: str, index: int | str | Place) -> Any:
        if isinstance(index, Place):
            return self._values[array][self._values[index.name] + index.steps]
        return self._values[array][self._values[index] if isinstance(index, str) else index]

    def _truth(self, expr: Expr) -> Any:
        if expr in (TRUE, FALSE):
            return np.bool_(expr == TRUE)
        match expr:
            case Compare(op=op, left=left, right=right):
                return _SIGNS[op](self._value(left), self._value(right))
            case Logic(op="not", operands=(operand,)):
                return ~self._truth(operand)
            case Logic(op=op, operands=operands):
                join = np.logical_and if op == "and" else np.logical_or
                truth = self._truth(operands[0])
                for operand in operands[1:]:
                    truth = join(truth, self._truth(operand))
                return truth
        raise CodegenError(f"a {type(expr).__name__} is not a condition")

    def _rounded(self, values: Any) -> Any:
        """Round to the nearest in the first lane, up or down at random in the others."""
        near = nearest(values)
        if near.ndim == 0 or near.shape[-1] != LANES:
            return near
        beyond = np.nextafter(near.astype(np.float32), np.where(values > near, np.inf, -np.inf).astype(np.float32))
        chosen = (values != near) & np.isfinite(near) & (self._random.random_sample(near.shape) < 0.5)
        chosen[..., 0] = False
        return np.where(chosen, beyond.astype(np.float64), near)


def nearest(values: Any) -> Any:
    """Return numbers as single precision has them."""
    with np.errstate(all="ignore"):
        return np.asarray(np.asarray(values, dtype=np.float64).astype(np.float32), dtype=np.float64)
