"""Merging of activations before a sum: by rule, by consequent term, or by position."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import reduce

from fuzzyctl.expr import ZERO, Compare, Expr, Logic, Number, Where, replace_names
from fuzzyctl.formulas import aggregation
from fuzzyctl.kernels.inference.defuzzify.defuzzify import Activation
from fuzzyctl.kernels.plan.build import OutputPlan
from fuzzyctl.kernels.program.builder import Builder


def merged(
    builder: Builder, output: OutputPlan, active: Sequence[Activation], inputs: Mapping[str, Expr]
) -> list[Activation]:
    """Write the activations that a sum over rules runs over.

    Args:
        builder: The program to write into.
        output: An output that sums over rules.
        active: Its rules, in the order written.
        inputs: What consequents that are functions read, by name.

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
    """Return what tells consequents apart that are always at one place."""
    own = output.terms[term]
    return own.expression if own.expression is not None else own.peak if output.averages or output.sums else own


def _joined(builder: Builder, output: OutputPlan, own: Sequence[Activation]) -> Activation:
    """Join the activations of some rules as if they were one rule."""
    if len(own) == 1:
        return own[0]
    join = aggregation(output.aggregation, output.equal)
    strength = reduce(lambda a, b: builder.let(join(a, b)), (a.strength for a in own))
    most = sum(a.weight for a in own) if output.aggregation == "sum" else 1.0
    conditions = [a.acts for a in own]
    acts = None if None in conditions else tuple(c for found in conditions for c in found or ())
    return replace(own[0], strength=strength, weight=most, acts=acts)


def _meeting(
    builder: Builder, output: OutputPlan, active: Sequence[Activation], inputs: Mapping[str, Expr]
) -> list[Activation]:
    """Join consequents that meet at the point of evaluation: functions of the inputs may have one value there."""
    join = aggregation(output.aggregation, output.equal)
    values = [_value(builder, output, a.term, inputs) for a in active]
    found: list[Activation] = []
    for k, a in enumerate(active):
        strength = a.strength
        for other, value in zip(active[k + 1 :], values[k + 1 :], strict=True):
            there = builder.let(Where(Compare("==", values[k], value), other.strength, ZERO))
            strength = builder.let(join(strength, there))
        earlier = tuple(Compare("==", v, values[k]) for v in values[:k])
        if earlier:
            met = earlier[0] if len(earlier) == 1 else Logic("or", earlier)
            strength = builder.let(Where(met, ZERO, strength))
        found.append(replace(a, strength=strength))
    return found


def _value(builder: Builder, output: OutputPlan, term: int, inputs: Mapping[str, Expr]) -> Expr:
    own = output.terms[term]
    return Number(own.peak) if own.expression is None else builder.let(replace_names(own.expression, inputs))
