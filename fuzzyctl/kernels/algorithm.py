"""The choice of an algorithm: all of them compute the same function, and a system has one that is fastest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

from fuzzyctl.errors import ArgumentError
from fuzzyctl.kernels import inference, interpolation
from fuzzyctl.kernels.factoring import factored
from fuzzyctl.kernels.grid import Grid, grid_of
from fuzzyctl.kernels.inlining import inlined
from fuzzyctl.kernels.plan import Plan
from fuzzyctl.kernels.program import Program
from fuzzyctl.kernels.skips import skipping

#: `rules` evaluates every rule; `interpolation` looks up what the rules say in the cell of the inputs; `auto` takes
#: interpolation where the system allows it.
ALGORITHMS: Final = ("auto", "interpolation", "rules")


@dataclass(frozen=True)
class Algorithm:
    """An algorithm for a plan.

    Args:
        plan: The plan.
        grid: Its values at the knots, for interpolation; None for evaluation of the rules.
        reason: Why it is not interpolation, or what is interpolated.
    """

    plan: Plan
    grid: Grid | None
    reason: str

    @property
    def name(self) -> str:
        """One of `ALGORITHMS` but `auto`."""
        return "rules" if self.grid is None else "interpolation"

    @cached_property
    def point(self) -> Program:
        """The program for one point."""
        return inference.evaluation(self.plan) if self.grid is None else interpolation.lookup(self.plan, self.grid)

    @cached_property
    def interpreted(self) -> Program:
        """The program for one point in generated Python."""
        if self.grid is None:
            return inlined(factored(skipping(inference.evaluation(self.plan, branches=True))))
        return self.point

    @cached_property
    def many(self) -> Program:
        """The program for loops over many points, of which compilers make vector instructions."""
        if self.grid is None:
            return inference.evaluation(self.plan, many=True)
        return interpolation.batch(self.plan, self.grid)


def algorithm_of(plan: Plan, wanted: str = "auto") -> Algorithm:
    """Choose the algorithm for a plan.

    Args:
        plan: The plan.
        wanted: One of `ALGORITHMS`.

    Raises:
        ArgumentError: For interpolation where the system does not interpolate.
    """
    if wanted == "rules":
        return Algorithm(plan, None, "it was asked for")
    grid = grid_of(plan)
    if isinstance(grid, Grid):
        knots = " x ".join(str(len(k)) for k in grid.knots)
        quotient = " of two sums" if any(t.weight for t in grid.outputs) else ""
        return Algorithm(plan, grid, f"the output{quotient} at {knots} knots of the inputs")
    if wanted == "interpolation":
        raise ArgumentError(f"the system does not interpolate: {grid}")
    return Algorithm(plan, None, grid)
