"""Defuzzifiers: statements from the activations of the rules to one number; the rules that an activation lets act."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import reduce
from itertools import pairwise
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Compare, Expr, Logic, Name, Number, Where, minus, plus, replace_names, times
from fuzzyctl.formulas import MEMBERSHIP, Vertex, aggregation, exact_norms, is_endless
from fuzzyctl.kernels.inference.defuzzify.centroid import Height, exact_centroid, has_many_pieces, unit_of
from fuzzyctl.kernels.inference.defuzzify.curved_sets import adaptive
from fuzzyctl.kernels.inference.defuzzify.envelope import (
    size_of,
    straight_bisector,
    straight_centroid,
    straight_maximum,
)
from fuzzyctl.kernels.inference.defuzzify.maxima import has_cuts, maximum_of_union, sampled_maximum
from fuzzyctl.kernels.inference.defuzzify.sampled_bisector import sampled_bisector, sampled_polygon
from fuzzyctl.kernels.inference.defuzzify.sampling import Samples, points_at, sampled_moments
from fuzzyctl.kernels.plan.build import ActivationPlan, OutputPlan, SetPlan
from fuzzyctl.kernels.plan.traced import greatest, is_free, least
from fuzzyctl.kernels.program.builder import Builder, clip
from fuzzyctl.kernels.program.program import NAN, STATE, Item
from fuzzyctl.kernels.program.scalar import scalar_function
from fuzzyctl.model.method import MAXIMA
from fuzzyctl.records import record

#: Larger outlines cost more than an adaptive integral.
LARGEST: Final = 20_000


@record(frozen=True)
class Activation:
    """How far one rule is active in one output.

    Args:
        strength: Its activation as an atom of the program.
        term: Position of its consequent term.
        state: Position of its adaptive consequent, None for a fixed one.
        weight: The largest activation it can have.
        acts: Conditions besides an activation above 0 under which it acts; None for a rule that always does.
    """

    strength: Expr
    term: int
    state: int | None
    weight: float
    acts: tuple[Expr, ...] | None = ()


Hull = tuple[float | Expr, float | Expr]


def defuzzify(
    builder: Builder,
    output: OutputPlan,
    active: Sequence[Activation],
    inputs: Mapping[str, Expr],
    previous: Expr | None,
    total: Expr | None = None,
) -> tuple[Expr, Expr]:
    """Write the assignments for one output.

    Args:
        builder: The program to write into.
        output: The output.
        active: The rules that name it, without those of activation 0.
        inputs: The clamped inputs by name, for consequents that are functions of them.
        previous: The previous value of an output that holds it where no rule fires, else None.
        total: The divisor of an average, None for the sum of the activations.

    Returns:
        Its value as an atom, and the condition that some rule fires.
    """
    otherwise = previous or _otherwise(output)
    hull: Hull
    if output.over_rules:
        numerator, denominator, hull = _over_rules(builder, output, active, inputs)
        if total is not None:
            denominator, hull = total, with_zero(builder, hull)
        fires = Compare(">", denominator, ZERO)
        if output.sums:
            return _defined(builder, output, builder.let(Where(fires, numerator, otherwise)), fires, otherwise)
        quotient: Expr = numerator / denominator
    else:
        place, measure = _of_set(builder, output, active)
        hull = support_hull(output, [a.term for a in active])
        fires = Compare(">" if output.kind not in MAXIMA or output.none_active == "otherwise" else ">=", measure, ZERO)
        quotient = place if middle(output) == 0.0 else middle(output) + place
    return _held(builder, output, quotient, fires, hull, otherwise)


def average(builder: Builder, output: OutputPlan, above: Expr, below: Expr, hull: Hull) -> tuple[Expr, Expr]:
    """Write an average over rules as the quotient of two sums.

    Args:
        builder: The program to write into.
        output: The output, which does not hold its value.
        above: Σ activation · consequent.
        below: Σ activation, as an atom.
        hull: Bounds of the consequents.

    Returns:
        Its value as an atom, and the condition that some rule fires.
    """
    fires = Compare(">", below, ZERO)
    return _held(builder, output, above / below, fires, hull, _otherwise(output))


def _held(
    builder: Builder, output: OutputPlan, quotient: Expr, fires: Expr, hull: Hull, otherwise: Expr
) -> tuple[Expr, Expr]:
    """Hold a value within a hull where some rule fires.

    Quotients of rounded (or denormal) sums may leave the hull of their operands, and proved bounds are bounds of the
    numbers returned. NaN stays NaN.
    """
    value = builder.let(clip(builder.let(Where(fires, quotient, otherwise)), *hull))
    if not _passes(hull, otherwise):
        value = builder.let(Where(fires, value, otherwise))
    return _defined(builder, output, value, fires, otherwise)


def _defined(builder: Builder, output: OutputPlan, value: Expr, fires: Expr, otherwise: Expr) -> tuple[Expr, Expr]:
    """Return a value and whether it exists; a NaN that counts as no value is replaced by the `else` value."""
    if output.fallback == "unfired":
        return value, fires
    there = Compare("==", value, value)
    return builder.let(Where(there, value, otherwise)), Logic("and", (fires, there))


def _of_set(builder: Builder, output: OutputPlan, active: Sequence[Activation]) -> tuple[Expr, Expr]:
    """Write the place of the aggregated set, counted from the middle, and a measure that is above 0 if it exists."""
    heights = _heights(builder, output, active)
    if output.resolution is None:
        return _exact(builder, output, heights)
    samples = Samples.of(builder, output, heights)
    if output.rule == "polygon":
        return sampled_polygon(samples, middle(output))
    if output.kind in MAXIMA:
        return sampled_maximum(samples, middle(output))
    if output.kind == "bisector":
        return sampled_bisector(samples, middle(output))
    moment, area = sampled_moments(samples, middle(output))
    return moment / area, area


def _exact(builder: Builder, output: OutputPlan, heights: Sequence[Height]) -> tuple[Expr, Expr]:
    """Write the same without samples: in closed form where there is one, else by adaptive integrals."""
    form = closed_form(output, [output.terms[t] for t, _, _ in heights])
    match output.kind, form:
        case "centroid", True if output.rule == "polygon":
            return straight_centroid(builder, output, heights)
        case "centroid", True if not has_many_pieces(output, heights, builder.most_pairs):
            return exact_centroid(builder, output, heights)
        case "bisector", True if size_of(output, heights) <= LARGEST:
            return straight_bisector(builder, output, heights)
        case "centroid", _:
            moment, area = adaptive(builder, output, heights)
            return times(Number(unit_of(output)), moment / area), area
        case "bisector", _:
            place, area = adaptive(builder, output, heights)
            return times(Number(unit_of(output)), place), area
    if output.aggregation == "max" and all(has_cuts(output.terms[t]) for t, _, _ in heights):
        return maximum_of_union(builder, output, heights)
    return straight_maximum(builder, output, heights)


def closed_form(output: OutputPlan, terms: Sequence[SetPlan]) -> bool:
    """Return whether an exact defuzzifier of some terms has a closed form, a finite number of operations."""
    one = not output.mixes_implications
    return one and exact_norms(output.implication, output.aggregation) and all(t.vertices for t in terms)


def _otherwise(output: OutputPlan) -> Number:
    return Number(output.otherwise) if isinstance(output.otherwise, float) else NAN


def with_zero(builder: Builder, hull: Hull) -> Hull:
    """Return the bounds of quotients whose parts are divided by more than their sum."""
    low, high = hull
    if isinstance(low, float) and isinstance(high, float):
        return min(low, 0.0), max(high, 0.0)
    ends = [end if isinstance(end, Expr) else Number(end) for end in hull]
    return builder.smallest([ends[0], ZERO]), builder.largest([ends[1], ZERO])


def _passes(hull: Hull, otherwise: Expr) -> bool:
    """Return whether clipping to the hull keeps a value."""
    if not isinstance(otherwise, Number):
        return False
    low, high = hull
    inside = isinstance(low, float) and isinstance(high, float) and low <= otherwise.value <= high
    return inside or math.isnan(otherwise.value)


def middle(output: OutputPlan) -> float:
    """Return the point that moments are taken about: the middle of the range, so that errors scale with the range."""
    return 0.5 * output.lower + 0.5 * output.upper


def consequent_hull(output: OutputPlan, terms: Sequence[int]) -> tuple[float, float]:
    """Return the least and the largest value that an average over these terms, fixed or adaptive, can have."""
    if output.rate is not None:
        return output.lower, output.upper
    ends = [end for t in terms for end in _values(output, output.terms[t])] or [0.0]
    return least(ends), greatest(ends)


def _values(output: OutputPlan, term: SetPlan) -> tuple[float, float]:
    """Return the bounds of a consequent's contribution; a function of the inputs is bounded later."""
    if term.reads_inputs:
        return term.reach or (-math.inf, math.inf)
    if output.takes_degrees:
        ends = [0.0, term.height]
    elif output.inverts and output.places == "free":
        return -math.inf, math.inf
    elif output.inverts and term.is_free:
        return output.lower, output.upper
    elif output.inverts:
        value = scalar_function(term.inverse(Name("w")))
        ends = sorted(value(w) for w in (0.0, 1.0))
    else:
        return term.peak, term.peak
    if output.places == "clamped":
        ends = [min(max(end, output.lower), output.upper) for end in ends]
    return ends[0], ends[1]


