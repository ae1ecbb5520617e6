"""Certificates of loops: a problem and hints for `fuzzyctl.analysis.verify`, which searches for nothing.

The loop is translated into operations on numbers. The sets are those of the checker's own arithmetic: hints, such as
tubes and bases, are proposed in floating point and tried at once.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Sequence
from contextlib import suppress
from operator import eq, ge, gt, le, lt, ne
from pathlib import Path
from typing import Any, Final

import numpy as np

from fuzzyctl.analysis import verify
from fuzzyctl.analysis.reach.prover import ANCHORS, LoopProver
from fuzzyctl.analysis.reach.reach import ReachableSets
from fuzzyctl.analysis.reach.series import Nodes
from fuzzyctl.analysis.reach.sets import _boxed, modes
from fuzzyctl.analysis.reach.surfaces import SystemSurface, _over_slabs, _slopes
from fuzzyctl.analysis.verify import ONE, Loop, keyed
from fuzzyctl.analysis.work import clock
from fuzzyctl.formats.fz_strings import guarantee_text
from fuzzyctl.kernels.plan.expansion import STARTED
from fuzzyctl.model.loop import TIME, Always, Stable
from fuzzyctl.model.loop import Loop as LoopBlock
from fuzzyctl.simulation.sample_times import ALIGNED

#: What rounding may add to each value of a controller.
ROUNDING: Final = 1e-12
#: Order of the Taylor polynomials, and most parts of a period.
_ORDER: Final = 4
_PARTS: Final = 64
#: Most clauses of a claim.
_CLAUSES: Final = 64
#: Lines along which the inputs of a table move together.
_SHEARS: Final = 4
#: Seconds that the search for an invariant set may take.
_SECONDS: Final = 60.0
#: How often a range is halved at most, each half again.
_CUTS: Final = 3
#: Symbols for each state from which on they are reduced, and to which.
_MOST: Final = 16
_LEFT: Final = 7

_COMPARISONS: Final = {"<": lt, "<=": le, ">": gt, ">=": ge, "==": eq, "!=": ne}

Item = list[Any]


class NoCertificateError(Exception):
    """Raised if a proof has no certificate."""


class _Translation:
    """Operations on numbers, for all expressions of a loop."""

    def __init__(self) -> None:
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
        op, value = self.nodes[a][:2]
        return self.number(-value) if op == "const" else self.product(self.number(-1.0), a)

    def sum(self, a: int, b: int) -> int:
        nothing = ["const", 0.0]
        return b if self.nodes[a] == nothing else a if self.nodes[b] == nothing else self.add("+", a, b)

    def product(self, a: int, b: int) -> int:
        one = ["const", 1.0]
        return b if self.nodes[a] == one else a if self.nodes[b] == one else self.add("*", a, b)

    def larger(self, a: int, b: int) -> int:
        """Return max(a, b) = (a + b + |a - b|) / 2."""
        difference = self.sum(a, self.negative(b))
        return self.product(self.number(0.5), self.sum(self.sum(a, b), self.add("abs", difference)))

    def wave(self, kind: str, a: int) -> int:
        place = len(self.nodes)
        for name, other in (("sin", place + 1), ("cos", place)):
            key = repr((name, a))
            if key not in self._known:
                self._known[key] = len(self.nodes)
                self.nodes.append([name, a, other])
        return self._known[repr((kind, a))]

    def translated(self, nodes: Nodes, inputs: dict[str, Item], wanted: Sequence[int]) -> list[int]:
        """Return for each node its operation, -1 for those that the wanted ones do not need."""
        needed: set[int] = set()
        stack = [*wanted]
        while stack:
            at = stack.pop()
            if at not in needed:
                needed.add(at)
                stack += nodes.nodes[at].parts
        places = [-1] * len(nodes.nodes)
        for at in sorted(needed):
            places[at] = self._place(nodes, at, places, inputs)
        return places

    def _place(self, nodes: Nodes, at: int, places: Sequence[int], inputs: dict[str, Item]) -> int:
        node = nodes.nodes[at]
        parts = [places[p] for p in node.parts]
        if -1 in parts and node.kind not in ("max", "min", "output", "compare", "logic", "where"):
            raise NoCertificateError("a choice has no operation in a certificate")
        match node.kind:
            case "number":
                return self.number(node.detail) if math.isfinite(node.detail) else -1
            case "input":
                return self.add(*inputs[node.detail])
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
                return self.add("abs", *parts)
            case "max" | "min" if -1 in parts:  # clamp(x, 0, inf)
                ends = [nodes.nodes[p].detail for p in node.parts if nodes.nodes[p].kind == "number"]
                if (-math.inf if node.kind == "max" else math.inf) not in ends or max(parts) < 0:
                    raise NoCertificateError("a choice has no operation in a certificate")
                return max(parts)
            case "max":
                return self.larger(*parts)
            case "min":
                return self.negative(self.larger(*map(self.negative, parts)))
            case "output":
                call = nodes.nodes[node.parts[0]]
                return self._output(call.detail, [places[p] for p in call.parts], node.detail)
            case "where" if (choice := _constant(nodes, node.parts[0])) is not None:
                return parts[1] if choice else parts[2]
            case "where" if (first := _at_first(nodes, node.parts[0])) is not None:
                # The state is 0 at the first sample and 1 from then on.
                started = self.add(*inputs[STARTED])
                before, after = parts[1:] if first else parts[:0:-1]
                if -1 in (before, after):
                    raise NoCertificateError("a value may be missing")
                change = self.sum(after, self.negative(before))
                return self.sum(before, self.product(started, change))
            case "system" | "compare" | "logic" | "where":
                return -1
        raise NoCertificateError(f"'{node.kind}' has no operation in a certificate")

    def _output(self, surface: SystemSurface, arguments: list[int], output: int) -> int:
        grid = surface.grid
        if grid is None or max(len(k) for k in grid.knots) < 2:
            raise NoCertificateError(f"system '{surface.system.name}' does not interpolate")
        table, error = grid.outputs[output], surface._boxed.errors[output]
        if not math.isfinite(error):
            raise NoCertificateError(f"the rounding of system '{surface.system.name}' has no bound")
        inputs = [arguments[i] for i in grid.inputs]
        place = self.add("table", self._table(grid.knots, table.value), *inputs)
        if table.weight:
            weight = self.add("table", self._table(grid.knots, table.weight), *inputs)
            place = self.product(place, self.add("inverse", weight))
        return self.add("+", place, self.add("error", 2.0 * error)) if error else place

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
    sets: ReachableSets, claims: Sequence[Any], starts: Sequence[Any], params: Sequence[Any]
) -> dict[str, Any]:
    """Return a loop as data.

    Args:
        sets: The loop, with the conditions of the claims.
        claims: Of each its text and its times, in periods; the last one None for all times.
        starts, params: Ends of the ranges of the states at the begin, those of plants first, and of the params.
    """
    equations = sets.equations
    if equations.rates:
        raise NoCertificateError("controllers at several rates have no operation in a certificate")
    if sets.columns:
        raise NoCertificateError("noise and signals of files have no operation in a certificate")
    new = _Translation()
    groups = {"state": sets.plant, "memory": sets.memory, "held": sets.held, "param": sets.free,
              "disturbance": [*equations.disturbances]}  # fmt: skip
    inputs: dict[str, Item] = {TIME: ["time"]}
    for kind, names in groups.items():
        inputs |= {name: [kind, k] for k, name in enumerate(names)}
    for k in range(len(sets.plant)):  # the first nodes are the states
        new.add("state", k)
    between = new.translated(sets.flow.nodes, inputs, sets.flow.nodes.values)
    rates = [between[v] for v in sets.flow.nodes.values]
    sampled = new.translated(sets.sample, {k: v for k, v in inputs.items() if k not in sets.held}, sets.sample.values)
    if any(sampled[v] < 0 for v in sets.sample.values) or -1 in rates:
        raise NoCertificateError("a choice has no operation in a certificate")
    rounding = new.add("error", ROUNDING)
    values = [
        sampled[v] if new.nodes[sampled[v]][0] == "const" else new.add("+", sampled[v], rounding)
        for v in sets.sample.values
    ]
    places = new.translated(sets.claims, inputs, sets.claims.conditions)
    data = [
        [text, new.clauses(sets.claims, places, at), begin, end]
        for (text, begin, end), at in zip(claims, sets.claims.conditions, strict=True)
    ]
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
    count = len(sets.held)
    return {
        "nodes": new.nodes, "tables": new.tables, "rates": rates, "held": values[:count], "next": values[count:],
        "period": equations.step, "params": [*params], "start": [*starts],
        "disturbances": [[low, high] for low, high, _ in equations.disturbances.values()],
        "names": [*sets.free, *sets.plant, *sets.memory], "claims": data,
    }  # fmt: skip


class Search:
    """The hints of a run, found sample by sample.

    Args:
        loop: The checker of the loop.
        ranges: Of the params, then of the states.
    """

    def __init__(self, loop: Loop, ranges: Sequence[Any]) -> None:
        self.loop = loop
        box = [verify.enclosed(*ends) for ends in ranges]
        forms = [[a[0], 0, *[0] * i, a[1]] for i, a in enumerate(box)]
        self.fixed = keyed(param=forms[: loop.params], disturbance=loop.noise)
        self.rows = forms[loop.params :]
        self.steps: list[dict[str, Any]] = []
        self.before: list[list[int]] = []

    def sample(self) -> tuple[dict[Any, Any], list[list[int]], dict[str, Any]]:
        """Return the values that are held from a sample on, the next memory, and the planes of all tables."""
        n, k = len(self.loop.rates), len(self.steps)
        inputs = self.fixed | keyed(state=self.rows[:n], memory=self.rows[n:]) | {("time",): [k * self.loop.period, 0]}
        hints: dict[str, Any] = {}
        values = self.loop.series(inputs, None, hints)
        for i, (op, *rest) in enumerate(self.loop.nodes):
            if op == "table":
                hints[str(i)] = _plane(self.loop.tables[rest[0]], [values(p) for p in rest[1:]])
        return inputs | keyed(held=[values(i) for i in self.loop.values]), [values(i) for i in self.loop.next], hints

    def period(self, anchor: bool = False) -> None:
        """Find the hints of a period, and go on by it."""
        loop, n, k = self.loop, len(self.loop.rates), len(self.steps)
        inputs, memory, hints = self.sample()
        hint: dict[str, Any] = {"tables": hints}
        count = 1
        while True:
            hint["parts"], x = [], self.rows[:n]
            try:
                for j in range(count):
                    a, b = ((k * count + i) * loop.period // count for i in (j, j + 1))
                    hint["parts"].append(self.part(inputs, x, a, b - a))
                    x, _, _ = loop.advance(inputs, x, a, b - a, hint["parts"][-1])
                break
            except AssertionError:
                count *= 2
                if count > _PARTS:
                    raise
        self.before, rows = self.rows, [*x, *memory]
        columns = verify.columns_of(rows, loop.params)
        self.rows = [[a[0], 0, *symbols] for a, symbols in zip(rows, zip(*columns, strict=True), strict=True)]
        if anchor or len(self.rows[0]) - 2 - loop.params > _MOST * len(rows):
            hint |= self.smaller(anchor) | ({"anchor": True} if anchor else {})
        self.steps.append(hint)

    def come_back(self, begin: float, until: float) -> None:
        """Go on until a set lies within an earlier one.

        Args:
            begin: The first sample that a claim is about.
            until: Processor seconds at which the time is over.

        Raises:
            NoCertificateError: If none does in time.
        """
        p = self.loop.params
        anchor: Any = None
        while True:
            k = len(self.steps) + 1
            place = k in ANCHORS and k >= begin
            self.period(place)
            if place:
                rows = [[a[0], 0, *a[2 : 2 + p]] for a in self.rows]
                anchor = rows, *verify.hinted(self.steps[-1]["set"])
            elif anchor is not None:
                with suppress(AssertionError):
                    self.loop.inside(self.rows, *anchor)
                    return
            if clock.used() > until:
                raise NoCertificateError(f"no set of the first {k} periods lies in an earlier one")

    def part(self, inputs: Any, x: list[list[int]], begin: int, step: int) -> dict[str, Any]:
        """Return a tube over a part of a period.

        Raises:
            AssertionError: If none is found.
        """
        loop, starts = self.loop, [verify.ends(a) for a in x]
        fixed = inputs | {("time",): verify.between(begin, begin + step)}
        tube = starts
        for attempt in range(12):
            span = fixed | keyed(state=[verify.between(*t) for t in tube])
            values = loop.series(span)
            moved = []
            for (low, high), r in zip(starts, loop.rates, strict=True):
                slow, fast = verify.ends(values(r))
                moved.append(
                    (low + min(0, slow * step >> verify.BITS), high + max(0, (fast * step >> verify.BITS) + 1))
                )
            if attempt and all(a <= c and d <= b for (a, b), (c, d) in zip(tube, moved, strict=True)):
                hint = {"tube": [[a / ONE, b / ONE] for a, b in tube], "order": _ORDER}
                return hint | ({"apart": self._apart(span, step)} if loop.noise else {})
            grown = []
            for low, high in moved:
                more = (high - low) // 20 + (ONE >> 40)
                grown.append([_rounded((low - more) / ONE), _rounded((high + more) / ONE)])
            tube = verify.hinted(grown)
        raise AssertionError("no tube is found")

    def _apart(self, inputs: Any, step: int) -> list[float]:
        """Return how far disturbances may move each state."""
        n = len(self.loop.rates)
        keys = [*(("state", j) for j in range(n)), *(("disturbance", j) for j in range(len(self.loop.noise)))]
        slopes = [self.loop.series(inputs, {key: [ONE, 0]}) for key in keys]
        largest = np.array([[max(map(abs, verify.ends(s(r, 1)))) / ONE for s in slopes] for r in self.loop.rates])
        largest = largest.reshape(n, len(keys))
        sources = largest[:, n:] @ np.array([w[1] / ONE for w in self.loop.noise])
        apart = np.zeros(n)
        for _ in range(60):
            apart = step / ONE * (largest[:, :n] @ apart + sources) * (1.0 + 1e-9) + 1e-24
        return [float(a) for a in apart * 1.001]

    def smaller(self, anchor: bool) -> dict[str, Any]:
        """Return a set of fewer symbols that holds the set, and go on with it."""
        params = self.loop.params
        rows = _floats(self.rows)
        g = rows[:, 2 + params :]
        scale = np.maximum(np.abs(g).sum(1), 1e-9)
        sized = np.abs(g / scale[:, None])
        order = np.argsort(sized.max(0) - sized.sum(0))
        large = [] if anchor else sorted(int(k) for k in order[: _LEFT * len(rows)])
        width = min(len(r) for r in self.before)
        motion = modes(*([a[None, :width] for a in _floats(r)] for r in (self.before, self.rows)))
        rest = np.concatenate([np.delete(g, large, 1), np.diag(1e-8 * scale)], 1)
        columns, _ = _boxed(rest, scale, motion)
        columns = columns * (1.02 if anchor else 1.0 + 1e-9)
        hint = [columns.tolist(), np.linalg.inv(columns).tolist(), (1e-11 * scale).tolist()]
        basis, _, slack = verify.hinted(hint)
        keep = [*range(params), *(params + k for k in large)]
        self.rows = [
            [a[0], e, *(a[2 + k] for k in keep), *row] for a, e, row in zip(self.rows, slack, basis, strict=True)
        ]
        return {"set": hint, "keep": keep[params:]}


def _floats(x: Any) -> Any:
    """Return nested lists of units as an array; rows are filled up with zeros."""
    rows = [_floats(y) if isinstance(y, list) else y / ONE for y in x]
    if rows and isinstance(rows[0], np.ndarray) and rows[0].ndim == 1:
        width = max(map(len, rows))
        rows = [np.pad(r, (0, width - len(r))) for r in rows]
    return np.array(rows)


def _rounded(x: float) -> float:
    return float(f"{x:.12g}")


def _plane(table: Any, inputs: list[list[int]]) -> list[list[float]]:
    """Return the slopes of a plane near a table, and those of lines along which its inputs move together."""
    ratios: list[float] = []
    for other in inputs[1:]:  # of the symbols that move both most
        pairs = [(x / ONE, y / ONE) for x, y in zip(inputs[0][2:], other[2:], strict=False) if x]
        pairs.sort(key=lambda p: -abs(p[0]) - abs(p[1]))
        ratios += [y / x for x, y in pairs[:_SHEARS] if abs(y) < 1e6 * abs(x)]
    sides = list(_floats(inputs))
    knots, values = table
    points, heights = _over_slabs(_floats(values), [_floats(k) for k in knots], sides)
    moved = points - np.array([a[0] for a in sides])
    slopes = min(_slopes(moved, heights), key=lambda s: float(np.ptp(heights - moved @ s)))
    return [[float(x) for x in slopes], ratios]


def certificate_of(
    prover: LoopProver, proved: Sequence[Always | Stable]
) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Return the certificates of proved claims of a loop, and by claim why it has none.

    Args:
        prover: Of the loop.
        proved: Claims in its `own` that are proved.
    """
    groups: list[list[Always]] = [[c for c in proved if isinstance(c, Always) and not c.forever]]
    groups += [[c] for c in proved if isinstance(c, Always) and c.forever]
    reasons = {guarantee_text(c): "contraction has no certificate yet" for c in proved if not isinstance(c, Always)}
    parts = []
    for claims in filter(None, groups):
        try:
            parts.append(_source(prover.loop, claims, prover.settings) | _certified(prover, claims))
        except (NoCertificateError, AssertionError) as error:
            reasons |= {guarantee_text(c): str(error) for c in claims}
        except RecursionError:
            reasons |= dict.fromkeys(map(guarantee_text, claims), "its equations are nested too deeply")
    return parts, reasons


