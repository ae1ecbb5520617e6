"""Loops as data for certificates: operations on numbers."""

from __future__ import annotations

import itertools
import math
from collections.abc import Container, Mapping, Sequence
from operator import eq, ge, gt, le, lt, ne
from typing import Any, Final

import numpy as np

from fuzzyctl.analysis.reach.reach import ReachableSets
from fuzzyctl.analysis.reach.series import Nodes
from fuzzyctl.analysis.reach.surfaces import SystemSurface
from fuzzyctl.analysis.verify import CONVERGES
from fuzzyctl.expr import ZERO, Binary, Call, Compare, Expr, Name, Number, Where, names_in, walk
from fuzzyctl.kernels.inference.inference import evaluation
from fuzzyctl.kernels.plan.equations import Equation
from fuzzyctl.kernels.plan.expansion import STARTED
from fuzzyctl.kernels.plan.plan import Plan
from fuzzyctl.kernels.program.program import Assign
from fuzzyctl.kernels.program.scalar import scalar_function
from fuzzyctl.model.loop import TIME
from fuzzyctl.simulation.sample_times import ALIGNED

#: What rounding may add to each value of a controller.
ROUNDING: Final = 1e-12
#: What rounding may add to a degree.
_OF_DEGREES: Final = 1e-14
#: Most clauses of a claim.
_CLAUSES: Final = 64

_COMPARISONS: Final = {"<": lt, "<=": le, ">": gt, ">=": ge, "==": eq, "!=": ne}

Item = list[Any]


class NoCertificateError(Exception):
    """Raised if a proof has no certificate."""