def support_hull(output: OutputPlan, terms: Sequence[int]) -> tuple[float, float]:
    """Return the ends of the part of the range where centroid, bisector and maxima of these terms can lie."""
    whole = output.lower, output.upper
    if output.kind in MAXIMA and output.none_active == "range":
        return whole
    if output.resolution is None:
        inside = [end for t in terms for end in support(output, output.terms[t])]
        return (least(inside), greatest(inside)) if inside else whole
    if any(output.terms[t].is_free for t in terms):
        return whole
    if output.rule in ("nearest", "two_sided", "between", "running"):
        return whole
    degrees = [scalar_function(output.terms[t].degree(Name("x"))) for t in dict.fromkeys(terms)]
    # The first and the last sample above 0 are looked for from both ends: most samples are never computed.
    samples = range(output.resolution)
    sides = (points_at(output, samples), points_at(output, reversed(samples)))
    first, last = (
        next((x for x in samples_of_side if any(d(x) > 0.0 for d in degrees)), None) for samples_of_side in sides
    )
    if first is None or last is None:
        return whole
    # A place between samples may be a step away from those above 0.
    between = output.kind == "bisector" or output.rule == "polygon"
    beyond = (output.upper - output.lower) / max(output.resolution - 1, 1) if between else 0.0
    return max(first - beyond, output.lower), min(last + beyond, output.upper)


