"""Test sequence of a step: inputs one after the other, with the outputs that a target must compute."""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Sequence
from typing import Final

import numpy as np

from fuzzyctl.codegen.comments import ends_of
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.single_precision import LANES, Numbers, Roundings, nearest
from fuzzyctl.codegen.unit import TOLERANCE, Unit
from fuzzyctl.codegen.vectors import Expected, Vector, rounded
from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.kernels.kernel import Kernel
from fuzzyctl.kernels.program import scalar
from fuzzyctl.kernels.step_form import StepForm

#: Steps of a sequence.
STEPS: Final = 200
#: Steps at which an argument is NaN.
NAN_AT: Final = (60, 130)
#: Step at which `dt` is 0, where it is an argument.
STILL_AT: Final = 100
#: Times since the step before [s], where a step takes them.
TIMES: Final = (0.01, 0.01, 0.005, 0.02)
#: Draws of the inputs of a step before the sequence ends.
_DRAWS: Final = 8
#: The part of its tolerance by which a number may change with rounding.
_STEADY: Final = 0.25
#: Larger numbers end a sequence.
_LARGEST: Final = {"double": 1e150, "float": 1e15}
#: Copies of the step in double precision: the units by which all that each takes is off; 0 is one or the other.
_OFF: Final = (0, 1, -1, 0)

#: Outputs, new values of the slots, and the output for which no rule fires.
Found = tuple[list[float], list[float], str]


def sequence(unit: Unit, *, seed: int = 1) -> Expected:
    """Return the steps that a target must make.

    Where rounding decides, such as at a jump, a step has other inputs. Where none are found, or numbers grow beyond all
    bounds, the sequence ends. Errors are relative to the largest magnitudes of outputs; where that ends the sequence
    early, as for a difference that is 0 but for rounding, to those of inputs and starts.

    Raises:
        CodegenError: Where it would be empty.
    """
    result = _steps(unit, random.Random(seed), 0.0)
    if len(result.vectors) < STEPS:
        result = max(result, _steps(unit, random.Random(seed), _magnitude(unit)), key=lambda steps: len(steps.vectors))
    if not result.vectors:
        raise CodegenError(
            "no first step is found that is finite and that rounding does not decide: there is no self-test"
        )
    return result


def _magnitude(unit: Unit) -> float:
    """Return the largest magnitude of inputs and starts."""
    ends = [abs(x) for signal in unit.controller.inputs for x in ends_of(unit, signal.bounds)]
    starts = [abs(slot.start) for slot in unit.slots if math.isfinite(slot.start)]
    return max([*ends, *starts], default=0.0) or 1.0


def _steps(unit: Unit, rng: random.Random, least: float) -> Expected:
    """Draw a sequence.

    Args:
        unit: The unit that makes the steps.
        rng: Draws the inputs.
        least: The least reference of relative errors.
    """
    kernel = Kernel(StepForm(unit.equations), "python")
    state = kernel.start()
    copies = _Single(unit) if unit.precision == "float" else _Double(unit, rng)
    steps = Expected([least] * len(unit.program.results))
    point: tuple[float, ...] = ()
    for k in range(STEPS):
        missing = _without_a_step(unit, k, point)
        if missing:
            steps.anywhere.append(Vector(missing, (math.nan,) * len(unit.outputs)))
            continue
        for _ in range(_DRAWS):
            drawn = _drawn(unit, rng, point)
            wider = _wider(steps.scales, copies.tried(drawn), unit)
            if wider:
                break
        else:
            break
        point, steps.scales = drawn, wider
        copies.keep()
        vector, state = _made(kernel, unit, point, state)
        steps.anywhere.append(vector)
    return steps


def _made(kernel: Kernel, unit: Unit, point: tuple[float, ...], state: Numbers) -> tuple[Vector, Numbers]:
    """Make a step of the kernel; where it refuses the state stays."""
    inputs, time = point[: len(unit.inputs)], point[len(unit.inputs) :]
    try:
        outputs, after = kernel(*inputs, state, dt=time[0] if time else None)
    except NoRuleFiresError as error:
        return Vector(point, (math.nan,) * len(unit.outputs), error.output), state
    return Vector(point, (outputs,) if len(unit.outputs) == 1 else tuple(outputs)), after


def _without_a_step(unit: Unit, k: int, before: tuple[float, ...]) -> tuple[float, ...]:
    """Return arguments at which no step is made, where it is time for them."""
    if k in NAN_AT and before:
        place = NAN_AT.index(k) % len(before)
        return (*before[:place], math.nan, *before[place + 1 :])
    if k == STILL_AT and unit.takes_time:
        return (*before[:-1], 0.0)
    return ()


def _drawn(unit: Unit, rng: random.Random, before: tuple[float, ...]) -> tuple[float, ...]:
    """Draw inputs: some stay, some move a little, some jump."""
    values = []
    for place, signal in enumerate(unit.controller.inputs):
        low, high = ends_of(unit, signal.bounds)
        kind, anywhere = rng.random(), rng.uniform(low, high)
        if not before or kind < 0.3:
            values.append(anywhere)
        elif kind < 0.35:
            values.append(rng.choice([low, high]))
        else:
            values.append(before[place] + (0.05 * (anywhere - before[place]) if kind < 0.7 else 0.0))
    values += [rng.choice(TIMES)] if unit.takes_time else []
    return tuple(rounded(x, unit.precision) for x in values)


