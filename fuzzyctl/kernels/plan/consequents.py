"""Consequents of a plan: sets, numbers and functions, with hedges and weights applied."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from functools import reduce

from fuzzyctl.diagnostics.diagnostic import UnknownNameError
from fuzzyctl.expr import (
    ZERO,
    Expr,
    Name,
    Number,
    replace_names,
)
from fuzzyctl.formulas import (
    HEDGES,
    VARIANTS,
    held,
    inverse_hedge,
)
from fuzzyctl.formulas import hedge as usual_hedge
from fuzzyctl.kernels.plan.expressions import constants_of, guarded, number_of, over_inputs, require_known
from fuzzyctl.kernels.plan.plan import ImpliedPlan
from fuzzyctl.kernels.plan.sets import ITSELF, SetPlan
from fuzzyctl.kernels.plan.traced import is_free
from fuzzyctl.model.rule import Consequent, Rule
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Membership, Output


def set_of(system: FuzzySystem, membership: Membership) -> SetPlan:
    """Return a membership function with numbers, in the variant that the semantics ask for."""
    height = number_of(system, membership.height)
    variant = f"{membership.kind} {getattr(system.method.semantics, membership.kind, '')}"
    kind = variant if variant in VARIANTS else membership.kind
    return SetPlan(kind, tuple(number_of(system, a) for a in membership.arguments), height)


def own_set(system: FuzzySystem, variable: str, membership: Membership, kind: str) -> SetPlan:
    """Return a set that is an expression over the variable itself and params."""
    numbers = constants_of(system, {variable})
    require_known(membership.arguments[0], {variable}, numbers)
    inside: dict[str, Expr] = {**numbers, variable: Name(ITSELF)}
    expression = guarded(replace_names(membership.arguments[0], inside))
    return SetPlan(kind, (), number_of(system, membership.height), expression)


def term_of_output(system: FuzzySystem, output: str, membership: Membership) -> SetPlan:
    """Return a term of an output with numbers: a set, or a consequent that is a function."""
    if membership.kind == "formula":
        return own_set(system, output, membership, "formula")
    return consequent_of(system, membership)


def consequent_of(system: FuzzySystem, membership: Membership) -> SetPlan:
    """Return a consequent with numbers: a set, or a function of the inputs and of other outputs."""
    match membership.kind:
        case "linear":
            *factors, constant = (number_of(system, a) for a in membership.arguments)
            names = [i.name for i in system.inputs]
            parts = [c * Name(n) for c, n in zip(factors, names, strict=True) if c != 0.0]
            reach = _reach(system, factors, constant)
            return SetPlan("linear", (), expression=_sum([*parts, Number(constant)]), reach=reach)
        case "function":
            return SetPlan(
                "function", (), expression=guarded(over_inputs(system, membership.arguments[0], outputs=True))
            )
    return set_of(system, membership)


def _reach(system: FuzzySystem, factors: Sequence[float], constant: float) -> tuple[float, float] | None:
    """Return what a linear consequent lies between while the inputs are in their ranges; None if they need not be."""
    if any(map(is_free, (*factors, constant))):
        return None
    low = high = constant
    for factor, variable in zip(factors, system.inputs, strict=True):
        if factor == 0.0:
            continue
        if variable.extrapolate:
            return None
        ends = sorted(factor * number_of(system, end) for end in (variable.lower, variable.upper))
        low, high = low + ends[0], high + ends[1]
    return (low, high) if math.isfinite(high - low) else None


def _sum(parts: list[Expr]) -> Expr:
    return reduce(lambda a, b: a + b, [p for p in parts if p != ZERO] or [ZERO])


class Conclusions:
    """Collect the consequents of the rules in one output."""

    def __init__(self, system: FuzzySystem, output: Output) -> None:
        self.system, self.output = system, output
        self.semantics = system.method.semantics
        self.over_rules = (output.defuzzifier or system.method.defuzzifier).over_rules
        #: That of the first rule; of others whose rule blocks say something else the terms say it.
        own = output.implication or system.method.implication
        self.implication = own if self.over_rules else system.implications_of(output)[0]
        self.terms = [term_of_output(system, output.name, term.membership) for term in output.terms]
        self.positions = {term.name: i for i, term in enumerate(output.terms)}
        self.unnamed: dict[SetPlan, int] = {}
        self.implied: list[ImpliedPlan] = []

    def add(self, position: int, rule: Rule, place: int) -> None:
        """Add a consequent of a rule, the one at a place among all of its consequents."""
        consequent = rule.consequents[place]
        factor = number_of(self.system, rule.weight) if self.semantics.weight == "after" else 1.0
        term = self._term(consequent)
        changes: list[Expr] = []
        if not self.over_rules and self.semantics.consequent_hedges in ("set", "undone"):
            changes += self._hedges(consequent)
        implication = self.implication if self.over_rules else self.system.implication_of(position, self.output)
        if factor != 1.0 and not self.over_rules and implication == "min":
            changes.append(factor * Name(ITSELF))
        other = implication if implication != self.implication else None
        if changes or other:
            term = self._own(dataclasses.replace(self.terms[term], changes=tuple(changes), implication=other))
        self.implied.append(ImpliedPlan(position, term, factor, self._change(rule, place)))

    def _term(self, consequent: Consequent) -> int:
        term = consequent.term
        if isinstance(term, Membership):
            return self._own(consequent_of(self.system, term))
        if term not in self.positions:
            raise UnknownNameError("term", term, self.positions)
        return self.positions[term]

    def _own(self, term: SetPlan) -> int:
        """Return the position of a consequent without a name."""
        position = self.unnamed.setdefault(term, len(self.terms))
        if position == len(self.terms):
            self.terms.append(term)
        return position

    def _hedges(self, consequent: Consequent, *, undone: bool = False) -> list[Expr]:
        """Return what hedges do one after the other, the nearest to the term first, or what undoes them."""
        return [hedge_change(self.system, hedge, undone=undone) for hedge in reversed(consequent.hedges)]

    def _change(self, rule: Rule, place: int) -> Expr | None:
        """Return what hedges make of the activation of a rule in one of its consequents."""
        how = self.semantics.consequent_hedges
        if how == "set" or (how == "undone" and not self.over_rules):
            return None
        before = rule.consequents[:place] if how == "carried" else ()
        changes = [c for own in (*before, rule.consequents[place]) for c in self._hedges(own, undone=how == "undone")]
        if not changes:
            return None
        return reduce(lambda whole, change: replace_names(change, {ITSELF: whole}), changes)


def hedge_change(system: FuzzySystem, hedge: str, *, undone: bool) -> Expr:
    """Return what a hedge, or its inverse, makes of a degree, an expression over `ITSELF`."""
    x, cube = Name(ITSELF), system.method.semantics.extremely == "cube"
    own = next((h for h in system.hedges if h.name == hedge), None)
    if own is not None:
        numbers = constants_of(system, {own.parameter})
        require_known(own.expression, {own.parameter}, numbers)
        return held(guarded(replace_names(own.expression, {**numbers, own.parameter: x})))
    if hedge not in HEDGES:
        raise UnknownNameError("hedge", hedge, [*HEDGES, *(h.name for h in system.hedges)])
    found = inverse_hedge(hedge, cube=cube) if undone else usual_hedge(hedge, cube=cube)
    assert found is not None, "hedges without an inverse are refused"
    return found(x)