def support(output: OutputPlan, term: SetPlan) -> tuple[float, ...]:
    """Return the ends of the support of a term within the output range, nothing where it has none."""
    ends: list[float] = []
    for x0, x1 in _stretches(output, term):
        left, right = greatest((x0, output.lower)), least((x1, output.upper))
        if is_free(left) or is_free(right) or left < right:
            ends += [left, right]
    return (least(ends), greatest(ends)) if ends else ()


def _stretches(output: OutputPlan, term: SetPlan) -> list[tuple[float, float]]:
    """Return the stretches between corners where a term is above 0; of a curved term those where its formula is."""
    if term.vertices:
        return [(x0, x1) for (x0, y0), (x1, y1) in pairwise(_whole(term.vertices)) if max(y0, y1) > 0.0]
    places = sorted({output.lower, *term.pieces, output.upper})
    # A formula is above 0 all over a stretch, or nowhere, except for values that round to 0 far from its middle.
    if term.kind not in MEMBERSHIP or is_endless(term.kind) or term.changes:
        return list(pairwise(places))
    degree = scalar_function(term.degree(Name("x")))
    return [(a, b) for a, b in pairwise(places) if degree(0.5 * a + 0.5 * b) > 0.0]


def _whole(vertices: tuple[Vertex, ...]) -> tuple[Vertex, ...]:
    """Return corners with the stretches beyond the outer ones."""
    return ((-math.inf, vertices[0][1]), *vertices, (math.inf, vertices[-1][1]))


def _over_rules(
    builder: Builder, output: OutputPlan, active: Sequence[Activation], inputs: Mapping[str, Expr]
) -> tuple[Expr, Expr, Hull]:
    """Sum activation · consequent, and activation, over rules; rules of equal consequents are summed first."""
    if output.rate is not None:
        numerator = builder.total(times(a.strength, Item(STATE, a.state or 0)) for a in active)
        return numerator, builder.total(a.strength for a in active), consequent_hull(output, ())
    by_value: dict[Expr, list[Activation]] = {}
    values = [_consequent(builder, output, output.terms[a.term], a.strength, inputs) for a in active]
    for a, value in zip(active, values, strict=True):
        by_value.setdefault(value, []).append(a)
    sums = {value: builder.total(a.strength for a in rules) for value, rules in by_value.items()}
    may_be_infinite = output.inverts and output.places == "free"
    if not may_be_infinite and all(not output.terms[a.term].reads_inputs or output.terms[a.term].reach for a in active):
        numerator = builder.total(times(s, value) for value, s in sums.items() if value != ZERO)
        return numerator, builder.total(sums.values()), consequent_hull(output, [a.term for a in active])
    numerator = builder.total(
        _part(builder, s, value, _acting(by_value[value])) for value, s in sums.items() if value != ZERO
    )
    denominator = builder.total(sums.values())
    least = builder.smallest(_if_firing(builder, s, value, math.inf) for value, s in sums.items())
    most = builder.largest(_if_firing(builder, s, value, -math.inf) for value, s in sums.items())
    return numerator, denominator, (least, most)


