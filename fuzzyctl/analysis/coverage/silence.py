"""Points where no rule moves an output, or where the strongest rule acts weakly.

Coverage by cells and boxes may stay undecided. Then a pattern search starts at the points where the rules fire least
and moves along one input after the other; its steps grow while the activation falls and shrink otherwise. Each point
that it returns is evaluated; without a point the question stays open. Tails of smooth terms may keep rules active far
from their peaks: the coverage check does not report that, so weak activations have another diagnostic.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import replace
from functools import cached_property
from itertools import islice
from typing import Any, Final

from fuzzyctl.analysis import sampling
from fuzzyctl.analysis.coverage.box_search import Hole
from fuzzyctl.analysis.work import SEARCH, SpentError, Work, compilation, evaluation
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.diagnostics.fixes import Fix, Replacement
from fuzzyctl.diagnostics.source import Span
from fuzzyctl.expr import Call, Compare, Name
from fuzzyctl.formulas import is_endless
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import HeldPlan, Otherwise, OutputPlan, Plan, plan
from fuzzyctl.kernels.program import scalar
from fuzzyctl.kernels.program.program import Program
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.model.variable import Output


class Silence:
    """Tells where kernels fall back on the `else` of an output, or activate none of its rules.

    Args:
        flat: The system.
        name: The output.
        work: The work that is allowed; a search that takes more raises `SpentError`.
    """

    def __init__(self, flat: Plan, name: str, work: Work) -> None:
        self.system, self.work = flat, work
        self.position = next(k for k, o in enumerate(flat.outputs) if o.name == name)
        #: Whether no output reads another one, so that all may be silent at once.
        self.apart = not any(o.reads for o in flat.outputs)
        self.flat = replace(
            flat, outputs=tuple(_nan_where_silent(o, own=self.apart or o.name == name) for o in flat.outputs)
        )
        self.state: list[Any] = [self.flat.initial_state] if self.flat.initial_state else []

    def of(self, name: str, work: Work) -> Silence:
        """Return the same for another output, without compiling anew where that can be spared."""
        if not self.apart:
            return Silence(self.system, name, work)
        other = copy(self)
        other.work, other.position = work, next(k for k, o in enumerate(self.flat.outputs) if o.name == name)
        return other

    @cached_property
    def units(self) -> float:
        """The work of an evaluation."""
        return 2 + evaluation(self.flat)

    @cached_property
    def value(self) -> Callable[..., Any]:
        """The outputs, NaN where they are silent."""
        self.work.spend(compilation(self.flat))
        return _compiled(self.flat, inference.evaluation(self.flat))

    @cached_property
    def strength(self) -> Callable[..., Any]:
        """The largest activation of each output."""
        self.work.spend(compilation(self.flat))
        return _compiled(self.flat, inference.largest_activations(self.flat))

    def holds_at(self, point: Sequence[float]) -> bool:
        """Return whether the output is silent at a point, the values of the inputs in order."""
        self.work.spend(self.units)
        if math.isnan(self._own(self.value(*point, *self.state))):
            return True
        return not self.state and self.activation(point) == 0.0

    def activation(self, point: Sequence[float]) -> float:
        """Return the largest activation among the rules of an output without states at a point."""
        self.work.spend(self.units)
        return self._own(self.strength(*point))

    def confirms(self, hole: Hole) -> bool:
        """Return whether the output is silent at the witness of a hole."""
        return self.holds_at(list(hole.witness.values()))

    def _own(self, found: Any) -> float:
        return float(found[self.position] if isinstance(found, tuple) else found)


def unclear_at(hole: Hole) -> str:
    """Return why a hole that is not confirmed decides nothing."""
    at = ", ".join(f"{n} = {x:.12g}" for n, x in hole.witness.items())
    return f"some rule moves it at {at}, but so little that it is not known whether one does nearby"


def at(flat: Plan, point: Sequence[float]) -> str:
    """Return a point in words, with as many digits as it has."""
    return ", ".join(f"{i.name} = {_digits(x)}" for i, x in zip(flat.inputs, point, strict=True))


def _digits(x: float) -> str:
    short = f"{x:.12g}"
    return short if float(short) == x else repr(x)


def _nan_where_silent(output: OutputPlan, *, own: bool) -> OutputPlan:
    """Return an output with an `else` of NaN, for the one asked about and for others that raise."""
    value: Otherwise = output.otherwise.start if isinstance(output.otherwise, HeldPlan) else output.otherwise
    return replace(output, otherwise=math.nan if own or not isinstance(value, float) else value)


def _compiled(flat: Plan, program: Program) -> Callable[..., Any]:
    names = [i.name for i in flat.inputs]
    return scalar.compile_source(scalar.evaluation_source(program), program, names)


#: Points to go from: those of a grid where the rules fire least, and as many random ones.
STARTS: Final = 8
#: Random points among which those that count are looked for.
TRIES: Final = 500
#: Steps below this part of the range are not taken.
SHORTEST: Final = 1e-12

Point = Sequence[float]


def silent_point(flat: Plan, silence: Silence, inside: Callable[[Point], bool] | None = None) -> list[float] | None:
    """Return a point where no rule moves an output, with few digits, or None.

    Args:
        flat: The system.
        silence: Of the output; it says how much may be computed, too.
        inside: Tells the points that count, all if it is None.
    """
    if len(flat.rules) > sampling.RULES:
        return None
    search = _Search(flat, silence, inside or (lambda _: True))
    try:
        result = search.found()
    except SpentError:
        return None
    try:
        return None if result is None else search.shortened(result, silence.holds_at)
    except SpentError:
        return result


def weakest_point(flat: Plan, silence: Silence, below: float) -> list[float] | None:
    """Return a point, with few digits, where the strongest rule acts, but below a bound; None if none is found."""
    if len(flat.rules) > sampling.RULES:
        return None
    search, points = _Search(flat, silence, lambda _: True), [list(p) for p in sampling.points(flat)]
    ranked = sorted((silence.activation(p), p) for p in points)
    with suppress(SpentError):
        more = search.random() if len(points) == sampling.POINTS else ()
        for start in [*(p for _, p in ranked[:3]), *more] if ranked[0][0] > 0.0 else []:
            point = search.descended(start)
            ranked = min(ranked[:1], [(silence.activation(point), point)])
    lowest, point = ranked[0]
    if not 0.0 < lowest < below:
        return None
    return search.shortened(point, lambda p: 0.0 < silence.activation(p) < min(below, 1.1 * lowest))


class _Search:
    def __init__(self, flat: Plan, silence: Silence, inside: Callable[[Point], bool]) -> None:
        self.flat, self.silence, self.inside = flat, silence, inside

    def found(self) -> list[float] | None:
        grid: list[tuple[float, list[float]]] = []
        guided = not self.silence.state  # activations are those of outputs without states
        for point in map(list, sampling.points(self.flat)):
            if self.inside(point):
                if self.silence.holds_at(point):
                    return point
                if guided:
                    grid.append((self.silence.activation(point), point))
        if not guided:
            return None
        grid.sort(key=lambda pair: pair[0])
        for start in [*(point for _, point in grid[:STARTS]), *self.random()]:
            point = self.descended(start)
            if self.silence.holds_at(point):
                return point
        return None

    def random(self) -> Iterator[list[float]]:
        rng = random.Random(0)
        points = ([rng.uniform(v.lower, v.upper) for v in self.flat.inputs] for _ in range(TRIES))
        yield from islice((point for point in points if self.inside(point)), STARTS)

    def descended(self, point: list[float]) -> list[float]:
        """Return a point near which rules fire no less anywhere along an input."""
        lowest = self.silence.activation(point)
        widths = [v.upper - v.lower for v in self.flat.inputs]
        steps = [0.25 * w for w in widths]
        while lowest > 0.0:
            if all(s < SHORTEST * w for s, w in zip(steps, widths, strict=True)):
                break
            for i in range(len(steps)):
                better = self._along(point, i, steps[i], lowest)
                if better is None:
                    steps[i] *= 0.5
                else:
                    lowest, point = better
                    steps[i] *= 2.0
        return point

    def _along(self, point: list[float], position: int, step: float, lowest: float) -> tuple[float, list[float]] | None:
        variable = self.flat.inputs[position]
        for x in (point[position] - step, point[position] + step):
            if not variable.extrapolate:
                x = min(max(x, variable.lower), variable.upper)
            moved = [*point[:position], x, *point[position + 1 :]]
            if math.isfinite(x) and self.inside(moved):
                activation = self.silence.activation(moved)
                if activation < lowest:
                    return activation, moved
        return None

    def shortened(self, point: list[float], holds: Callable[[Point], bool]) -> list[float]:
        """Return the point with as few digits as it needs for a condition to hold."""
        for digits in range(1, 17):
            short = [float(f"{x:.{digits}g}") for x in point]
            if self._is_in_range(short) and self.inside(short) and holds(short):
                return short
        return point

    def _is_in_range(self, point: list[float]) -> bool:
        sides = zip(point, self.flat.inputs, strict=True)
        return all(v.extrapolate or v.lower <= x <= v.upper for x, v in sides)


#: Activation of the strongest rule below which coverage is weak.
WEAK: Final = 0.1


def weak_coverage(system: FuzzySystem, flat: Plan) -> Iterator[Diagnostic]:
    """Report outputs for which the strongest rule acts weakly somewhere within the ranges of the inputs."""
    kinds = {d.set.kind.split()[0] for d in flat.degrees if not d.set.vertices}
    if not any(map(is_endless, kinds)) or flat.initial_state:
        return
    claimed = dict(_claims(system))
    for output in system.outputs:
        if claimed.get(output.name, WEAK) >= WEAK and system.conclusions.get(output.name):
            with suppress(SpentError):
                yield from _weak(system, output, _clamped(flat), is_claimed=output.name in claimed)


def _clamped(flat: Plan) -> Plan:
    return replace(flat, inputs=tuple(replace(i, extrapolate=False) for i in flat.inputs))


def _claims(system: FuzzySystem) -> Iterator[tuple[str, float]]:
    """Yield outputs with the strength that is claimed of their rules."""
    for guarantee in system.guarantees:
        match guarantee.claim:
            case Compare(left=Call(function="total", arguments=(Name(name=name),)), right=strength):
                yield name, system.number(strength)


def _weak(system: FuzzySystem, output: Output, flat: Plan, *, is_claimed: bool) -> Iterator[Diagnostic]:
    # A separate budget, so that other checks keep theirs.
    silence = Silence(flat, output.name, Work(SEARCH))
    point = weakest_point(flat, silence, WEAK)
    if point is not None and system.method.conjunction != "min":
        # By products of many degrees of one half every activation is small; weak is a rule with a small degree.
        method = system.method.model_copy(update={"conjunction": "min"})
        least = _clamped(plan(system.model_copy(update={"method": method})))
        point = weakest_point(least, Silence(least, output.name, Work(SEARCH)), WEAK)
    if point is None:
        return
    activation = silence.activation(point)
    message = f"no rule for output '{output.name}' acts by more than {activation:.2g} at {at(flat, point)}"
    fact = "terms without an end, such as gaussian and bell, leave a little activation everywhere: tails decide there"
    claim = f"require total({output.name}) >= {WEAK:g}"
    help_text = "let a term of the inputs or a rule reach there"
    help_text += "" if is_claimed else f", and write the claim '{claim}'"
    fix = None if is_claimed else _written(system, output, claim)
    yield Diagnostic("FZ411", message, output.span, "warning", (fact,), help_text, fix=fix)


def _written(system: FuzzySystem, output: Output, claim: str) -> Fix | None:
    """Return the edit that writes a claim below the last rule or guarantee of the system."""
    if output.span is None:
        return None
    source = output.span.source
    spans = [part.span for part in (output, *system.rules, *system.guarantees)]
    last = max(s.end for s in spans if s is not None and s.source is source)
    end = last + len(source.text[last:].partition("\n")[0])
    return Fix((Replacement(Span(source, end, end), f"\n{claim}"),), "likely")
