"""Evaluated numbers of a system, where computable; checks read ranges and shapes from here."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import zip_longest

from fuzzyctl.expr import Expr, ExprError, Number, evaluate
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.model.block import ParamValues
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import LinguisticVariable, Membership, Term

#: A term with its parameters.
Shape = tuple[Term, tuple[float, ...]]


class Numbers:
    """The numbers of a system that can be computed.

    A check that asks here never meets a number that is reported elsewhere, nor a shape with bad parameters.

    Args:
        system: The system.
        partial: Whether parts of it could not be read or resolved; their users have no value then.
    """

    def __init__(self, system: FuzzySystem, *, partial: bool = False) -> None:
        self.system = system
        self.params = ParamValues(system.params, partial=True) if partial else system.param_values
        self._given_of: dict[int, list[Shape]] = {}
        self._shapes_of: dict[int, list[Shape]] = {}

    @property
    def variables(self) -> tuple[LinguisticVariable, ...]:
        """Inputs, outputs and lets."""
        return self.system.variables

    def failure(self, expr: Expr) -> ExprError | None:
        """Return why an expression has no value; None if it has one, and if the reason is reported elsewhere."""
        if self.params.lacks(expr):
            return None
        try:
            evaluate(expr, self.params.values)
        except ExprError as error:
            return error
        return None

    def value(self, expr: Expr) -> float | None:
        """Return the value of an expression, None where it has none."""
        if type(expr) is Number:  # nearly all are
            return expr.value
        try:
            return evaluate(expr, self.params.values)
        except ExprError:
            return None

    def finite(self, expr: Expr) -> float | None:
        """Return the value of an expression, None where it has none or an infinite one."""
        value = self.value(expr)
        return value if value is not None and math.isfinite(value) else None

    def ends(self, variable: LinguisticVariable) -> tuple[float, float] | None:
        """Return the ends of a range, in whatever order; None where one of them has no finite value."""
        low, high = self.finite(variable.lower), self.finite(variable.upper)
        return (low, high) if low is not None and high is not None else None

    def range(self, variable: LinguisticVariable) -> tuple[float, float] | None:
        """Return the ends of a range that is neither too wide nor empty, else None."""
        ends = self.ends(variable)
        return ends if ends is not None and 0 < ends[1] - ends[0] < math.inf else None

    def given(self, variable: LinguisticVariable) -> list[Shape]:
        """Return the terms that are fuzzy sets and whose parameters can be computed, good or bad."""
        results = self._given_of.get(id(variable))
        if results is None:
            results = self._given_of[id(variable)] = list(self._given(variable))
        return results

    def shapes(self, variable: LinguisticVariable) -> list[Shape]:
        """Return the terms that are fuzzy sets with sound parameters."""
        results = self._shapes_of.get(id(variable))
        if results is None:
            pairs = self.given(variable)
            results = [(t, p) for t, p in pairs if MEMBERSHIP[t.membership.kind].mistake(p) is None]
            self._shapes_of[id(variable)] = results
        return results

    def core(self, shape: Shape) -> float:
        """Return the middle of the core of a term."""
        term, parameters = shape
        left, right = MEMBERSHIP[term.membership.kind].core(parameters)
        return (left + right) / 2

    def _given(self, variable: LinguisticVariable) -> Iterator[Shape]:
        for term in variable.terms:
            if term.membership.kind not in MEMBERSHIP:
                continue
            formula = MEMBERSHIP[term.membership.kind]
            numbers = [
                self.value(e) if name in formula.infinite else self.finite(e)
                for e, name in zip_longest(term.membership.arguments, formula.parameters)
                if e is not None
            ]
            values = tuple(v for v in numbers if v is not None)
            if len(values) == len(numbers):
                yield term, values


def parameters(membership: Membership, name: str) -> Iterator[tuple[Expr, bool, str]]:
    """Yield the parameters of a term with whether each may be infinite and its description."""
    if membership.kind in ("function", "formula"):
        return  # an expression over variables has no fixed value
    formula = MEMBERSHIP.get(membership.kind)
    for i, argument in enumerate(membership.arguments):
        named = formula is not None and i < len(formula.parameters)
        parameter = formula.parameters[i] if formula is not None and named else f"parameter {i + 1}"
        yield argument, formula is not None and parameter in formula.infinite, f"{parameter} of '{name}'"