def _consequent(
    builder: Builder, output: OutputPlan, term: SetPlan, strength: Expr, inputs: Mapping[str, Expr]
) -> Expr:
    """Return the value of a rule's consequent as an atom."""
    if term.reads_inputs and term.expression is not None:
        return builder.let(replace_names(term.expression, inputs))
    if output.inverts:
        # Beyond its height a term has the degree nowhere; other tools go on with the formula of the inverse.
        limited = output.places == "clamped" and (term.height != 1.0 or output.merge != "rules")
        place = builder.let(term.inverse(builder.let(term.share(strength, limited=limited))))
    elif output.takes_degrees:
        place = builder.let(term.degree(strength))
    else:
        return Number(term.peak)
    return builder.let(clip(place, output.lower, output.upper)) if output.places == "clamped" else place


def _acting(active: Sequence[Activation]) -> tuple[Expr, ...] | None:
    """Return conditions under which some rule of a consequent acts besides that it fires; None if one always does."""
    acts = [a.acts for a in active]
    return None if None in acts else tuple(c for conditions in acts for c in conditions or ())


def _part(builder: Builder, strength: Expr, value: Expr, acts: tuple[Expr, ...] | None) -> Expr:
    """Return activation · consequent; a function without a value, or an infinite one, counts only if its rule acts."""
    product = times(strength, value)
    if isinstance(value, Number) or acts is None:
        return product
    fires = Compare(">", strength, ZERO)
    return builder.let(Where(Logic("or", (fires, *acts)) if acts else fires, product, ZERO))


def _if_firing(builder: Builder, strength: Expr, value: Expr, otherwise: float) -> Expr:
    return builder.let(Where(Compare(">", strength, ZERO), value, Number(otherwise)))


def _heights(builder: Builder, output: OutputPlan, active: Sequence[Activation]) -> list[Height]:
    """Return (term, activation, largest activation) with rules merged where the aggregation allows it.

    Under `max`, and under `sum` of scaled sets, rules of one term act as one rule.
    """
    if output.aggregation not in ("max", "sum"):
        return [(a.term, a.strength, a.weight) for a in active]
    merged: list[Height] = [(a.term, a.strength, a.weight) for a in active if not _merges(output, output.terms[a.term])]
    for term in dict.fromkeys(a.term for a in active if _merges(output, output.terms[a.term])):
        same_term = [a for a in active if a.term == term]
        if output.aggregation == "max":
            merged.append((term, builder.largest(a.strength for a in same_term), max(a.weight for a in same_term)))
        else:
            merged.append((term, builder.total(a.strength for a in same_term), sum(a.weight for a in same_term)))
    return merged


def _merges(output: OutputPlan, term: SetPlan) -> bool:
    return output.aggregation == "max" or (output.aggregation, output.implication_of(term)) == ("sum", "product")


def acting(builder: Builder, method: ActivationPlan, activations: Sequence[Expr]) -> list[Expr]:
    """Write how far each rule acts.

    Args:
        builder: The program to write into.
        method: The activation method.
        activations: Weight times firing strength of each rule as atoms, in the order the rules are written.

    Returns:
        As many atoms: the activation of a rule that acts, 0 of the others; shares of the sum for `proportional`.
    """
    positions = [k for k, a in enumerate(activations) if a != ZERO]
    chosen = list(activations)
    for k, value in zip(positions, _acting_rules(builder, method, [activations[k] for k in positions]), strict=True):
        chosen[k] = value
    return chosen


def _acting_rules(builder: Builder, method: ActivationPlan, activations: list[Expr]) -> list[Expr]:
    match method.kind:
        case "threshold":
            bound = Number(method.threshold)
            return [builder.let(Where(Compare(method.comparison, a, bound), a, ZERO)) for a in activations]
        case "proportional":
            total = builder.total(activations)
            fires = Compare(">", total, ZERO)
            return [builder.let(Where(fires, a / total, ZERO)) for a in activations]
        case "first":
            return _first(builder, method, activations)
        case "last":
            return _first(builder, method, activations[::-1])[::-1]
        case "highest":
            return _best(builder, method.count, activations, activations)
        case "lowest":
            keys = [builder.let(Where(Compare(">", a, ZERO), a, Number(math.inf))) for a in activations]
            negated = [builder.let(minus(ZERO, key)) for key in keys]
            return _best(builder, method.count, activations, negated)
    return activations