class _Translation:
    """Operations on numbers, for all expressions of a loop.

    Args:
        exact: Whether they are those of real arithmetic, without errors of rounding.
        step: The sample time [s].
    """

    def __init__(self, exact: bool, step: float) -> None:
        self.exact, self.step = exact, step
        #: Whether the operations are those of the plants between samples.
        self.is_between = False
        self.nodes: list[Item] = []
        self.tables: list[dict[str, Any]] = []
        #: Nodes that must not be negative, since roots are taken of them.
        self.positive: list[int] = []
        self._known: dict[str, int] = {}
        self._surfaces: dict[tuple[int, int, bool], int] = {}

    def add(self, *item: Any) -> int:
        key = repr(item)
        if key not in self._known:
            self._known[key] = len(self.nodes)
            self.nodes.append(list(item))
        return self._known[key]

    def number(self, value: float) -> int:
        if not math.isfinite(value):
            raise NoCertificateError("a constant of the loop is infinite")
        return self.add("const", value)

    def negative(self, a: int) -> int:
        op, *parts = self.nodes[a]
        return self.number(-parts[0]) if op == "const" else self.product(self.number(-1.0), a)

    def sum(self, a: int, b: int) -> int:
        nothing = ["const", 0.0]
        return b if self.nodes[a] == nothing else a if self.nodes[b] == nothing else self.add("+", a, b)

    def product(self, a: int, b: int) -> int:
        one = ["const", 1.0]
        return b if self.nodes[a] == one else a if self.nodes[b] == one else self.add("*", a, b)

    def larger(self, a: int, b: int) -> int:
        """Return max(a, b) = (a + b + |a - b|) / 2, between samples one of both, as |a - b| has no derivative there."""
        difference = self.sum(a, self.negative(b))
        if self.is_between:
            return self.add("choice", difference, 0, a, b)
        return self.product(self.number(0.5), self.sum(self.sum(a, b), self.add("abs", difference)))

    def smaller(self, a: int, b: int) -> int:
        return self.negative(self.larger(self.negative(a), self.negative(b)))

    def wave(self, kind: str, a: int) -> int:
        place = len(self.nodes)
        for name, other in (("sin", place + 1), ("cos", place)):
            key = repr((name, a))
            if key not in self._known:
                self._known[key] = len(self.nodes)
                self.nodes.append([name, a, other])
        return self._known[repr((kind, a))]

    def translated(
        self,
        nodes: Nodes,
        inputs: Mapping[str, Item | int],
        wanted: Sequence[int],
        others: Mapping[int, Item] | None = None,
    ) -> list[int]:
        """Return for each node its operation, -1 for those that the wanted ones do not need.

        Args:
            nodes: The nodes.
            inputs: By name an operation, or the position of one.
            wanted: Positions of nodes.
            others: Operations in place of those of some nodes.
        """
        others = others or {}
        needed: set[int] = set()
        stack = [*wanted]
        while stack:
            at = stack.pop()
            if at not in needed:
                needed.add(at)
                stack += () if at in others else nodes.nodes[at].parts
        places = [-1] * len(nodes.nodes)
        for at in sorted(needed):
            places[at] = self.add(*others[at]) if at in others else self._place(nodes, at, places, inputs)
        return places

    def _place(self, nodes: Nodes, at: int, places: Sequence[int], inputs: Mapping[str, Item | int]) -> int:
        node = nodes.nodes[at]
        parts = [places[p] for p in node.parts]
        if -1 in parts and node.kind not in ("max", "min", "output", "compare", "logic", "where"):
            raise NoCertificateError("a choice has no operation in a certificate")
        match node.kind:
            case "number":
                return self.number(node.detail) if math.isfinite(node.detail) else -1
            case "input":
                return self._input(inputs[node.detail])
            case "negative":
                return self.negative(parts[0])
            case "sin" | "cos":  # each has its partner for its slope
                return self.wave(node.kind, parts[0])
            case "+":
                return self.sum(*parts)
            case "*":
                return self.product(*parts)
            case "exp":  # which is its slope
                return self.add("exp", *parts, len(self.nodes))
            case "/":
                return self.product(parts[0], self.add("inverse", parts[1]))
            case "sqrt":
                if not nodes.nodes[node.parts[0]].positive and parts[0] not in self.positive:
                    self.positive.append(parts[0])
                return self.add("sqrt", *parts)
            case "abs":
                return self.larger(parts[0], self.negative(parts[0])) if self.is_between else self.add("abs", *parts)
            case "held":  # within [0, 1]
                return self.smaller(self.number(1.0), self.larger(self.number(0.0), parts[0]))
            case "max" | "min" if -1 in parts:  # clamp(x, 0, inf)
                ends = [nodes.nodes[p].detail for p in node.parts if nodes.nodes[p].kind == "number"]
                if (-math.inf if node.kind == "max" else math.inf) not in ends or max(parts) < 0:
                    raise NoCertificateError("a choice has no operation in a certificate")
                return max(parts)
            case "max":
                return self.larger(*parts)
            case "min":
                return self.smaller(*parts)
            case "output":
                call = nodes.nodes[node.parts[0]]
                return self._output(call.detail, [places[p] for p in call.parts], node.detail)
            case "last_entry":
                return self._last_entry([nodes.nodes[p].detail for p in node.parts[1::2]], parts)
            case "where" if (choice := _constant(nodes, node.parts[0])) is not None:
                return parts[1] if choice else parts[2]
            case "where" if (first := _at_first(nodes, node.parts[0])) is not None:
                # The state is 0 at the first sample and 1 from then on.
                started = self._input(inputs[STARTED])
                before, after = parts[1:] if first else parts[:0:-1]
                if -1 in (before, after):
                    raise NoCertificateError("a value may be missing")
                change = self.sum(after, self.negative(before))
                return self.sum(before, self.product(started, change))
            case "where":
                if -1 in parts[1:]:
                    raise NoCertificateError("a value may be missing")
                return self._chosen(self.clauses(nodes, places, node.parts[0]), *parts[1:])
            case "system" | "compare" | "logic":
                return -1
        raise NoCertificateError(f"'{node.kind}' has no operation in a certificate")

    def _input(self, item: Item | int) -> int:
        return item if isinstance(item, int) else self.add(*item)

    def _chosen(self, clauses: list[list[list[int]]], yes: int, no: int) -> int:
        """Return one value where a condition holds, see `clauses`, and another one elsewhere."""
        for clause in reversed(clauses):
            value = no
            for at, mark in reversed(clause):
                value = self.add("choice", self.rounded(at, ROUNDING), mark, yes, value)
            yes = value
        return yes

    def _last_entry(self, times: Sequence[float], parts: Sequence[int]) -> int:
        """Return the value of the last time that has come; at a sample, of those that have for a run."""
        value = parts[2]
        for time, later in zip(times[1:], parts[4::2], strict=True):
            sample = round(time / self.step)
            if abs(time / self.step - sample) <= ALIGNED * max(sample, 1):  # products of the period are rounded
                time += ALIGNED * self.step * (1.0 if sample * self.step < time else -1.0)
            value = self.add("choice", self.sum(parts[0], self.number(-time)), 0, later, value)
        return value

    def _output(self, surface: SystemSurface, arguments: list[int], output: int) -> int:
        grid = surface.grid
        if grid is None or max(len(k) for k in grid.knots) < 2:
            return self._computed(surface.plan, arguments, output)
        table, error = grid.outputs[output], surface._boxed.errors[output]
        if not math.isfinite(error):
            raise NoCertificateError(f"the rounding of system '{surface.system.name}' has no bound")
        inputs = [arguments[i] for i in grid.inputs]
        place = self.add("table", self._table(grid.knots, table.value), *inputs)
        if table.weight:
            weight = self.add("table", self._table(grid.knots, table.weight), *inputs)
            place = self.product(place, self.add("inverse", weight))
        return self.rounded(place, 2.0 * error) if error else place

    def _computed(self, system: Plan, arguments: list[int], output: int) -> int:
        """Return an output of a system as its kernel computes it, degrees that are lines between points as tables."""
        program = evaluation(system)
        operations: dict[str, Item | int] = dict(zip(program.arguments, arguments, strict=True))
        body: list[Equation] = []
        for item in program.body:
            if not isinstance(item, Assign):
                raise NoCertificateError("an integral has no operation in a certificate")
            points = _points_of(item.value)
            if points is None:
                body.append(Equation(item.name, _of_real_numbers(item.value)))
                continue
            (name, *_), places, values = points
            nodes = Nodes([*operations], body, [Name(name)])
            place = self.translated(nodes, operations, nodes.values)[nodes.values[0]]
            operations[item.name] = self.rounded(self.add("table", self._table([places], values), place), _OF_DEGREES)
        nodes = Nodes([*operations], body, [program.results[output]])
        return self.translated(nodes, operations, nodes.values)[nodes.values[0]]

    def rounded(self, a: int, error: float) -> int:
        """Return a value with an error."""
        return a if self.exact or self.nodes[a][0] == "const" else self.add("+", a, self.add("error", error))

    def _table(self, knots: Sequence[Sequence[float]], values: Sequence[float]) -> int:
        shaped = np.array(values).reshape([len(k) for k in knots]).tolist()
        data = {"knots": [list(k) for k in knots], "values": shaped}
        if data not in self.tables:
            self.tables.append(data)
        return self.tables.index(data)

    def clauses(self, nodes: Nodes, places: Sequence[int], at: int, wanted: bool = True) -> list[list[list[int]]]:
        """Return a condition, or its negation: of each clause one node must be at least 0, or above it if marked by 1.

        Raises:
            NoCertificateError: If there are too many clauses, or it has no such form.
        """
        node = nodes.nodes[at]
        if node.kind == "logic":
            if node.detail == "not":
                return self.clauses(nodes, places, node.parts[0], not wanted)
            parts = [self.clauses(nodes, places, p, wanted) for p in node.parts]
            if (node.detail == "and") == wanted:
                return [clause for part in parts for clause in part]
            if math.prod(map(len, parts)) > _CLAUSES:
                raise NoCertificateError(f"a claim has more than {_CLAUSES} clauses")
            return [list(itertools.chain(*choice)) for choice in itertools.product(*parts)]
        a, b = node.parts
        if node.detail in ("==", "!="):
            inner = nodes.nodes[a]
            if inner.kind == "where" and [nodes.nodes[p].detail for p in (*inner.parts[1:], b)] == [1.0, 0.0, 0.0]:
                return self.clauses(nodes, places, inner.parts[0], wanted == (node.detail == "!="))
        if places[a] < 0 or places[b] < 0:
            raise NoCertificateError("a choice has no operation in a certificate")
        more, less = (self.sum(places[x], self.negative(places[y])) for x, y in ((a, b), (b, a)))
        match node.detail, wanted:
            case (">", True) | ("<=", False):
                return [[[more, 1]]]
            case (">=", True) | ("<", False):
                return [[[more, 0]]]
            case ("<", True) | (">=", False):
                return [[[less, 1]]]
            case ("<=", True) | (">", False):
                return [[[less, 0]]]
            case ("==", True) | ("!=", False):
                return [[[more, 0]], [[less, 0]]]
        return [[[more, 1], [less, 1]]]


