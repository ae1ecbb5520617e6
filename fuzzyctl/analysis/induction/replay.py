"""Replay of steps by the kernel: whether a claim is false at a step, and runs from the start that look for one."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Final

from fuzzyctl.analysis.claims import Bound, Claim, Every, Some, Truth, bounds_in
from fuzzyctl.analysis.induction.claims import NEXT, Claims, StepClaim
from fuzzyctl.analysis.induction.step_model import FAR
from fuzzyctl.analysis.verdicts import Witness
from fuzzyctl.analysis.work import clock
from fuzzyctl.expr import Expr, Name, Number
from fuzzyctl.kernels.kernel import Kernel
from fuzzyctl.kernels.plan.equations import DT
from fuzzyctl.kernels.step_form import StepForm
from fuzzyctl.records import record

#: Largest difference of two expressions by rounding, relative to them, for a claim about exact arithmetic.
_ROUNDING: Final = Fraction(1, 1 << 36)
#: Steps of a run, and runs of each kind.
_STEPS, _RUNS = 60, 6
#: Candidates of inputs at each step of a run that heads for the violation of one claim.
_CANDIDATES: Final = 8

#: The least and the largest value.
Ends = tuple[float, float]


class NoValueError(ArithmeticError):
    """Raised if a comparison has no value."""


class Replay:
    """The step of a controller, in plain Python.

    Args:
        claims: All claims about it.
        exact: Comparisons that are about exact arithmetic, so that a difference in the last digits breaks none.
    """

    def __init__(self, claims: Claims, exact: frozenset[Bound]) -> None:
        self.claims, self.exact = claims, exact
        equations = claims.equations
        self.arguments = [*equations.inputs, *([DT] if equations.period is None else [])]
        self.states = [s.name for s in equations.states]
        self.names = [*(name for name, _ in equations.outputs), *(NEXT + n for n in self.states)]
        self.start = [float(s.start) for s in equations.states]

    @cached_property
    def step(self) -> Kernel:
        """The step; a proof without a witness needs none."""
        return Kernel(StepForm(self.claims.equations), "python")

    def breaks(self, claim: Claim, point: Mapping[str, float]) -> bool:
        """Return whether a claim is false at a point; other inputs are 0, `dt` 1 s, other states at their start."""
        arguments = [point.get(n, 1.0 if n == DT else 0.0) for n in self.arguments]
        state = [point.get(n, x) for n, x in zip(self.states, self.start, strict=True)]
        return self.witness(claim, arguments, state, ()) is not None

    def values(self, given: Sequence[float], state: Sequence[float]) -> dict[str, float] | None:
        """Return the outputs and the next state by name; None where no rule fires of a system that must have one."""
        result = [0.0] * len(self.names)
        try:
            self.step.jit(*given, *([list(state)] if state else []), result)
        except ArithmeticError:
            return None
        return dict(zip(self.names, map(float, result), strict=True))

    def witness(
        self, claim: Claim, given: Sequence[float], state: Sequence[float], shown: Sequence[str]
    ) -> Witness | None:
        """Return a step as a witness if a claim is false there, and it lies in the region of the claim.

        Args:
            claim: The claim.
            given: The inputs, and `dt` for a controller without period.
            state: The state before the step.
            shown: The arguments that matter.
        """
        values = self.values(given, state)
        if values is None:
            return None
        try:
            if not self.holds(claim.region, values) or self.holds(claim.truth, values):
                return None
        except NoValueError:
            return None
        bound = next(b for b in bounds_in(claim.truth) if not self.holds(b, values))
        arguments = dict(zip([*self.arguments, *self.states], [*given, *state], strict=True))
        sides = tuple((text, values[name]) for text, name in self.claims.sides.get(bound, ()))
        return Witness({n: arguments[n] for n in shown if n in arguments}, sides or self._side(bound, values))

    def holds(self, truth: Truth, values: Mapping[str, float]) -> bool:
        """Return whether a claim holds for the numbers of a step.

        Raises:
            NoValueError: If a side is NaN; but a next value that is NaN has left its range.
        """
        if isinstance(truth, Every | Some):
            parts = [self.holds(p, values) for p in truth.parts]
            return all(parts) if isinstance(truth, Every) else any(parts)
        assert isinstance(truth, Bound)
        a, b = _number(truth.left, values), _number(truth.right, values)
        if math.isnan(a) or math.isnan(b):
            if any(isinstance(e, Name) and e.name.startswith(NEXT) for e in (truth.left, truth.right)):
                return False
            raise NoValueError
        if math.isinf(a) or math.isinf(b):
            return a > b or (a == b and not truth.strict)
        margin = Fraction(a) - Fraction(b) + truth.tolerance
        if truth in self.exact:
            return margin + _ROUNDING * (abs(Fraction(a)) + abs(Fraction(b))) >= 0
        return margin > 0 if truth.strict else margin >= 0

    @staticmethod
    def _side(bound: Bound, values: Mapping[str, float]) -> tuple[tuple[str, float], ...]:
        return tuple((e.name, values[e.name]) for e in (bound.left, bound.right) if isinstance(e, Name))


class Judge:
    """Evaluates a claim at points of a boxed step; states that the claim does not depend on have their start values.

    Args:
        replay: The step.
        names: The sides of a box.
        shown: The names that a witness shows: all that the claim depends on.
        claim: The claim that a witness has to break, for a range with room for rounding; None for the claim itself.
    """

    def __init__(
        self, replay: Replay, names: Sequence[str], shown: Sequence[str] = (), claim: Claim | None = None
    ) -> None:
        self.replay, self.names, self.shown, self.claim = replay, names, shown, claim

    def broken(self, truth: Truth, region: Truth, point: Sequence[float]) -> Witness | None:
        """Return a point as a witness if it lies in the region and the claim is false there."""
        if not all(map(math.isfinite, point)):
            return None
        claim = self.claim or Claim("", truth, region)
        return self.replay.witness(claim, *self._arguments(point), self.shown)

    def values(self, point: Sequence[float]) -> dict[str, float] | None:
        """Return the values of a step by name; None where it has none."""
        return self.replay.values(*self._arguments(point))

    def _arguments(self, point: Sequence[float]) -> tuple[list[float], list[float]]:
        at = dict(zip(self.names, point, strict=True))
        arguments = [at.get(n, 1.0 if n == DT else 0.0) for n in self.replay.arguments]
        return arguments, [at.get(n, x) for n, x in zip(self.replay.states, self.replay.start, strict=True)]


@record(frozen=True)
class Reached:
    """A step of a run from the start: the arguments, the state before it, and the number of steps before it."""

    given: list[float]
    state: list[float]
    steps: int


class Runs:
    """Runs from the start with inputs in their ranges: at random, at their ends, switching, held for some steps.

    Args:
        replay: The step.
        ranges: Ranges of the inputs and of `dt`.
        deadline: When to stop, on the monotonic clock [s].
    """

    def __init__(self, replay: Replay, ranges: Mapping[str, Ends], deadline: float) -> None:
        self.replay, self.deadline = replay, deadline
        self.ranges = [ranges.get(n, (-FAR, FAR)) for n in replay.arguments]
        self.random = random.Random(1)

    def search(self, claims: Sequence[StepClaim]) -> dict[int, Reached]:
        """Return the first steps found at which claims are false, by the position of the claim."""
        results: dict[int, Reached] = {}
        for moves in self._patterns():
            self._run(moves, claims, results)
        for k, claim in enumerate(claims):
            if k not in results and clock.now() <= self.deadline:
                reached: dict[int, Reached] = {}
                self._run(self._towards(claim), [claim], reached)
                if reached:
                    results[k] = reached[0]
        return results

    def _run(self, moves: Iterator[list[float]], claims: Sequence[StepClaim], reached: dict[int, Reached]) -> None:
        state = self.replay.start
        self._state = state
        for steps, move in enumerate(moves):
            if not all(map(math.isfinite, state)):
                return
            values = self.replay.values(move, state)
            if values is None or clock.now() > self.deadline:
                return
            for k, claim in enumerate(claims):
                if k not in reached and self.replay.witness(claim.claim, move, state, ()) is not None:
                    reached[k] = Reached(move, state, steps)
            state = [values[NEXT + n] for n in self.replay.states]
            self._state = state

    def _patterns(self) -> Iterator[Iterator[list[float]]]:
        for _ in range(_RUNS):
            yield (self._draw(0.1) for _ in range(_STEPS))
            yield (self._draw(1.0) for _ in range(_STEPS))
            yield self._held()

    def _held(self) -> Iterator[list[float]]:
        """Yield inputs at their ends that stay for some steps."""
        move = self._draw(1.0)
        for _ in range(2 * _STEPS):
            if self.random.random() < 0.1:
                move = self._draw(0.8)
            yield move

    def _towards(self, claim: StepClaim) -> Iterator[list[float]]:
        """Yield at each step the inputs, of some, that bring a claim nearest to being false."""
        for _ in range(_STEPS):
            drawn = [self._draw(0.7) for _ in range(_CANDIDATES)]
            yield min(drawn, key=lambda given: self._margin(claim.claim, given))

    def _margin(self, claim: Claim, given: list[float]) -> float:
        values = self.replay.values(given, self._state)
        return math.inf if values is None else _margin(claim.truth, values)

    def _draw(self, ends: float) -> list[float]:
        """Draw inputs, each with some probability at an end of its range."""
        return [self._drawn(low, high, ends) for low, high in self.ranges]

    def _drawn(self, low: float, high: float, ends: float) -> float:
        # Of a range without an end, numbers of usual size.
        low, high = (x if abs(x) < FAR else math.copysign(10.0 ** self.random.uniform(-3, 3), x) for x in (low, high))
        low, high = min(low, high), max(low, high)
        if self.random.random() < ends:
            return self.random.choice((low, high))
        return self.random.uniform(low, high)


def _number(expr: Expr, values: Mapping[str, float]) -> float:
    return expr.value if isinstance(expr, Number) else values[expr.name] if isinstance(expr, Name) else math.nan


def _margin(truth: Truth, values: Mapping[str, float]) -> float:
    """Return by how much a claim holds; below 0 where it is false."""
    match truth:
        case Every(parts=parts):
            return min((_margin(p, values) for p in parts), default=math.inf)
        case Some(parts=parts):
            return max((_margin(p, values) for p in parts), default=-math.inf)
    assert isinstance(truth, Bound)
    result = _number(truth.left, values) - _number(truth.right, values)
    return -math.inf if math.isnan(result) else result
