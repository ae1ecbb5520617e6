"""Intervals of lets, degrees, firing strengths and activations of a plan over boxes of its inputs.

The inputs are cut at all corners of their terms. Between corners degrees are monotone, so their interval over a cell is
exact; cells are single points and the floats strictly between two neighbouring ones.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

from fuzzyctl.expr import Compare, Expr, Name, Number, names_in
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.interval.scalar import ANYTHING, Interval, decide, enclose
from fuzzyctl.kernels.plan.build import (
    ITSELF,
    CallPlan,
    ImpliedPlan,
    InputPlan,
    LetPlan,
    Plan,
    RulePlan,
    SetPlan,
    chain_name,
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