def _points_of(value: Expr) -> tuple[list[str], list[float], list[float]] | None:
    """Return the variable and the points of a function that is lines between points and constant beyond, else None."""
    names, parts = list(dict.fromkeys(n.name for n in names_in(value))), walk(value)
    bends = {e.right.value for e in parts if isinstance(e, Compare) and isinstance(e.right, Number)}
    lines = (Where, Compare, Binary, Name, Number)
    divides = any(isinstance(e, Binary) and e.op in "/^" and not isinstance(e.right, Number) for e in parts)
    if len(names) != 1 or len(bends) < 2 or divides or not all(isinstance(e, lines) for e in parts):
        return None
    if not all(map(math.isfinite, bends)):
        return None
    places = [min(bends) - 1.0, *sorted(bends), max(bends) + 1.0]
    at = scalar_function(value)
    values = [at(x) for x in places]
    if values[0] != values[1] or values[-1] != values[-2]:
        return None
    for (a, b), (low, high) in zip(itertools.pairwise(places), itertools.pairwise(values), strict=True):
        for share in (2.0**-20, 0.25, 0.5, 0.75, 1.0 - 2.0**-20):
            if abs(at(a + share * (b - a)) - (low + share * (high - low))) > _OF_DEGREES:
                return None
    return names, places[1:-1], values[1:-1]


