"""Choice of the fastest algorithm among those that compute the same function."""

from __future__ import annotations

from functools import cached_property
from typing import Final, Literal, get_args

from fuzzyctl.diagnostics.diagnostic import ArgumentError, UnknownNameError
from fuzzyctl.kernels.algorithms import interpolation, rule_cells
from fuzzyctl.kernels.algorithms.grid import Grid, grid_of
from fuzzyctl.kernels.algorithms.rule_cells import Active
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.program.program import Program
from fuzzyctl.records import record

#: `rules` evaluates every rule; `interpolation` looks up the cell of the inputs; `active`
#: averages over the rules that act; `auto` takes the fastest that the system allows.
AlgorithmName = Literal["auto", "interpolation", "active", "rules"]
ALGORITHMS: Final = get_args(AlgorithmName)

#: Most pairs of lines of an exact centroid that is written out: compiled (a second for some hundreds), and
#: interpreted; beyond, integrals are faster than waiting for the compiler.
COMPILED: Final = 1000
INTERPRETED: Final = 10_000


@record(frozen=True)
class Algorithm:
    """An algorithm for a plan.

    Args:
        plan: The plan.
        grid: Its values at the knots, for interpolation, else None.
        reason: Why it is not interpolation, or the interpolated quantity.
        active: The rules of each cell, for averages over the rules that act, else None.
        is_forced: Whether the caller chose it, so that it is used even if another one is faster.
        most_coefficients: Of all cells that are interpolated in; beyond, values at their corners are stored.
    """

    plan: Plan
    grid: Grid | None
    reason: str
    active: Active | None = None
    is_forced: bool = False
    most_coefficients: int = interpolation.MOST_COEFFICIENTS

    def __repr__(self) -> str:
        return f"Algorithm({self.name}: {self.reason})"

    @property
    def name(self) -> str:
        """One of `ALGORITHMS` but `auto`."""
        if self.grid is not None:
            return "interpolation"
        return "rules" if self.active is None else "active"

    @property
    def is_defined(self) -> bool:
        """Whether it is seen from it that some rule fires wherever the inputs are."""
        return self.grid is not None

    @cached_property
    def point(self) -> Program:
        """The program for one point."""
        if self.grid is not None:
            return interpolation.lookup(self.plan, self.grid, self.most_coefficients)
        if self.active is not None:
            return rule_cells.lookup(self.plan, self.active)
        return inference.evaluation(self.plan, most_pairs=COMPILED)

    @cached_property
    def printed(self) -> Program:
        """The program for one point in another language, which has no integrals and no loops over corners."""
        if self.grid is not None:
            return interpolation.written_out(self.plan, self.grid, self.most_coefficients)
        return self.point if self.name != "rules" else inference.evaluation(self.plan)

    @cached_property
    def interpreted(self) -> Program:
        """The program for one point in generated Python."""
        if self.grid is not None:
            return interpolation.interpreted(self.plan, self.grid)
        if self._gains(rule_cells.LEAST_GAIN_INTERPRETED):
            return self.point
        return inference.evaluation(self.plan, most_pairs=INTERPRETED)

    @cached_property
    def many(self) -> Program:
        """The program for loops over many points, in a form that compilers vectorise."""
        if self.grid is not None:
            return interpolation.lookup(self.plan, self.grid)
        if self._gains(rule_cells.LEAST_GAIN_MANY):
            return self.point
        return inference.evaluation(self.plan, many=True, most_pairs=COMPILED)

    @property
    def arrays(self) -> Program:
        """The program for arrays that numpy takes operation by operation; looking up is fast there."""
        if self.grid is not None:
            return interpolation.arrays(self.plan, self.grid)
        return self.point if self._gains(rule_cells.LEAST_GAIN_INTERPRETED) else self.many

    def _gains(self, least: float) -> bool:
        """Whether rules are looked up: by the ratio of all rules to those that can act, or on request."""
        return self.active is not None and (self.is_forced or self.active.gain >= least)


def algorithm_of(plan: Plan, wanted: str = "auto") -> Algorithm:
    """Choose the algorithm for a plan.

    Args:
        plan: The plan.
        wanted: One of `ALGORITHMS`.

    Raises:
        UnknownNameError: For another one.
        ArgumentError: For an algorithm that the system does not allow.
    """
    if wanted not in ALGORITHMS:
        raise UnknownNameError("algorithm", wanted, ALGORITHMS)
    if wanted == "rules":
        return Algorithm(plan, None, "it was asked for")
    grid = grid_of(plan)
    if wanted == "auto" and isinstance(grid, Grid) and interpolation.is_sparse(plan, grid):
        grid = f"{len(plan.rules)} rules are less work than the corners of a cell"
    if wanted != "active" and isinstance(grid, Grid):
        knots = " x ".join(str(len(k)) for k in grid.knots)
        quotient = " of two sums" if any(t.weight for t in grid.outputs) else ""
        return Algorithm(plan, grid, f"the output{quotient} at {knots} knots of the inputs")
    if wanted == "interpolation":
        raise ArgumentError(f"the system does not interpolate: {grid}")
    reason = grid if isinstance(grid, str) else "it was asked for"
    table = rule_cells.active_of(plan, least_gain=0.0 if wanted == "active" else rule_cells.LEAST_GAIN)
    if isinstance(table, Active):
        together = f"{1 << len(table.axes)} of {len(plan.rules)} rules at a time"
        return Algorithm(plan, None, f"{together}; {reason}", active=table, is_forced=wanted == "active")
    if wanted == "active":
        raise ArgumentError(f"rules that can act are not looked up: {table}")
    return Algorithm(plan, None, reason)