def _source(item: LoopBlock, claims: Sequence[Always | Stable], settings: Sequence[str]) -> dict[str, Any]:
    """Return where a loop comes from: files with their hashes, and the lines of the claims."""
    blocks = (item, *item.systems, *item.controllers, *item.plants, *(s for c in item.controllers for s in c.systems))
    paths = dict.fromkeys(b.path for b in blocks if b.path)
    hashes = {p: hashlib.sha256(Path(p).read_bytes()).hexdigest() for p in paths if Path(p).is_file()}
    lines = [f"require {guarantee_text(c)}" for c in claims]
    return {"kind": "loop", "loop": item.name, "lines": lines, "sha256": hashes, "settings": [*settings]}


def is_of(part: dict[str, Any], loop: LoopBlock) -> bool:
    """Return whether the equations, ranges and claims of a part of a certificate are those of a loop."""
    prover = LoopProver(loop, 0.0)
    lines, claims = [*part["lines"]], list[Always]()
    for claim in prover.own:  # a file may have a line twice
        if isinstance(claim, Always) and (text := f"require {guarantee_text(claim)}") in lines:
            lines.remove(text)
            claims.append(claim)
    problem = _problem(prover, claims)[0] if claims and not lines else {"claims": None}
    return bool(json.loads(json.dumps(problem)) == {key: part[key] for key in problem})


