"""Test vectors: input points in their order of evaluation, with the outputs that a target must compute."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice, product
from typing import Any, Final

import numpy as np

from fuzzyctl.analysis.degrees import breakpoints
from fuzzyctl.codegen.c_text import single
from fuzzyctl.codegen.errors import CodegenError
from fuzzyctl.codegen.single_precision import LANES, Numbers, Roundings, nearest
from fuzzyctl.codegen.unit import TOLERANCE, Precision, Unit
from fuzzyctl.diagnostics.diagnostic import NoRuleFiresError
from fuzzyctl.expr import Compare, Expr, Number
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.program import scalar
from fuzzyctl.kernels.program.program import Quadrature
from fuzzyctl.kernels.program.traversal import map_expressions

#: Most corners, and random points.
CORNERS: Final = 100
RANDOM: Final = 100
#: Step of an adaptive system between vectors [s].
STEP: Final = 0.01
#: A vector is left out where an output changes by more than this part of its tolerance within the last bits of the
#: inputs: there, at a jump, targets may differ.
_STEADY: Final = 0.25

#: Activations below this may be 0 in single precision, whose smallest number with all digits is 1.2e-38.
_UNDERFLOW: Final = 1e-30


@dataclass(frozen=True)
class Vector:
    """Inputs with the expected results.

    Args:
        inputs: One number for each input.
        outputs: One for each output; NaN where it has none.
        refused: The output for which no rule fires, or an empty string.
    """

    inputs: tuple[float, ...]
    outputs: tuple[float, ...]
    refused: str = ""


@dataclass
class Expected:
    """Vectors of a self-test.

    Args:
        scales: The reference of relative errors of each output, then of each slot of a controller.
        anywhere: Vectors that hold wherever `double` has 32 bits only, too, or is not used there.
        here: Further ones.
    """

    scales: Sequence[float]
    anywhere: list[Vector] = field(default_factory=list)
    here: list[Vector] = field(default_factory=list)

    @property
    def vectors(self) -> list[Vector]:
        """All vectors."""
        return [*self.anywhere, *self.here]

    def tolerance(self, output: int, precision: Precision) -> float:
        """Return the largest error of an output that a self-test allows: what rounding may make of it."""
        return TOLERANCE[precision] * self.scales[output]


def in_parts(unit: Unit, *, seed: int = 1) -> tuple[list[Vector], list[Vector]]:
    """Return vectors that also hold if `double` has 32 bits only, and then those that do not.

    They lie at corners of the terms, at random points, outside the ranges, and at NaN and infinities. A system with a
    state is evaluated from its start on, and adapts by one step of `STEP` after each vector.
    """
    tried = points(unit, random.Random(seed))
    wide, narrow = Reference(unit), _narrowed(unit)
    if narrow is None:
        return [], [wide.next(p) for p in tried if wide.steady(p)]
    anywhere: list[Vector] = []
    waiting: list[tuple[float, ...]] = []
    # Without a state every point is rounded at once.
    alike = narrow.rounded_alike(tried) if not narrow.state else None
    for k, point in enumerate(tried):
        same = alike[k] if alike is not None else narrow.rounded_alike([point])[0]
        if same and narrow.steady(point) and wide.steady(point):
            anywhere.append(wide.next(point))
            narrow.next(point)
        elif unit.precision == "double":
            waiting.append(point)
    return anywhere, [wide.next(p) for p in waiting if wide.steady(p)]


def _narrowed(unit: Unit) -> Reference | None:
    """Return the reference of single precision, None where that has not all numbers of the system.

    Adaptive integrals have none either: only JavaScript has them, whose numbers are always double.
    """
    if any(isinstance(s, Quadrature) for s in unit.program.body):
        return None
    try:
        for _, values in unit.program.tables:
            for value in filter(math.isfinite, values):
                single(value)
        return Reference(replace(unit, precision="float"))
    except CodegenError:
        if unit.precision == "float":
            raise
        return None


def points(unit: Unit, rng: random.Random) -> list[tuple[float, ...]]:
    """Return the inputs to try, as the precision has them."""
    flat = unit.plan
    ends = [(i.lower, i.upper) for i in flat.inputs]
    axes = [
        [*breakpoints(variable, [d.set for d in flat.degrees if d.variable == i]), *ends[i]]
        for i, variable in enumerate(flat.inputs)
    ]
    corners = list(islice(product(*(sorted(set(a)) for a in axes)), 20 * CORNERS))
    chosen = rng.sample(corners, min(CORNERS, len(corners)))
    inside = [tuple(rng.uniform(a, b) for a, b in ends) for _ in range(RANDOM)]
    outside = [tuple(rng.uniform(a - 2 * (b - a), b + 2 * (b - a)) for a, b in ends) for _ in range(RANDOM // 4)]
    middle = tuple(0.5 * a + 0.5 * b for a, b in ends)
    odd = [
        (*middle[:i], value, *middle[i + 1 :])
        for i in range(len(ends))
        for value in (math.nan, math.inf, -math.inf, 0.0, -0.0)
    ]
    every = [*chosen, *inside, *outside, *odd, tuple(math.nan for _ in ends), *inside[:3]]
    return [tuple(rounded(x, unit.precision) for x in point) for point in every]


def rounded(x: float, precision: str) -> float:
    """Return a number as a precision has it."""
    return single(x) if precision == "float" and math.isfinite(x) else x


class Reference:
    """The kernel in Python, with the state that its caller keeps."""

    def __init__(self, unit: Unit) -> None:
        self.unit = unit
        program, names = unit.algorithm.printed, [i.name for i in unit.plan.inputs]
        self._evaluate = scalar.compile_source(scalar.evaluation_source(program), program, names)
        self._coarse = self._evaluate
        if unit.precision == "float":
            coarse = map_expressions(program, _as_single)
            self._coarse = scalar.compile_source(scalar.evaluation_source(coarse), coarse, names)
        self._single = _Single(unit) if unit.precision == "float" else None
        self.state = list(unit.plan.initial_state)
        self._rates: Callable[..., Any] | None = None
        if unit.plan.states:
            rates = inference.rates(unit.plan)
            self._rates = scalar.compile_source(scalar.storing_source(rates), rates, names)

    def evaluate(self, point: Sequence[float]) -> Vector:
        """Evaluate at a point; the state stays."""
        return self._evaluated(self._evaluate, point)

    def _evaluated(self, function: Callable[..., Any], point: Sequence[float]) -> Vector:
        state = (self.state,) if self.state else ()
        try:
            result = function(*point, *state)
        except NoRuleFiresError as error:
            return Vector(tuple(point), (math.nan,) * len(self.unit.plan.outputs), error.output)
        return Vector(tuple(point), result if isinstance(result, tuple) else (result,))

    def next(self, point: Sequence[float]) -> Vector:
        """Evaluate at a point, keep held outputs, and adapt by one step."""
        result = self.evaluate(point)
        self.state = self._after(result)
        if self._single is not None:
            self._single.keep()
        return result

    def _after(self, vector: Vector) -> list[float]:
        """Return the state after a vector, which holds and adapts."""
        flat, state = self.unit.plan, list(self.state)
        if not vector.refused:
            for k, o in enumerate(flat.held, start=len(flat.states)):
                if not math.isnan(vector.outputs[o]):
                    state[k] = vector.outputs[o]
        if self._rates is not None:
            self._adapt(self._rates, vector.inputs, state)
        return state

    def _adapt(self, write_rates: Callable[..., Any], point: Sequence[float], state: list[float]) -> None:
        flat = self.unit.plan
        rates = [math.nan] * len(flat.states)
        try:
            write_rates(*point, state, rates)
        except NoRuleFiresError:
            return
        for k, (o, _) in enumerate(flat.states):
            value = state[k] + STEP * rates[k]
            if not math.isnan(value):
                state[k] = min(max(value, flat.outputs[o].lower), flat.outputs[o].upper)

    def rounded_alike(self, tried: Sequence[tuple[float, ...]]) -> list[bool]:
        """Return for some points whether single precision, however it rounds, stays near, and so does the state."""
        assert self._single is not None
        vectors = [self.evaluate(point) for point in tried]
        lanes = self._single.vectors(tried)
        return [
            all(self._alike(a, b) for b in result) and all(self._same_state(self._after(a), after) for after in states)
            for a, (result, states) in zip(vectors, lanes, strict=True)
        ]

    def _same_state(self, a: Sequence[float], b: Sequence[float]) -> bool:
        flat = self.unit.plan
        outputs = [*(o for o, _ in flat.states), *flat.held]
        return all(self._near(o, x, y) for o, x, y in zip(outputs, a, b, strict=True))

    def steady(self, point: Sequence[float]) -> bool:
        """Return whether outputs are the same within the last bits of inputs, activations and constants."""
        vector = self.evaluate(point)
        if not self._alike(vector, self._evaluated(self._coarse, point)):
            return False
        others = neighbours(
            point, self.unit.precision, [max(abs(i.lower), abs(i.upper)) for i in self.unit.plan.inputs]
        )
        after = self._after(vector)
        near = [self.evaluate(other) for other in others]
        return all(self._alike(vector, result) and self._same_state(after, self._after(result)) for result in near)

    def _alike(self, a: Vector, b: Vector) -> bool:
        if a.refused != b.refused:
            return False
        return all(self._near(k, x, y) for k, (x, y) in enumerate(zip(a.outputs, b.outputs, strict=True)))

    def _near(self, output: int, x: float, y: float) -> bool:
        return (math.isnan(x) and math.isnan(y)) or abs(x - y) <= _STEADY * self.unit.tolerance(output)


class _Single:
    """What single precision may make of vectors, each rounding with the state that it has come to."""

    def __init__(self, unit: Unit) -> None:
        self.unit = unit
        self._evaluate = Roundings(unit.program)
        self._rates = Roundings(unit.rates) if unit.rates is not None else None
        self._state = [np.full((1, LANES), single(v)) for v in unit.plan.initial_state]
        self._next = self._state

    def keep(self) -> None:
        """Go on from the last point."""
        self._state = self._next

    def vectors(self, tried: Sequence[tuple[float, ...]]) -> list[tuple[list[Vector], list[tuple[float, ...]]]]:
        """Return for each point the vector of each lane, and the state after it; one point where there is a state."""
        numbers = nearest(tried)
        results, refused = self._evaluate.run(numbers, self._state)
        none = (refused != "") | np.isnan(numbers).any(axis=1)[:, None]
        results = [np.where(none, np.nan, r) for r in results]
        refused = np.where(np.isnan(numbers).any(axis=1)[:, None], "", refused)
        if self._state:
            self._next = self._after(numbers, results)
        rows = []
        for i, point in enumerate(tried):
            lanes = [Vector(point, tuple(float(r[i, k]) for r in results), str(refused[i, k])) for k in range(LANES)]
            rows.append((lanes, [tuple(float(s[i, k]) for s in self._next) for k in range(LANES)]))
        return rows

    def _after(self, numbers: Numbers, results: list[Numbers]) -> list[Numbers]:
        flat, state = self.unit.plan, list(self._state)
        for k, o in enumerate(flat.held, start=len(flat.states)):
            state[k] = np.where(np.isnan(results[o]), state[k], results[o])
        if self._rates is None or np.isnan(numbers).any():
            return state
        rates, refused = self._rates.run(numbers, state)
        for k, (o, _) in enumerate(flat.states):
            value = nearest(state[k] + nearest(nearest(STEP) * rates[k]))
            number = np.clip(value, nearest(flat.outputs[o].lower), nearest(flat.outputs[o].upper))
            state[k] = np.where(np.isnan(value) | (refused != ""), state[k], number)
        return state


def _as_single(node: Expr) -> Expr:
    """Replace numbers that may be 0 in single precision by 0, and round constants, as places of singletons, to it."""
    match node:
        case Compare(op=">", left=left, right=Number(value=0.0)):
            return Compare(">", left, Number(_UNDERFLOW))
        case Number(value=value) if value != 0.0 and math.isfinite(single(value)) and abs(value) > _UNDERFLOW:
            return Number(single(value))
    return node


def neighbours(point: Sequence[float], precision: str, scales: Sequence[float]) -> list[tuple[float, ...]]:
    """Return points that differ from one by a few units in the last place of one input, or of the ends of its range.

    Degrees are rounded like the corners that an input is compared with, also where the input itself is near 0.
    """
    relative = 2.0**-50 if precision == "double" else 2.0**-22
    results = []
    for i, (x, scale) in enumerate(zip(point, scales, strict=True)):
        if math.isfinite(x):
            for sign in (-1.0, 1.0):
                results.append((*point[:i], x + sign * max(max(abs(x), scale) * relative, 1e-300), *point[i + 1 :]))
    return results
