"""Minimum, maximum and steepest slope of each output: proved bounds, with points that come near them."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, Final

from fuzzyctl.analysis import bounds as system_bounds
from fuzzyctl.analysis.accuracy import located
from fuzzyctl.analysis.bounds import SPENT, OutputBound
from fuzzyctl.analysis.multilinear.slopes import steepest
from fuzzyctl.analysis.multilinear.surface import Surface, surface_of
from fuzzyctl.analysis.witnesses import Judge
from fuzzyctl.analysis.work import SECOND, Work, clock, compiling, evaluation
from fuzzyctl.kernels.plan.build import Plan, plan
from fuzzyctl.model.block import Block
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.records import record
from fuzzyctl.support import arguments

#: Seconds that all ends and slopes may take, see `extents`, and all bounds of a controller.
TIMEOUT: Final = 5.0
#: Largest distance of a bound from an attained value, as a part of the bounds of the consequents: about one percent of
#: the range of the attained values.
GAP: Final = 0.008


@record(frozen=True)
class Extent:
    """The extremes of an output over all inputs.

    Args:
        name: The output.
        lo, hi: Every number that a kernel returns lies between them.
        lo_at, hi_at: Points where kernels come nearest to them, as far as found.
        lo_found, hi_found: The output there.
        steepness: A bound of the slope along each input by name, in exact arithmetic; infinite if unknown.
        note: Why bounds are not as tight as they may be; empty if they are.
    """

    name: str
    lo: float
    hi: float
    lo_at: dict[str, float] | None
    hi_at: dict[str, float] | None
    lo_found: float
    hi_found: float
    steepness: dict[str, float]
    note: str = ""


def extents(system: FuzzySystem, *, timeout: float = TIMEOUT) -> tuple[Extent, ...]:
    """Bound every output over all inputs, and its slope along each of them.

    Args:
        system: A well-formed system.
        timeout: Seconds that all ends and slopes may take together on a usual machine. Operations are counted, so that
            bounds are the same in every run, no clock is read; ends come before slopes.

    Returns:
        One for each output, in order.

    Raises:
        ArgumentError: For an object that is not a system, and for a timeout that is not a number.
        ValueOutOfBoundsError: For a negative timeout.
    """
    arguments.instance("the system", FuzzySystem, "a FuzzySystem", system)
    timeout = arguments.seconds("'timeout'", timeout)
    flat = plan(system)
    surface = surface_of(flat)
    bounds = system_bounds.output_bounds(system)
    is_late = not timeout or clock.is_over(compiling(flat)) or not located(flat, Work(0.5 * SECOND * timeout))
    if surface is None and is_late:
        return tuple(_consequents_alone(system, bounds[o.name]) for o in system.outputs)
    judge = Judge(system)
    finder = _AtCorners(system, surface) if surface is not None else _BySubdivision(system, flat, timeout, judge)
    ends = [_ends(system, k, bounds[o.name], finder, judge) for k, o in enumerate(system.outputs)]
    return tuple(_extent(system, k, pair, finder) for k, pair in enumerate(ends))


#: An end: its value, a point that comes near it, and the value there.
_End = tuple[float, dict[str, float] | None, float]


def _ends(system: FuzzySystem, position: int, known: OutputBound, finder: Any, judge: Judge) -> list[_End]:
    """Return both ends of an output, each the tighter one of the bounds by its consequents and by the whole system."""
    ends: list[_End] = []
    for sign, value, at in ((1, known.lo, known.lo_at), (-1, known.hi, known.hi_at)):
        if known.exact and at is None:
            # Some state of an adaptive output attains it; there is no point to look for.
            ends.append((value, None, math.nan))
            continue
        point = list(at.values()) if at is not None else None
        bound, extreme = value, _found(judge, known.name, point)
        if extreme != value:
            bound, point = finder.least(position, sign)
            bound, extreme = max(value, bound) if sign > 0 else min(value, bound), _found(judge, known.name, point)
        ends.append((bound, dict(zip(judge.inputs, point, strict=True)) if point is not None else None, extreme))
    return ends


def _consequents_alone(system: FuzzySystem, known: OutputBound) -> Extent:
    """Return the bounds of an output by its consequents, for which no kernel is compiled."""
    steepness = {v.name: math.inf for v in system.inputs}
    return Extent(known.name, known.lo, known.hi, None, None, math.nan, math.nan, steepness, SPENT)


def _extent(system: FuzzySystem, position: int, ends: list[_End], finder: Any) -> Extent:
    (lo, lo_at, lo_found), (hi, hi_at, hi_found) = ends
    steepness = {v.name: finder.steepest(position, i) for i, v in enumerate(system.inputs)}
    note = SPENT if position in finder.spent else ""
    return Extent(system.outputs[position].name, lo, hi, lo_at, hi_at, lo_found, hi_found, steepness, note)


def _found(judge: Judge, output: str, point: list[float] | None) -> float:
    """Return an output at a point, NaN without one."""
    return judge.outputs(point)[output] if point is not None and not clock.is_over() else math.nan


class _AtCorners:
    """Systems that interpolate: everything is at corners."""

    def __init__(self, system: FuzzySystem, surface: Surface) -> None:
        self.system, self.surface = system, surface
        self.spent: set[int] = set()

    def least(self, output: int, sign: int) -> tuple[float, list[float]]:
        """Return the least (sign 1) or the largest value (-1), rounding included, and where it is."""
        surface = self.surface

        def value(corner: tuple[int, ...]) -> Fraction:
            above, below = surface.sums_at(output, corner)
            return sign * above / below

        best = min(surface.indices, key=value)
        bound = sign * (value(best) - surface.errors[output])
        point = [self.system.number(v.lower) for v in self.system.inputs]
        for k, i in enumerate(surface.inputs):
            point[i] = float(surface.corners[k][best[k]])
        return math.nextafter(float(bound), -sign * math.inf), point

    def steepest(self, output: int, position: int) -> float:
        """Return a bound of the slope along an input."""
        if position not in self.surface.inputs:
            return 0.0
        bound = float(steepest(self.surface, output, self.surface.inputs.index(position)))
        return math.nextafter(bound, math.inf) if bound else 0.0


class _BySubdivision:
    """Any other system: boxes are halved until the bound is near a value that is attained."""

    def __init__(self, system: FuzzySystem, flat: Plan, timeout: float, judge: Judge) -> None:
        from fuzzyctl.analysis.branch_and_bound.boxed_system import System

        self.boxed, self.work = System(system, flat), Work(SECOND * timeout)
        #: How many ends, and slopes, are still to come.
        self.ends, self.slopes = 2 * len(self.boxed.outputs), len(self.boxed.outputs) * len(self.boxed.inputs)
        #: Outputs whose bounds may be tighter with more work.
        self.spent: set[int] = set()
        self.units = evaluation(flat)
        self.judge = judge

    def least(self, output: int, sign: int) -> tuple[float, list[float] | None]:
        """Return a lower bound (sign 1) or an upper one (-1), and a point that comes near it."""
        from fuzzyctl.analysis.branch_and_bound.minimum import least

        if self._is_late(output):
            return -sign * math.inf, None
        limits = self.boxed.bounds[self.boxed.outputs[output]]
        span = limits.hi - limits.lo
        gap = GAP * span if math.isfinite(span) and span else GAP
        work = self.work.part(self.work.left / self.ends)
        self.ends -= 1

        def value(point: list[float]) -> float:
            if not work.takes(self.units) and clock.is_over():
                return math.nan
            return sign * self.judge.outputs(point)[name]

        name = self.boxed.outputs[output]
        bound, point = least(self.boxed, output, sign, gap, value, work)
        self._note_spent(output, work)
        return sign * bound, point

    def steepest(self, output: int, position: int) -> float:
        """Return a bound of the slope along an input."""
        from fuzzyctl.analysis.branch_and_bound.minimum import steepest

        if self._is_late(output):
            return math.inf
        work = self.work.part(self.work.left / self.slopes)
        self.slopes -= 1
        bound = steepest(self.boxed, output, position, work)
        self._note_spent(output, work)
        return bound

    def _is_late(self, output: int) -> bool:
        """Return whether the time is over, and note it."""
        if clock.is_over():
            self.spent.add(output)
        return clock.is_over()

    def _note_spent(self, output: int, work: Work) -> None:
        if work.left <= 0.0:
            self.spent.add(output)


def output_bounds(system: FuzzySystem | Controller, *, timeout: float = TIMEOUT) -> dict[str, OutputBound]:
    """Bound every output of a system over all inputs, or every output and state of a controller over all steps.

    Of a system, an average lies between the consequents of the rules that can fire, a weighted sum within the sum of
    what each rule can add, a centroid between the ends of their supports, an adaptive output within its range. Where it
    is not proved that some rule always fires, `else` counts too. NaN, for `else nan` and for inputs that are NaN, is
    not bounded. Of a controller, inputs are taken in their ranges, and states in those that no step leaves, see
    `prove`; the note of a bound says why an end is infinite, and for which inputs it is proved if not for all.

    Args:
        system: The system or the controller.
        timeout: Seconds that all bounds of a controller may take together; those of a system take no search.

    Returns:
        A bound for each output by name, of a controller for each declared state, too.

    Raises:
        ArgumentError: For an object that is neither a system nor a controller, and for a timeout that is not a number.
        ValueOutOfBoundsError: For a negative timeout.
    """
    timeout = arguments.seconds("'timeout'", timeout)
    block: Any = arguments.instance("the system", Block, "a FuzzySystem or a Controller", system)
    if not block.is_sampled:
        return system_bounds.output_bounds(block)
    from fuzzyctl.analysis.induction.bounds import controller_bounds

    return controller_bounds(block, timeout)
