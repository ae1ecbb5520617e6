"""Pattern search for a point where no rule fires, where cells and boxes leave coverage open.

From points where the rules fire least it goes along one input after the other to where they fire less, by steps that
grow while that helps and shrink where it does not. What it finds is evaluated; that it finds nothing says nothing.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from itertools import islice
from typing import Final

from fuzzyctl.analysis import sampling
from fuzzyctl.analysis.coverage.fires import Silence
from fuzzyctl.analysis.work import SpentError
from fuzzyctl.kernels.plan.build import Plan

#: Points to go from: those of a grid where the rules fire least, and as many random ones.
STARTS: Final = 8
#: Random points among which those that count are looked for.
TRIES: Final = 500
#: Steps below this part of the range are not taken.
SHORTEST: Final = 1e-12

Point = Sequence[float]


def silent_point(flat: Plan, silence: Silence, inside: Callable[[Point], bool] | None = None) -> list[float] | None:
    """Return a point where no rule moves an output, with few digits; None where none is found.

    Args:
        flat: The system.
        silence: Of the output; it says how much may be computed, too.
        inside: Tells the points that count, all if it is None.
    """
    if len(flat.rules) > sampling.RULES:
        return None
    search = _Search(flat, silence, inside or (lambda _: True))
    try:
        found = search.found()
    except SpentError:
        return None
    try:
        return None if found is None else search.shortened(found, silence.holds_at)
    except SpentError:
        return found


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
