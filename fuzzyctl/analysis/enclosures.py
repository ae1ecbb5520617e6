"""Enclosures of many boxes at once: between what a program's results lie, how steep they are, how far rounding goes.

The programs are those that kernels print; each operation is rounded outward by several ulp, so that an enclosure holds
the real value and what any backend computes, with the functions of any library.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from fuzzyctl.analysis import intervals
from fuzzyctl.expr import Binary, Call, Compare, Expr, Logic, Name, Negate, Number, Where
from fuzzyctl.kernels.program import STATE, Accumulate, Assign, Fold, Item, Place, Program, Quadrature, Refuse

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Truths = tuple[Mask, Mask]

#: What an operation may be off by, relative to its value: that of another form of the same program included.
_ULPS: Final = 8 * 2.0**-53
#: The same for library functions.
_LIBRARY: Final = 64 * 2.0**-53
#: Quotients of smaller numbers have lost their digits.
_LEAST: Final = 1e-290
_TINY: Final = 1e-300


@dataclass(frozen=True)
class Enclosure:
    """A value over some boxes.

    Args:
        lo, hi: What the real value, and the floats of kernels, lie between; shape (boxes,), or () for a constant.
        slopes: Two arrays of shape (inputs, boxes): between them lie the slopes of the real value along each input;
            infinite where it may jump; None for 0.
        error: How far floats may be from the real value.
    """

    lo: Array
    hi: Array
    slopes: tuple[Array, Array] | None
    error: Array

    @property
    def size(self) -> Array:
        """The largest magnitude."""
        return np.maximum(np.abs(self.lo), np.abs(self.hi))


def constant(low: float, high: float | None = None, *, error: float = 0.0) -> Enclosure:
    """Return the enclosure of a number, or of one that is only known to lie between two."""
    return Enclosure(np.array(low), np.array(low if high is None else high), None, np.array(error))


def boxes(lo: Array, hi: Array) -> list[Enclosure]:
    """Return the enclosure of each input over boxes whose ends have the shape (inputs, boxes)."""
    found = []
    for i in range(len(lo)):
        unit = np.zeros((len(lo), 1))
        unit[i] = 1.0
        found.append(Enclosure(lo[i], hi[i], (unit, unit), np.array(0.0)))
    return found


class Interpreter:
    """Encloses expressions.

    Args:
        names: What names stand for.
        call: What a function that the language does not know gives.
    """

    def __init__(
        self,
        names: Mapping[str, Enclosure],
        items: Callable[[Item], Enclosure] | None = None,
        call: Callable[[Call], Enclosure | None] | None = None,
    ) -> None:
        self.names, self.items, self.call = dict(names), items, call
        #: Boxes where what was computed has no value.
        self.void: Mask = np.array(False)

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
                return _BINARY[op](self.enclose(left), self.enclose(right))
            case Where():
                return self._where(expr)
            case Call(function=function, arguments=arguments):
                own = self.call(expr) if self.call is not None else None
                return own if own is not None else _call(function, [self.enclose(a) for a in arguments])
        raise TypeError(f"{type(expr).__name__} has no enclosure")

    def _where(self, expr: Where) -> Enclosure:
        yes, no = self.decide(expr.condition)
        # Claims are about points where there is a value: NaN counts as whatever the other side is.
        if _is_nan(expr.then):
            self.void = self.void | yes
            return self.enclose(expr.otherwise)
        if _is_nan(expr.otherwise):
            self.void = self.void | no
            return self.enclose(expr.then)
        if yes.all():
            return self.enclose(expr.then)
        if no.all():
            return self.enclose(expr.otherwise)
        return _chosen(yes, no, self.enclose(expr.then), self.enclose(expr.otherwise))

    def decide(self, condition: Expr) -> Truths:
        """Return where a condition surely holds, and where it surely does not."""
        match condition:
            case Compare(op="!=", left=left, right=right) if left == right:
                return np.array(False), np.array(True)  # whether it is NaN, which boxes never hold
            case Compare(op=op, left=left, right=right):
                return _compare(op, self.enclose(left), self.enclose(right))
            case Logic(op="not", operands=(operand,)):
                yes, no = self.decide(operand)
                return no, yes
            case Logic(op=op, operands=operands):
                found = [self.decide(o) for o in operands]
                yes, no = found[0]
                for y, n in found[1:]:
                    yes, no = (yes & y, no | n) if op == "and" else (yes | y, no & n)
                return yes, no
        raise TypeError(f"{type(condition).__name__} is no condition")

    def run(self, program: Program, wanted: Sequence[int]) -> list[Enclosure]:
        """Enclose some results of a program whose arguments have been given by name."""
        tables = dict(program.tables)
        for statement in program.body:
            match statement:
                case Assign(name=name, value=value):
                    self.names[name] = self.enclose(value)
                case Accumulate():
                    self._accumulate(statement, tables)
                case Fold(then=then):
                    # What is made of it is held within the hull of the sets; that is what is known.
                    self.names |= {s.name: _anything() for s in then}
                case Quadrature(found=found, area=area):
                    self.names |= {found: _anything(), area: _anything()}
                case Refuse():
                    pass  # claims are about points that have a value
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
        for own in statement.sums:
            self.names[own.name] = _summed(inner.enclose(own.value), statement.count)


def _anything() -> Enclosure:
    return _jumping(np.array(-np.inf), np.array(np.inf))


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
    rounding = count * _ULPS
    size = total(np.broadcast_to(e.size, np.broadcast_shapes(e.lo.shape, e.hi.shape)), -2) * rounding
    slopes = None
    if e.slopes is not None:
        slack = [total(np.abs(s), -2) * rounding for s in e.slopes]
        slopes = (total(e.slopes[0], -2) - slack[0], total(e.slopes[1], -2) + slack[1])
    lo, hi = total(e.lo, -2), total(e.hi, -2)
    below = np.where((lo >= 0.0) & (lo - size < 0.0), 0.0, lo - size)
    error = total(np.broadcast_to(e.error, e.size.shape), -2) + size
    return _sound(below, hi + size, slopes, error)


def _sound(lo: Array, hi: Array, slopes: tuple[Array, Array] | None, error: Array) -> Enclosure:
    """Return an enclosure in which what may be no number is any."""
    bad = np.isnan(lo) | np.isnan(hi)
    if bad.any():
        lo, hi = np.where(bad, -np.inf, lo), np.where(bad, np.inf, hi)
        error = np.where(bad, np.inf, error)
        if slopes is not None:
            slopes = np.where(bad, -np.inf, slopes[0]), np.where(bad, np.inf, slopes[1])
    if slopes is not None:
        slopes = (
            np.where(np.isnan(slopes[0]), -np.inf, slopes[0]),
            np.where(np.isnan(slopes[1]), np.inf, slopes[1]),
        )
    return Enclosure(lo, hi, slopes, np.where(np.isnan(error), np.inf, error))


def _outward(lo: Array, hi: Array) -> tuple[Array, Array]:
    return lo - np.abs(lo) * _ULPS, hi + np.abs(hi) * _ULPS


def _times(a: tuple[Array, Array], b: tuple[Array, Array]) -> tuple[Array, Array]:
    products = [x * y for x in a for y in b]
    lo = np.minimum(np.minimum(products[0], products[1]), np.minimum(products[2], products[3]))
    hi = np.maximum(np.maximum(products[0], products[1]), np.maximum(products[2], products[3]))
    return _outward(lo, hi)


def _slope_times(factor: tuple[Array, Array], slopes: tuple[Array, Array]) -> tuple[Array, Array]:
    """Multiply slopes; 0 times a slope that is not known is 0."""
    products = [np.where((x == 0.0) | (y == 0.0), 0.0, x * y) for x in factor for y in slopes]
    lo = np.minimum(np.minimum(products[0], products[1]), np.minimum(products[2], products[3]))
    hi = np.maximum(np.maximum(products[0], products[1]), np.maximum(products[2], products[3]))
    return _outward(lo, hi)


Slopes = tuple[Array, Array] | None


def _plus_slopes(a: Slopes, b: Slopes) -> Slopes:
    if a is None or b is None:
        return b if a is None else a
    return _outward(a[0] + b[0], a[1] + b[1])


def negative(a: Enclosure) -> Enclosure:
    """Enclose -a."""
    return Enclosure(-a.hi, -a.lo, None if a.slopes is None else (-a.slopes[1], -a.slopes[0]), a.error)


def plus(a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose a + b."""
    lo, hi = _outward(a.lo + b.lo, a.hi + b.hi)
    error = a.error + b.error + np.maximum(np.abs(lo), np.abs(hi)) * _ULPS
    return _sound(lo, hi, _plus_slopes(a.slopes, b.slopes), error)


