"""Sample points of a comparison: corners of terms, an even grid, and random points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.expr import ExprError
from fuzzyctl.formulas import MEMBERSHIP
from fuzzyctl.model.block import Block

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

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
