"""How a system infers: norms, implication, aggregation and defuzzifier."""

from __future__ import annotations

from typing import Final, Literal

from pydantic import InstanceOf

from fuzzyctl.expr import Expr
from fuzzyctl.model.node import Node

#: Defuzzifiers over rules: each rule counts with the middle of the core of its consequent term, weighted by its
#: activation; implication and aggregation then have no effect. `center_average` is the name Mamdani systems use,
#: `weighted_average` the one of Takagi-Sugeno systems; the formula is the same, Eq. (18) of Goto, Bertol, Martins.
AVERAGES: Final = ("center_average", "weighted_average")

#: Defuzzifiers whose result is a sum over rules; `tsukamoto` takes for each rule the value at which the monotone
#: membership function of its consequent has the degree of the activation, `weighted_sum` does not divide.
OVER_RULES: Final = (*AVERAGES, "weighted_sum", "tsukamoto")

#: All defuzzifiers.
DEFUZZIFIERS: Final = ("centroid", *OVER_RULES)

#: Activation methods: which rules act, given the activations of all. `first`, `last`: the first or last COUNT rules,
#: in the order written, whose activation is above 0 and at least THRESHOLD; `highest`, `lowest`: the COUNT rules of
#: highest or lowest activation above 0, of equal ones the earlier; `proportional`: activations divided by their sum;
#: `threshold`: those that compare with THRESHOLD as said.
ACTIVATIONS: Final = ("general", "first", "last", "highest", "lowest", "proportional", "threshold")

Grid = Literal["midpoint", "endpoints"]


class Defuzzifier(Node):
    """A defuzzifier.

    Args:
        kind: One of `DEFUZZIFIERS`.
        resolution: For `centroid` the number of sample points; None for the exact centroid.
        grid: Where the samples stand: the middles of equal cells, or equal steps from end to end.
    """

    kind: str = "centroid"
    resolution: int | None = None
    grid: Grid = "midpoint"

    @property
    def averages(self) -> bool:
        """Whether it is an average over rules."""
        return self.kind in AVERAGES

    @property
    def over_rules(self) -> bool:
        """Whether it sums over rules rather than over a fuzzy set."""
        return self.kind in OVER_RULES


class Activation(Node):
    """An activation method.

    Args:
        kind: One of `ACTIVATIONS`.
        count: Number of rules for `first`, `last`, `highest`, `lowest`; else None.
        threshold: Least activation for `first`, `last`, the bound for `threshold`; else None.
        comparison: For `threshold` one of `<`, `<=`, `==`, `!=`, `>=`, `>`; else None.
    """

    kind: str = "general"
    count: int | None = None
    threshold: InstanceOf[Expr] | None = None
    comparison: str | None = None


class Method(Node):
    """The inference method of a system; the defaults are those of the profile `exact`."""

    conjunction: str = "min"
    disjunction: str = "max"
    implication: str = "min"
    aggregation: str = "max"
    activation: Activation = Activation()
    defuzzifier: Defuzzifier = Defuzzifier()