def _of_real_numbers(value: Expr) -> Expr:
    """Return the value of an average that a kernel guards against rounding, and against products of 0 and infinity."""
    match value:
        case Where(condition=Compare(op=">", left=a, right=Number(value=0.0)), then=Binary() as then, otherwise=other):
            if isinstance(other, Number) and ((then.op, then.left, other) == ("*", a, ZERO) or math.isnan(other.value)):
                return then
        case Call(function="clip", arguments=(inner, low, _)) if not isinstance(low, Number):
            return inner
    return value


def _bends_of(nodes: Nodes, inputs: Container[str]) -> list[int]:
    """Return the nodes without derivatives that depend on some inputs only, and that no other such node needs."""
    constant: list[bool] = []
    for node in nodes.nodes:
        is_input = node.kind == "input"
        constant.append(node.detail in inputs if is_input else all(constant[p] for p in node.parts))
    bends = [k for k, n in enumerate(nodes.nodes) if constant[k] and n.kind in ("abs", "max", "min", "where", "output")]
    inner = {p for k in bends for p in nodes.nodes[k].parts}
    return [k for k in bends if k not in inner]


def _constant(nodes: Nodes, at: int) -> bool | None:
    """Return whether a condition holds for all real numbers or for none, else None; x != x says that x is NaN."""
    node = nodes.nodes[at]
    if node.kind == "compare":
        return node.detail in ("==", "<=", ">=") if node.parts[0] == node.parts[1] else None
    truths = [_constant(nodes, p) for p in node.parts]
    if node.detail == "not":
        return None if truths[0] is None else not truths[0]
    sure = node.detail == "or"
    return sure if sure in truths else None if None in truths else not sure


