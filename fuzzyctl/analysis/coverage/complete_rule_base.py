"""Combinatorial proof of coverage: a rule for every combination of terms, whatever the number of inputs.

Everywhere each input has a term of some least degree. If there is a rule for every combination of the terms, that of
the best ones fires, and no box of the inputs needs to be looked at.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import inf, nextafter
from typing import Final, NamedTuple

from fuzzyctl.analysis.degrees import Cell, bounded, degree_in
from fuzzyctl.analysis.work import Work, units_of
from fuzzyctl.expr import Expr, names_in
from fuzzyctl.kernels.interval.scalar import Interval, enclose
from fuzzyctl.kernels.plan.build import DegreePlan, Plan, SetPlan, step_name
from fuzzyctl.records import record

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
