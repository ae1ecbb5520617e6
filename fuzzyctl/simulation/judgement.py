"""Measures and requirements of a loop: which signals they take, and their values on a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace as replaced
from graphlib import TopologicalSorter
from typing import TYPE_CHECKING, Any, Final

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
from fuzzyctl.formats.fz_strings import guarantee_text
from fuzzyctl.model.block import Guarantee, ParamValues
from fuzzyctl.model.forms import bound
from fuzzyctl.model.loop import MEASURES, Always, Loop
from fuzzyctl.records import dataclass

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]
    BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Requirement:
    """A claim about the measures of a run, or about its samples.

    Args:
        text: As it was written.
        holds: Whether the run meets it.
        verdict: The same in words; a run proves nothing of a claim about every instant of every member.
        facts: The measures that it names, with their values, and its tolerance; the first sample that breaks a claim
            about every instant, with the values of its signals.
    """

    text: str
    holds: bool
    verdict: str
    facts: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return the claim and its verdict as plain data."""
        return {"claim": self.text, "holds": self.holds, "verdict": self.verdict, "facts": list(self.facts)}


#: Verdicts on claims about measures, and about every instant; on one that a stopped run has not broken.
MET: Final = {True: "met", False: "not met"}
KEPT: Final = {True: "kept by this run", False: "broken"}
OPEN: Final = "open, the run was stopped"


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
        lets = {d.name for d in loop.signals}
        operands = dict.fromkeys(e for c in calls for e in _signals_of(c))
        operands |= dict.fromkeys(e for g in loop.always for e in operands_of(g.claim) if not isinstance(e, Number))
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

    def requirements(
        self,
        measures: Mapping[str, float],
        t: FloatArray,
        signal: Callable[[Expr], FloatArray],
        free: Mapping[str, float],
        *,
        stopped: bool,
    ) -> tuple[Requirement, ...]:
        """Return whether each requirement holds; none does in a run that was stopped.

        Args:
            measures: By name.
            t: Times of the samples, shape (n,) [s].
            signal: As for `measures`.
            free: Values of free params.
            stopped: Whether the run was stopped.
        """
        params = self._values(free)
        names = params | dict(measures)
        judged = [self._requirement(g, names, measures) for g in self._loop.requirements]
        judged = [replaced(r, holds=False, verdict=MET[False]) for r in judged] if stopped else judged
        always = [_kept(g, t, signal, params, self._params) for g in self._loop.always]
        always = [replaced(r, holds=False, verdict=OPEN) if r.holds else r for r in always] if stopped else always
        return (*judged, *always)

    def _values(self, free: Mapping[str, float]) -> dict[str, float]:
        """Return the values of all params, those that depend on free ones included."""
        params = [replaced(p, expression=Number(free[p.name])) if p.name in free else p for p in self._loop.params]
        return (ParamValues(params).values if free else self._params) | dict(free)

    def _requirement(self, g: Guarantee, names: Mapping[str, float], measures: Mapping[str, float]) -> Requirement:
        within = 0.0 if g.within is None else evaluate(g.within, names)
        used = dict.fromkeys(n.name for n in names_in(g.claim) if n.name in measures)
        facts = tuple(f"{n} = none" if math.isnan(measures[n]) else f"{n} = {measures[n]:.6g}" for n in used)
        tolerance = () if g.within is None else (f"within {within:.6g}",)
        holds = _truth(g.claim, names, within) is True
        return Requirement(to_text(g.claim), holds, MET[holds], facts + tolerance)


def _kept(
    g: Always,
    t: FloatArray,
    signal: Callable[[Expr], FloatArray],
    params: Mapping[str, float],
    constants: Collection[str],
) -> Requirement:
    """Judge a claim about every instant at the samples of a run; one without a value there is broken.

    Args:
        g: The claim.
        t: Times of the samples, shape (n,) [s].
        signal: Returns the record of an expression, shape (n,).
        params: Values of all params.
        constants: Names whose values are no news.
    """
    broken = broken_at(g, t, signal, params)
    facts: tuple[str, ...] = ()
    if len(broken):
        k = int(broken[0])
        reads = dict.fromkeys(e for e in operands_of(g.claim) if not isinstance(e, Number))
        values = [f"{to_text(e)} = {float(signal(e)[k]):.6g}" for e in reads if to_text(e) not in constants]
        facts = (f"at t = {float(t[k]):.6g} s", *values)
    return Requirement(guarantee_text(g), not facts, KEPT[not facts], facts)


def broken_at(
    g: Always,
    t: FloatArray,
    signal: Callable[[Expr], FloatArray],
    params: Mapping[str, float],
    more: float | FloatArray = 0.0,
) -> npt.NDArray[np.intp]:
    """Return the samples at which a claim about every instant is broken, by more than its tolerance and some more."""
    import numpy as np

    from fuzzyctl.simulation.measures import between

    begin, end, within = (default if e is None else evaluate(e, params)
                          for e, default in ((g.begin, 0.0), (g.end, math.inf), (g.within, 0.0)))  # fmt: skip
    holds, _ = _truths(g.claim, signal, within + more)
    return np.flatnonzero(between(t, begin, end) & ~holds)


def operands_of(claim: Expr) -> Iterator[Expr]:
    """Yield the expressions that a condition compares, and those that hold by themselves."""
    match claim:
        case Logic(operands=operands):
            for operand in operands:
                yield from operands_of(operand)
        case Compare(left=left, right=right):
            yield from (left, right)
        case _:
            yield claim


def _truths(
    claim: Expr, signal: Callable[[Expr], FloatArray], within: float | FloatArray
) -> tuple[BoolArray, BoolArray]:
    """Return whether a condition holds, and whether it fails, at each sample, shapes (n,); neither for NaN."""
    match claim:
        case Logic(op="not", operands=(operand,)):
            holds, fails = _truths(operand, signal, within)
            return fails, holds
        case Logic(op=op, operands=(first, *rest)):
            holds, fails = _truths(first, signal, within)
            for operand in rest:
                more_holds, more_fails = _truths(operand, signal, within)
                is_and = op == "and"
                holds = holds & more_holds if is_and else holds | more_holds
                fails = fails | more_fails if is_and else fails & more_fails
            return holds, fails
        case Compare(op=op, left=left, right=right):
            a, b = signal(left), signal(right)
            if op in (">", ">="):
                a, b, op = b, a, "<" if op == ">" else "<="
            if op in ("<", "<="):
                return (a < b + within, a >= b + within) if op == "<" else (a <= b + within, a > b + within)
            near, far = (a <= b + within) & (b <= a + within), (a > b + within) | (b > a + within)
            return (near, far) if op == "==" else (far, near)
    value = signal(claim)
    return (value < 0.0) | (value > 0.0), value == 0.0


def loosened(claim: Expr, tolerance: float) -> Expr:
    """Return a condition whose comparisons hold up to a tolerance."""
    match claim:
        case Compare(op="<" | "<=" as op, left=left, right=right) if tolerance:
            return Compare(op, left, right + tolerance)
        case Compare(op=">" | ">=" as op, left=left, right=right) if tolerance:
            return Compare(op, left + tolerance, right)
        case Compare(op="==" | "!=" as op, left=left, right=right) if tolerance:
            near = Logic("and", (Compare("<=", left, right + tolerance), Compare("<=", right, left + tolerance)))
            return near if op == "==" else Logic("not", (near,))
        case Logic(op=op, operands=operands):
            return Logic(op, tuple(loosened(o, tolerance) for o in operands))
    return claim


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
