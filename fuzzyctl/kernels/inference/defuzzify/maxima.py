"""Smallest, largest and mean of maxima, of samples and of intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Call, Compare, CompareOp, Expr, Logic, Name, Number, Where, minus, plus, times
from fuzzyctl.formulas import MEMBERSHIP, Cut, alpha_cut
from fuzzyctl.formulas.formula import is_infinite
from fuzzyctl.kernels.inference.defuzzify.centroid import Height, in_units, unit_of
from fuzzyctl.kernels.inference.defuzzify.sampling import HALF, Carried, Samples, Step, largest
from fuzzyctl.kernels.plan.build import OutputPlan, SetPlan
from fuzzyctl.kernels.program.builder import Builder, clip, sorted_atoms
from fuzzyctl.kernels.program.scalar import scalar_function
from fuzzyctl.records import record

#: Degrees that fall short of the largest by less than this part of it count as largest, unless a file says otherwise.
TOLERANCE: Final = 1e-9
#: Places closer to each other than this part of the range are one place, and shorter intervals are points.
_SAME: Final = 1e-12


def tolerance(output: OutputPlan) -> float:
    """Return the part of the largest degree by which others may fall short."""
    return TOLERANCE if output.tolerance is None else output.tolerance


def sampled_maximum(samples: Samples, middle: float) -> tuple[Expr, Expr]:
    """Write the place of the maximum that the output asks for.

    Returns:
        Its place, counted from the middle, and the largest degree; the place is not computed yet, so that it may be
        left out where the set is empty.
    """
    most = largest(samples)
    if samples.output.rule == "running":
        return _running(samples, middle), most
    bound = samples.builder.let(times(Number(1.0 - tolerance(samples.output)), most))
    # Where the set is empty all samples are maxima, for those who look at them.
    gaps = samples.output.none_active == "range"
    places = [p - middle for p in samples.points]
    if samples.output.kind == "mom":
        return _mean(samples, bound, places, gaps=gaps), most
    if samples.output.by == "magnitude":
        return _by_magnitude(samples, bound, places, gaps=gaps), most
    largest_place = samples.output.kind == "lom"
    join, neutral = ("max", -math.inf) if largest_place else ("min", math.inf)

    def step(b: Builder, v: Expr, items: Sequence[Expr], c: Mapping[str, Expr]) -> Carried:
        candidate = b.let(Where(Compare(">=", v, bound), items[0], Number(neutral)))
        return {"place": Call(join, (c["place"], candidate))}

    return samples.scan({"place": Number(neutral)}, step, [places], gaps=gaps)["place"], most


def _mean(samples: Samples, bound: Expr, places: Sequence[float], *, gaps: bool) -> Expr:
    def step(b: Builder, v: Expr, items: Sequence[Expr], c: Mapping[str, Expr]) -> Carried:
        hit = b.let(Where(Compare(">=", v, bound), ONE, ZERO))
        return {"total": plus(c["total"], times(hit, items[0])), "count": plus(c["count"], hit)}

    sums = samples.scan({"total": ZERO, "count": ZERO}, step, [places], gaps=gaps)
    return sums["total"] / sums["count"]


def _by_magnitude(samples: Samples, bound: Expr, places: Sequence[float], *, gaps: bool) -> Expr:
    """Return the place of smallest or largest magnitude; of two that are equally far from 0 the lower one."""
    op: CompareOp = "<" if samples.output.kind == "som" else ">"
    worst = math.inf if samples.output.kind == "som" else -1.0

    def step(b: Builder, v: Expr, items: Sequence[Expr], c: Mapping[str, Expr]) -> Carried:
        better = Logic("and", (Compare(">=", v, bound), Compare(op, items[1], c["away"])))
        hit = b.let(Where(better, ONE, ZERO))
        is_hit = Compare(">", hit, ZERO)
        return {"place": Where(is_hit, items[0], c["place"]), "away": Where(is_hit, items[1], c["away"])}

    start = {"place": ZERO, "away": Number(worst)}
    magnitudes = [abs(p) for p in samples.points]
    return samples.scan(start, step, [places, magnitudes], gaps=gaps)["place"]


def _running(samples: Samples, middle: float) -> Expr:
    """Return the place that a largest degree so far leads to, from left to right.

    Degrees that differ from it by less than the tolerance are equal to it. The smallest place is where it was exceeded
    last, the largest where it was reached or exceeded last, and from then on that degree is the largest so far; the
    mean is the middle of the samples in a row, from the smallest place on, that are equal to it.
    """
    same = samples.output.tolerance or 0.0
    places = [p - middle for p in samples.points]
    step = {"som": _exceeding, "lom": _reaching, "mom": _staying}[samples.output.kind](same)
    start: Carried = {"most": Number(-1.0), "place": Number(places[0])}
    if samples.output.kind == "mom":
        start = {**start, "end": Number(places[0]), "stays": ZERO}
    result = samples.scan(start, step, [places], gaps=True)
    return times(HALF, plus(result["place"], result["end"])) if samples.output.kind == "mom" else result["place"]


def _exceeds(degree: Expr, most: Expr, same: float) -> Expr:
    above = Compare(">", degree, most)
    return Logic("and", (above, Compare(">=", minus(degree, most), Number(same)))) if same else above


def _exceeding(same: float) -> Step:
    def step(b: Builder, v: Expr, items: Sequence[Expr], c: Mapping[str, Expr]) -> Carried:
        hit = Compare(">", b.let(Where(_exceeds(v, c["most"], same), ONE, ZERO)), ZERO)
        return {"most": Where(hit, v, c["most"]), "place": Where(hit, items[0], c["place"])}

    return step


def _reaching(same: float) -> Step:
    def step(b: Builder, v: Expr, items: Sequence[Expr], c: Mapping[str, Expr]) -> Carried:
        reached: Expr = Compare(">=", v, c["most"])
        if same:
            reached = Logic("or", (reached, Compare("<", minus(c["most"], v), Number(same))))
        hit = Compare(">", b.let(Where(reached, ONE, ZERO)), ZERO)
        return {"most": Where(hit, v, c["most"]), "place": Where(hit, items[0], c["place"])}

    return step


def _staying(same: float) -> Step:
    def step(b: Builder, v: Expr, items: Sequence[Expr], c: Mapping[str, Expr]) -> Carried:
        hit = Compare(">", b.let(Where(_exceeds(v, c["most"], same), ONE, ZERO)), ZERO)
        falls = Compare(">", b.let(Where(_exceeds(c["most"], v, same), ONE, ZERO)), ZERO)
        stays = b.let(Where(hit, ONE, Where(falls, ZERO, c["stays"])))
        return {
            "most": Where(hit, v, c["most"]),
            "place": Where(hit, items[0], c["place"]),
            "end": Where(Compare(">", stays, ZERO), items[0], c["end"]),
            "stays": stays,
        }

    return step


@record(frozen=True)
class Hits:
    """Where a set may be largest, each with an atom that is 1 if it is largest there, else 0.

    Args:
        intervals: (hit, left end, right end), from left to right, without overlap.
        points: (hit, place) from left to right; they include the ends of the intervals.
    """

    intervals: tuple[tuple[Expr, Expr, Expr], ...]
    points: tuple[tuple[Expr, Expr], ...]


def place_of(builder: Builder, output: OutputPlan, hits: Hits) -> Expr:
    """Return the place that the output asks for, counted from the middle of the range as all places here are."""
    if output.kind == "mom":
        return _middle_of(builder, output, hits)
    if output.by == "magnitude":
        return _nearest_or_farthest(builder, output, hits)
    join, neutral = ("max", -math.inf) if output.kind == "lom" else ("min", math.inf)
    place: Expr = Number(neutral)
    for hit, x in hits.points:
        candidate = builder.let(Where(Compare(">", hit, ZERO), x, Number(neutral)))
        place = builder.let(Call(join, (place, candidate)))
    return place


def _nearest_or_farthest(builder: Builder, output: OutputPlan, hits: Hits) -> Expr:
    """Return the place of smallest or largest magnitude; of two that are equally far from 0 the lower one."""
    middle = 0.5 * output.lower + 0.5 * output.upper
    op: CompareOp = "<" if output.kind == "som" else ">"
    candidates = list(hits.points)
    if output.kind == "som":  # 0 itself, if it lies within an interval
        candidates += [(h, builder.let(clip(Number(0.0 - middle), a, b))) for h, a, b in hits.intervals]
    place: Expr = ZERO
    away: Expr = Number(math.inf if output.kind == "som" else -1.0)
    for hit, x in candidates:
        magnitude = builder.let(Call("abs", (builder.let(plus(x, Number(middle))),)))
        better = Logic("and", (Compare(">", hit, ZERO), Compare(op, magnitude, away)))
        place, away = builder.let(Where(better, x, place)), builder.let(Where(better, magnitude, away))
    return place


def _middle_of(builder: Builder, output: OutputPlan, hits: Hits) -> Expr:
    """Return the middle of all intervals together; the mean of the points where there are only points."""
    unit = unit_of(output)
    least, same = (Number(_SAME * ((output.upper - output.lower) / u)) for u in (1.0, unit))
    lengths, moments = [], []
    for hit, a, b in hits.intervals:
        length = builder.let(times(hit, in_units(minus(b, a), unit)))
        lengths.append(length)
        moments.append(times(length, times(Number(0.5), plus(a, b))))
    length, moment = builder.total(lengths), builder.total(moments)
    total: Expr = ZERO
    count: Expr = ZERO
    last: Expr = Number(-math.inf)
    for hit, x in hits.points:
        is_new = Logic("and", (Compare(">", hit, ZERO), Compare(">", minus(x, last), least)))
        count_of_one = builder.let(Where(is_new, ONE, ZERO))
        total, count = builder.let(plus(total, times(count_of_one, x))), builder.let(plus(count, count_of_one))
        last = builder.let(Where(is_new, x, last))
    return Where(Compare(">", length, same), moment / length, total / count)


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
        top, cut = _top(builder, output, output.terms[t], activation)
        tops.append(top)
        ends.append(cut)
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
    cut = alpha_cut(term.kind, positive, term.parameters)
    assert cut is not None
    middle = 0.5 * output.lower + 0.5 * output.upper
    left, right = (builder.let(clip(builder.let(e), output.lower, output.upper)) for e in cut)
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
    for hit, cut in reversed(list(zip(hits, ends, strict=True))[:-1]):
        left, right = (builder.let(Where(Compare(">", hit, ZERO), e, o)) for e, o in zip(cut, chosen, strict=True))
        chosen = left, right
    chosen_ends = [
        tuple(builder.let(Where(Compare(">", hit, ZERO), e, o)) for e, o in zip(cut, chosen, strict=True))
        for hit, cut in zip(hits, ends, strict=True)
    ]
    lefts = sorted_atoms(builder, [e[0] for e in chosen_ends])
    rights = sorted_atoms(builder, [e[1] for e in chosen_ends])
    intervals: list[tuple[Expr, Expr, Expr]] = []
    points: list[tuple[Expr, Expr]] = []
    before: Expr = Number(-math.inf)
    for left, right in zip(lefts, rights, strict=True):
        start = left if not intervals else builder.let(Call("max", (left, before)))
        intervals.append((ONE, start, right))
        points += [(ONE, start), (ONE, right)]
        before = right
    return Hits(tuple(intervals), tuple(points))
