"""Coverage: does some rule fire everywhere, and if not, where does none?

The inputs are cut at all corners of their terms. Between corners degrees are monotone, so their interval over a cell is
exact; cells are single points and the floats strictly between two neighbouring ones.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise, product
from typing import Final

from fuzzyctl.analysis.intervals import Interval, enclose
from fuzzyctl.errors import Diagnostic
from fuzzyctl.expr import Name, names_in
from fuzzyctl.kernels.defuzzify import sample_points, sampled_degrees, support
from fuzzyctl.kernels.plan import InputPlan, OutputPlan, Plan, SetPlan, degree_name, plan
from fuzzyctl.model.system import FuzzySystem

#: A rule whose activation is at least this counts as firing: far above where sums and areas of activations lose digits.
CERTAIN: Final = 1e-200
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
        return f"{brackets[0]}{self.lower:.6g}, {self.upper:.6g}{brackets[1]}"

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


def uncovered(system: FuzzySystem) -> dict[str, Verdict]:
    """Find for each output a region where no rule fires.

    Returns:
        By name of the output None (proved: some rule always fires), a `Hole`, or `Undecided`. What is proved holds for
        the floats that kernels compute.
    """
    return uncovered_of(plan(system))


def uncovered_of(flat: Plan) -> dict[str, Verdict]:
    """Do the same for a plan."""
    return {output.name: _Search(flat, output).verdict() for output in flat.outputs}


def diagnostics(system: FuzzySystem) -> list[Diagnostic]:
    """Report each output without `else` for which some rule is not proved to fire always."""
    verdicts = uncovered(system)
    found: list[Diagnostic] = []
    for output in system.outputs:
        verdict = verdicts[output.name]
        named = any(c.output == output.name for rule in system.rules for c in rule.consequents)
        # An output without rules has a diagnostic of its own.
        if verdict is None or output.otherwise is not None or not named:
            continue
        if isinstance(verdict, Hole):
            witness = ", ".join(f"{n} = {v:.6g}" for n, v in verdict.witness.items())
            message = f"no rule fires for output '{output.name}' where {verdict}"
            is_point = all(side.lower == side.upper for side in verdict.region.values())
            facts = [] if is_point else [f"for example at {witness}"]
            facts.append("without 'else' some rule must fire everywhere")
            help_text = f"let a term of the inputs reach there, or say 'output {output.name} ... else VALUE'"
        else:
            message = f"it cannot be decided whether some rule always fires for output '{output.name}'"
            facts = [verdict.reason]
            help_text = f"say what holds where none does: 'output {output.name} ... else VALUE'"
        found.append(Diagnostic("FZ401", message, output.span, facts=tuple(facts), help=help_text))
    return found


@dataclass(frozen=True)
class Cell:
    """A point or the floats strictly between two points, as an interval of floats, with the points it lies between."""

    floats: Interval
    ends: Interval
    is_point: bool


def breakpoints(variable: InputPlan, sets: Sequence[SetPlan]) -> list[float]:
    """Return the corners of some terms of an input, and its range, as far as its values reach."""
    found = {variable.lower, variable.upper}
    for term in sets:
        corners = [x for x, _ in term.vertices] or list(_core(term))
        found |= {x for x in corners if variable.extrapolate or variable.lower <= x <= variable.upper}
    return sorted(found)


def _core(term: SetPlan) -> tuple[float, ...]:
    return (term.peak,)


def cells(variable: InputPlan, sets: Sequence[SetPlan]) -> list[Cell]:
    """Cut the values of an input at the corners of some of its terms."""
    points: list[float] = list(breakpoints(variable, sets))
    if variable.extrapolate:
        points = [-math.inf, *points, math.inf]
    found: list[Cell] = []
    for a, b in pairwise(points):
        if not math.isinf(a):
            found.append(Cell((a, a), (a, a), True))
        between = (a if math.isinf(a) else math.nextafter(a, b), b if math.isinf(b) else math.nextafter(b, a))
        if between[0] <= between[1]:
            found.append(Cell(between, (a, b), False))
    last = points[-1]
    if not math.isinf(last):
        found.append(Cell((last, last), (last, last), True))
    return found


@dataclass
class _Search:
    """One search for a hole; it walks the product of the inputs' cells, input by input.

    Rules that cannot fire any more are dropped on the way down, and a box where one must fire is left at once.
    """

    plan: Plan
    output: OutputPlan
    spent: int = 0
    open_boxes: list[tuple[Interval, ...]] = field(default_factory=list)

    def verdict(self) -> Verdict:
        self._prepare()
        try:
            for position in self._holes(0, (), {}, list(self.weights)):
                return self._grown(position)
            return self._split_open_boxes()
        except _SpentError:
            return Undecided(f"the terms of {len(self.used)} inputs cut their ranges into too many cells")

    def _prepare(self) -> None:
        """Find the rules that count, their strengths, and the inputs they look at."""
        self.weights: dict[int, float] = {}
        for entry in self.output.implied:
            rule = self.plan.rules[entry.rule]
            if rule.weight > 0.0 and _counts(self.output, self.output.terms[entry.term]):
                self.weights[rule.strength] = max(rule.weight, self.weights.get(rule.strength, 0.0))
        names = {n.name for s in self.weights for n in names_in(self.plan.strengths[s])}
        self.degrees = {degree_name(i): d for i, d in enumerate(self.plan.degrees) if degree_name(i) in names}
        self.used = sorted({d.variable for d in self.degrees.values()})
        self.cells = [
            cells(self.plan.inputs[i], [d.set for d in self.plan.degrees if d.variable == i]) for i in self.used
        ]
        self.known = [[self._degrees_in(k, cell.floats) for cell in own] for k, own in enumerate(self.cells)]

    def _degrees_in(self, position: int, floats: Interval) -> dict[str, Interval]:
        here = {"x": floats}
        own = {n: d for n, d in self.degrees.items() if d.variable == self.used[position]}
        return {n: enclose(d.set.degree(Name("x")), here) for n, d in own.items()}

    def _activation(self, strength: int, box: dict[str, Interval]) -> Interval:
        self.spent += 1
        if self.spent > BUDGET:
            raise _SpentError
        low, high = enclose(self.plan.strengths[strength], box)
        return low * self.weights[strength], high * self.weights[strength]

    def _remaining(self, alive: list[int], box: dict[str, Interval]) -> list[int] | None:
        """Return the rules that may still fire in a box, None if one must."""
        kept: list[int] = []
        for strength in alive:
            low, high = self._activation(strength, box)
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
        return all(self._activation(s, box)[1] <= 0.0 for s in self.weights)

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
                return Undecided("firing strengths come too close to 0")
            box = boxes.pop()
            degrees: dict[str, Interval] = {}
            for k, floats in enumerate(box):
                degrees |= self._degrees_in(k, floats)
            kept = self._remaining(list(self.weights), degrees)
            if kept is None:
                continue
            if not kept:
                return self._hole({self.used[k]: Side(*floats) for k, floats in enumerate(box)})
            halves = _halved(box)
            if not halves:
                return Undecided("at some points the only rule fires with a strength close to 0")
            boxes.extend(halves)
        return None


class _SpentError(Exception):
    """Raised when a search has used up its budget."""


def _counts(output: OutputPlan, term: SetPlan) -> bool:
    """Return whether a consequent can move the output: a set without area in the range has no centroid there.

    A sampled set counts if some sample meets it; an exact one if its area is far from rounding to 0.
    """
    if output.averages:
        return True
    if output.resolution is not None:
        return max(sampled_degrees(term, sample_points(output))) >= NARROW
    ends = support(output, term)
    return bool(ends) and ends[1] - ends[0] > NARROW * (output.upper - output.lower)


def _halved(box: tuple[Interval, ...]) -> list[tuple[Interval, ...]]:
    """Cut a box in two across its longest side, none if it is a point."""
    k = max(range(len(box)), key=lambda i: box[i][1] - box[i][0])
    low, high = box[k]
    if low == high:
        return []
    middle = _between(low, high)
    left, right = (low, middle), (math.nextafter(middle, math.inf), high)
    return [(*box[:k], part, *box[k + 1 :]) for part in (left, right) if part[0] <= part[1]]


def _between(low: float, high: float) -> float:
    if math.isinf(low):
        return high - max(1.0, abs(high)) * 1e6
    if math.isinf(high):
        return low + max(1.0, abs(low)) * 1e6
    return min(max(0.5 * low + 0.5 * high, low), math.nextafter(high, -math.inf))
