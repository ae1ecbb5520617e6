"""Holes: the search for a region in which no rule moves an output."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise, product
from typing import Final

from fuzzyctl.analysis.complete_tables import Conditions, halved
from fuzzyctl.analysis.degrees import (
    CERTAIN,
    Truths,
    activation_in,
    always_acts,
    cells,
    chain_in,
    degree_in,
    degrees_read,
    effect_in,
)
from fuzzyctl.analysis.intervals import Interval, enclose
from fuzzyctl.expr import Name
from fuzzyctl.formulas import CONJUNCTIONS, EXACT_IMPLICATIONS
from fuzzyctl.kernels.adaptive import nodes_of, places_of
from fuzzyctl.kernels.defuzzify import closed_form, support
from fuzzyctl.kernels.plan import (
    ImpliedPlan,
    OutputPlan,
    Plan,
    SetPlan,
    chain_name,
    degree_name,
)
from fuzzyctl.kernels.python_backend import scalar_function
from fuzzyctl.kernels.sampling import sampled_degrees, seen_points

#: A consequent set narrower than this part of the range, or lower than this at all samples, does not count.
NARROW: Final = 1e-12
#: Evaluations of firing strengths spent on one output before it is left undecided: about a second.
BUDGET: Final = 150_000
#: Boxes that are halved where cells alone do not decide.
SPLITS: Final = 4000


@dataclass(frozen=True)
class Side:
    """The values of one input in a region, with or without their ends."""

    lower: float
    upper: float
    lower_closed: bool = True
    upper_closed: bool = True

    def __str__(self) -> str:
        if self.lower == self.upper:
            return f"{self.lower:.6g}"
        brackets = "[" if self.lower_closed else "(", "]" if self.upper_closed else ")"
        # Ends that look equal in six digits are written with as many as tell them apart.
        digits = next(d for d in range(6, 18) if f"{self.lower:.{d}g}" != f"{self.upper:.{d}g}")
        return f"{brackets[0]}{self.lower:.{digits}g}, {self.upper:.{digits}g}{brackets[1]}"

    @property
    def middle(self) -> float:
        """A value inside."""
        if math.isinf(self.lower):
            return 0.0 if math.isinf(self.upper) else self.upper - max(1.0, abs(self.upper))
        if math.isinf(self.upper):
            return self.lower + max(1.0, abs(self.lower))
        middle = 0.5 * self.lower + 0.5 * self.upper
        return min(max(middle, self.lower), self.upper)


@dataclass(frozen=True)
class Hole:
    """A region where no rule fires for an output.

    Args:
        region: The values of each input.
        witness: A point in it.
    """

    region: dict[str, Side]
    witness: dict[str, float]

    def __str__(self) -> str:
        return ", ".join(
            f"{name} {'=' if side.lower == side.upper else 'in'} {side}" for name, side in self.region.items()
        )


@dataclass(frozen=True)
class Undecided:
    """It is not known whether some rule always fires; `reason` says why."""

    reason: str


Verdict = Hole | Undecided | None


@dataclass
class Search:
    """One search for a hole; it walks the product of the inputs' cells, input by input.

    Rules that cannot fire any more are dropped on the way down, and a box where one must fire is left at once.

    Args:
        plan: The system.
        output: The output.
        free_outputs: Whether outputs in antecedents are walked through like inputs, as if each could have any value in
            its range whatever the inputs are; if not, all that is known of a degree is what it is over the range.
    """

    plan: Plan
    output: OutputPlan
    free_outputs: bool = False
    spent: int = 0
    open_boxes: list[tuple[Interval, ...]] = field(default_factory=list)

    def verdict(self) -> Verdict:
        """Return a hole, None if some rule always moves the output, or why neither is known."""
        self._prepare()
        if self._is_complete_table():
            return None
        self.known = [[self._degrees_in(k, cell.floats) for cell in own] for k, own in enumerate(self.cells)]
        try:
            for position in self._holes(0, (), {}, list(self.rules)):
                return self._grown(position)
            return self._split_open_boxes()
        except _SpentError:
            return Undecided(f"the terms of {len(self.used)} inputs cut their ranges into too many cells")

    def _prepare(self) -> None:
        """Find the rules that count, their strengths, and the inputs they look at."""
        self.rules: dict[int, list[tuple[ImpliedPlan, Interval]]] = {}
        terms = {entry.term: self.output.terms[entry.term] for entry in self.output.implied}
        tops = {t: _top(self.output, term) for t, term in terms.items() if counts(self.output, term)}
        for entry in self.output.implied:
            rule = self.plan.rules[entry.rule]
            if (rule.weight > 0.0 or always_acts(self.plan, entry)) and entry.term in tops:
                self.rules.setdefault(rule.strength, []).append((entry, tops[entry.term]))
        names = {n for s in self.rules for n in degrees_read(self.plan, self.plan.strengths[s])}
        named = {degree_name(i): d for i, d in enumerate(self.plan.degrees) if degree_name(i) in names}
        inputs = len(self.plan.inputs)
        self.degrees = {n: d for n, d in named.items() if self.free_outputs or d.variable < inputs}
        self.fixed: dict[str, Interval] = {chain_name(i): chain_in(self.plan, i) for i in range(len(self.plan.chains))}
        for n, d in named.items():
            if n not in self.degrees:
                variable = self.plan.variable(d.variable)
                self.fixed[n] = degree_in(d.set, (variable.lower, variable.upper))
        self.used = sorted({d.variable for d in self.degrees.values()})
        self.cells = [
            cells(self.plan.variable(i), [d.set for d in self.plan.degrees if d.variable == i]) for i in self.used
        ]

    def _is_complete_table(self) -> bool:
        """Return whether the rules are a complete table, for which no box needs to be looked at."""
        cells_of = dict(zip(self.used, self.cells, strict=True))
        return Conditions(self.plan, self.degrees, cells_of, self.rules, self._acts).some_rule_fires()

    def _acts(self, strength: int, fired: Interval) -> bool:
        """Return whether some rule of a firing strength surely moves the output."""
        return any(self._moved(entry, top, fired)[0] >= CERTAIN for entry, top in self.rules[strength])

    def _degrees_in(self, position: int, floats: Interval) -> dict[str, Interval]:
        own = {n: d for n, d in self.degrees.items() if d.variable == self.used[position]}
        return {n: degree_in(d.set, floats) for n, d in own.items()}

    def _activation(self, strength: int, truths: Truths) -> Interval:
        """Enclose how far the rules of a firing strength move the output."""
        self.spent += 1
        if self.spent > BUDGET:
            raise _SpentError
        fired = truths.strength(self.plan.strengths[strength])
        moved = [self._moved(entry, top, fired) for entry, top in self.rules[strength]]
        return max(low for low, _ in moved), max(high for _, high in moved)

    def _moved(self, entry: ImpliedPlan, top: Interval, fired: Interval) -> Interval:
        rule, gate = self.plan.rules[entry.rule], self.plan.least or 0.0
        low, high = activation_in(self.plan, rule, fired)
        method = self.plan.activation_of(entry.rule)
        if method.compares:
            # Which rules act is settled for all of them together.
            least = method.threshold if method.kind in ("first", "last") else 0.0
            low = fired[0] * rule.weight
            low = low if low >= least and low > gate else 0.0
        low, high = effect_in(self.plan, entry, (low, high))
        implication = self.output.implication_of(self.output.terms[entry.term])
        if self.output.over_rules or implication in EXACT_IMPLICATIONS:
            return low, high
        implied = _implied(implication)
        return implied(low, top[0]), implied(high, top[1])

    def _remaining(self, alive: list[int], box: dict[str, Interval]) -> list[int] | None:
        """Return the rules that may still fire in a box, None if one must."""
        truths = Truths(self.plan, self.fixed | box)
        kept: list[int] = []
        for strength in alive:
            low, high = self._activation(strength, truths)
            if low >= CERTAIN:
                return None
            if high > 0.0:
                kept.append(strength)
        return kept

    def _holes(
        self, depth: int, position: tuple[int, ...], box: dict[str, Interval], alive: list[int]
    ) -> Iterator[tuple[int, ...]]:
        """Yield cells without a firing rule; collect those where it is not clear."""
        later = {n: (0.0, 1.0) for n, d in self.degrees.items() if self.used.index(d.variable) >= depth}
        kept = self._remaining(alive, box | later)
        if kept is None:
            return
        if not kept:
            yield (*position, *(0 for _ in self.used[depth:]))
        elif depth == len(self.used):
            self.open_boxes.append(tuple(self.cells[k][c].floats for k, c in enumerate(position)))
        else:
            for c, degrees in enumerate(self.known[depth]):
                yield from self._holes(depth + 1, (*position, c), box | degrees, kept)

    def _is_hole(self, position: tuple[int, ...]) -> bool:
        box: dict[str, Interval] = {}
        for k, c in enumerate(position):
            box |= self.known[k][c]
        truths = Truths(self.plan, self.fixed | box)
        return all(self._activation(s, truths)[1] <= 0.0 for s in self.rules)

    def _grown(self, position: tuple[int, ...]) -> Hole:
        """Extend a hole of one cell to a box of cells, input by input."""
        ranges = [(c, c) for c in position]
        for k, own in enumerate(self.cells):
            for step in (-1, 1):
                while True:
                    edge = ranges[k][0] - 1 if step < 0 else ranges[k][1] + 1
                    slab = [range(a, b + 1) if j != k else (edge,) for j, (a, b) in enumerate(ranges)]
                    if not 0 <= edge < len(own) or not self._all_holes(slab):
                        break
                    ranges[k] = (edge, ranges[k][1]) if step < 0 else (ranges[k][0], edge)
        sides = {}
        for k, (first, last) in enumerate(ranges):
            a, b = self.cells[k][first], self.cells[k][last]
            sides[self.used[k]] = Side(a.ends[0], b.ends[1], a.is_point, b.is_point)
        return self._hole(sides)

    def _all_holes(self, slab: Sequence[Sequence[int]]) -> bool:
        try:
            return all(self._is_hole(position) for position in product(*slab))
        except _SpentError:
            return False

    def _hole(self, sides: dict[int, Side]) -> Hole:
        """Name a region; inputs that do not matter keep their whole range."""
        region = {v.name: sides.get(i, Side(v.lower, v.upper)) for i, v in enumerate(self.plan.inputs)}
        return Hole(region, {name: side.middle for name, side in region.items()})

    def _split_open_boxes(self) -> Verdict:
        """Halve boxes where intervals do not decide, such as those of norms that are not strict."""
        budget = SPLITS
        boxes = self.open_boxes
        while boxes:
            budget -= 1
            if budget < 0:
                return Undecided(self._doubt("firing strengths come too close to 0"))
            box = boxes.pop()
            degrees: dict[str, Interval] = {}
            for k, floats in enumerate(box):
                degrees |= self._degrees_in(k, floats)
            kept = self._remaining(list(self.rules), degrees)
            if kept is None:
                continue
            if not kept:
                return self._hole({self.used[k]: Side(*floats) for k, floats in enumerate(box)})
            halves = _halved(box)
            if not halves:
                return Undecided(self._doubt("at some points the only rule fires with a strength close to 0"))
            boxes.extend(halves)
        return None

    def _doubt(self, reason: str) -> str:
        names = {o.name for k, o in enumerate(self.plan.outputs) if k in self.output.reads}
        return f"all that is known of {', '.join(sorted(names))} is the range" if self.fixed else reason


@cache
def _implied(implication: str) -> Callable[[float, float], float]:
    """Return what an implication makes of an activation and a degree."""
    found: Callable[[float, float], float] = scalar_function(CONJUNCTIONS[implication](Name("a"), Name("b")))
    return found


class _SpentError(Exception):
    """Raised when a search has used up its budget."""


def counts(output: OutputPlan, term: SetPlan) -> bool:
    """Return whether a consequent can move the output: a set without area in the range has no centroid there.

    A sampled set counts if some sample meets it; an exact one if its area is far from rounding to 0.
    """
    if output.over_rules:
        return True
    if output.resolution is not None:
        return max(sampled_degrees(term, seen_points(output))) >= NARROW
    if not closed_form(output, [term]):
        return max(sampled_degrees(term, nodes_of(output, term))) >= NARROW
    ends = support(output, term)
    return bool(ends) and ends[1] - ends[0] > NARROW * (output.upper - output.lower)


def _top(output: OutputPlan, term: SetPlan) -> Interval:
    """Enclose the largest degree of a consequent set that samples, or an adaptive integral, see.

    The integral sees it at its first nodes at least, and at most what it is anywhere in the range.
    """
    if output.over_rules or (output.resolution is None and closed_form(output, [term])):
        return 1.0, 1.0
    if output.resolution is not None:
        top = max(sampled_degrees(term, seen_points(output)))
        return top, top
    nodes = max(sampled_degrees(term, nodes_of(output, term)))
    degree = term.degree(Name("x"))
    return nodes, max(enclose(degree, {"x": ends})[1] for ends in pairwise(places_of(output, [term])))


def _halved(box: tuple[Interval, ...]) -> list[tuple[Interval, ...]]:
    """Cut a box in two across its longest side, none if it is a point."""
    if not box:
        return []
    k = max(range(len(box)), key=lambda i: box[i][1] - box[i][0])
    return [(*box[:k], part, *box[k + 1 :]) for part in halved(box[k])]