def _certified(prover: LoopProver, claims: Sequence[Always]) -> dict[str, Any]:
    """Return the certificate of claims that end together, or never."""
    problem, ranges = _problem(prover, claims)
    loop = Loop(problem)
    proof = _proof(loop, ranges, clock.used() + _SECONDS, _CUTS)
    return problem | {"proofs": [proof | {"claims": [*range(len(loop.claims))]}]}


def _problem(prover: LoopProver, claims: Sequence[Always]) -> tuple[dict[str, Any], list[list[float]]]:
    """Return a loop and claims that end together, or never, as data, and the ranges of params and states."""
    number, loop, forever = prover.loop.number, prover.loop, claims[0].forever
    ends = [math.inf if forever else number(loop.duration if c.end is None else c.end) for c in claims]
    begins = [0.0 if c.begin is None else number(c.begin) for c in claims]
    sets = prover.sets(claims, max(ends))
    step = sets.equations.step
    timed = [
        (guarantee_text(c), _periods(begin, step), None if forever else _periods(end, step))
        for c, begin, end in zip(claims, begins, ends, strict=True)
    ]
    at = {d.state: [d.low, d.high] for d in prover.dimensions if d.state}
    states = [(s.name, s.start) for s in sets.equations.plant_states]
    states += [(s.name, s.start) for s in sets.equations.states]
    starts = [at.get(name, [start, start]) for name, start in states]
    params = [[d.low, d.high] for d in prover.dimensions if not d.state]
    return problem_of(sets, timed, starts, params), [*params, *starts]