def _first(builder: Builder, method: ActivationPlan, activations: list[Expr]) -> list[Expr]:
    """Count the rules that qualify from the first one on; those act that have less than `count` before them."""
    chosen: list[Expr] = []
    before: Expr = ZERO
    for a in activations:
        qualifies: Expr = Compare(">", a, ZERO)
        if method.threshold > 0.0:
            qualifies = Compare(">=", a, Number(method.threshold))
        if len(chosen) < method.count:
            chosen.append(builder.let(Where(qualifies, a, ZERO)))
        else:
            room = Compare("<", before, Number(float(method.count)))
            chosen.append(builder.let(Where(Logic("and", (qualifies, room)), a, ZERO)))
        before = builder.let(plus(before, Where(qualifies, ONE, ZERO)))
    return chosen


def _best(builder: Builder, count: int, activations: list[Expr], keys: list[Expr]) -> list[Expr]:
    """Choose `count` times the rule of the largest key among those left, of equal ones the earliest."""
    if count >= len(activations):
        return activations
    left = list(keys)
    for _ in range(count):
        best = builder.largest(left)
        largest: Expr = ZERO
        for k, key in enumerate(left):
            chosen = Logic("and", (Compare("==", key, best), Compare("==", largest, ZERO)))
            left[k] = builder.let(Where(chosen, _TAKEN, key))
            if k + 1 < len(left):
                largest = builder.let(Where(chosen, ONE, largest))
    return [builder.let(Where(Compare("==", key, _TAKEN), a, ZERO)) for key, a in zip(left, activations, strict=True)]


#: The key of a rule that has been chosen.
_TAKEN: Final = Number(-math.inf)


def merged(
    builder: Builder, output: OutputPlan, active: Sequence[Activation], inputs: Mapping[str, Expr]
) -> list[Activation]:
    """Write the activations that a sum over rules runs over.

    Args:
        builder: The program to write into.
        output: An output that sums over rules.
        active: Its rules, in the order written.
        inputs: Inputs of consequents that are functions, by name.

    Returns:
        The rules themselves, or one activation for each consequent term or place.
    """
    if output.merge == "rules":
        return list(active)
    keys = [a.term if output.merge == "terms" else _place(output, a.term) for a in active]
    joined = [
        _joined(builder, output, [a for a, k in zip(active, keys, strict=True) if k == key])
        for key in dict.fromkeys(keys)
    ]
    if output.merge == "terms" or all(output.terms[a.term].expression is None for a in joined):
        return joined
    return _meeting(builder, output, joined, inputs)


def _place(output: OutputPlan, term: int) -> object:
    """Return a key that is equal for consequents that are always at one place."""
    term_set = output.terms[term]
    return (
        term_set.expression
        if term_set.expression is not None
        else term_set.peak
        if output.averages or output.sums
        else term_set
    )


def _joined(builder: Builder, output: OutputPlan, activations: Sequence[Activation]) -> Activation:
    """Join the activations of some rules as if they were one rule."""
    if len(activations) == 1:
        return activations[0]
    join = aggregation(output.aggregation, output.equal)
    strength = reduce(lambda a, b: builder.let(join(a, b)), (a.strength for a in activations))
    most = sum(a.weight for a in activations) if output.aggregation == "sum" else 1.0
    conditions = [a.acts for a in activations]
    acts = None if None in conditions else tuple(c for found in conditions for c in found or ())
    return replace(activations[0], strength=strength, weight=most, acts=acts)


def _meeting(
    builder: Builder, output: OutputPlan, active: Sequence[Activation], inputs: Mapping[str, Expr]
) -> list[Activation]:
    """Join consequents that meet at the point of evaluation: functions of the inputs may have one value there."""
    join = aggregation(output.aggregation, output.equal)
    values = [_value(builder, output, a.term, inputs) for a in active]
    merged: list[Activation] = []
    for k, a in enumerate(active):
        strength = a.strength
        for other, value in zip(active[k + 1 :], values[k + 1 :], strict=True):
            there = builder.let(Where(Compare("==", values[k], value), other.strength, ZERO))
            strength = builder.let(join(strength, there))
        earlier = tuple(Compare("==", v, values[k]) for v in values[:k])
        if earlier:
            met = earlier[0] if len(earlier) == 1 else Logic("or", earlier)
            strength = builder.let(Where(met, ZERO, strength))
        merged.append(replace(a, strength=strength))
    return merged


def _value(builder: Builder, output: OutputPlan, term: int, inputs: Mapping[str, Expr]) -> Expr:
    term_set = output.terms[term]
    return (
        Number(term_set.peak)
        if term_set.expression is None
        else builder.let(replace_names(term_set.expression, inputs))
    )
