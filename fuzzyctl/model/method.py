"""How a system infers: norms, implication, aggregation and defuzzifier."""

from __future__ import annotations

from typing import Final, Literal

from fuzzyctl.model.node import Node

#: Defuzzifiers over rules: each rule counts with the middle of the core of its consequent term, weighted by its
#: activation; implication and aggregation then have no effect. `center_average` is the name Mamdani systems use,
#: `weighted_average` the one of Takagi-Sugeno systems; the formula is the same, Eq. (18) of Goto, Bertol, Martins.
AVERAGES: Final = ("center_average", "weighted_average")

#: All defuzzifiers.
DEFUZZIFIERS: Final = ("centroid", *AVERAGES)

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
        """Whether it sums over rules rather than over a fuzzy set."""
        return self.kind in AVERAGES


class Method(Node):
    """The inference method of a system; the defaults are those of the profile `exact`."""

    conjunction: str = "min"
    disjunction: str = "max"
    implication: str = "min"
    aggregation: str = "max"
    defuzzifier: Defuzzifier = Defuzzifier()