def _at_first(nodes: Nodes, at: int) -> bool | None:
    """Return whether a condition holds at the first sample only (True), or at all others (False); None for neither."""
    node = nodes.nodes[at]
    if node.kind != "compare":
        return None
    parts = [nodes.nodes[p] for p in node.parts]
    if [p.kind for p in parts] != ["input", "number"] or parts[0].detail != STARTED:
        return None
    holds = [bool(_COMPARISONS[node.detail](x, parts[1].detail)) for x in (0.0, 1.0)]
    return holds[0] if holds[0] != holds[1] else None


def problem_of(
    sets: ReachableSets, claims: Sequence[Any], starts: Sequence[Any], params: Sequence[Any], exact: bool
) -> dict[str, Any]:
    """Return a loop as data.

    Args:
        sets: The loop, with the conditions of the claims.
        claims: Of each its text and its times, in periods; the last one None for all times.
        starts, params: Ends of the ranges of the states at the begin, those of plants first, and of the params.
        exact: Whether the claim is that all runs converge, in real arithmetic.
    """
    equations = sets.equations
    if equations.rates:
        raise NoCertificateError("controllers at several rates have no operation in a certificate")
    new = _Translation(exact, equations.step)
    groups = {"state": sets.plant, "memory": sets.memory, "given": sets.columns, "held": sets.held,
              "param": sets.free, "disturbance": [*equations.disturbances]}  # fmt: skip
    inputs: dict[str, Item] = {TIME: ["time"]}
    for kind, names in groups.items():
        inputs |= {name: [kind, k] for k, name in enumerate(names)}
    inputs |= {name: ["error", size] for name, size in equations.errors.items()}
    for k in range(len(sets.plant)):  # the first nodes are the states
        new.add("state", k)
    sampled = new.translated(sets.sample, {k: v for k, v in inputs.items() if k not in sets.held}, sets.sample.values)
    if any(sampled[v] < 0 for v in sets.sample.values):
        raise NoCertificateError("a choice has no operation in a certificate")
    values = [new.rounded(sampled[v], ROUNDING) for v in sets.sample.values]
    signals, following = values[: len(sets.held)], values[len(sets.held) :]
    # Bends between samples are those of signals that are held, which are computed at samples.
    flow, at_samples = sets.flow.nodes, {n: inputs[n] for n in sets.free} | dict(zip(sets.held, signals, strict=True))
    bends = _bends_of(flow, at_samples)
    operations = new.translated(flow, at_samples, bends)
    signals += [operations[at] for at in bends]
    new.is_between = True
    others = {at: ["held", len(sets.held) + k] for k, at in enumerate(bends)}
    between = new.translated(flow, inputs, flow.values, others)
    new.is_between = False
    rates = [between[v] for v in flow.values]
    if -1 in rates or -1 in signals:
        raise NoCertificateError("a choice has no operation in a certificate")
    places = new.translated(sets.claims, inputs, sets.claims.conditions)
    conditions = [CONVERGES] if exact else [new.clauses(sets.claims, places, at) for at in sets.claims.conditions]
    data = [[text, clauses, *times] for (text, *times), clauses in zip(claims, conditions, strict=True)]
    ends = [end for *_, end in data]
    last = None if None in ends else max(ends, default=0)
    for k, state in enumerate(equations.plant_states):
        limits = ((1.0, state.low, state.without_low), (-1.0, state.high, state.without_high))
        bounds = [
            [[new.sum(new.product(new.number(sign), k), new.number(-sign * end)), int(strict)]]
            for sign, end, strict in limits
            if math.isfinite(end)
        ]
        if bounds:
            data.append([f"'{state.name}' stays in its range", bounds, 0, last])
    for at in new.positive:
        data.append(["no root of a negative number", [[[at, 0]]], 0, last])
    return {
        "nodes": new.nodes, "tables": new.tables, "rates": rates, "held": signals, "next": following,
        "period": equations.step, "params": [*params], "start": [*starts],
        "given": sets.given.tolist() if sets.columns else [],
        "disturbances": [[low, high] for low, high, _ in equations.disturbances.values()],
        "names": [*sets.free, *sets.plant, *sets.memory], "claims": data,
    }  # fmt: skip
