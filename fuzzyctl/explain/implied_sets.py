"""Implied and aggregated sets of an output at a point, as plots show them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from functools import reduce

from fuzzyctl.expr import Name
from fuzzyctl.formulas import aggregation, conjunction
from fuzzyctl.kernels.inference.defuzzify.sampling import sampled_degrees
from fuzzyctl.kernels.plan.build import OutputPlan, SetPlan, planned_set
from fuzzyctl.kernels.plan.clauses import hedge_change
from fuzzyctl.kernels.program.scalar import scalar_function
from fuzzyctl.model.rule import Is
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable

#: Degrees at the points of a picture.
Curve = tuple[float, ...]


def antecedent_set(system: FuzzySystem, variable: LinguisticVariable, part: Is) -> SetPlan | None:
    """Return the set that a part of an antecedent asks for, its hedges included; None for a function of the inputs."""
    term = variable.term(part.term)
    planned = None if term is None else planned_set(system, variable, term)
    if planned is None:
        return None
    changes = tuple(hedge_change(system, hedge, undone=False) for hedge in reversed(part.hedges))
    return dataclasses.replace(planned, changes=changes)


class ImpliedSets:
    """Implied sets of the rules of one output, over some of its values.

    Args:
        output: The output, whose defuzzifier looks at a set.
        points: Values of the output.
    """

    def __init__(self, output: OutputPlan, points: Sequence[float]) -> None:
        self.output, self.points = output, points
        self._join = scalar_function(aggregation(output.aggregation, output.equal)(Name("a"), Name("b")))

    def _term(self, rule: int, nth: int) -> SetPlan:
        return self.output.terms[[e for e in self.output.implied if e.rule == rule][nth].term]

    def consequent(self, rule: int, nth: int = 0) -> Curve | None:
        """Return the set that a rule names for the output, as its hedges leave it; None for other consequents.

        Args:
            rule: Position of the rule.
            nth: Which of its consequents for this output, from 0 on; rules of some formats name an output twice.
        """
        term = self._term(rule, nth)
        return None if term.reads_inputs else sampled_degrees(term, self.points)

    def implied(self, rule: int, activation: float, nth: int = 0) -> Curve | None:
        """Return the implied set of a rule: its consequent under the activation applied to it."""
        implied = self.consequent(rule, nth)
        if implied is None:
            return None
        norm = conjunction(self.output.implication_of(self._term(rule, nth)), self.output.equal)
        imply = scalar_function(norm(Name("a"), Name("b")))
        return tuple(imply(activation, degree) for degree in implied)

    def together(self, rules: Iterable[tuple[int, float, int]]) -> Curve:
        """Return the aggregated set of rules, each given with the activation applied to it and its consequent."""
        curves = [
            curve for rule, consequent, nth in rules if (curve := self.implied(rule, consequent, nth)) is not None
        ]
        return tuple(reduce(self._join, degrees) for degrees in zip(*curves, strict=True)) if curves else ()

    @property
    def has_crisp_values(self) -> bool:
        """Whether rules give a crisp value each, as by Tsukamoto's method, and no set."""
        return self.output.inverts or self.output.takes_degrees

    def crisp_values(self, rules: Iterable[tuple[int, float, int]]) -> list[tuple[float, float]]:
        """Return the crisp values of rules with the activation applied to each; arguments as for `together`.

        A function of the inputs has none.
        """
        activated: dict[object, tuple[SetPlan, float]] = {}
        for rule, consequent, nth in rules:
            term = self._term(rule, nth)
            if term.reads_inputs:
                continue
            # Where the sum runs over terms, rules of one term give one value together.
            key: object = term if self.output.merge != "rules" else (rule, nth)
            activated[key] = (term, self._join(activated[key][1], consequent) if key in activated else consequent)
        return [(self._crisp_value(term, strength), strength) for term, strength in activated.values()]

    def _crisp_value(self, term: SetPlan, strength: float) -> float:
        output = self.output
        if output.inverts:
            # As kernels do: see `defuzzify`.
            limited = output.places == "clamped" and (term.height != 1.0 or output.merge != "rules")
            share = scalar_function(term.share(Name("w"), limited=limited))(strength)
            value = float(scalar_function(term.inverse(Name("w")))(share))
        else:
            value = float(scalar_function(term.degree(Name("w")))(strength))
        return min(max(value, output.lower), output.upper) if output.places == "clamped" else value
