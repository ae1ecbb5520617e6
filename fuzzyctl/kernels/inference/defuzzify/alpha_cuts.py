"""Maxima of a union of sets in closed form, by alpha-cuts."""

from __future__ import annotations

import math
from collections.abc import Sequence

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Name, Number, Where, minus, times
from fuzzyctl.formulas import MEMBERSHIP, Cut, alpha_cut
from fuzzyctl.formulas.shared import is_infinite
from fuzzyctl.kernels.inference.defuzzify.centroid import Height
from fuzzyctl.kernels.inference.defuzzify.envelope import sorted_atoms
from fuzzyctl.kernels.inference.defuzzify.maxima import Hits, place_of, tolerance
from fuzzyctl.kernels.plan.build import OutputPlan, SetPlan
from fuzzyctl.kernels.program.builder import Builder, clip
from fuzzyctl.kernels.program.scalar import scalar_function


def has_cuts(term: SetPlan) -> bool:
    """Return whether every alpha-cut of the term is one interval with closed-form end points."""
    return term.expression is None and not term.changes and alpha_cut(term.kind, ONE, term.parameters) is not None


def maximum_of_union(builder: Builder, output: OutputPlan, heights: Sequence[Height]) -> tuple[Expr, Expr]:
    """Write the place of the maximum that the output asks for, for aggregation `max`.

    Args:
        builder: The program to write into.
        output: Terms that have cuts, implication `min` or `product`.
        heights: Activations, merged by term.

    Returns:
        Its place, counted from the middle of the range, not computed yet; and the largest degree as an atom.
    """
    tops: list[Expr] = []
    ends: list[Cut] = []
    for t, activation, _ in heights:
        top, own = _top(builder, output, output.terms[t], activation)
        tops.append(top)
        ends.append(own)
    most = builder.largest(tops)
    bound = builder.let(times(Number(1.0 - tolerance(output)), most))
    hits = [builder.let(Where(Compare(">=", top, bound), ONE, ZERO)) for top in tops]
    return place_of(builder, output, _disjoint(builder, hits, ends)), most


def _top(builder: Builder, output: OutputPlan, term: SetPlan, activation: Expr) -> tuple[Expr, Cut]:
    """Return the largest degree of an implied set, and where it has it."""
    peak = _peak(output, term)
    if peak <= 0.0:
        return ZERO, (ZERO, ZERO)
    if output.implication_of(term) == "product":
        level: Expr = Number(peak)
        top = builder.let(times(activation, level))
    else:
        level = top = builder.let(Call("min", (activation, Number(peak))))
    share = builder.let(term.share(level))
    # Where the activation is 0 the set is not largest anywhere, and its ends do not matter.
    positive = builder.let(Where(Compare(">", share, ZERO), share, ONE))
    found = alpha_cut(term.kind, positive, term.parameters)
    assert found is not None
    middle = 0.5 * output.lower + 0.5 * output.upper
    left, right = (builder.let(clip(builder.let(e), output.lower, output.upper)) for e in found)
    from_middle = [builder.let(minus(e, Number(middle))) for e in (left, right)]
    return top, (from_middle[0], builder.let(Call("max", (from_middle[0], from_middle[1]))))


def _peak(output: OutputPlan, term: SetPlan) -> float:
    """Return the largest degree of a term within the range of the output."""
    left, right = MEMBERSHIP[term.kind].core(term.parameters)
    if is_infinite(left):
        left = right = output.lower if left < 0.0 else output.upper
    place = min(max(left, output.lower), max(output.upper, left)) if right < output.lower else left
    place = min(max(place, output.lower), output.upper)
    if left <= output.lower <= right:
        place = output.lower
    degree: float = scalar_function(term.degree(Name("x")))(place)
    return degree


def _disjoint(builder: Builder, hits: Sequence[Expr], ends: Sequence[Cut]) -> Hits:
    """Return intervals that do not overlap, and their ends in order.

    Sets that are not largest are put where one is that is. Of the ends in order, left ones and right ones each, the
    k-th interval reaches from the k-th left end, or from the right end before if that lies further, to the k-th right
    end: together they cover the same.
    """
    chosen = ends[-1] if ends else (ZERO, ZERO)
    for hit, own in reversed(list(zip(hits, ends, strict=True))[:-1]):
        left, right = (builder.let(Where(Compare(">", hit, ZERO), e, o)) for e, o in zip(own, chosen, strict=True))
        chosen = left, right
    held = [
        tuple(builder.let(Where(Compare(">", hit, ZERO), e, o)) for e, o in zip(own, chosen, strict=True))
        for hit, own in zip(hits, ends, strict=True)
    ]
    lefts = sorted_atoms(builder, [e[0] for e in held])
    rights = sorted_atoms(builder, [e[1] for e in held])
    intervals: list[tuple[Expr, Expr, Expr]] = []
    points: list[tuple[Expr, Expr]] = []
    before: Expr = Number(-math.inf)
    for left, right in zip(lefts, rights, strict=True):
        start = left if not intervals else builder.let(Call("max", (left, before)))
        intervals.append((ONE, start, right))
        points += [(ONE, start), (ONE, right)]
        before = right
    return Hits(tuple(intervals), tuple(points))
