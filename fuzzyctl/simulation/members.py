"""Members of the family of a loop: corners, a Latin hypercube, their runs, the claims that these break, and tubes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.expr import Compare, Logic, Number, Where, evaluate, walk
from fuzzyctl.kernels.plan.equations import Equation
from fuzzyctl.model.block import ParamValues
from fuzzyctl.model.instance_params import with_instance_params
from fuzzyctl.model.loop import Always, Loop
from fuzzyctl.simulation.equations import reached
from fuzzyctl.simulation.expansion import loop_equations
from fuzzyctl.simulation.experiment import Experiment
from fuzzyctl.simulation.fmu_plant import require_fixed
from fuzzyctl.simulation.judgement import broken_at, operands_of
from fuzzyctl.simulation.loop_params import with_settings
from fuzzyctl.simulation.run import Run

if TYPE_CHECKING:
    from fuzzyctl.annotations import FloatArray

#: Most corners of a family that are run.
MOST_CORNERS: Final = 2**8
#: How many times finer the steps are of a run that confirms another one.
_FINER: Final = 4
#: The claim that a stopped run breaks.
STOPPED: Final = "stopped"

#: The numbers of a member by name.
Member = Mapping[str, float]


def members(loop: Loop, count: int = MOST_CORNERS, seed: int = 0) -> list[Member]:
    """Return members of the family of a loop: its corners if there are no more than `count`, then a Latin hypercube.

    Args:
        loop: The loop.
        count: How many there are at most.
        seed: Of the hypercube.
    """
    size = len(loop.family)
    corners = list(itertools.product((0.0, 1.0), repeat=size)) if 2**size <= min(count, MOST_CORNERS) else []
    points: list[Sequence[float]] = [*corners]
    if len(points) < count:
        from scipy.stats import qmc

        points += qmc.LatinHypercube(size, seed=seed).random(count - len(points)).tolist() if size else []
    return [_member(loop, point) for point in points]


def corners(loop: Loop) -> list[Member]:
    """Return the corners of the family of a loop; if there are more than `MOST_CORNERS`, a Latin hypercube."""
    return members(loop, min(2 ** len(loop.family), MOST_CORNERS))


def _member(loop: Loop, point: Sequence[float]) -> Member:
    """Return the member at a point of the unit cube; ends that do not belong to a range are missed by a hair."""
    values: dict[str, float] = {}
    for (name, bounds), part in zip(loop.family.items(), point, strict=True):
        changed = [replace(p, expression=Number(values[p.name])) if p.name in values else p for p in loop.params]
        params = ParamValues(changed).values
        low, high = evaluate(bounds.lower, params), evaluate(bounds.upper, params)
        low = math.nextafter(low, high) if bounds.without_lower else low
        high = math.nextafter(high, low) if bounds.without_upper else high
        values[name] = min(max((1.0 - part) * low + part * high, low), high)
    return values


def can_be_free(loop: Loop, name: str) -> bool:
    """Whether a number can be an argument of a compiled run; params that starts depend on, or of FMUs, cannot."""
    try:
        require_fixed(loop, (name,))
        loop_equations(with_instance_params(loop, (name,)), free=(name,))
    except ArgumentError:
        return False
    return True


def runs(loop: Loop, members: Iterable[Member], *, substeps: int = 1) -> Iterator[Run]:
    """Run members of the family of a loop, each compiled once for the numbers that can be arguments.

    Raises:
        DiagnosticError: For a member that the loop does not take.
    """
    names: list[str] = []
    experiments: dict[tuple[float, ...], Experiment] = {}
    for member in members:
        names = names or [name for name in member if can_be_free(loop, name)]
        fixed = {name: value for name, value in member.items() if name not in names}
        key = tuple(fixed.values())
        if key not in experiments:
            experiments[key] = Experiment(with_settings(loop, fixed) if fixed else loop, free=names)
        yield experiments[key].run([member[name] for name in names], substeps=substeps)


def is_broken(claim: Always, loop: Loop, member: Member, run: Run) -> bool:
    """Return whether a member breaks a claim by more than the error of its run, which a run with finer steps shows.

    Steps across a jump of a derivative err by as much as a signal moves in a step, whatever their length. At the start
    there is no such error.
    """
    fine = next(runs(loop, [member], substeps=_FINER))
    params = {**loop.param_values.values, **run.params}
    broken = broken_at(claim, run.t, run.signal, params)
    seen = slice(min(2 * broken[0] + _FINER, len(run.t), len(fine.t)))
    equations = loop_equations(loop)
    derivatives = [s.derivative for s in equations.plant_states]
    body = [i.value for i in reached(equations, derivatives)[0] if isinstance(i, Equation)]
    jumps = any(isinstance(n, Where | Compare | Logic) for e in (*derivatives, *body) for n in walk(e))
    error = 0.0
    for expr in operands_of(claim.claim):
        if not isinstance(expr, Number):
            rough, exact = run.signal(expr)[seen], fine.signal(expr)[seen]
            moves = np.max(abs(np.diff(exact)), initial=0.0) / _FINER if jumps else 0.0
            error = max(error, float(np.max(abs(rough - exact)) + moves))
    common = set(broken[broken < seen.stop].tolist())
    for more in (0.0, np.where(fine.t > fine.t[0], error, 0.0)):
        common &= set(broken_at(claim, fine.t, fine.signal, params, more).tolist())
    return bool(common)


@dataclass(frozen=True)
class Broken:
    """A claim that some members break.

    Args:
        claim: Its text, or why the runs were stopped.
        count: How many members break it.
        member: The first of them.
        facts: Of its run.
    """

    claim: str
    count: int
    member: Member
    facts: tuple[str, ...]


def broken(members: Sequence[Member], runs: Iterable[Run]) -> list[Broken]:
    """Return the claims that the runs of some members break, each with the first of them."""
    results: dict[str, Broken] = {}
    for member, run in zip(members, runs, strict=True):
        reasons = {f"require {r.text}": r.facts for r in run.requirements if not r.holds}
        if run.stopped is not None:
            reasons = {STOPPED: (run.stopped.message,)}
        for claim, facts in reasons.items():
            first = results.get(claim)
            results[claim] = Broken(claim, 1, member, facts) if first is None else replace(first, count=first.count + 1)
    return list(results.values())


def replayed(member: Member, settings: Sequence[str] = ()) -> str:
    """Return the options of `fuzzyctl simulate` that run a member, of a loop with settings by `NAME=VALUE`."""
    return " ".join(f"--set {text}" for text in (*settings, *(f"{n}={value!r}" for n, value in member.items())))


@dataclass(frozen=True, eq=False)
class Tube:
    """Bounds of signals over stretches of time, for all members of a family.

    Args:
        begin: Where each stretch begins, shape (n,) [s].
        end: Where it ends, the begin of the next one, shape (n,) [s].
        bounds: The least and the greatest value of each signal over each stretch, shape (n,), by name.
    """

    begin: FloatArray
    end: FloatArray
    bounds: Mapping[str, tuple[FloatArray, FloatArray]]


def hull(tubes: Sequence[Tube]) -> Tube:
    """Return the union of tubes of parts of a family, up to the time at which the first of them ends."""
    return _merged(tubes, min(t.end[-1] if len(t.end) else 0.0 for t in tubes), np.min, np.max)


def intersection(tubes: Sequence[Tube]) -> Tube:
    """Return the intersection of tubes of one family, up to the time at which the last of them ends."""
    return _merged(tubes, max(t.end[-1] if len(t.end) else 0.0 for t in tubes), np.max, np.min)


def _merged(
    tubes: Sequence[Tube], last: float, low: Callable[..., FloatArray], high: Callable[..., FloatArray]
) -> Tube:
    if len(tubes) == 1:
        return tubes[0]
    times = np.unique(np.concatenate([np.zeros(1), *(t.end for t in tubes)]))
    times = times[times <= last]
    # The stretches in which the middles lie; behind the last one a tube bounds nothing.
    places = [np.searchsorted(t.end, 0.5 * (times[:-1] + times[1:])) for t in tubes]
    bounds = {}
    for name in tubes[0].bounds:
        if all(name in t.bounds for t in tubes):
            sides = [t.bounds[name] for t in tubes]
            lows = [np.append(a, -np.inf)[at] for (a, _), at in zip(sides, places, strict=True)]
            highs = [np.append(b, np.inf)[at] for (_, b), at in zip(sides, places, strict=True)]
            bounds[name] = low(lows, axis=0), high(highs, axis=0)
    return Tube(times[:-1], times[1:], bounds)
