"""Intervals of lets, degrees, firing strengths and activations over boxes of inputs; whether some rule fires there.

The inputs are cut at all corners of their terms. Between corners degrees are monotone, so their interval over a cell is
exact; cells are single points and the floats strictly between two neighbouring ones.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from math import inf, nextafter
from typing import Final, NamedTuple

from fuzzyctl.analysis.work import Work, units_of
from fuzzyctl.expr import Compare, Expr, Name, Number, names_in
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.interval.scalar import ANYTHING, Interval, decide, enclose
from fuzzyctl.kernels.plan.build import (
    ITSELF,
    CallPlan,
    DegreePlan,
    ImpliedPlan,
    InputPlan,
    LetPlan,
    Plan,
    RulePlan,
    SetPlan,
    chain_name,
    step_name,
)
from fuzzyctl.records import record

#: A rule whose activation is at least this counts as firing: far above where sums and areas of activations lose digits.
CERTAIN: Final = 1e-200


@record(frozen=True)
class Cell:
    """A point or the floats strictly between two points, as an interval of floats, with the points it lies between."""

    floats: Interval
    ends: Interval
    is_point: bool


def chain_in(flat: Plan, position: int) -> Interval:
    """Enclose how far a term of an output may have been activated by the rules before."""
    chain = flat.chains[position]
    most = float(len(chain.entries)) if flat.outputs[chain.output].aggregation == "sum" else 1.0
    return 0.0, most


class Truths(Mapping[str, Interval]):
    """Intervals of degrees, and of the steps of firing strengths, each computed at first use.

    Args:
        flat: The plan.
        degrees: By name the intervals of degrees.
        before: Called with the name of each step before it is computed.
    """

    def __init__(
        self, flat: Plan, degrees: Mapping[str, Interval], before: Callable[[str], None] | None = None
    ) -> None:
        self._before = before
        self._steps = flat.named_steps
        self._known = {chain_name(i): chain_in(flat, i) for i in range(len(flat.chains))} | dict(degrees)
        # The rules of a chain may add up to more than a degree.
        self._most = max((high for _, high in self._known.values()), default=1.0) if flat.chains else 1.0

    def __getitem__(self, name: str) -> Interval:
        if name in self._known:
            return self._known[name]
        waiting = [name]
        while waiting:
            # Steps read earlier ones; a long chain of them must not be a deep recursion.
            step = waiting[-1]
            missing = {n.name for n in names_in(self._steps[step])} - self._known.keys()
            if missing:
                waiting.extend(missing)
            elif step in self._known:  # which two that wait may read
                waiting.pop()
            else:
                if self._before is not None:
                    self._before(step)
                self._known[step] = self.strength(self._steps[step])
                waiting.pop()
        return self._known[name]

    def strength(self, expr: Expr) -> Interval:
        """Return the interval of a firing strength, which is a degree too."""
        return bounded(enclose(expr, self), self._most)

    def __iter__(self) -> Iterator[str]:
        return iter(self._known)

    def __len__(self) -> int:
        return len(self._known)


def degree_in(term: SetPlan, x: Interval) -> Interval:
    """Enclose the degrees of a term over an interval."""
    if term.expression is not None and math.inf in map(abs, x):
        return 0.0, term.height
    return bounded(enclose(term.degree_of_x, {"x": x}), term.height)


def bounded(values: Interval, most: float) -> Interval:
    """Return an interval clamped to the range of degrees."""
    return min(max(values[0], 0.0), most), min(max(values[1], 0.0), most)


def degrees_read(flat: Plan, strengths: Iterable[Expr]) -> set[str]:
    """Return the names of the degrees that some firing strengths depend on."""
    steps = flat.named_steps
    results: set[str] = set()
    waiting = list(strengths)
    while waiting:
        for name in {n.name for n in names_in(waiting.pop())} - results:
            results.add(name)
            if name in steps:
                waiting.append(steps[name])
    return results - steps.keys()


def activation_in(flat: Plan, rule: RulePlan, strength: Interval) -> Interval:
    """Enclose how far a rule acts: 0 where the activation method may leave it out, or it is not above the least."""
    low, high = _chosen(flat, rule, strength)
    least = flat.least or 0.0
    return (low if low > least else 0.0), (high if high > least else 0.0)


def effect_in(flat: Plan, entry: ImpliedPlan, activation: Interval) -> Interval:
    """Enclose the activation applied to a consequent of a rule, after hedges and weight."""
    low, high = activation
    if entry.change is not None:
        low, high = bounded(enclose(entry.change, {ITSELF: activation}), math.inf)
        method = flat.activation_of(entry.rule)
        if flat.least is not None or method.kind != "general":
            # Hedges make nothing of a rule that does not act.
            low = low if activation[0] > 0.0 else 0.0
        if flat.least is not None or method.compares:
            # A threshold may let a rule of activation 0 act if it is the only condition.
            high = high if activation[1] > 0.0 else 0.0
    return low * entry.factor, high * entry.factor


def always_acts(flat: Plan, entry: ImpliedPlan) -> bool:
    """Return whether hedges may make something of a rule whose activation is 0."""
    return flat.least is None and entry.change is not None


def _chosen(flat: Plan, rule: RulePlan, strength: Interval) -> Interval:
    low, high = strength[0] * rule.weight, strength[1] * rule.weight
    method = flat.activations[rule.group]
    match method.kind:
        case "threshold":
            truth = decide(Compare(method.comparison, Name("a"), Number(method.threshold)), {"a": (low, high)})
            return (low, high) if truth else (0.0, 0.0 if truth is False else high)
        case "first" | "last" if high < method.threshold:
            return 0.0, 0.0
        case "proportional":
            return 0.0, 1.0 if high > 0.0 else 0.0
    return (low if method.kind == "general" else 0.0), high


def breakpoints(variable: InputPlan, sets: Sequence[SetPlan]) -> list[float]:
    """Return the values at which the formulas of some terms of an input change, and the ends of its range."""
    results = {variable.lower, variable.upper}
    for term in sets:
        corners = [x for x, _ in term.vertices] or term.pieces
        results |= {x for x in corners if variable.extrapolate or variable.lower <= x <= variable.upper}
    return sorted(results)


def cells(variable: InputPlan, sets: Sequence[SetPlan]) -> list[Cell]:
    """Cut the values of an input at the corners of some of its terms."""
    points: list[float] = list(breakpoints(variable, sets))
    if variable.extrapolate:
        points = [-math.inf, *points, math.inf]
    results: list[Cell] = []
    for a, b in pairwise(points):
        if not math.isinf(a):
            results.append(Cell((a, a), (a, a), True))
        between = (a if math.isinf(a) else math.nextafter(a, b), b if math.isinf(b) else math.nextafter(b, a))
        if between[0] <= between[1]:
            results.append(Cell(between, (a, b), False))
    last = points[-1]
    if not math.isinf(last):
        results.append(Cell((last, last), (last, last), True))
    return results


def enclosed(flat: Plan) -> dict[str, Interval]:
    """Enclose the inputs as consequents see them, and the lets, by name."""
    box = {i.name: ANYTHING if i.extrapolate else (i.lower, i.upper) for i in flat.inputs}
    for let in flat.lets:
        for call in let.calls:
            box[call.name] = _called(call, [enclose(a, box) for a in call.arguments])
        box[let.name] = enclose(let.value, box)
    return box


def narrowed(flat: Plan) -> Plan:
    """Return a plan whose lets have no wider ranges than they need: it computes the same."""
    box = enclosed(flat)
    return replace(flat, lets=tuple(_narrowed(let, box[let.name]) for let in flat.lets))


def without_idle(flat: Plan) -> Plan:
    """Return a plan without its lets where no rule reads one and all have a value everywhere: it computes the same."""
    others = len(flat.inputs) + len(flat.outputs)
    if any(d.variable >= others for d in flat.degrees) or any(let.calls for let in flat.lets):
        return flat
    box = enclosed(flat)
    return flat if any(box[let.name] == ANYTHING for let in flat.lets) else replace(flat, lets=())


def _narrowed(let: LetPlan, ends: Interval) -> LetPlan:
    lower, upper = max(let.lower, ends[0]), min(let.upper, ends[1])
    is_valid = math.isfinite(let.lower) and lower < upper
    return replace(let, lower=lower, upper=upper) if is_valid else let


def _called(call: CallPlan, arguments: Sequence[Interval]) -> Interval:
    """Enclose an output of another system for enclosed arguments."""
    # Only systems that call others need arrays here.
    import numpy as np

    from fuzzyctl.kernels.interval.program import Interpreter
    from fuzzyctl.kernels.interval.vector import constant

    program = inference.evaluation(call.system)
    values = dict(zip(program.arguments, (constant(*ends) for ends in arguments), strict=True))
    with np.errstate(all="ignore"):
        (result,) = Interpreter(values).run(program, [call.output])
    return (float(result.lo), float(result.hi)) if result.lo <= result.hi else ANYTHING


#: A degree that is high enough: products of hundreds of them do not underflow.
_HIGH: Final = 0.25
#: How often a cell is halved if no term has such a degree in all of it.
_HALVINGS: Final = 6
#: Firing strengths that no rounding brings to where activations lose digits, whatever the order of a product.
_CLEAR: Final = 1e-150
#: Units of work for a rule that is looked at, and for a degree over an interval.
_LOOKED, _DEGREE = 0.5, 10

#: The names of degrees, as they are or hedged, that a firing strength depends on: one for each of some variables.
Literals = Mapping[int, str]


@record(frozen=True)
class Conditions:
    """The degrees and steps that the rules depend on which can move the output.

    Args:
        plan: The system.
        degrees: By name those that vary: terms of inputs, and of outputs that are walked through like inputs.
        cells: By variable its values, cut at the corners of its terms.
        strengths: Positions of the firing strengths of the rules.
        acts: From the position of a firing strength and the interval it is in whether some rule of it surely acts.
        work: The work that is allowed before a search takes over.
    """

    plan: Plan
    degrees: Mapping[str, DegreePlan]
    cells: Mapping[int, Sequence[Cell]]
    strengths: Iterable[int]
    acts: Callable[[int, Interval], bool]
    work: Work

    def some_rule_fires(self) -> bool:
        """Return whether the rules are a table that is known to be complete; False says nothing about the rules."""
        steps = {step_name(i): step for i, step in enumerate(self.plan.steps)}
        by_step = _literals_of_steps(self.degrees, steps)
        by_strength = {s: _joined(self.plan.strengths[s], by_step) for s in self.strengths}
        conditions = {s: literals for s, literals in by_strength.items() if literals}
        # A table may be complete without a rule with a hedge.
        plain = {s: literals for s, literals in conditions.items() if all(n in self.degrees for n in literals.values())}
        return self._covered(conditions, steps) or (len(plain) < len(conditions) and self._covered(plain, steps))

    def _covered(self, rules: Mapping[int, Literals], steps: Mapping[str, Expr]) -> bool:
        if not rules:
            return False
        names: dict[int, dict[str, None]] = {}
        for literals in rules.values():
            for variable, name in literals.items():
                names.setdefault(variable, {})[name] = None
        sets = {v: {n: d.set for n, d in self.degrees.items() if d.variable == v} for v in names}
        candidates = {v: _candidates(self.cells[v], list(group), sets[v]) for v, group in names.items()}
        if not all(group for cells in candidates.values() for group in cells):
            return False  # a cell in which all terms are 0
        least = {}
        for variable in names:
            least[variable] = _least(
                self.cells[variable], candidates[variable], _Sets(sets[variable], steps, self.work)
            )
            if least[variable] == 0.0:
                return False
        fired = _Truths({n: (least[v], 1.0) for v, group in names.items() for n in group}, steps)
        sure = [literals for s, literals in rules.items() if self._is_sure(s, fired)]
        return _Table([list(group) for group in names.values()], self.work).is_covered(
            [tuple(literals.get(v, "") for v in names) for literals in sure]
        )

    def _is_sure(self, strength: int, truths: _Truths) -> bool:
        fired = truths.strength(self.plan.strengths[strength])
        return fired[0] >= _CLEAR and self.acts(strength, fired)


def _least(cells: Sequence[Cell], candidates: Sequence[Sequence[str]], sets: _Sets) -> float:
    """Return a degree that one of some literals has wherever a variable is."""
    least = 1.0
    for cell, names in zip(cells, candidates, strict=True):
        least = min(least, _best(cell.floats, names, sets, _HALVINGS))
        if least == 0.0:
            break
    return least


def _literals_of_steps(degrees: Mapping[str, DegreePlan], steps: Mapping[str, Expr]) -> dict[str, Literals | None]:
    """Return the variables that degrees and steps depend on; steps of one variable, as hedged terms, are literals."""
    literals: dict[str, Literals | None] = {name: {d.variable: name} for name, d in degrees.items()}
    of_variable = {name: {d.variable} for name, d in degrees.items()}
    for name, step in steps.items():
        parts = [of_variable.get(n.name) for n in names_in(step)]
        variables = {v for p in parts if p is not None for v in p}
        if None not in parts:
            of_variable[name] = variables
        literals[name] = (
            dict.fromkeys(variables, name) if None not in parts and len(variables) == 1 else _joined(step, literals)
        )
    return literals


def _joined(expr: Expr, known: Mapping[str, Literals | None]) -> Literals | None:
    """Return the variables that an expression depends on; None if it reads two literals of one, or anything else."""
    results: dict[int, str] = {}
    for name in names_in(expr):
        literals = known.get(name.name)
        if literals is None or any(results.setdefault(v, n) != n for v, n in literals.items()):
            return None
    return results


class _Truths(dict[str, Interval]):
    """Intervals of literals, and of the steps that read them, each computed at first use."""

    def __init__(self, known: Mapping[str, Interval], steps: Mapping[str, Expr]) -> None:
        super().__init__(known)
        self._steps = steps

    def __missing__(self, name: str) -> Interval:
        waiting = [name]
        while waiting:
            # Steps read earlier ones; a long chain of them must not be a deep recursion.
            step = self._steps[waiting[-1]]
            missing = [n.name for n in names_in(step) if n.name not in self and n.name in self._steps]
            if missing:
                waiting.extend(missing)
            else:
                self[waiting.pop()] = self.strength(step)
        return self[name]

    def strength(self, expr: Expr) -> Interval:
        return bounded(enclose(expr, self), 1.0)


def _candidates(cells: Sequence[Cell], names: Sequence[str], sets: Mapping[str, SetPlan]) -> list[list[str]]:
    """Return for each cell the literals that may be above 0 in it."""
    candidates: list[list[str]] = [[] for _ in cells]
    starts, stops = [cell.floats[0] for cell in cells], [cell.floats[1] for cell in cells]
    for name in names:
        corners = sets[name].vertices if name in sets else ()
        first = bisect_left(stops, corners[0][0]) if corners and corners[0][1] == 0.0 else 0
        last = bisect_right(starts, corners[-1][0]) if corners and corners[-1][1] == 0.0 else len(cells)
        for row in candidates[first:last]:
            row.append(name)
    return candidates


class _Sets(NamedTuple):
    """The terms of a variable, the steps that read them, and the work that is allowed."""

    terms: Mapping[str, SetPlan]
    steps: Mapping[str, Expr]
    work: Work


def _best(x: Interval, names: Sequence[str], sets: _Sets, halvings: int) -> float:
    """Return a degree that one of some literals has everywhere in an interval; 0 where there is no work left."""
    if not sets.work.takes(_DEGREE * (len(names) + 1)):
        return 0.0
    truths = _Degrees(x, sets)
    degrees = [truths[n] for n in names]
    best = max([low for low, _ in degrees], default=0.0)
    if best >= _HIGH or halvings == 0 or max([high for _, high in degrees], default=0.0) == 0.0:
        return best
    halves = halved(x)
    return max(best, min((_best(h, names, sets, halvings - 1) for h in halves), default=0.0))


class _Degrees(_Truths):
    """Degrees over an interval of a variable, and the steps that read them."""

    def __init__(self, x: Interval, sets: _Sets) -> None:
        super().__init__({}, sets.steps)
        self._x, self._sets = x, sets

    def __missing__(self, name: str) -> Interval:
        if name not in self._sets.terms:
            return super().__missing__(name)
        result = self[name] = degree_in(self._sets.terms[name], self._x)
        return result

    def strength(self, expr: Expr) -> Interval:
        return super().strength(expr) if self._sets.work.takes(units_of(expr)) else (0.0, 1.0)


def halved(x: Interval) -> tuple[Interval, ...]:
    """Return the floats of an interval in two parts, none for a point."""
    low, high = x
    if low == high:
        return ()
    middle = _between(low, high)
    right = nextafter(middle, inf), high
    return ((low, middle), right) if right[0] <= high else ((low, middle),)


def _between(low: float, high: float) -> float:
    if low == -inf:
        return high - max(1.0, abs(high)) * 1e6
    if high == inf:
        return low + max(1.0, abs(low)) * 1e6
    return min(max(0.5 * low + 0.5 * high, low), nextafter(high, -inf))


class _Table:
    """The combinations of the literals of some variables.

    Args:
        literals: Of each variable.
        work: The work that is allowed; if it does not suffice, no box counts as covered.
    """

    def __init__(self, literals: Sequence[Sequence[str]], work: Work) -> None:
        self._literals, self._work = literals, work

    def is_covered(self, rules: Sequence[Sequence[str]], depth: int = 0) -> bool:
        """Return whether each combination has a rule.

        Args:
            rules: For each variable the literal it asks for, an empty text where it asks for none.
            depth: The first variable that is not settled yet.
        """
        if not rules or not self._work.takes(1 + _LOOKED * len(rules)):
            return False
        if any(not any(rule[depth:]) for rule in rules):
            return True
        of: dict[str, list[Sequence[str]]] = {}
        for rule in rules:
            of.setdefault(rule[depth], []).append(rule)
        free = of.pop("", [])
        if not of:
            return self.is_covered(free, depth + 1)
        return all(self.is_covered(of.get(n, []) + free, depth + 1) for n in self._literals[depth])
