"""Activations of rules: the rules that an activation method selects, and those of one term merged."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import reduce
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Compare, Expr, Logic, Number, Where, minus, plus, replace_names
from fuzzyctl.formulas import aggregation
from fuzzyctl.kernels.inference.defuzzify.defuzzify import Activation
from fuzzyctl.kernels.plan.build import ActivationPlan, OutputPlan
from fuzzyctl.kernels.program.builder import Builder


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
    for k, value in zip(positions, _acting(builder, method, [activations[k] for k in positions]), strict=True):
        chosen[k] = value
    return chosen


def _acting(builder: Builder, method: ActivationPlan, activations: list[Expr]) -> list[Expr]:
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
