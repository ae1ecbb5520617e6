"""Interval evaluation of kernel programs over many boxes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np

from fuzzyctl.expr import Binary, Call, Compare, Expr, Logic, Name, Negate, Number, Where
from fuzzyctl.kernels.interval.vector import (
    ULPS,
    Array,
    Enclosure,
    Mask,
    Truths,
    applied,
    chosen,
    compared,
    constant,
    divided,
    jumping,
    minus,
    negative,
    plus,
    power,
    sound,
    square,
    times,
)
from fuzzyctl.kernels.program.program import STATE, Accumulate, Assign, Fold, Item, Place, Program, Quadrature, Refuse


class Interpreter:
    """Encloses expressions.

    Args:
        names: Enclosures by name.
        items: Enclosures of numbers of arrays; None without arrays.
        call: Encloses a function that the language does not know.
        sparse: Whether a value that is 0 in all boxes counts as the number 0, so that it costs no further work. Its
            slopes are then those within the boxes: 0 along a side without width, too.
    """

    def __init__(
        self,
        names: Mapping[str, Enclosure],
        items: Callable[[Item], Enclosure] | None = None,
        call: Callable[[Call], Enclosure | None] | None = None,
        *,
        sparse: bool = False,
    ) -> None:
        self.names, self.items, self.call, self.sparse = dict(names), items, call, sparse
        #: Boxes in which a value does not exist, and those in which there may be points without one.
        self.void: Mask = np.array(False)
        self.gaps: Mask = np.array(False)

    def enclose(self, expr: Expr) -> Enclosure:
        """Enclose an expression."""
        match expr:
            case Number(value=value):
                return constant(value)
            case Name(name=name):
                return self.names[name]
            case Item() if self.items is not None:
                return self.items(expr)
            case Negate(operand=operand):
                return negative(self.enclose(operand))
            case Binary(op="*", left=left, right=right) if left == right:
                return square(self.enclose(left))
            case Binary(op=op, left=left, right=right):
                return self._binary(op, self.enclose(left), self.enclose(right))
            case Where():
                return self._where(expr)
            case Call(function=function, arguments=arguments):
                enclosure = self.call(expr) if self.call is not None else None
                return enclosure if enclosure is not None else applied(function, [self.enclose(a) for a in arguments])
        raise TypeError(f"{type(expr).__name__} has no enclosure")

    def _binary(self, op: str, a: Enclosure, b: Enclosure) -> Enclosure:
        if self.sparse and op in ("+", "*"):
            for zero, other in ((a, b), (b, a)):
                if zero is _ZERO and (op == "+" or bool(np.all(np.isfinite(other.lo) & np.isfinite(other.hi)))):
                    return other if op == "+" else zero
        return _BINARY[op](a, b)

    def _where(self, expr: Where) -> Enclosure:
        return self._chosen(expr, *self.decide(expr.condition))

    def _chosen(self, expr: Where, yes: Mask, no: Mask) -> Enclosure:
        """Enclose a choice whose condition surely holds in some boxes, and surely does not in others."""
        # Claims are about points where there is a value: NaN counts as whatever the other side is.
        if _is_nan(expr.then):
            self.void, self.gaps = self.void | yes, self.gaps | ~no
            return self.enclose(expr.otherwise)
        if _is_nan(expr.otherwise):
            self.void, self.gaps = self.void | no, self.gaps | ~yes
            return self.enclose(expr.then)
        if yes.all():
            return self.enclose(expr.then)
        if no.all():
            return self.enclose(expr.otherwise)
        return chosen(yes, no, self.enclose(expr.then), self.enclose(expr.otherwise))

    def decide(self, condition: Expr) -> Truths:
        """Return where a condition surely holds, and where it surely does not."""
        match condition:
            case Compare(op="!=", left=left, right=right) if left == right:
                return np.array(False), np.array(True)  # whether it is NaN, which boxes never hold
            case Compare(op=op, left=left, right=right):
                return compared(op, self.enclose(left), self.enclose(right))
            case Logic(op="not", operands=(operand,)):
                yes, no = self.decide(operand)
                return no, yes
            case Logic(op=op, operands=operands):
                truths = [self.decide(o) for o in operands]
                yes, no = truths[0]
                for y, n in truths[1:]:
                    yes, no = (yes & y, no | n) if op == "and" else (yes | y, no & n)
                return yes, no
        raise TypeError(f"{type(condition).__name__} is no condition")

    def run(self, program: Program, wanted: Sequence[int]) -> list[Enclosure]:
        """Enclose some results of a program whose arguments have been given by name."""
        tables = dict(program.tables)
        for statement in program.body:
            match statement:
                case Assign(name=name, value=value):
                    enclosure = self.enclose(value)
                    is_zero = self.sparse and not (np.any(enclosure.lo) or np.any(enclosure.hi))
                    self.names[name] = _ZERO if is_zero else enclosure
                case Accumulate():
                    self._accumulate(statement, tables)
                case Fold(then=then):
                    # The result is clamped to the hull of the sets, which is all that is known.
                    self.names |= {s.name: _anything() for s in then}
                case Quadrature(found=found, area=area):
                    self.names |= {found: _anything(), area: _anything()}
                case Refuse(condition=condition):  # claims are about points that have a value
                    self.gaps = self.gaps | ~self.decide(condition)[1]
                case _:
                    raise TypeError(f"{type(statement).__name__} has no enclosure")
        return [self.enclose(program.results[k]) for k in wanted]

    def _accumulate(self, statement: Accumulate, tables: Mapping[str, tuple[float, ...]]) -> None:
        """Enclose a loop: its entries are an axis before that of the boxes."""

        def items(item: Item) -> Enclosure:
            if item.array == STATE or isinstance(item.index, int | Place):
                assert self.items is not None
                return _spread(self.items(item))
            values = np.array(tables[item.array])[:, None]
            return Enclosure(values, values, None, np.array(0.0))

        inner = Interpreter({n: _spread(e) for n, e in self.names.items()}, items)
        for assignment in statement.body:
            inner.names[assignment.name] = inner.enclose(assignment.value)
        for assign in statement.sums:
            self.names[assign.name] = _summed(inner.enclose(assign.value), statement.count)


_ZERO: Final = constant(0.0)


def _anything() -> Enclosure:
    return jumping(np.array(-np.inf), np.array(np.inf))


def _is_nan(expr: Expr) -> bool:
    return isinstance(expr, Number) and math.isnan(expr.value)


def _spread(e: Enclosure) -> Enclosure:
    def wide(array: Array) -> Array:
        return array[..., None, :] if array.ndim else array

    slopes = None if e.slopes is None else (wide(e.slopes[0]), wide(e.slopes[1]))
    return Enclosure(wide(e.lo), wide(e.hi), slopes, wide(e.error))


def _summed(e: Enclosure, count: int) -> Enclosure:
    def total(array: Array, axis: int) -> Array:
        shape = list(array.shape)
        if len(shape) > -axis - 1 and shape[axis] == 1:
            return np.asarray(np.squeeze(array, axis) * count)
        return np.asarray(array.sum(axis=axis))

    if e.lo.ndim < 2:
        e = Enclosure(np.broadcast_to(e.lo, (1, 1)), np.broadcast_to(e.hi, (1, 1)), e.slopes, e.error)
    rounding = count * ULPS
    size = total(np.broadcast_to(e.size, np.broadcast_shapes(e.lo.shape, e.hi.shape)), -2) * rounding
    slopes = None
    if e.slopes is not None:
        slack = [total(np.abs(s), -2) * rounding for s in e.slopes]
        slopes = (total(e.slopes[0], -2) - slack[0], total(e.slopes[1], -2) + slack[1])
    lo, hi = total(e.lo, -2), total(e.hi, -2)
    below = np.where((lo >= 0.0) & (lo - size < 0.0), 0.0, lo - size)
    error = total(np.broadcast_to(e.error, e.size.shape), -2) + size
    return sound(below, hi + size, slopes, error)


_BINARY: Final[dict[str, Callable[[Enclosure, Enclosure], Enclosure]]] = {
    "+": plus,
    "-": minus,
    "*": times,
    "/": divided,
    "^": power,
}
