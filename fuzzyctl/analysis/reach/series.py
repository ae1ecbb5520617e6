"""Taylor series in time of expressions over forms: each node of an expression has a recurrence for its coefficients.

With x(t) = sum of x[k] t^k and x' = f(x) the coefficients of the states follow from those of f:
x[k + 1] = f[k] / (k + 1).

Source:
    Moore: Interval Analysis, 1966; Griewank, Walther: Evaluating Derivatives, 2nd ed. 2008, table 13.2 (recurrences).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Final

import numpy as np

from fuzzyctl.analysis.reach import forms
from fuzzyctl.analysis.reach.forms import DomainError, Mask, Value, as_form, ends, minus, negative, plus, scaled, times
from fuzzyctl.expr import Binary, Call, Compare, Expr, Logic, Name, Negate, Number, Where, evaluate
from fuzzyctl.kernels.interval import vector
from fuzzyctl.kernels.interval.vector import Enclosure
from fuzzyctl.kernels.plan.equations import Equation, Evaluation
from fuzzyctl.kernels.program.builder import LAST_ENTRY
from fuzzyctl.model.loop import TIME
from fuzzyctl.simulation.signals import SAME

#: A table of a system: returns its outputs for the values of its inputs.
Table = Callable[[Sequence[Value]], list[Value]]
#: Masks of the boxes in which a condition surely holds, and of those in which it surely fails.
Truths = tuple[Mask, Mask]

#: Functions of numbers that are computed once.
_ARITHMETIC: Final = frozenset({"number", "negative", "+", "*", "/", "exp", "log", "sqrt", "power"})
#: Functions that jump.
STEPS: Final = frozenset({LAST_ENTRY, "sign", "floor", "ceil", "round", "mod", "fmod", "atan2"})


class NotSmoothError(Exception):
    """Raised if a derivative of higher order is needed while a choice is open."""


@dataclass(slots=True)
class _Node:
    kind: str
    parts: tuple[int, ...] = ()
    detail: Any = None
    #: Whether the formula shows that no value is negative, as that of a sum of squares does.
    positive: bool = False


class Nodes:
    """Expressions as nodes in the order in which they are computed.

    Args:
        inputs: Names of the values that are given.
        body: Equations and calls of systems, each after those that it reads.
        values: The expressions that are wanted.
        tables: Enclosures of the systems that `body` calls, by position in it.
    """

    def __init__(
        self,
        inputs: Sequence[str],
        body: Sequence[Equation | Evaluation],
        values: Sequence[Expr],
        tables: Mapping[int, Table] | None = None,
    ) -> None:
        self.nodes: list[_Node] = []
        self.names: dict[str, int] = {}
        self._known: dict[Any, int] = {}
        #: Values of nodes that depend on numbers only, computed once.
        self.fixed: dict[int, Value] = {}
        #: Positions of the nodes that depend on the time only.
        self.timed: set[int] = set()
        for name in inputs:
            self.names[name] = self._add("input", (), name)
        self.inputs = [self.names[n] for n in inputs]
        for item in body:
            if isinstance(item, Evaluation):
                parts = tuple(self._of(a) for a in item.arguments)
                call = self._add("system", parts, (tables or {})[id(item)])
                for k, name in enumerate(item.names):
                    self.names[name] = self._add("output", (call,), k)
            else:
                self.names[item.name] = self._of(item.value)
        self.values = [self._of(v) for v in values]
        #: Positions of the conditions that were added.
        self.conditions: list[int] = []

    def ask(self, condition: Expr) -> None:
        """Add a condition, see `Series.truths`; a number is one that is not 0."""
        is_number = not isinstance(condition, Compare | Logic)
        self.conditions.append(self._condition(Compare("!=", condition, Number(0.0)) if is_number else condition))

    def _add(self, kind: str, parts: tuple[int, ...] = (), detail: Any = None) -> int:
        key = kind, parts, detail if kind != "system" else id(detail)
        if key not in self._known:
            self._known[key] = self._new(kind, parts, detail)
        return self._known[key]

    def _new(self, kind: str, parts: tuple[int, ...], detail: Any) -> int:
        at = len(self.nodes)
        self.nodes.append(_Node(kind, parts, detail, self._is_positive(kind, parts, detail)))
        of_time = any(p in self.timed for p in parts)
        if (kind == "input" and detail == TIME) or (
            of_time and all(p in self.timed or self.nodes[p].kind == "number" for p in parts)
        ):
            self.timed.add(at)
        return at

    def _is_positive(self, kind: str, parts: tuple[int, ...], detail: Any) -> bool:
        signs = [self.nodes[p].positive for p in parts]
        match kind:
            case "number":
                return bool(detail >= 0.0)
            case "*":
                return parts[0] == parts[1] or all(signs)
            case "+" | "/" | "min":
                return all(signs)
            case "max":
                return any(signs)
        return kind in ("abs", "sqrt", "exp")

    def _of(self, expr: Expr) -> int:
        match expr:
            case Number(value=value):
                return self._add("number", (), value)
            case Name(name=name):
                return self.names[name] if name in self.names else self._add("number", (), evaluate(expr, {}))
            case Negate(operand=operand):
                return self._add("negative", (self._of(operand),))
            case Binary(op="-", left=left, right=right):
                return self._add("+", (self._of(left), self._add("negative", (self._of(right),))))
            case Binary(op="^", left=left, right=right):
                power = self.nodes[self._of(right)]
                if power.kind == "negative" and self.nodes[power.parts[0]].kind == "number":
                    power = _Node("number", (), -self.nodes[power.parts[0]].detail)
                if power.kind == "number":
                    return self._power(self._of(left), float(power.detail))
                exponent = self._add("*", (self._of(right), self._add("log", (self._of(left),))))
                return self._add("exp", (exponent,))
            case Binary(op=op, left=left, right=right):
                return self._add(op, (self._of(left), self._of(right)))
            case Where(condition=condition, then=then, otherwise=otherwise):
                return self._add("where", (self._condition(condition), self._of(then), self._of(otherwise)))
            case Compare() | Logic():
                return self._add("where", (self._condition(expr), self._of(Number(1.0)), self._of(Number(0.0))))
            case Call(function=function, arguments=arguments):
                return self._call(function, tuple(map(self._of, arguments)))
        raise DomainError(f"{type(expr).__name__} has no enclosure")

    def _power(self, base: int, exponent: float) -> int:
        if exponent == int(exponent) and 0 <= exponent <= 16:
            node = self._add("number", (), 1.0) if exponent == 0 else base
            for _ in range(int(exponent) - 1):
                node = self._add("*", (node, base))
            return node
        if exponent == int(exponent) and -16 <= exponent < 0:
            return self._power(self._add("/", (self._add("number", (), 1.0), base)), -exponent)
        return self._add("power", (base,), exponent)

    def _call(self, function: str, parts: tuple[int, ...]) -> int:
        if function in ("min", "max"):
            node = parts[0]
            for other in parts[1:]:
                node = self._add(function, (node, other))
            return node
        if function == "clip":
            return self._add("max", (self._add("min", (parts[0], parts[2])), parts[1]))
        if function == "tan":
            return self._add("/", (self._call("sin", parts), self._call("cos", parts)))
        if function == "divide":
            return self._add("/", parts)
        if function in ("sin", "cos"):  # each has the other one in its recurrence
            pair = {"sin": len(self.nodes), "cos": len(self.nodes) + 1}
            if ("sin", parts, None) not in self._known:
                self._known |= {(name, parts, None): at for name, at in pair.items()}
                self._new("sin", parts, pair["cos"])
                self._new("cos", parts, pair["sin"])
            return self._known[function, parts, None]
        return self._add(function, parts)

    def _condition(self, expr: Expr) -> int:
        match expr:
            case Compare(op=op, left=left, right=right):
                return self._add("compare", (self._of(left), self._of(right)), op)
            case Logic(op=op, operands=operands):
                return self._add("logic", tuple(map(self._condition, operands)), op)
        raise DomainError(f"{type(expr).__name__} is no condition")


class Series:
    """Coefficients of all nodes for given inputs, computed order by order.

    A jump or a kink of a signal beside an end of a range of times is at this end, see `signals.SAME`.

    Args:
        nodes: The nodes.
        values: Coefficients of order 0 of the inputs.
        whole: The series over a set that holds this one, and whose choices are taken where they are sure.
        exact: Whether systems are evaluated in exact arithmetic at numbers, without the rounding of kernels.
    """

    def __init__(
        self, nodes: Nodes, values: Sequence[Value], whole: Series | None = None, *, exact: bool = False
    ) -> None:
        self.nodes, self.whole, self.exact = nodes, whole, exact
        self.coefficients: list[list[Any]] = [[] for _ in nodes.nodes]
        #: Of a choice, where it is surely the first, and where surely the second.
        self.choices: dict[int, Truths] = {}
        self._inverses: dict[int, Value] = {}
        for at, value in zip(nodes.inputs, values, strict=True):
            self.coefficients[at].append(value)

    @np.errstate(all="ignore")
    def extend(self, inputs: Sequence[Value] | None = None) -> list[Value]:
        """Compute the next order of all nodes and return those of the wanted values.

        Args:
            inputs: Coefficients of this order of the inputs; None at order 0.
        """
        table, order = self.coefficients, len(self.coefficients[self.nodes.inputs[0]]) if self.nodes.inputs else 0
        if inputs is not None:
            for at, value in zip(self.nodes.inputs, inputs, strict=True):
                table[at].append(value)
        else:
            order = 0
        fixed = self.nodes.fixed
        for at, node in enumerate(self.nodes.nodes):
            if at in fixed:
                table[at].append(fixed[at] if order == 0 else 0.0)
            elif node.kind != "input":
                if len(table[at]) > order:  # computed with its pair
                    continue
                table[at].append(self._first(at, node) if order == 0 else self._next(at, node, order))
                if order == 0 and node.kind in _ARITHMETIC and all(self._is_number(p) for p in node.parts):
                    fixed[at] = table[at][0]
        return [table[at][order] for at in self.nodes.values]

    def may_jump(self) -> bool:
        """Return whether a value may jump over the set: a choice is open, or a step function has several values."""
        for at, node in enumerate(self.nodes.nodes):
            if node.kind == "where":
                yes, no = self.choices[at]
                if not bool(np.all(yes | no)):
                    return True
            value = self.coefficients[at][0]
            if node.kind in STEPS and not isinstance(value, float) and bool(np.any(forms.radius(value) > 1e-9)):
                return True
        return False

    def truths(self) -> list[Truths]:
        """Return for each condition masks of the boxes in which it surely holds, and surely fails; after order 0."""
        return [self.coefficients[at][0] for at in self.nodes.conditions]

    def _first(self, at: int, node: _Node) -> Any:
        parts = [self.coefficients[p][0] for p in node.parts] if node.kind not in ("compare", "logic", "where") else []
        match node.kind:
            case "number":
                return float(node.detail)
            case "negative":
                return negative(parts[0])
            case "+":
                return plus(parts[0], parts[1])
            case "*" | "/" if self.exact and any(is_zero(p) for p in parts[: 2 if node.kind == "*" else 1]):
                return 0.0 if all(np.all(np.isfinite(as_form(p))) for p in parts) else math.nan
            case "*":
                return times(parts[0], parts[1])
            case "/":
                self._inverses[at] = forms.inverse(parts[1])
                return times(parts[0], self._inverses[at])
            case "sin":
                return forms.sine(parts[0])
            case "cos":
                return forms.sine(parts[0], math.pi / 2)
            case "exp":
                return forms.exponential(parts[0])
            case "log":
                self._inverses[at] = forms.inverse(parts[0])
                return forms.logarithm(parts[0])
            case "sqrt":
                return forms.root(parts[0], self.nodes.nodes[node.parts[0]].positive)
            case "power":
                return forms.powered(parts[0], node.detail)
            case "abs":
                self.choices[at] = self._sure(at, _signs(self._inner(node, parts[0])))
                return forms.absolute(parts[0])
            case "min" | "max":
                open_end = next((k for k in (0, 1) if isinstance(parts[k], float) and math.isinf(parts[k])), None)
                if open_end is not None:  # as in clamp(x, 0, inf)
                    keeps = (parts[open_end] > 0.0) == (node.kind == "min")
                    sure = np.array([True])
                    first = keeps == (open_end == 1)
                    self.choices[at] = (sure, ~sure) if first else (~sure, sure)
                    return parts[0] if first else parts[1]
                difference = minus(parts[0], parts[1]) if node.kind == "max" else minus(parts[1], parts[0])
                self.choices[at] = self._sure(at, _signs(self._inner(node, difference)))
                join = forms.larger if node.kind == "max" else forms.smaller
                return join(parts[0], parts[1])
            case "compare":
                a, b = (self.coefficients[p][0] for p in node.parts)
                truths = _compared(node.detail, a, b, lambda difference: self._inner(node, difference))
                if node.detail in ("==", "!="):
                    same = self._same(*node.parts)
                    yes, no = truths if node.detail == "==" else truths[::-1]
                    yes, no = yes | same, no & ~same
                    truths = (yes, no) if node.detail == "==" else (no, yes)
                return _taken(truths, self.whole.coefficients[at][0] if self.whole else None)
            case "logic":
                return _joined(node.detail, [self.coefficients[p][0] for p in node.parts])
            case "where":
                condition, then, otherwise = (self.coefficients[p][0] for p in node.parts)
                self.choices[at] = condition
                return _without_nan(condition, then, otherwise)
            case "system":
                return node.detail.exactly(parts) if self.exact else node.detail(parts)
            case "output":
                return self.coefficients[node.parts[0]][0][node.detail]
        if node.kind == LAST_ENTRY:
            whole = self.whole.coefficients[at][0] if self.whole else None
            return whole if isinstance(whole, float) else _last_entry([self._inner(node, parts[0]), *parts[1:]])
        return _hull(node.kind, parts)

    def _sure(self, at: int, own: Truths) -> Truths:
        return _taken(own, self.whole.choices[at] if self.whole else None)

    def _inner(self, node: _Node, value: Value) -> Value:
        """Return a range without the slack at its ends, if it depends on the time only."""
        if isinstance(value, float) or not all(p in self.nodes.timed or self._is_number(p) for p in node.parts):
            return value
        low, high = ends(value)
        middle, half = 0.5 * (low + high), 0.5 * (high - low) * (1.0 - 2.0 * SAME)
        return np.stack([middle, half], -1)

    def _is_number(self, at: int) -> bool:
        return self.nodes.nodes[at].kind == "number" or at in self.nodes.fixed

    def _next(self, at: int, node: _Node, k: int) -> Any:
        table = self.coefficients
        if node.kind in ("number", "compare", "logic", "system"):
            is_open = node.kind == "system" or (node.kind == "compare" and not _decided(table[at][0]))
            if is_open and any(not is_zero(table[p][k]) for p in node.parts):
                raise NotSmoothError
            return 0.0
        parts = [table[p] for p in node.parts]
        match node.kind:
            case "output":
                return 0.0
            case "negative":
                return negative(parts[0][k])
            case "+":
                return plus(parts[0][k], parts[1][k])
            case "*" if node.parts[0] == node.parts[1]:
                twice = scaled(_convolved(parts[0], parts[0], range((k + 1) // 2), k), 2.0)
                return twice if k % 2 else plus(twice, times(parts[0][k // 2], parts[0][k // 2]))
            case "*":
                return _convolved(parts[0], parts[1], range(k + 1), k)
            case "/":
                if all(is_zero(p[j]) for p in parts for j in range(1, k + 1)):
                    return 0.0
                rest = minus(parts[0][k], _convolved(parts[1], table[at], range(1, k + 1), k))
                return times(rest, self._inverses[at])
            case "sin":
                slopes = [0.0, *(scaled(parts[0][j], float(j)) for j in range(1, k + 1))]
                cosine = negative(forms.divided(_convolved(slopes, table[at], range(1, k + 1), k), k))
                sine = forms.divided(_convolved(slopes, table[node.detail], range(1, k + 1), k), k)
                table[node.detail].append(cosine)
                return sine
            case "exp":
                slopes = [0.0, *(scaled(parts[0][j], float(j)) for j in range(1, k + 1))]
                return forms.divided(_convolved(slopes, table[at], range(1, k + 1), k), k)
            case "log":
                slopes = [0.0, *(scaled(table[at][j], float(j)) for j in range(1, k))]
                rest = forms.divided(_convolved(slopes, parts[0], range(1, k), k), k)
                return times(minus(parts[0][k], rest), self._inverses[at])
            case "sqrt" | "power":
                if all(is_zero(parts[0][j]) for j in range(1, k + 1)):
                    return 0.0
                b = 0.5 if node.kind == "sqrt" else node.detail
                total: Value = 0.0
                for j in range(1, k + 1):
                    if not is_zero(parts[0][j]):
                        factor = forms.rounded((Fraction(b) * j - (k - j)) / k)
                        total = plus(total, times(times(parts[0][j], table[at][k - j]), factor))
                if at not in self._inverses:
                    self._inverses[at] = forms.inverse(parts[0][0])
                return times(total, self._inverses[at])
            case "abs":
                return self._picked(at, parts[0][k], negative(parts[0][k]))
            case "min" | "max":
                return self._picked(at, parts[0][k], parts[1][k])
            case "where":
                return self._picked(at, parts[1][k], parts[2][k])
        if not isinstance(table[at][0], float) and any(not is_zero(p[k]) for p in parts):
            raise NotSmoothError
        return 0.0

    def _same(self, a: int, b: int, depth: int = 6) -> Mask:
        """Return where two nodes are one value, since choices that are made pass it on, as in x != clamp(x, 0, 1)."""
        same = np.array([a == b])
        for one, other in ((a, b), (b, a)):
            node = self.nodes.nodes[other]
            if depth and node.kind in ("min", "max", "where"):
                for part, sure in zip(node.parts[-2:], self.choices[other], strict=True):
                    same = same | (sure & self._same(one, part, depth - 1))
        return same

    def _picked(self, at: int, a: Value, b: Value) -> Value:
        yes, no = self.choices[at]
        if not _decided((yes, no)) and not (is_zero(a) and is_zero(b)):
            raise NotSmoothError
        return forms.chosen(yes, no, a, b)


def is_zero(a: Any) -> bool:
    """Return whether a value is the number 0."""
    return isinstance(a, float) and a == 0.0


def _convolved(a: Sequence[Value], b: Sequence[Value], indices: range, k: int) -> Value:
    """Return the sum of a[j] b[k - j] over some j."""
    total: Value = 0.0
    for j in indices:
        if not (is_zero(a[j]) or is_zero(b[k - j])):
            total = plus(total, times(a[j], b[k - j]))
    return total


def _decided(truths: Truths) -> bool:
    return bool(np.all(truths[0] | truths[1]))


def _taken(own: Truths, whole: Truths | None) -> Truths:
    """Return own truths, or those over a set that holds the own one where they are sure: a limit lies on its side."""
    if whole is None:
        return own
    yes, no = whole
    return yes | (own[0] & ~no), no & ~yes | (own[1] & ~yes)


def _signs(a: Value) -> Truths:
    low, high = ends(a)
    return low >= 0.0, high <= 0.0


def _compared(op: str, a: Value, b: Value, inner: Callable[[Value], Value]) -> Truths:
    """Return masks of the boxes in which a comparison surely holds, and surely fails."""
    if a is b and op in ("!=", "=="):
        certain = np.array([True])
        return (certain, ~certain) if op == "==" else (~certain, certain)
    is_number = isinstance(a, float) and isinstance(b, float)
    low, high = (np.array([a - b]),) * 2 if is_number else ends(inner(minus(a, b)))
    zero = np.zeros_like(low)
    difference, nothing = Enclosure(low, high, None, zero), Enclosure(zero, zero, None, zero)
    return vector.compared(op, difference, nothing)


def _joined(op: str, truths: Sequence[Truths]) -> Truths:
    yes, no = truths[0]
    if op == "not":
        return no, yes
    for y, n in truths[1:]:
        yes, no = (yes & y, no | n) if op == "and" else (yes | y, no & n)
    return yes, no


def _without_nan(condition: Truths, then: Value, otherwise: Value) -> Value:
    """Return a choice; a value that is not a number is not taken by a run of finite numbers."""
    yes, no = condition
    for value, sure in ((then, no), (otherwise, yes)):
        if isinstance(value, float) and math.isnan(value) and not bool(np.all(sure)):
            raise DomainError("a value may be missing")
    if isinstance(then, float) and math.isnan(then):
        return otherwise
    if isinstance(otherwise, float) and math.isnan(otherwise):
        return then
    return forms.chosen(yes, no, then, otherwise)


def _last_entry(parts: Sequence[Any]) -> Value:
    """Return the value of the last time that has come."""
    (low,), (high,) = (e[:1] for e in ends(parts[0]))
    times, values = parts[1::2], parts[2::2]
    first = max(k for k, time in enumerate(times) if k == 0 or time <= low)
    last = max(k for k, time in enumerate(times) if k == 0 or time <= high)
    possible = values[first : last + 1]
    if len(set(possible)) == 1:
        return float(possible[0])
    return forms.interval(np.array([min(possible)]), np.array([max(possible)]))


def _hull(function: str, parts: Sequence[Value]) -> Value:
    """Return the range of a function without its slopes."""
    zero = np.array([0.0])
    boxes = [Enclosure(*ends(as_form(p)), None, zero) for p in parts]
    enclosure = vector.applied(function, boxes)
    if not bool(np.all(np.isfinite(enclosure.lo) & np.isfinite(enclosure.hi))):
        raise DomainError(f"no finite enclosure of '{function}' is known")
    return forms.interval(enclosure.lo, enclosure.hi)
