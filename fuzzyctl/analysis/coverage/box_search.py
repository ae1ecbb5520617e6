"""Interval search for a region in which no rule fires for an output."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import field
from functools import cache, cached_property
from itertools import pairwise, product
from typing import Final

from fuzzyctl.analysis.degrees import (
    CERTAIN,
    Conditions,
    Truths,
    activation_in,
    always_acts,
    cells,
    chain_in,
    degree_in,
    degrees_read,
    effect_in,
    halved,
)
from fuzzyctl.analysis.work import COVERAGE, SPENT, SpentError, Work, sampling, units_of
from fuzzyctl.expr import Name
from fuzzyctl.formulas import CONJUNCTIONS, IMPLICATIONS
from fuzzyctl.kernels.inference.defuzzify.curved_sets import nodes_of, places_of
from fuzzyctl.kernels.inference.defuzzify.defuzzify import closed_form, support
from fuzzyctl.kernels.inference.defuzzify.sampling import sampled_degrees, seen_points
from fuzzyctl.kernels.interval.scalar import Interval, enclose, hull
from fuzzyctl.kernels.plan.build import DegreePlan, ImpliedPlan, OutputPlan, Plan, SetPlan, chain_name, degree_name
from fuzzyctl.kernels.program.scalar import scalar_function
from fuzzyctl.records import dataclass, record

#: A consequent set narrower than this part of the range, or lower than this at all samples, does not count.
NARROW: Final = 1e-12
#: Units of work for the search itself, where a complete table has not settled it.
BUDGET: Final = 800_000
#: Units of work for a degree over an interval, a step of a firing strength, a degree that is copied, and each further
#: rule of the same firing strength.
_DEGREE, _STEP, _COPIED, _MOVED = 8, 0.5, 0.2, 4
#: Units of a step that is long.
_LONG: Final = 100
#: Most cells that are looked at one by one to extend a hole.
MOST_CELLS: Final = 1000
#: Boxes that are halved where cells alone do not decide.
SPLITS: Final = 4000


@record(frozen=True)
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


@record(frozen=True)
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


@record(frozen=True)
class Undecided:
    """It is not known whether some rule always fires; `reason` says why, `spent` whether for lack of work only."""

    reason: str
    spent: bool = False


Verdict = Hole | Undecided | None


@dataclass
class Search:
    """One search for a hole; it walks the product of the inputs' cells, input by input.

    Rules that cannot fire any more are dropped on the way down, and a box where one must fire is left at once.

    Args:
        plan: The system.
        output: The output.
        free_outputs: Whether outputs in antecedents are walked through like inputs, as if each could have any value in
            its range whatever the inputs are; if not, a degree is known over the whole range only.
        work: The work that is allowed.
    """

    plan: Plan
    output: OutputPlan
    free_outputs: bool = False
    work: Work = field(default_factory=lambda: Work(COVERAGE))
    open_boxes: list[tuple[Interval, ...]] = field(default_factory=list)

    def verdict(self) -> Verdict:
        """Return a hole, None if some rule always moves the output, or why neither is known."""
        try:
            self._prepare()
            if self._is_complete_table():
                return None
            self.work = self.work.part(BUDGET)
            position = self._first_hole()
            return self._split_open_boxes() if position is None else self._grown(position)
        except SpentError:
            return Undecided(SPENT, spent=True)

    def _prepare(self) -> None:
        """Find the rules that count, their strengths, and the inputs they look at."""
        self.rules: dict[int, list[tuple[ImpliedPlan, Interval]]] = {}
        tops = self._tops()
        for entry in self.output.implied:
            rule = self.plan.rules[entry.rule]
            if (rule.weight > 0.0 or always_acts(self.plan, entry)) and entry.term in tops:
                self.rules.setdefault(rule.strength, []).append((entry, tops[entry.term]))
        self.units = {s: units_of(self.plan.strengths[s]) for s in self.rules}
        self.work.spend(sum(self.units.values()))
        names = degrees_read(self.plan, [self.plan.strengths[s] for s in self.rules])
        named = {degree_name(i): d for i, d in enumerate(self.plan.degrees) if degree_name(i) in names}
        inputs = len(self.plan.inputs)
        self.degrees = {n: d for n, d in named.items() if self.free_outputs or d.variable < inputs}
        #: Lets known by their ranges only.
        self.lets: set[str] = set()
        self.fixed: dict[str, Interval] = {chain_name(i): chain_in(self.plan, i) for i in range(len(self.plan.chains))}
        for n, d in named.items():
            if n not in self.degrees:
                variable = self.plan.variable(d.variable)
                self.fixed[n] = degree_in(d.set, (variable.lower, variable.upper))
                self.lets |= {variable.name} & {let.name for let in self.plan.lets}
        self.used = sorted({d.variable for d in self.degrees.values()})
        self.own: dict[int, dict[str, DegreePlan]] = {v: {} for v in self.used}
        for n, d in self.degrees.items():
            self.own[d.variable][n] = d
        self.steps: dict[str, float] = {}
        self.known: dict[tuple[int, int], dict[str, Interval]] = {}
        self.cells = [cells(self.plan.variable(i), sets) for i in self.used for sets in [self._sets.get(i, [])]]

    @cached_property
    def _sets(self) -> dict[int, list[SetPlan]]:
        """The terms of each variable that some rule names."""
        sets: dict[int, list[SetPlan]] = {}
        for d in self.plan.degrees:
            sets.setdefault(d.variable, []).append(d.set)
        return sets

    def _tops(self) -> dict[int, Interval]:
        """Enclose the largest degree of each consequent set that can move the output."""
        output = self.output
        tops: dict[int, Interval] = {}
        for t in dict.fromkeys(entry.term for entry in output.implied):
            self.work.spend(1 + sampling(output, 2))
            top = largest_degree(output, output.terms[t])
            if top is not None:
                tops[t] = top
        return tops

    def _is_complete_table(self) -> bool:
        """Return whether the rules are a complete table, for which no box needs to be looked at."""
        cells_of = dict(zip(self.used, self.cells, strict=True))
        work = self.work.part(0.5 * self.work.left)
        return Conditions(self.plan, self.degrees, cells_of, self.rules, self._acts, work).some_rule_fires()

    def _acts(self, strength: int, fired: Interval) -> bool:
        """Return whether some rule of a firing strength surely moves the output."""
        return any(self._moved(entry, top, fired)[0] >= CERTAIN for entry, top in self.rules[strength])

    def _degrees_in(self, position: int, floats: Interval) -> dict[str, Interval]:
        degrees = self.own[self.used[position]]
        self.work.spend(_DEGREE * len(degrees))
        return {n: degree_in(d.set, floats) for n, d in degrees.items()}

    def _degrees_of(self, position: int, cell: int) -> dict[str, Interval]:
        """Return the degrees in a cell of an input, computed at first use."""
        degrees = self.known.get((position, cell))
        if degrees is None:
            degrees = self.known[position, cell] = self._degrees_in(position, self.cells[position][cell].floats)
        return degrees

    def _truths(self, box: Mapping[str, Interval]) -> Truths:
        self.work.spend(5 + _STEP * len(self.plan.steps) + _COPIED * len(box))
        return Truths(self.plan, {**self.fixed, **box}, self._count_step)

    def _count_step(self, name: str) -> None:
        """Spend the work of a long step, such as an own hedge; short ones are counted with their box."""
        units = self.steps.get(name)
        if units is None:
            units = self.steps[name] = units_of(self.plan.named_steps[name])
        if units > _LONG:
            self.work.spend(units)

    def _activation(self, strength: int, truths: Truths) -> Interval:
        """Enclose how far the rules of a firing strength move the output."""
        self.work.spend(self.units[strength] + _MOVED * (len(self.rules[strength]) - 1))
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
        if self.output.over_rules or IMPLICATIONS[implication].straight:
            return low, high
        implied = _implied(implication)
        return implied(low, top[0]), implied(high, top[1])

    def _remaining(self, alive: list[int], box: Mapping[str, Interval]) -> list[int] | None:
        """Return the rules that may still fire in a box, None if one must."""
        truths = self._truths(box)
        strengths: list[int] = []
        for strength in alive:
            low, high = self._activation(strength, truths)
            if low >= CERTAIN:
                return None
            if high > 0.0:
                strengths.append(strength)
        return strengths

    def _first_hole(self) -> tuple[int, ...] | None:
        """Return the first cell without a firing rule, input by input; collect the cells where it is not clear."""
        box: dict[str, Interval] = dict.fromkeys(self.degrees, (0.0, 1.0))
        waiting: list[tuple[tuple[int, ...], list[int]]] = [((), list(self.rules))]
        depth = 0
        while waiting:
            position, alive = waiting.pop()
            for k in range(len(position), depth):
                box.update(dict.fromkeys(self.own[self.used[k]], (0.0, 1.0)))
            depth = len(position)
            if position:
                box.update(self._degrees_of(depth - 1, position[-1]))
            strengths = self._remaining(alive, box)
            if strengths is None:
                continue
            if not strengths:
                return (*position, *(0 for _ in self.used[depth:]))
            if depth == len(self.used):
                self.open_boxes.append(tuple(self.cells[k][c].floats for k, c in enumerate(position)))
                continue
            self.work.spend(_COPIED * depth * len(self.cells[depth]))
            waiting.extend(((*position, c), strengths) for c in reversed(range(len(self.cells[depth]))))
        return None

    def _is_hole(self, position: tuple[int, ...]) -> bool:
        box: dict[str, Interval] = {}
        for k, c in enumerate(position):
            box |= self._degrees_of(k, c)
        return self._is_silent(box)

    def _is_silent(self, box: Mapping[str, Interval]) -> bool:
        """Return whether no rule fires where degrees are in some intervals."""
        truths = self._truths(box)
        return all(self._activation(s, truths)[1] <= 0.0 for s in self.rules)

    def _grown(self, position: tuple[int, ...]) -> Hole:
        """Extend a hole of one cell to a box of cells, input by input, as long as there is work left."""
        ranges = [(c, c) for c in position]
        with suppress(SpentError):
            self._extend(ranges)
        sides = {}
        for k, (first, last) in enumerate(ranges):
            a, b = self.cells[k][first], self.cells[k][last]
            sides[self.used[k]] = Side(a.ends[0], b.ends[1], a.is_point, b.is_point)
        return self._hole(sides)

    def _extend(self, ranges: list[tuple[int, int]]) -> None:
        """Extend the first and last cells of a hole along each input."""
        hulls = [self._degrees_of(k, first) for k, (first, _) in enumerate(ranges)]
        for k, side in enumerate(self.cells):
            for step in (-1, 1):
                while True:
                    edge = ranges[k][0] - 1 if step < 0 else ranges[k][1] + 1
                    if not 0 <= edge < len(side):
                        break
                    at_edge = self._degrees_of(k, edge)
                    sides = [*hulls[:k], at_edge, *hulls[k + 1 :]]
                    slab = [range(a, b + 1) if j != k else (edge,) for j, (a, b) in enumerate(ranges)]
                    if not self._are_holes(sides, slab):
                        break
                    ranges[k] = (edge, ranges[k][1]) if step < 0 else (ranges[k][0], edge)
                    hulls[k] = {n: hull([degree, at_edge[n]]) for n, degree in hulls[k].items()}

    def _are_holes(self, hulls: Sequence[Mapping[str, Interval]], slab: Sequence[Sequence[int]]) -> bool:
        """Return whether no rule fires in all cells of a slab, looked at together or, if they are few, one by one.

        Args:
            hulls: The degrees in the slab, by input.
            slab: The cells of each input.
        """
        self.work.spend(_COPIED * len(self.degrees))
        if self._is_silent({name: degree for side in hulls for name, degree in side.items()}):
            return True
        return math.prod(map(len, slab)) <= MOST_CELLS and all(map(self._is_hole, product(*slab)))

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
            strengths = self._remaining(list(self.rules), degrees)
            if strengths is None:
                continue
            if not strengths:
                return self._hole({self.used[k]: Side(*floats) for k, floats in enumerate(box)})
            halves = _halved(box)
            if not halves:
                return Undecided(self._doubt("at some points the only rule fires with a strength close to 0"))
            boxes.extend(halves)
        return None

    def _doubt(self, reason: str) -> str:
        names = {o.name for k, o in enumerate(self.plan.outputs) if k in self.output.reads} | self.lets
        return f"all that is known of {', '.join(sorted(names))} is the range" if self.fixed else reason


@cache
def _implied(implication: str) -> Callable[[float, float], float]:
    """Return the function that an implication applies to an activation and a degree."""
    result: Callable[[float, float], float] = scalar_function(CONJUNCTIONS[implication](Name("a"), Name("b")))
    return result


def largest_degree(output: OutputPlan, term: SetPlan) -> Interval | None:
    """Enclose the largest degree of a consequent set; None for one that cannot move the output.

    A set without area in the range has no centroid. A sampled set moves the output if a sample meets it, an exact one
    if its area is far from rounding to 0. An adaptive integral sees the largest degree at its first nodes at least,
    and at most the largest one in the range.
    """
    if output.over_rules:
        return 1.0, 1.0
    if output.resolution is not None:
        largest = max(sampled_degrees(term, seen_points(output)))
        return (largest, largest) if largest >= NARROW else None
    if closed_form(output, [term]):
        ends = support(output, term)
        return (1.0, 1.0) if ends and ends[1] - ends[0] > NARROW * (output.upper - output.lower) else None
    least = max(sampled_degrees(term, nodes_of(output, term)))
    if least < NARROW:
        return None
    degree = term.degree(Name("x"))
    most = max(enclose(degree, {"x": ends})[1] for ends in pairwise(places_of(output, [term])))
    return least, min(most, 1.0)


def _halved(box: tuple[Interval, ...]) -> list[tuple[Interval, ...]]:
    """Cut a box in two across its longest side, none if it is a point."""
    if not box:
        return []
    k = max(range(len(box)), key=lambda i: box[i][1] - box[i][0])
    return [(*box[:k], part, *box[k + 1 :]) for part in halved(box[k])]
