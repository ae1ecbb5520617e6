"""Measures and requirements of a loop: which signals they take, and their values on a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace as replaced
from graphlib import TopologicalSorter
from typing import TYPE_CHECKING

from fuzzyctl.expr import (
    Call,
    Compare,
    Expr,
    ExprError,
    Logic,
    Name,
    Number,
    evaluate,
    names_in,
    replace,
    to_text,
    walk,
)
from fuzzyctl.model.block import Guarantee, ParamValues
from fuzzyctl.model.forms import bound
from fuzzyctl.model.loop import MEASURES, Loop
from fuzzyctl.records import dataclass

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Requirement:
    """A claim about the measures of a run.

    Args:
        text: As it was written.
        holds: Whether the run meets it.
        facts: The measures that it names, with their values, and its tolerance.
    """

    text: str
    holds: bool
    facts: tuple[str, ...] = ()


class Judgement:
    """Measures and requirements of a loop.

    Args:
        loop: The loop.

    Attributes:
        signals: Expressions over signals that are to be recorded besides, in order; lets and outputs are in any case.
    """

    def __init__(self, loop: Loop) -> None:
        self._loop, self._params = loop, loop.param_values.values
        calls = [c for m in loop.measures for c in _calls(m.value)]
        lets = {d.name for d in loop.definitions}
        operands = dict.fromkeys(e for c in calls for e in _signals_of(c))
        self.signals = tuple(e for e in operands if not (isinstance(e, Name) and (e.name in lets or "." in e.name)))

    def measures(
        self, t: FloatArray, signal: Callable[[Expr], FloatArray], free: Mapping[str, float]
    ) -> dict[str, float]:
        """Return the measures by name; NaN for one that cannot be computed.

        Args:
            t: Times of the samples, shape (n,) [s].
            signal: Returns the record of an expression, shape (n,).
            free: Values of free params.
        """
        from fuzzyctl.simulation.measures import measured

        params = self._values(free)

        def value(node: Expr) -> Expr:
            if not (isinstance(node, Call) and node.function in MEASURES):
                return node
            settings = {n: evaluate(e, params) for n, e in _settings_of(node).items()}
            return Number(measured(node.function, t, tuple(map(signal, _signals_of(node))), settings))

        written = {m.name: m.value for m in self._loop.measures}
        reads = {n: [r.name for r in names_in(e) if r.name in written] for n, e in written.items()}
        values = dict(params)
        for name in TopologicalSorter(reads).static_order():
            values[name] = _number(replace(written[name], value), values)
        return {n: values[n] for n in written}

    def requirements(self, measures: Mapping[str, float], free: Mapping[str, float]) -> tuple[Requirement, ...]:
        """Return whether each requirement holds."""
        names = self._values(free) | dict(measures)
        return tuple(self._requirement(g, names, measures) for g in self._loop.requirements)

    def _values(self, free: Mapping[str, float]) -> dict[str, float]:
        """Return the values of all params, those that depend on free ones included."""
        params = [replaced(p, expression=Number(free[p.name])) if p.name in free else p for p in self._loop.params]
        return (ParamValues(params).values if free else self._params) | dict(free)

    def _requirement(self, g: Guarantee, names: Mapping[str, float], measures: Mapping[str, float]) -> Requirement:
        within = 0.0 if g.within is None else evaluate(g.within, names)
        used = dict.fromkeys(n.name for n in names_in(g.claim) if n.name in measures)
        facts = tuple(f"{n} = none" if math.isnan(measures[n]) else f"{n} = {measures[n]:.6g}" for n in used)
        tolerance = () if g.within is None else (f"within {within:.6g}",)
        return Requirement(to_text(g.claim), _truth(g.claim, names, within) is True, facts + tolerance)


def _calls(expr: Expr) -> list[Call]:
    return [node for node in walk(expr) if isinstance(node, Call) and node.function in MEASURES]


def _signals_of(call: Call) -> list[Expr]:
    arguments, form = bound(MEASURES[call.function], call), MEASURES[call.function]
    return [arguments[n] for n in form.signals]


def _settings_of(call: Call) -> dict[str, Expr]:
    arguments, form = bound(MEASURES[call.function], call), MEASURES[call.function]
    return {n: arguments[n] for n in form.settings}


def _number(expr: Expr, names: Mapping[str, float]) -> float:
    if isinstance(expr, Compare | Logic):
        holds = _truth(expr, names, 0.0)
        return math.nan if holds is None else float(holds)
    try:
        return evaluate(expr, names)
    except ExprError:
        return math.nan


def _truth(expr: Expr, names: Mapping[str, float], within: float) -> bool | None:
    """Return whether a condition holds; comparisons hold up to a tolerance, and are open, None, for NaN."""
    match expr:
        case Logic(op="not", operands=(operand,)):
            truth = _truth(operand, names, within)
            return None if truth is None else not truth
        case Logic(op=op, operands=operands):
            decides = op == "or"
            truths = [_truth(o, names, within) for o in operands]
            return decides if decides in truths else None if None in truths else not decides
        case Compare(op=op, left=left, right=right):
            a, b = _number(left, names), _number(right, names)
            if math.isnan(a) or math.isnan(b):
                return None
            if a == b and math.isinf(a):
                return op in ("<=", ">=", "==")
            return {
                "<": a < b + within, "<=": a <= b + within, ">": a > b - within, ">=": a >= b - within,
                "==": abs(a - b) <= within, "!=": abs(a - b) > within,
            }[op]  # fmt: skip
    value = _number(expr, names)
    return None if math.isnan(value) else value != 0.0