def minus(a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose a - b."""
    return plus(a, negative(b))


def times(a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose a · b."""
    lo, hi = _times((a.lo, a.hi), (b.lo, b.hi))
    slopes = _plus_slopes(
        None if b.slopes is None else _slope_times((a.lo, a.hi), b.slopes),
        None if a.slopes is None else _slope_times((b.lo, b.hi), a.slopes),
    )
    error = a.size * b.error + b.size * a.error + a.error * b.error + np.maximum(np.abs(lo), np.abs(hi)) * _ULPS
    return _sound(lo, hi, slopes, error)


def square(a: Enclosure) -> Enclosure:
    """Enclose a², which is not negative."""
    ends = a.lo * a.lo, a.hi * a.hi
    inside = (a.lo <= 0.0) & (a.hi >= 0.0)
    lo, hi = _outward(np.where(inside, 0.0, np.minimum(*ends)), np.maximum(*ends))
    slopes = None if a.slopes is None else _slope_times((2.0 * a.lo, 2.0 * a.hi), a.slopes)
    return _sound(lo, hi, slopes, (2.0 * a.size + a.error) * a.error + hi * _ULPS)


def divided(a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose a / b; anything where b may be 0, or so small that its digits are lost."""
    bad = (b.lo <= _LEAST) & (b.hi >= -_LEAST)
    low, high = np.where(bad, 1.0, b.lo), np.where(bad, 1.0, b.hi)
    inverse = 1.0 / high, 1.0 / low
    products = [x / y for x in (a.lo, a.hi) for y in (low, high)]
    lo = np.minimum(np.minimum(products[0], products[1]), np.minimum(products[2], products[3]))
    hi = np.maximum(np.maximum(products[0], products[1]), np.maximum(products[2], products[3]))
    lo, hi = _outward(np.where(bad, np.nan, lo), np.where(bad, np.nan, hi))
    slopes = None
    above = a.slopes
    if b.slopes is not None:
        above = _plus_slopes(above, _slope_times((-hi, -lo), b.slopes))
    if above is not None:
        slopes = _slope_times(_outward(*inverse), above)
    least = np.minimum(np.abs(low), np.abs(high))
    size = np.maximum(np.abs(lo), np.abs(hi))
    rest = least - b.error
    error = np.where(rest > 0.0, (a.error + size * b.error) / np.where(rest > 0.0, rest, 1.0), np.inf)
    return _sound(lo, hi, slopes, error + size * _ULPS)


def _quotient_held(q: Enclosure, low: Enclosure, high: Enclosure) -> Enclosure:
    return smaller(larger(q, low), high)


def smaller(a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose min(a, b)."""
    slopes = _either(a.hi <= b.lo, b.hi <= a.lo, a.slopes, b.slopes)
    return Enclosure(np.minimum(a.lo, b.lo), np.minimum(a.hi, b.hi), slopes, _larger_error(a, b))


def larger(a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose max(a, b)."""
    return negative(smaller(negative(a), negative(b)))


def _larger_error(a: Enclosure, b: Enclosure) -> Array:
    """Return the error of the smaller or the larger of two values, which differs by what both lie between at most."""
    return np.maximum(a.error, b.error)


def _either(first: Mask, second: Mask, a: Slopes, b: Slopes) -> Slopes:
    """Return slopes of one, of the other, or of both where it is not clear which counts."""
    if a is None and b is None:
        return None
    zero = np.zeros((1, 1))
    a, b = a or (zero, zero), b or (zero, zero)
    lo = np.where(first, a[0], np.where(second, b[0], np.minimum(a[0], b[0])))
    hi = np.where(first, a[1], np.where(second, b[1], np.maximum(a[1], b[1])))
    return lo, hi


def _chosen(yes: Mask, no: Mask, a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose a choice; where it is not clear which, the value may jump."""
    lo = np.where(yes, a.lo, np.where(no, b.lo, np.minimum(a.lo, b.lo)))
    hi = np.where(yes, a.hi, np.where(no, b.hi, np.maximum(a.hi, b.hi)))
    open_ = ~(yes | no)
    error = np.where(yes, a.error, np.where(no, b.error, hi - lo))
    slopes = _either(yes, no, a.slopes, b.slopes)
    if open_.any():
        low, high = slopes or (np.zeros((1, 1)), np.zeros((1, 1)))
        slopes = np.where(open_, -np.inf, low), np.where(open_, np.inf, high)
    return Enclosure(lo, hi, slopes, error)


def _compare(op: str, a: Enclosure, b: Enclosure) -> Truths:
    match op:
        case "<":
            return a.hi < b.lo, a.lo >= b.hi
        case "<=":
            return a.hi <= b.lo, a.lo > b.hi
        case ">" | ">=":
            return _compare("<" if op == ">" else "<=", b, a)
        case "==":
            return (a.lo == a.hi) & (b.lo == b.hi) & (a.lo == b.lo), (a.hi < b.lo) | (b.hi < a.lo)
    yes, no = _compare("==", a, b)
    return no, yes


def _call(function: str, a: list[Enclosure]) -> Enclosure:
    match function:
        case "min" | "max" | "smaller" | "larger":
            join = smaller if function in ("min", "smaller") else larger
            found = a[0]
            for other in a[1:]:
                found = _unless_nan(join(found, other), other)
            return found
        case "divide":
            return divided(a[0], a[1])
        case "clip":
            return _quotient_held(a[0], a[1], a[2])
        case "held":
            return _quotient_held(a[0], constant(0.0), constant(1.0))
        case "abs":
            return larger(a[0], negative(a[0]))
        case "exp":
            return _exp(a[0])
        case "sqrt":
            return _sqrt(a[0])
        case "sign":
            return _sign(a[0])
        case "log" | "sin" | "cos":
            return _by_scalars(function, a[0])
        case "atan2" | "tan":
            values = _scalars(lambda *x: intervals._call(function, list(x)), a)
            return _jumping(*values)
    raise TypeError(f"function {function!r} has no enclosure")


def _unless_nan(found: Enclosure, second: Enclosure) -> Enclosure:
    """Return a smaller or larger value; what may be NaN, the second operand hands on."""
    bad = np.isneginf(second.lo) & np.isposinf(second.hi)
    if not bad.any():
        return found
    return _sound(np.where(bad, np.nan, found.lo), found.hi, found.slopes, found.error)


def _exp(a: Enclosure) -> Enclosure:
    low, high = np.exp(a.lo), np.exp(a.hi)
    lo = np.where(low < _TINY, 0.0, low * (1.0 - _LIBRARY))
    hi = np.where(high < _TINY, np.where(a.hi < -800.0, 0.0, _TINY), high * (1.0 + _LIBRARY))
    lo, hi = np.where(a.lo == 0.0, 1.0, lo), np.where(a.hi == 0.0, 1.0, hi)
    slopes = None if a.slopes is None else _slope_times((lo, hi), a.slopes)
    return _sound(lo, hi, slopes, hi * (np.expm1(np.minimum(a.error, 1.0)) * 1.01 + _LIBRARY))


def _sqrt(a: Enclosure) -> Enclosure:
    lo, hi = _outward(np.sqrt(a.lo), np.sqrt(a.hi))
    with_root = np.where(lo > 0.0, lo, 1.0)
    slopes = None
    if a.slopes is not None:
        steep = np.where(lo > 0.0, 0.5 / with_root, np.inf) * (1.0 + _ULPS)
        slopes = _slope_times((0.5 / np.where(hi > 0.0, hi, 1.0) * (1.0 - _ULPS), steep), a.slopes)
    error = np.where(lo * lo > 2.0 * a.error, a.error / with_root, np.sqrt(3.0 * a.error)) + hi * _ULPS
    return _sound(lo, hi, slopes, error)


def _sign(a: Enclosure) -> Enclosure:
    return _jumping(np.sign(a.lo), np.sign(a.hi))


def _jumping(lo: Array, hi: Array) -> Enclosure:
    """Return an enclosure of which only the ends are known."""
    flat = lo == hi
    steep = np.where(flat, 0.0, np.inf)[None]
    return _sound(lo, hi, (-steep, steep), hi - lo)


def _scalars(function: Callable[..., intervals.Interval], a: Sequence[Enclosure]) -> tuple[Array, Array]:
    """Apply a function of intervals box by box."""
    ends = np.broadcast_arrays(*(x for e in a for x in (e.lo, e.hi)))
    shape = ends[0].shape
    flat = [e.reshape(-1).tolist() for e in ends]
    found = [function(*((row[2 * k], row[2 * k + 1]) for k in range(len(a)))) for row in zip(*flat, strict=True)]
    values = np.array(found, dtype=np.float64).reshape((*shape, 2))
    return values[..., 0], values[..., 1]


def _by_scalars(function: str, a: Enclosure) -> Enclosure:
    lo, hi = _scalars(lambda x: intervals._call(function, [x]), [a])
    if function == "log":
        steep = divided(constant(1.0), Enclosure(a.lo, a.hi, None, np.array(0.0)))
        derivative = steep.lo, steep.hi
    else:
        other = "cos" if function == "sin" else "sin"
        derivative = _scalars(lambda x: intervals._call(other, [x]), [a])
        if function == "cos":
            derivative = -derivative[1], -derivative[0]
    return _through(a, lo, hi, derivative)


def _through(a: Enclosure, lo: Array, hi: Array, derivative: tuple[Array, Array]) -> Enclosure:
    """Return a function of a with given values and derivatives."""
    slopes = None if a.slopes is None else _slope_times(derivative, a.slopes)
    steep = np.maximum(np.abs(derivative[0]), np.abs(derivative[1]))
    error = np.where(a.error == 0.0, 0.0, steep * a.error * 2.0) + np.maximum(np.abs(lo), np.abs(hi)) * _LIBRARY
    return _sound(lo, hi, slopes, error)


def power(a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose a^b; slopes are known for exponents that are numbers."""
    lo, hi = _scalars(intervals._power, [a, b])
    if b.slopes is not None or (b.lo != b.hi).any():
        return _jumping(lo, hi)
    lower = _scalars(intervals._power, [a, Enclosure(b.lo - 1.0, b.hi - 1.0, None, b.error)])
    derivative = _times((b.lo, b.hi), lower)
    bad = np.isnan(derivative[0]) | np.isnan(derivative[1])
    return _through(a, lo, hi, (np.where(bad, -np.inf, derivative[0]), np.where(bad, np.inf, derivative[1])))


_BINARY: Final[dict[str, Callable[[Enclosure, Enclosure], Enclosure]]] = {
    "+": plus,
    "-": minus,
    "*": times,
    "/": divided,
    "^": power,
}
