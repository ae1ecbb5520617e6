"""Maxima of a union of sets in closed form, by alpha-cuts."""

from __future__ import annotations

import math
from collections.abc import Sequence

from fuzzyctl.expr import ONE, ZERO, Call, Compare, Expr, Name, Number, Where
from fuzzyctl.formulas import MEMBERSHIP, Parameters
from fuzzyctl.formulas.shared import is_infinite
from fuzzyctl.kernels.inference.defuzzify.centroid import Height
from fuzzyctl.kernels.inference.defuzzify.envelope import sorted_atoms
from fuzzyctl.kernels.inference.defuzzify.maxima import Hits, place_of, tolerance
from fuzzyctl.kernels.plan.build import OutputPlan, SetPlan
from fuzzyctl.kernels.program.builder import Builder, clip, minus, plus, times
from fuzzyctl.kernels.program.scalar import scalar_function

#: Left and right end of where a set has some degree at least.
Ends = tuple[Expr, Expr]


def has_cuts(term: SetPlan) -> bool:
    """Return whether every alpha-cut of the term is one interval with closed-form end points."""
    return term.expression is None and not term.changes and ends_of(term.kind, ONE, term.parameters) is not None


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
    ends: list[Ends] = []
    for t, activation, _ in heights:
        top, own = _top(builder, output, output.terms[t], activation)
        tops.append(top)
        ends.append(own)
    most = builder.largest(tops)
    bound = builder.let(times(Number(1.0 - tolerance(output)), most))
    hits = [builder.let(Where(Compare(">=", top, bound), ONE, ZERO)) for top in tops]
    return place_of(builder, output, _disjoint(builder, hits, ends)), most


def _top(builder: Builder, output: OutputPlan, term: SetPlan, activation: Expr) -> tuple[Expr, Ends]:
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
    found = ends_of(term.kind, positive, term.parameters)
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


def _disjoint(builder: Builder, hits: Sequence[Expr], ends: Sequence[Ends]) -> Hits:
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


# --- where a set has some degree at least ----------------------------------------------------------------------------


def ends_of(kind: str, share: Expr, p: Parameters) -> Ends | None:
    """Return where a term has at least some share of its height; infinite where that has no end.

    Args:
        kind: Kind of membership function.
        share: An atom, above 0.
        p: Its parameters.
    """
    match kind:
        case "triangle" | "trapezoid" | "rectangle" | "ramp":
            return _straight(share, MEMBERSHIP[kind].vertices(p))
        case "gaussian":
            return _around(p[0], _spread(p[1], share), p[0], _spread(p[1], share))
        case "gaussian2" if p[0] <= p[2]:
            return _around(p[0], _spread(p[1], share), p[2], _spread(p[3], share))
        case "bell":
            odds = minus(ONE, share) / share
            reach = times(Number(p[1]), odds ** (0.5 / p[2]))
            return _around(p[0], reach, p[0], reach)
        case "cosine":
            # acos(2 s - 1), its cosine and sine written so that nothing cancels near the top.
            sine = Call("sqrt", (times(Number(4.0), times(share, minus(ONE, share))),))
            angle = Call("atan2", (sine, minus(times(Number(2.0), share), ONE)))
            reach = times(Number(p[1] / (2.0 * math.pi)), angle)
            return _around(p[0], reach, p[0], reach)
        case "spike":
            reach = times(Number(-0.1 * p[1]), Call("log", (share,)))
            return _around(p[0], reach, p[0], reach)
        case "semi_ellipse":
            half = Call("sqrt", (times(minus(ONE, share), plus(ONE, share)),))
            reach, center = times(Number(0.5 * (p[1] - p[0])), half), 0.5 * p[0] + 0.5 * p[1]
            return _around(center, reach, center, reach)
        case "pi_shape":
            return _rise(share, p[0], p[1], -math.inf), _rise(share, p[3], p[2], math.inf)
        case "sigmoid" | "s_shape" | "z_shape" | "concave" | "arc":
            place = MEMBERSHIP[kind].inverse(share, p)
            assert place is not None
            rises = {"sigmoid": p[1] > 0.0, "s_shape": True, "z_shape": False}.get(kind, p[-1] > p[0])
            return (place, Number(math.inf)) if rises else (Number(-math.inf), place)
    return None


def _straight(share: Expr, corners: Sequence[tuple[float, float]]) -> Ends:
    tops = [x for x, y in corners if y == 1.0]
    left: Expr = Number(-math.inf)
    right: Expr = Number(math.inf)
    if corners[0][1] == 0.0:
        left = plus(Number(corners[0][0]), times(Number(tops[0] - corners[0][0]), share))
    if corners[-1][1] == 0.0:
        right = plus(Number(corners[-1][0]), times(Number(tops[-1] - corners[-1][0]), share))
    return left, right


def _rise(share: Expr, foot: float, top: float, infinite: float) -> Expr:
    """Return where a side of a curved trapezoid has a share."""
    if is_infinite(foot):
        return Number(infinite)
    if foot == top:
        return Number(top)
    place = MEMBERSHIP["s_shape"].inverse(share, (foot, top))
    assert place is not None
    return place


def _spread(sigma: float, share: Expr) -> Expr:
    return times(Number(sigma), Call("sqrt", (times(Number(-2.0), Call("log", (share,))),)))


def _around(left: float, before: Expr, right: float, after: Expr) -> Ends:
    return minus(Number(left), before), plus(Number(right), after)
