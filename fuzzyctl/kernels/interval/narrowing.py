"""Interval evaluation that uses conditions: each branch of a choice narrows the names of its condition.

The condition is propagated backwards through arithmetic and through the definitions of names, as hull consistency does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import product
from typing import Final

import numpy as np

from fuzzyctl.expr import COMPARISONS, Binary, Call, Compare, Expr, Logic, Name, Negate, Number, Where, names_in, walk
from fuzzyctl.kernels.interval.program import Interpreter
from fuzzyctl.kernels.interval.vector import (
    ULPS,
    Array,
    Enclosure,
    Mask,
    Truths,
    applied,
    compared,
    divided,
    least_and_largest,
    minus,
    plus,
    sound,
    times,
)

#: Most conjunctions that a condition is written as.
_MOST_CASES: Final = 8
#: Most definitions that a condition is propagated through, one inside the other.
_DEEPEST: Final = 12
#: Products and quotients below it may have lost their digits.
_TINY: Final = 1e-300
#: Most parts of the end and the factor of a lag.
_SHORT: Final = 12

_NEGATED: Final = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
_TURNED: Final = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "=="}

Ends = tuple[Array, Array]


class NarrowingInterpreter(Interpreter):
    """Encloses expressions whose names are defined by other expressions.

    Args:
        names: Enclosures by name.
        definitions: Definitions by name; those without a definition are arguments.
        nearest: Whether only the values of kernels are enclosed, with arithmetic that rounds to nearest as theirs does,
            and not the real values; slopes are not known then.
    """

    def __init__(
        self, names: Mapping[str, Enclosure], definitions: Mapping[str, Expr], *, nearest: bool = False
    ) -> None:
        super().__init__(names)
        self.definitions, self.nearest = definitions, nearest

    def enclose(self, expr: Expr) -> Enclosure:
        """Enclose an expression; two forms of first-order lags more tightly than their parts are."""
        match expr:
            case Binary(op=op, left=left, right=right) if self.nearest and op in _NEAREST:
                a = self.enclose(left)
                enclosure = _nearest(op, a, a if left == right else self.enclose(right))
            case Call(function=function, arguments=arguments) if function not in COMPARISONS:
                parts = [self.enclose(a) for a in arguments]
                lacks = np.logical_or.reduce([*np.broadcast_arrays(*map(may_be_nan, parts))])
                return _lost(applied(function, parts), lacks)
            case _:
                enclosure = super().enclose(expr)
        match expr:
            case Binary(op="+"):
                return self._lag(expr, enclosure)
            case Binary(op="/", left=Name() | Number() as part, right=Binary(op="+", left=left, right=right)) if (
                part in (left, right)
            ):
                share, rest = self.enclose(part), self.enclose(left if part == right else right)
                inside = (share.lo > 0.0) & (rest.lo >= 0.0) & ~may_be_nan(enclosure)
                return _held(enclosure, np.where(inside, 0.0, -np.inf), np.where(inside, 1.0, np.inf))
        return enclosure

    def _lag(self, expr: Binary, enclosure: Enclosure) -> Enclosure:
        """Hold a sum of the form x + part · (y - x), of a part that is written shortly, between x and y."""
        match expr:
            case Binary(
                left=Name() as start, right=Binary(op="*", left=part, right=Binary(op="-", left=end) as way)
            ) if way.right == start and len(walk(part)) + len(walk(end)) <= _SHORT:
                return self._between(enclosure, self.enclose(start), self.enclose(end), self.enclose(part))
        return enclosure

    def _between(self, enclosure: Enclosure, start: Enclosure, end: Enclosure, part: Enclosure) -> Enclosure:
        """Hold start + part · (end - start) between start and end where the part is one of the whole.

        Where the end is above the start, rounding leaves the sum above the start, too; it may pass the end.
        """
        inside = (part.lo >= 0.0) & (part.hi <= 1.0) & np.isfinite(enclosure.size)  # no difference overflows
        slack = ULPS * (start.size + end.size)
        lo, hi = np.minimum(start.lo, end.lo - slack), np.maximum(start.hi, end.hi + slack)
        return _held(enclosure, np.where(inside, lo, -np.inf), np.where(inside, hi, np.inf))

    def decide(self, condition: Expr) -> Truths:
        """Return where a condition surely holds, and where it surely does not; NaN differs from all numbers."""
        if not isinstance(condition, Compare):
            return super().decide(condition)
        left, right = self.enclose(condition.left), self.enclose(condition.right)
        sure = ~(may_be_nan(left) | may_be_nan(right))
        if condition.left == condition.right:
            never = np.zeros_like(sure)
            return (never, sure) if condition.op in ("!=", "<", ">") else (sure, never)
        yes, no = compared(condition.op, left, right)
        return yes & (sure | (condition.op == "!=")), no

    def _where(self, expr: Where) -> Enclosure:
        yes, no = self.decide(expr.condition)
        whole = self._chosen(expr, yes, no)
        open_ = ~(yes | no)
        if not open_.any():
            return whole
        cases = [
            (case, value)
            for value, wanted in ((expr.then, True), (expr.otherwise, False))
            for case in alternatives(expr.condition, wanted)
        ]
        if len(cases) > 2 * _MOST_CASES:
            return whole
        ends = [self._under(case, value) for case, value in cases]
        lo = np.minimum.reduce(np.broadcast_arrays(*(low for low, _ in ends)))
        hi = np.maximum.reduce(np.broadcast_arrays(*(high for _, high in ends)))
        sure = open_ & (lo <= hi)
        return _held(whole, np.where(sure, lo, -np.inf), np.where(sure, hi, np.inf))

    def _under(self, case: tuple[Compare, ...], value: Expr) -> Ends:
        """Return bounds of a value where some comparisons hold; (inf, -inf) where they cannot hold together."""
        inner = _Narrowed(self)
        for compare in case:
            inner.assume(compare)
        enclosure = inner.enclose(value)
        return np.where(inner.empty, np.inf, enclosure.lo), np.where(inner.empty, -np.inf, enclosure.hi)


class _Narrowed(NarrowingInterpreter):
    """Encloses expressions where some comparisons hold."""

    def __init__(self, outer: NarrowingInterpreter) -> None:
        super().__init__(outer.names, outer.definitions, nearest=outer.nearest)
        self.empty: Mask = np.array(False)
        self._narrowed: set[str] = set()
        #: Whether names depend on narrowed ones; those computed again do not.
        self._again: dict[str, bool] = {}
        self._depth = 0

    def assume(self, compare: Compare) -> None:
        """Narrow the names in a comparison that holds."""
        left, right = self.enclose(compare.left), self.enclose(compare.right)
        op: str = compare.op
        if op == "!=":
            return
        self._hold(compare.left, *_side(op, right))
        self._hold(compare.right, *_side(_TURNED[op], left))
        self._again = {}

    def _where(self, expr: Where) -> Enclosure:
        return self._chosen(expr, *self.decide(expr.condition))  # branches within branches are not narrowed again

    def enclose(self, expr: Expr) -> Enclosure:
        """Enclose an expression; parts that depend on narrowed names are computed again."""
        if isinstance(expr, Name) and self._depth <= _DEEPEST and self._is_changed(expr.name, self._depth):
            self._again[expr.name] = False
            self._depth += 1
            again = self.enclose(self.definitions[expr.name])
            self._depth -= 1
            self._intersect(expr.name, again.lo, again.hi)
        return super().enclose(expr)

    def _is_changed(self, name: str, depth: int) -> bool:
        if name not in self._again:
            definition = self.definitions.get(name) if depth <= _DEEPEST else None
            parts = [] if definition is None else [n.name for n in names_in(definition)]
            self._again[name] = any(n in self._narrowed or self._is_changed(n, depth + 1) for n in parts)
        return self._again[name]

    def _hold(self, expr: Expr, lo: Array, hi: Array, depth: int = 0) -> None:
        """Narrow names so that a value lies between two ends, where it is known to be a number."""
        enclosure = self.enclose(expr)
        unknown = may_be_nan(enclosure)
        lo, hi = (
            np.where(unknown, -np.inf, np.maximum(lo, enclosure.lo)),
            np.where(unknown, np.inf, np.minimum(hi, enclosure.hi)),
        )
        if not ((lo > enclosure.lo) | (hi < enclosure.hi)).any() or depth > _DEEPEST:
            return
        want = Enclosure(lo - _TINY, hi + _TINY, None, np.array(0.0))
        match expr:
            case Name(name=name):
                self._intersect(name, lo, hi)
                if name in self.definitions:
                    self._hold(self.definitions[name], lo, hi, depth + 1)
            case Negate(operand=operand):
                self._hold(operand, -hi, -lo, depth + 1)
            case Binary(left=left, right=right):
                self._hold_parts(expr, want, left, right, depth + 1)
            case Call(function="max", arguments=parts):
                for part in parts:
                    self._hold(part, np.array(-np.inf), hi, depth + 1)
            case Call(function="min", arguments=parts):
                for part in parts:
                    self._hold(part, lo, np.array(np.inf), depth + 1)

    def _hold_parts(self, expr: Binary, want: Enclosure, left: Expr, right: Expr, depth: int) -> None:
        a, b = self.enclose(left), self.enclose(right)
        wide = np.maximum(want.size, np.maximum(a.size, b.size)) * ULPS
        match expr.op:
            case "+":
                ends = (minus(want, b), minus(want, a))
            case "-":
                ends = (plus(want, b), minus(a, want))
            case "*":
                ends, wide = (divided(want, b), divided(want, a)), np.array(0.0)
            case "/":
                ends, wide = (times(want, b), divided(a, want)), np.array(0.0)
            case _:
                return
        for part, e in zip((left, right), ends, strict=True):
            slack = wide + e.size * ULPS
            self._hold(part, _number(e.lo - slack, -np.inf), _number(e.hi + slack, np.inf), depth)

    def _intersect(self, name: str, lo: Array, hi: Array) -> None:
        before = self.names[name]
        low, high = np.maximum(before.lo, lo), np.minimum(before.hi, hi)
        none = low > high
        self.empty = self.empty | none
        self._narrowed.add(name)
        self.names[name] = Enclosure(
            np.where(none, before.lo, low), np.where(none, before.hi, high), before.slopes, before.error
        )


def alternatives(condition: Expr, wanted: bool) -> list[tuple[Compare, ...]]:
    """Return conjunctions of comparisons; one at least holds where a condition does, or where it does not."""
    match condition:
        case Compare(op=op, left=left, right=right):
            return [(condition if wanted else Compare(_NEGATED[op], left, right),)]  # type: ignore[arg-type]  # an operator
        case Logic(op="not", operands=(operand,)):
            return alternatives(operand, not wanted)
        case Logic(op=op, operands=operands):
            parts = [alternatives(o, wanted) for o in operands]
            return list(_joined(parts) if (op == "and") == wanted else (case for part in parts for case in part))
    raise TypeError(f"{type(condition).__name__} is no condition")


def _joined(parts: list[list[tuple[Compare, ...]]]) -> Iterator[tuple[Compare, ...]]:
    for chosen in product(*parts):
        yield tuple(compare for case in chosen for compare in case)


def _side(op: str, other: Enclosure) -> Ends:
    """Return the ends of values that compare with another one; with none that may be NaN."""
    unknown = may_be_nan(other)
    lo = np.where(unknown | (op in ("<", "<=")), -np.inf, other.lo)
    hi = np.where(unknown | (op in (">", ">=")), np.inf, other.hi)
    return lo, hi


def _nearest(op: str, a: Enclosure, b: Enclosure) -> Enclosure:
    """Enclose the result in floats, which is monotone in each operand, as rounding is."""
    lo, hi = least_and_largest([_NEAREST[op](x, y) for x in (a.lo, a.hi) for y in (b.lo, b.hi)])
    bad = np.isnan(lo) | may_be_nan(a)  # one of the four is enough; a square hides it
    if op == "/":
        bad = bad | ((b.lo <= 0.0) & (b.hi >= 0.0))
    if op == "*" and a is b:
        lo = np.where((a.lo <= 0.0) & (a.hi >= 0.0), 0.0, lo)
    return _lost(Enclosure(lo, hi, None, np.array(np.inf)), bad)


def _lost(enclosure: Enclosure, bad: Mask) -> Enclosure:
    """Return an enclosure in which some values may be no numbers."""
    if not bad.any():
        return enclosure
    nothing = np.where(bad, np.nan, enclosure.lo)
    return sound(nothing, enclosure.hi, enclosure.slopes, enclosure.error)


_NEAREST: Final[dict[str, Callable[[Array, Array], Array]]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
}


def may_be_nan(e: Enclosure) -> Mask:
    """Return where a value may be no number."""
    return np.isneginf(e.lo) & np.isposinf(e.hi)


def _held(enclosure: Enclosure, lo: Array, hi: Array) -> Enclosure:
    """Return an enclosure within other ends."""
    return Enclosure(np.maximum(enclosure.lo, lo), np.minimum(enclosure.hi, hi), enclosure.slopes, enclosure.error)


def _number(ends: Array, otherwise: float) -> Array:
    return np.where(np.isnan(ends), otherwise, ends)
