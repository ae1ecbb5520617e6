"""Dead times of a run: where steps of integration end, and where delayed signals are looked up."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from typing import Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.expr import Expr, Name, names_in
from fuzzyctl.kernels.plan.equations import Equation, Equations, Evaluation, KeptState, feedthrough
from fuzzyctl.model.loop import TIME, Loop
from fuzzyctl.simulation.equations import LoopEquations, needs, reached
from fuzzyctl.simulation.expansion import loop_equations
from fuzzyctl.simulation.sample_times import MOST_KEPT, sample_times

#: Parts of a step at which delayed signals are looked up: begin, middle, end, and a quarter. Signals that vary within
#: a step are kept there, too, and are cubic in between.
PARTS: Final = (0.0, 0.5, 1.0, 0.25)
_END: Final = 2
#: Steps end at jumps of a delayed signal and of this many of its derivatives; RK4 keeps its order at later ones.
_DERIVATIVES: Final = 2
#: Most jumps between two samples that are followed through several dead times.
_MOST_JUMPS: Final = 100
#: Times so near to each other, in sample times, are the same; digits of it, and for dead times of many sample times.
_SAME: Final = 1e-9
_DIGITS: Final = 8
_SAME_LONG: Final = 1e-15
#: Most states of a loop that keeps delayed signals.
_MOST_STATES: Final = 64


@dataclass(frozen=True)
class DeadTimes:
    """Steps of integration of a run, and its dead times.

    Args:
        steps: Steps of integration between two samples.
        size: How many numbers dead times keep.
        integers: Offset and length for each dead time; then the lag in steps for each dead time, step and part.
        weights: The start for each dead time; begin, in steps, and length [s] of each step; then the weights of the
            kept signals for each dead time, step and part, if it varies.
    """

    steps: int
    size: int
    integers: list[int]
    weights: list[float]


def dead_times(equations: LoopEquations, substeps: int) -> DeadTimes:
    """Return the steps of integration, and how delayed signals are looked up at each.

    A step ends where a delayed signal jumps, and none is longer than the shortest dead time.

    Args:
        equations: The loop.
        substeps: The fewest steps between two samples.

    Raises:
        ArgumentError: For more than `MOST_KEPT` numbers, and a number of substeps that is not a positive integer.
    """
    if not (type(substeps) is int and substeps >= 1):
        raise ArgumentError(f"'substeps' must be a positive integer, got {substeps!r}")
    delays, step = equations.delays, equations.step
    if not delays:
        return DeadTimes(substeps, 1, [], [])
    ratios, nodes = [d.time / step for d in delays], len(PARTS) if varies(equations) else 1
    density = max(substeps, 1.0 / min(ratios)) * (1.0 - _SAME)
    begins, lengths, mesh = [], [], []
    for begin, end in pairwise([*_jumps(equations, ratios), 1.0]):
        count = max(math.ceil((end - begin) * density), 1)
        length = (end - begin) / count
        begins += [begin + k * length for k in range(count)]
        lengths += [length] * count
        for k in range(count):
            mesh += [begin / length + k, step * (end - begin) / count]
    integers, lags, weights, offset = [], [], [], 0
    for ratio in ratios:
        lookups = list(_lags(ratio, begins, lengths))
        length = max(lag for lag, _ in lookups) + 1
        integers += [offset, length]
        lags += [lag for lag, _ in lookups]
        weights += [w for _, share in lookups for w in _cubic(share)] if nodes > 1 else []
        offset += nodes * length
        if offset + len(weights) > MOST_KEPT:
            raise ArgumentError(f"a dead time of {ratio * step:g} s is too long for steps of {step / len(begins):g} s")
    return DeadTimes(len(begins), offset, integers + lags, [d.start for d in delays] + mesh + weights)


def varies(equations: LoopEquations) -> bool:
    """Return whether some delayed signal may vary between two samples other than by jumps."""
    names = {d.name for d in equations.delays}
    return any(not names.issuperset(read) for read in _reads(equations))


def _reads(equations: LoopEquations) -> list[Sequence[str]]:
    """Return the states, delayed values and other varying signals that each delayed signal reads."""
    outputs = [n for e in equations.externals for n in e.outputs]
    states, delayed = [s.name for s in equations.plant_states], [d.name for d in equations.delays]
    body = tuple(i for i in equations.body if not (isinstance(i, Equation) and i.name in equations.held))
    signals = tuple((d.name, d.signal) for d in equations.delays)
    reads = feedthrough(Equations((TIME, *states, *outputs, *delayed), (), body, signals, (), None, 0))
    return [reads[name] for name in delayed]


def kept_samples(equations: LoopEquations) -> LoopEquations | str:
    """Return a loop that keeps delayed signals as states, one for each sample of a dead time, or why it cannot.

    That is exact for a signal that only changes at samples, and for any signal that is only read at samples.
    """
    body = [i for i in equations.body if not (isinstance(i, Equation) and i.name in equations.held)]
    varying = {TIME, *(s.name for s in equations.plant_states), *equations.disturbances}
    between = [*equations.integrated, *(e for name, e in equations.signals.items() if name.startswith("#"))]
    states, updates, values = list(equations.states), list(equations.updates), list[Equation | Evaluation]()
    for d in equations.delays:
        ratio = d.time / equations.step
        count = round(ratio)
        if count < 1 or abs(ratio - count) > _SAME * count:
            what = f"a dead time of {d.time:g} s is no whole number of samples of {equations.step:g} s"
            return f"{what}: a 'step' of the run that divides it helps"
        if needs(body, [d.signal], varying) and needs(body, between, {d.name}):
            return f"a signal that changes between samples acts {d.time:g} s later on a plant, which cannot be enclosed"
        names = [f"{d.name}#{k}" for k in range(count)]
        if len(states) + count > _MOST_STATES:
            return f"dead times of more than {_MOST_STATES} samples cannot be enclosed"
        states += [KeptState(name, d.start, span=d.span) for name in names]
        updates += [d.signal, *map(Name, names[:-1])]
        values.append(Equation(d.name, Name(names[-1]), d.span))
    delayed = {d.name for d in equations.delays}
    return replace(equations, body=(*values, *equations.body), states=tuple(states), updates=tuple(updates), delays=(),
                   held=equations.held | delayed)  # fmt: skip


def without_idle_samples(
    loop: Loop, conditions: Sequence[Expr], free: Sequence[str], outputs: Sequence[str] = ()
) -> LoopEquations | str:
    """Return the same of a loop at the samples of its controllers only, if nothing happens at the others.

    A dead time may end at another one, noise that others than controllers read changes there, and a state of a
    controller is seen to have changed.

    Args:
        loop: The loop.
        conditions: The claims, about `#0`, `#1` and so on of the signals.
        free: Params that are arguments.
        outputs: Names of further signals that are seen.
    """
    equations = kept_samples(loop_equations(loop, conditions, free))
    periods = [c.period for c in loop.controllers]
    if isinstance(equations, str) or loop.step is None or not periods or None in periods:
        return equations
    every = sample_times(loop)[1].values()
    if any(n % min(every) for n in every):  # no sample time but that of the run divides all periods
        return equations
    signals = [equations.signals[n] for n in (*outputs, *(f"#{k}" for k in range(len(conditions))))]
    readers: list[Expr] = [*(s.derivative for s in equations.plant_states), *signals]
    items, names = reached(equations, readers)
    readers += [e for i in items for e in (i.arguments if isinstance(i, Evaluation) else (i.value,))]
    if {*names, *(n.name for e in readers for n in names_in(e))}.intersection(chain.from_iterable(equations.given)):
        return equations
    states = {s.name for s in equations.states}
    if any(n.name in states for c in conditions for n in names_in(c)):
        return equations
    coarse = kept_samples(loop_equations(replace(loop, step=None), conditions, free))
    return equations if isinstance(coarse, str) else coarse


def _jumps(equations: LoopEquations, ratios: Sequence[float]) -> list[float]:
    """Return where delayed signals jump between two samples, in sample times: the sample first.

    Held signals jump at samples, and a delayed signal does at the begin; states have a jump one derivative later.
    """
    names, reads = [d.name for d in equations.delays], _reads(equations)
    direct = [[i for i, read in enumerate(reads) if name in read] for name in names]
    later = [i for i, read in enumerate(reads) if not {TIME, *names}.issuperset(read)]
    level = [(j, ratio % 1.0) for j, ratio in enumerate(ratios)]
    jumps = {0.0: 0.0} | {round(at, _DIGITS) % 1.0: at for _, at in level if round(at, _DIGITS) % 1.0}
    most, seen = len(jumps) + _MOST_JUMPS, set[tuple[int, float]]()
    for _ in range(_DERIVATIVES + 1):
        following = []
        for j, at in level:  # which grows
            key = round(at, _DIGITS) % 1.0
            if (j, key) in seen or len(jumps) > most:
                continue
            seen.add((j, key))
            jumps.setdefault(key, at)
            level += [(i, (at + ratios[i]) % 1.0) for i in direct[j]]
            following += [(i, (at + ratios[i]) % 1.0) for i in later]
        level = following
    return sorted(jumps.values())


def _lags(ratio: float, begins: Sequence[float], lengths: Sequence[float]) -> Iterator[tuple[int, float]]:
    """Yield for each step and part how many steps ago a dead time began, and the part of that step.

    At the end of a step a delayed signal has not jumped yet.
    """
    same = _SAME + _SAME_LONG * ratio
    for s, (begin, length) in enumerate(zip(begins, lengths, strict=True)):
        for part, fraction in enumerate(PARTS):
            at = begin + fraction * length - ratio
            beside = at - same if part == _END else at + same
            sample = math.floor(beside)
            n = bisect_right(begins, beside - sample) - 1
            share = (at - sample - begins[n]) / lengths[n]
            share = next((p for p in PARTS if abs(share - p) * lengths[n] <= same), share)
            yield s - n - sample * len(begins), share


def _cubic(share: float) -> list[float]:
    """Return the weights of values at `PARTS` in the cubic polynomial through them."""
    return [math.prod((share - b) / (a - b) for b in PARTS if b != a) for a in PARTS]