def sequence_of_points(unit: Unit, ranges: Sequence[tuple[int, int]], count: int, seed: int = 1) -> list[list[int]]:
    """Return integer inputs one after the other: some stay, some move a little, some jump to anywhere or to an end.

    Args:
        unit: The unit that takes them.
        ranges: The least and the largest integer of each.
        count: How many.
        seed: Of the draws.
    """
    rng, point = random.Random(seed), [0] * len(unit.arguments)
    points = []
    for k in range(count):
        drawn = []
        for before, (least, most) in zip(point, ranges, strict=True):
            kind, anywhere = rng.random(), rng.randint(least, most)
            near = min(max(before + round(0.05 * (anywhere - before)), least), most)
            drawn.append(
                anywhere
                if k == 0 or kind < 0.3
                else rng.choice([least, most])
                if kind < 0.4
                else near
                if kind < 0.7
                else before
            )
        point = drawn
        points.append(point)
    return points


def _wider(scales: Sequence[float], found: Sequence[Found], unit: Unit) -> list[float]:
    """Return the largest magnitudes so far with those of a step; empty where its copies are apart, or too large."""
    first, *others = ([*outputs, *values] for outputs, values, _ in found)
    if len({refused for _, _, refused in found}) > 1:
        return []
    if found[0][2]:
        return list(scales)
    values = first[len(unit.outputs) :]
    if not all(abs(x) <= _LARGEST[unit.precision] for x in values) or math.inf in map(abs, first):
        return []
    wider = [max(scale, abs(x)) if math.isfinite(x) else scale for scale, x in zip(scales, first, strict=True)]
    allowed = [_STEADY * TOLERANCE[unit.precision] * scale for scale in wider]
    for other in others:
        for a, b, most in zip(first, other, allowed, strict=True):
            if not (abs(a - b) <= most or (math.isnan(a) and math.isnan(b))):
                return []
    return wider


class _Double:
    """Copies of a step in double precision: the first as it is, the others with arguments and state off by one unit.

    A state that is at its start in all copies depends on no rounding and stays.
    """

    def __init__(self, unit: Unit, rng: random.Random) -> None:
        self._unit, self._rng = unit, rng
        source = scalar.storing_source(unit.program)
        self._store = scalar.compile_source(source, unit.program, unit.program.arguments)
        self._states = [[deque([s.start] * s.length, maxlen=s.length) for s in unit.slots] for _ in _OFF]
        self._found: list[Found] = []

    def tried(self, point: tuple[float, ...]) -> list[Found]:
        """Return the results of each copy at a point."""
        self._found = [self._made(point, state, k) for k, state in enumerate(self._states)]
        return self._found

    def _made(self, point: tuple[float, ...], state: Sequence[deque[float]], copy: int) -> Found:
        arguments = [*point, *(line[0] for line in state), *(number.start for number in self._unit.numbers)]
        if copy:
            off = [x * (1.0 + (_OFF[copy] or self._rng.choice((-1, 1))) * 2.0**-52) for x in arguments]
            for k in range(len(state)):
                if {slots[k][0] for slots in self._states} == {self._unit.slots[k].start}:
                    off[len(point) + k] = arguments[len(point) + k]
            arguments = off
        results = [math.nan] * len(self._unit.program.results)
        try:
            self._store(*arguments, results)
        except NoRuleFiresError as error:
            return [], [], error.output
        count = len(self._unit.outputs)
        return results[:count], results[count:], ""

    @property
    def is_refused(self) -> bool:
        """Whether no rule fires at the last point."""
        return bool(self._found[0][2])

    def keep(self) -> None:
        """Go on from the last point; where it was refused the state stays."""
        for state, (_, values, _) in zip(self._states, self._found, strict=True):
            for line, value in zip(state, values, strict=False):
                line.append(value)


class _Single:
    """What single precision may make of a step, each rounding with the state that it has come to."""

    def __init__(self, unit: Unit) -> None:
        self._unit = unit
        self._exact = _Double(unit, random.Random(0))
        self._run = Roundings(unit.program)
        starts = [np.full((1, LANES), nearest(s.start)) for s in unit.slots]
        self._state = [deque([x] * s.length, maxlen=s.length) for x, s in zip(starts, unit.slots, strict=True)]
        self._numbers = [np.full((1, LANES), nearest(n.start)) for n in unit.numbers]
        self._taken: list[Numbers] = []

    def tried(self, point: tuple[float, ...]) -> list[Found]:
        """Return what double precision makes of a point, then each rounding."""
        results, refused = self._run.run(nearest([point]), [*(line[0] for line in self._state), *self._numbers])
        count = len(self._unit.outputs)
        self._taken = list(results[count:])
        numbers = [[float(r[0, k]) for r in results] for k in range(LANES)]
        lanes = [(row[:count], row[count:], str(refused[0, k])) for k, row in enumerate(numbers)]
        return [self._exact.tried(point)[0], *(([], [], lane[2]) if lane[2] else lane for lane in lanes)]

    def keep(self) -> None:
        """Go on from the last point; where it was refused the state stays."""
        self._exact.keep()
        if not self._exact.is_refused:
            for line, value in zip(self._state, self._taken, strict=True):
                line.append(value)
