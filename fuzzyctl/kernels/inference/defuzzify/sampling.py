"""Sampled sets: degrees at the points of a grid, and loops over them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import reduce
from itertools import groupby
from typing import Final

from fuzzyctl.expr import ZERO, Call, Expr, Name, Number, times
from fuzzyctl.formulas import aggregation, conjunction
from fuzzyctl.kernels.plan.build import OutputPlan, SetPlan
from fuzzyctl.kernels.program.builder import Builder
from fuzzyctl.kernels.program.program import Accumulate, Assign, Fold, Item
from fuzzyctl.kernels.program.scalar import scalar_function
from fuzzyctl.records import record

#: (term, its activation as an atom, the largest value the activation can have)
Height = tuple[int, Expr, float]
#: Values that are carried from sample to sample, by meaning.
Carried = Mapping[str, Expr]
#: From a builder for the loop, the value of the sample, its item of each table and the old values: the new values.
Step = Callable[[Builder, Expr, Sequence[Expr], Mapping[str, Expr]], Carried]

HALF: Final = Number(0.5)


def sample_points(output: OutputPlan) -> tuple[float, ...]:
    """Return the grid: middles or left ends of equal cells, or equal steps from end to end."""
    return tuple(points_at(output, range(output.resolution or 0)))


def points_at(output: OutputPlan, positions: Iterable[int]) -> Iterator[float]:
    """Return the points of the grid at some positions, one by one."""
    count = output.resolution or 0
    width = output.upper - output.lower
    if output.grid == "midpoint":
        return (output.lower + (i + 0.5) * width / count for i in positions)
    if output.grid == "left":
        return (output.lower + i * width / count for i in positions)
    return (output.lower + i * width / (count - 1) for i in positions) if count > 1 else iter([output.lower])


def seen_points(output: OutputPlan) -> tuple[float, ...]:
    """Return the points of the grid where a set must be above 0 to count: the bisector from both ends skips one."""
    points = sample_points(output)
    return points[1:] if output.rule == "two_sided" else points


def sampled_degrees(term: SetPlan, points: Sequence[float]) -> tuple[float, ...]:
    """Return the degrees of a term at some points."""
    degree = scalar_function(term.degree(Name("x")))
    return tuple(degree(x) for x in points)


#: The activation of a set, its own degree, and the term.
Part = tuple[Expr, Expr, SetPlan]


def joined(output: OutputPlan, builder: Builder, parts: Sequence[Part]) -> Expr:
    """Return the aggregated degree of an output from the activation of each set and its own degree."""
    return aggregated(output, builder, implied_degrees(output, builder, parts))


def implied_degrees(output: OutputPlan, builder: Builder, parts: Sequence[Part]) -> list[Expr]:
    """Return the degrees of the implied sets as atoms."""
    return [
        builder.let(conjunction(output.implication_of(term), output.equal)(h, builder.let(d))) for h, d, term in parts
    ]


def aggregated(output: OutputPlan, builder: Builder, implied: Sequence[Expr]) -> Expr:
    """Return the aggregated degree from those of the implied sets."""
    join = aggregation(output.aggregation, output.equal)
    return reduce(lambda a, b: builder.let(join(a, b)), implied) if implied else ZERO


@record(frozen=True)
class Samples:
    """An aggregated set at the points of a grid, in a program.

    Args:
        builder: The program to write into.
        output: The output.
        heights: Activations, merged by term as far as the aggregation allows.
        points: The grid.
        degrees: Of each height's term at the points; None for a term with free numbers, whose degrees are computed.
    """

    builder: Builder
    output: OutputPlan
    heights: tuple[Height, ...]
    points: tuple[float, ...]
    degrees: tuple[tuple[float, ...] | None, ...]

    @classmethod
    def of(cls, builder: Builder, output: OutputPlan, heights: Sequence[Height]) -> Samples:
        """Sample the terms of an output."""
        points = sample_points(output)
        terms = [output.terms[t] for t, _, _ in heights]
        degrees = tuple(None if term.is_free else sampled_degrees(term, points) for term in terms)
        return cls(builder, output, tuple(heights), points, degrees)

    def join(self, builder: Builder, degrees: Mapping[int, Expr]) -> Expr:
        """Return the aggregated degree from the degrees of some sets, by the positions of their heights."""
        heights = {k: self.heights[k] for k in degrees}
        return joined(self.output, builder, [(h, degrees[k], self.output.terms[t]) for k, (t, h, _) in heights.items()])

    def at(self, position: int) -> Expr:
        """Return the aggregated degree at one point as an atom."""
        place = Number(self.points[position])
        degrees = {
            k: self._term(k).degree(place) if d is None else Number(d[position]) for k, d in enumerate(self.degrees)
        }
        return self.builder.let(self.join(self.builder, {k: d for k, d in degrees.items() if d != ZERO}))

    def stretches(self, first: int = 0, last: int | None = None) -> Iterator[tuple[tuple[int, ...], int, int]]:
        """Cut the grid into stretches where the same sets are, or may be, above 0; the others cost nothing there.

        Yields:
            The sets, and the first and the last position, the last one excluded.
        """
        stop = len(self.points) if last is None else last
        present = [tuple(k for k, d in enumerate(self.degrees) if d is None or d[i] > 0.0) for i in range(first, stop)]
        begin = first
        for sets, stretch in groupby(present):
            end = begin + len(list(stretch))
            yield sets, begin, end
            begin = end

    def joined(self, inner: Builder, sets: Sequence[int], begin: int, end: int, counter: str) -> Expr:
        """Return the aggregated degree at the sample that a loop over a stretch is at."""
        return self.join(inner, {k: self.degree(k, inner, begin, end, counter) for k in sets})

    def degree(self, k: int, inner: Builder, begin: int, end: int, counter: str) -> Expr:
        """Return the degree of the set at a position at the sample that a loop over a stretch is at."""
        values = self.degrees[k]
        if values is None:
            place = Item(self.builder.table(self.points[begin:end]), counter)
            return inner.let(self._term(k).degree(place))
        return Item(self.builder.table(values[begin:end]), counter)

    def _term(self, height: int) -> SetPlan:
        return self.output.terms[self.heights[height][0]]

    def scan(
        self,
        start: Carried,
        step: Step,
        tables: Sequence[Sequence[float]] = (),
        *,
        first: int = 0,
        gaps: bool = False,
    ) -> Carried:
        """Carry values along the samples.

        Args:
            start: The first values.
            step: The new values from each sample.
            tables: Numbers for each sample.
            first: The first sample that counts.
            gaps: Whether samples count where no set is above 0.
        """
        carried: Carried = dict(start)
        for sets, begin, end in self.stretches(first):
            if not sets and not gaps:
                continue
            counter, inner = self.builder.fresh(), self.builder.inner()
            names = {what: Name(self.builder.fresh()) for what in carried}
            value = self.joined(inner, sets, begin, end, counter)
            items = [inner.let(Item(self.builder.table(t[begin:end]), counter)) for t in tables]
            new = step(inner, inner.let(value), items, names)
            carried = carry(self.builder, inner, end - begin, counter, carried, names, new)
        return carried


def carry(
    builder: Builder,
    inner: Builder,
    count: int,
    counter: str,
    carried: Carried,
    names: Mapping[str, Name],
    new: Carried,
) -> Carried:
    """Write a loop that carries values along by name, from the first ones to the new ones of each entry."""
    then = {what: inner.let(v) for what, v in new.items()}
    body = tuple(s for s in inner.statements if isinstance(s, Assign))
    first, last = (tuple(Assign(names[k].name, values[k]) for k in names) for values in (carried, then))
    builder.statements.append(Fold(count, counter, first, body, last))
    return dict(names)


def sampled_moments(samples: Samples, middle: float) -> tuple[Expr, Expr]:
    """Write Σ x μ(x) and Σ μ(x) over the grid, x counted from the middle; the trapezoid rule halves both ends."""
    last = len(samples.points)
    areas: list[Expr] = []
    moments: list[Expr] = []
    ends = (0, last - 1) if samples.output.rule == "trapezoid" and last > 1 else ()
    for sets, begin, end in samples.stretches(*((1, last - 1) if ends else ())):
        if sets:
            area, moment = _sums(samples, sets, begin, end, middle)
            areas.append(area)
            moments.append(moment)
    for position in ends:
        half = samples.builder.let(times(HALF, samples.at(position)))
        areas.append(half)
        moments.append(samples.builder.let(times(Number(samples.points[position] - middle), half)))
    return samples.builder.total(moments), samples.builder.total(areas)


def _sums(samples: Samples, sets: Sequence[int], begin: int, end: int, middle: float) -> tuple[Expr, Expr]:
    """Add up area and moment over some samples."""
    builder = samples.builder
    counter, inner = builder.fresh(), builder.inner()
    # The last step of the join stays an expression: `area` and `moment` both name it.
    joined = samples.joined(inner, sets, begin, end, counter)
    x = Item(builder.table(p - middle for p in samples.points[begin:end]), counter)
    area, moment = inner.fresh(), inner.fresh()
    body = tuple(s for s in inner.statements if isinstance(s, Assign))
    sums = (Assign(area, joined), Assign(moment, times(x, joined)))
    builder.statements.append(Accumulate(end - begin, counter, body, sums))
    return Name(area), Name(moment)


def total(samples: Samples) -> Expr:
    """Write the sum of all samples, added up from left to right."""
    return samples.scan({"sum": ZERO}, lambda b, v, _, c: {"sum": c["sum"] + v})["sum"]


def largest(samples: Samples) -> Expr:
    """Write the largest sample."""
    return samples.scan({"most": ZERO}, lambda b, v, _, c: {"most": Call("max", (c["most"], v))})["most"]
