"""Activation methods: statements that choose the rules that act."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from fuzzyctl.expr import ONE, ZERO, Compare, Expr, Logic, Number, Where, minus, plus
from fuzzyctl.kernels.plan.build import ActivationPlan
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
    own = [k for k, a in enumerate(activations) if a != ZERO]
    chosen = list(activations)
    for k, value in zip(own, _acting(builder, method, [activations[k] for k in own]), strict=True):
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
        found: Expr = ZERO
        for k, key in enumerate(left):
            chosen = Logic("and", (Compare("==", key, best), Compare("==", found, ZERO)))
            left[k] = builder.let(Where(chosen, _TAKEN, key))
            if k + 1 < len(left):
                found = builder.let(Where(chosen, ONE, found))
    return [builder.let(Where(Compare("==", key, _TAKEN), a, ZERO)) for key, a in zip(left, activations, strict=True)]


#: The key of a rule that has been chosen.
_TAKEN: Final = Number(-math.inf)
