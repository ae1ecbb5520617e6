"""Params, hedges and guarantees."""

from __future__ import annotations

from fuzzyctl.expr import Expr
from fuzzyctl.model.block import Node
from fuzzyctl.records import dataclass


@dataclass(frozen=True, kw_only=True)
class Bounds(Node):
    """A range of numbers; each end belongs to it unless it is left out."""

    lower: Expr
    upper: Expr
    without_lower: bool = False
    without_upper: bool = False

    def holds(self, value: float, low: float, high: float) -> bool:
        """Return whether a value lies in the range, whose ends have these numbers."""
        above = value > low if self.without_lower else value >= low
        below = value < high if self.without_upper else value <= high
        return above and below

    def text(self, low: float, high: float) -> str:
        """Return the range with the numbers of its ends, such as `[0, 2)`."""
        return f"{'(' if self.without_lower else '['}{low:g}, {high:g}{')' if self.without_upper else ']'}"


@dataclass(frozen=True, kw_only=True, repr=False)
class Param(Node):
    """A named constant; its expression may use params declared anywhere in the system."""

    name: str
    expression: Expr
    unit: str = ""
    bounds: Bounds | None = None


@dataclass(frozen=True, kw_only=True, repr=False)
class Hedge(Node):
    """A hedge of the user's own: `hedge NAME(x) = expression`, over its parameter and params."""

    name: str
    parameter: str
    expression: Expr


@dataclass(frozen=True, kw_only=True, repr=False)
class Guarantee(Node):
    """A claim over the whole input box: `require CLAIM within TOLERANCE when REGION`."""

    claim: Expr
    within: Expr | None = None
    when: Expr | None = None
