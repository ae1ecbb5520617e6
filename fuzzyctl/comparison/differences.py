"""Differences between the outputs of two blocks: mean, largest, and where."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.expr import ExprError
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.kernels.compile import compile as compile_system
from fuzzyctl.kernels.kernel import Kernel
from fuzzyctl.model.block import Block
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.support import arguments

if TYPE_CHECKING:
    from fuzzyctl.annotations import FloatArray

#: Points that are compared unless the caller says otherwise.
POINTS: Final = 10_000

#: Rounds of points around the worst one found, each round in a smaller box.
ROUNDS: Final = 12
AROUND: Final = 64

#: Least number of points for which progress is reported, and the number of parts they are evaluated in.
MANY: Final = 500
PARTS: Final = 64

#: Progress callback of a comparison.
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Place:
    """A point, and what two blocks say of an output there.

    Args:
        point: The inputs of the first block by name.
        first: The value of the first block; NaN for no value.
        second: The value of the second.
    """

    point: dict[str, float]
    first: float
    second: float


@dataclass(frozen=True)
class Difference:
    """How far one output of two blocks is apart.

    Args:
        output: Its name in the first block, `next NAME` for the next value of a state.
        largest: The largest difference found where both have a value; infinite where one of the values is, or where at
            each point only one has a value.
        point: Where it is: the inputs of the first block by name.
        first: The value of the first block there; NaN for no value.
        second: The value of the second there.
        mean: The mean difference over all points where both have a value.
        points: How many points were compared.
        one_sided: At how many of them only one block has a value.
        gap: The first of these, or None.
    """

    output: str
    largest: float
    point: dict[str, float]
    first: float
    second: float
    mean: float
    points: int
    one_sided: int
    gap: Place | None = None

    @property
    def valued(self) -> bool:
        """Whether both have a value at the point of the largest difference, as they have unless they nowhere have."""
        return not math.isnan(self.first) and not math.isnan(self.second)

    def within(self, tolerance: float) -> bool:
        """Return whether both have a value wherever one has, and these differ by no more than a tolerance."""
        return self.one_sided == 0 and self.largest <= tolerance


def differences(
    a: Block,
    b: Block,
    *,
    points: int = POINTS,
    seed: int = 0,
    progress: Progress | None = None,
    states: Sequence[Sequence[float] | None] = (None, None),
) -> tuple[Difference, ...]:
    """Evaluate two systems, or one step of two controllers, at the same points.

    Corners of all terms, an even grid and random points are compared; around the worst of them it is looked for a
    worse one. Where no rule fires and a system says `else error`, it has no value; adaptive outputs, and those that
    hold their previous value, are evaluated with the same state at each point, as each step of a controller is.

    Args:
        a: The first system or controller.
        b: The second one, with the same inputs and outputs: by name, those of other names in order.
        points: How many points to compare.
        seed: For those at random.
        progress: Called now and then.
        states: The state of each; None for the initial one.

    Returns:
        One difference for each output of the first block, then for the next value of each state that both have.

    Raises:
        ArgumentError: For blocks whose inputs or outputs cannot be paired, an input without a finite range, and a
            controller whose steps depend on a time that it does not declare.
    """
    for block in (a, b):
        arguments.instance("what is compared", Block, "a FuzzySystem or a Controller", block)
    inputs, outputs = pairing(a, b)
    where = common_points(a, b, inputs, points, seed)
    pair = _Pair(a, b, inputs, outputs, states, progress)
    first, second = pair.values(where)
    return tuple(_difference(pair, where, (first[:, k], second[:, k]), k, seed) for k in range(first.shape[1]))


def pairing(a: Block, b: Block) -> tuple[list[int], list[int]]:
    """Return for each input and output of the first block its position in the second one.

    Raises:
        ArgumentError: Where names differ and numbers too.
    """
    return _positions("input", [v.name for v in a.inputs], [v.name for v in b.inputs]), _positions(
        "output", [v.name for v in a.outputs], [v.name for v in b.outputs]
    )


def _positions(what: str, names: list[str], other: list[str]) -> list[int]:
    if len(names) != len(other):
        message = f"the blocks have different {what}s: {', '.join(names)} and {', '.join(other)}"
        raise ArgumentError(message)
    unnamed = (k for k, name in enumerate(other) if name not in names)
    return [other.index(name) if name in other else next(unnamed) for name in names]


class _Pair:
    """Both blocks compiled, evaluated at the points of the first."""

    def __init__(
        self,
        a: Block,
        b: Block,
        inputs: list[int],
        outputs: list[int],
        states: Sequence[Sequence[float] | None],
        progress: Progress | None,
    ) -> None:
        import numpy as np

        self.names = [v.name for v in a.inputs]
        self.columns = list(np.argsort(inputs))
        self.progress = progress
        self.kernels, self.states = [_compiled(block) for block in (a, b)], states
        first, second = (k.state_names if k.form.moves else () for k in self.kernels)
        common = [(k, second.index(name)) for k, name in enumerate(first) if name in second]
        self.results = [*(o.name for o in a.outputs), *(f"next {first[k]}" for k, _ in common)]
        #: The columns of the results of each that are compared.
        self.chosen = [
            [*range(len(outputs)), *(len(outputs) + k for k, _ in common)],
            [*outputs, *(len(outputs) + k for _, k in common)],
        ]

    def point(self, at: FloatArray) -> dict[str, float]:
        return dict(zip(self.names, map(float, at), strict=True))

    def values(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what both say at points, shape (n, outputs) each, in the order of the first one's outputs."""
        import numpy as np

        if self.progress is None or len(points) < MANY:
            return self._values(points)
        columns = []
        for k, part in enumerate(np.array_split(points, PARTS)):
            self.progress(f"comparing at {len(points):,} points: {100 * k // PARTS} %")
            columns.append(self._values(part))
        first, second = (np.concatenate(side) for side in zip(*columns, strict=True))
        return first, second

    def _values(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        ordered = (points, points[:, self.columns])
        first, second = (
            _batch(kernel, inputs, state)[:, chosen]
            for kernel, inputs, state, chosen in zip(self.kernels, ordered, self.states, self.chosen, strict=True)
        )
        return first, second


def _compiled(block: Any) -> Kernel:
    """Return the kernel of a block that has no value where it would raise.

    Raises:
        ArgumentError: For a controller whose steps depend on a time that it does not declare.
    """
    kernel: Kernel = compile_system(block.with_systems(quiet), backend="numpy")
    if kernel.form.needs_time:
        raise ArgumentError(f"controller '{block.name}' has no 'every' line: its outputs depend on 'dt', too")
    return kernel


def _batch(kernel: Kernel, points: FloatArray, state: Sequence[float] | None = None) -> FloatArray:
    """Return all outputs of a kernel at points, shape (n, outputs), of a controller with its next states."""
    import numpy as np

    values = kernel.batch(np.ascontiguousarray(points), state)
    parts = values if kernel.form.moves else (values,)
    return np.concatenate([np.asarray(part).reshape(len(points), -1) for part in parts], axis=1)


def quiet(system: FuzzySystem) -> FuzzySystem:
    """Return a system that has no value where it would raise."""
    outputs = tuple(replace(o, otherwise="nan") if o.otherwise == "error" else o for o in system.outputs)
    return replace(system, outputs=outputs) if outputs != system.outputs else system


def apart(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return absolute differences: 0 where both have no value or the same infinite one, infinite where one has none."""
    import numpy as np

    with np.errstate(invalid="ignore"):
        distance: FloatArray = np.abs(first - second)
    distance[(first == second) | (np.isnan(first) & np.isnan(second))] = 0.0
    distance[np.isnan(distance)] = np.inf
    return distance


def _difference(
    pair: _Pair, points: FloatArray, values: tuple[FloatArray, FloatArray], output: int, seed: int
) -> Difference:
    """Return the difference of an output whose values in both systems were found at points."""
    import numpy as np

    first, second = values
    lonely = np.isnan(first) != np.isnan(second)
    distance = apart(first, second)
    both = np.isfinite(distance)
    worst = _worst(first, second)
    at, one, other = points[worst], float(first[worst]), float(second[worst])
    if 0.0 < distance[worst] < np.inf and points.shape[1]:
        at, one, other = _refined(pair, points, at, output, seed)
    gap = int(np.argmax(lonely))
    return Difference(
        output=pair.results[output],
        largest=float(apart(np.array([one]), np.array([other]))[0]),
        point=pair.point(at),
        first=one,
        second=other,
        mean=float(distance[both].mean()) if both.any() else 0.0,
        points=len(points),
        one_sided=int(lonely.sum()),
        gap=Place(pair.point(points[gap]), float(first[gap]), float(second[gap])) if lonely.any() else None,
    )


def _worst(first: FloatArray, second: FloatArray) -> int:
    """Return where two systems are farthest apart, of the points where both have a value if there are any."""
    import numpy as np

    valued, distance = ~np.isnan(first) & ~np.isnan(second), apart(first, second)
    return int(np.argmax(np.where(valued, distance, -1.0) if valued.any() else distance))


def _refined(
    pair: _Pair, points: FloatArray, at: FloatArray, output: int, seed: int
) -> tuple[FloatArray, float, float]:
    """Look around the worst point for a worse one, in boxes that shrink by half."""
    import numpy as np

    rng = np.random.default_rng(seed)
    low, high = points.min(axis=0), points.max(axis=0)
    size = (high - low) / max(2.0, len(points) ** (1.0 / points.shape[1]))
    for k in range(ROUNDS):
        if pair.progress is not None:
            pair.progress(f"looking for where {pair.results[output]} differs most: {100 * k // ROUNDS} %")
        near = np.clip(at + size * rng.uniform(-1.0, 1.0, (AROUND, points.shape[1])), low, high)
        near[0] = at
        first, second = (values[:, output] for values in pair.values(near))
        best = _worst(first, second)
        at, best_values = near[best], (float(first[best]), float(second[best]))
        size = size / 2.0
    return at, *best_values


def at_points(system: FuzzySystem, points: FloatArray, output: int) -> FloatArray:
    """Return the values of an output at points of shape (n, inputs); NaN for no value."""
    return _batch(compile_system(quiet(system), backend="numpy"), points)[:, output]


def at_point(system: FuzzySystem, point: Sequence[float], output: int) -> float:
    """Return the value of an output at a point; NaN for no value."""
    kernel = compile_system(quiet(system), backend="python")
    state = (kernel.plan.initial_state,) if kernel.n_states else ()
    result = kernel(*point, *state)
    return result if len(system.outputs) == 1 else result[output]


#: Share of the points that are corners of terms and an even grid; the others are random.
EVEN: Final = 0.5


def common_points(a: Block, b: Block, order: Sequence[int], count: int, seed: int) -> FloatArray:
    """Return points of the joint input range of two blocks.

    Args:
        a: The first block, in whose order of inputs the points are.
        b: The second block.
        order: For each input of the first the position of the same input in the second.
        count: How many, about.
        seed: For those at random.

    Returns:
        Shape (n, inputs), n at most `count`; the corners of all terms are among them where there is room.

    Raises:
        ArgumentError: For an input without a finite range.
    """
    import numpy as np

    if not a.inputs:
        return np.empty((1, 0))
    ranges = [_range(a, b, v, b.inputs[order[i]]) for i, v in enumerate(a.inputs)]
    low, high = np.array(ranges).T
    axes = [
        _axis(low[i], high[i], [*_corners(a, v), *_corners(b, b.inputs[order[i]])], _share(count, len(ranges)))
        for i, v in enumerate(a.inputs)
    ]
    rng = np.random.default_rng(seed)
    if math.prod(map(len, axes)) <= count:
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    else:  # even two values of each input are too many points
        grid = np.stack([rng.choice(axis, int(EVEN * count)) for axis in axes], axis=-1)
    random = low + (high - low) * rng.random((max(count - len(grid), 0), len(axes)))
    return np.concatenate([grid, random])


def _share(count: int, inputs: int) -> int:
    return max(2, int((EVEN * count) ** (1.0 / inputs)))


def _axis(low: float, high: float, corners: Sequence[float], room: int) -> FloatArray:
    """Return corners within the range and evenly spread values, as many as there is room for."""
    import numpy as np

    inside = np.unique([low, high, *(c for c in corners if low <= c <= high)])
    if len(inside) >= room:
        chosen: FloatArray = inside[np.linspace(0, len(inside) - 1, room).round().astype(int)]
        return chosen
    return np.unique(np.concatenate([inside, np.linspace(low, high, room - len(inside) + 2)]))


def _range(a: Block, b: Block, v: Any, w: Any) -> tuple[float, float]:
    (low, high), (lower, upper) = a.range_of(v), b.range_of(w)
    low, high = min(low, lower), max(high, upper)
    if not (math.isfinite(low) and math.isfinite(high)):
        raise ArgumentError(f"input '{v.name}' has no finite range to compare over")
    return low, high


def _corners(system: Block, variable: Any) -> list[float]:
    """Return where the formulas of an input's terms change, and their peaks."""
    corners: list[float] = []
    for term in variable.terms:
        formula = MEMBERSHIP.get(term.membership.kind)
        if formula is None:
            continue
        try:
            numbers = tuple(system.number(x) for x in term.membership.arguments)
        except ExprError:
            continue  # a function of the variable has no corners that are known beforehand
        corners += [x for x, _ in formula.vertices(numbers)]
        corners += [*formula.core(numbers), *formula.pieces(numbers)]
    return corners