def _proof(loop: Loop, ranges: Sequence[list[float]], until: float, cuts: int) -> dict[str, Any]:
    """Return the steps that show all claims, for two halves of the ranges if they do not show them for the whole.

    Args:
        loop: The checker of the loop.
        ranges: Ends of the ranges of params and states.
        until: Processor seconds at which the time is over.
        cuts: How often a range may still be halved.

    Raises:
        AssertionError, NoCertificateError: If they do not show them.
    """
    search = Search(loop, ranges)
    try:
        if any(math.isinf(end) for *_, end in loop.claims):
            search.come_back(max(begin for _, _, begin, _ in loop.claims) / ONE, until)
            proof: dict[str, Any] = {"steps": search.steps}
        else:
            while len(search.steps) * ONE < max(end for *_, end in loop.claims):
                search.period()
            proof = {"steps": [*search.steps, {"tables": search.sample()[2], "parts": []}]}
        loop.run(proof, loop.claims, ranges)
    except AssertionError:
        widths = [(high - low) / (abs(high) + abs(low) + 1e-9) for low, high in ranges]
        if not cuts or clock.used() > until or max(widths) == 0.0:
            raise
        side = widths.index(max(widths))
        low, high = ranges[side]
        middle = 0.5 * (low + high)
        halves = [[*ranges[:side], half, *ranges[side + 1 :]] for half in ([low, middle], [middle, high])]
        return {"cut": [side, middle], "halves": [_proof(loop, half, until, cuts - 1) for half in halves]}
    return proof


def _periods(time: float, step: float) -> float:
    """Return a time in periods; one that differs from a sample by rounding is this sample."""
    count = time / step
    return float(round(count)) if abs(count - round(count)) <= ALIGNED * max(count, 1.0) else count
