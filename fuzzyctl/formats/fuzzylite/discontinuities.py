"""Discontinuities of fuzzylite's terms, where its degree at a jump is not the larger one of the model.

At a jump of a Discrete term fuzzylite takes the degree of the first point there, behind the last point of all that of
the last one; pyfuzzylite always takes that of the last point. A PiShape whose left side has no width is 0 at its foot.
Measured with fuzzylite 6.0 and pyfuzzylite 8.0.6.

A jump of the model at the number next to that of the file has these degrees at every number.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby

Values = Sequence[float]


@dataclass(frozen=True)
class Corner:
    """Where a polygon has one point or, at a jump, several.

    Args:
        place: The place.
        first: The degree of the first point, to which the polygon tends from the left.
        last: The degree of the last point, to which it tends from the right.
        top: The largest degree, which holds there in the model.
        held: The degree that holds there in the file's tool.
    """

    place: float
    first: float
    last: float
    top: float
    held: float

    @property
    def points(self) -> tuple[float, ...]:
        """The points of the corner, none of them between the ends of the jump."""
        return self.jump_at(self.place) if self.first != self.last else (self.place, self.first)

    def jump_at(self, place: float) -> tuple[float, ...]:
        """Return the points of the jump at a place."""
        return place, self.first, place, self.last


def corners(points: Values, *, python: bool) -> list[Corner]:
    """Return the corners of a polygon.

    Args:
        points: x1, y1, x2, y2, ..., where no x is below the one before.
        python: Whether the file's tool is pyfuzzylite.
    """
    pairs = zip(points[::2], points[1::2], strict=True)
    groups = [(x, [y for _, y in there]) for x, there in groupby(pairs, lambda point: point[0])]
    found = []
    for k, (x, degrees) in enumerate(groups):
        is_end = k == len(groups) - 1 and k > 0
        held = degrees[-1] if python or is_end else degrees[0]
        found.append(Corner(x, degrees[0], degrees[-1], max(degrees), held))
    return found


def polygon_as_computed(points: Values, *, python: bool = False) -> tuple[float, ...]:
    """Return the points of the polygon of the model that has the degrees which the file's tool computes."""
    found: list[float] = []
    for c in corners(points, python=python):
        if c.held == max(c.first, c.last):
            found += c.points
        else:  # the jump is behind a place that has the lower degree of the left side, or before one of the right side
            found += c.jump_at(math.nextafter(c.place, math.inf if c.held == c.first else -math.inf))
    if len(found) == 2:
        found += [_further(found[0]), found[1]]
    return tuple(found)


def polygon_as_written(points: Values, *, python: bool = False) -> tuple[float, ...]:
    """Return the points for which the file's tool computes the degrees of the model."""
    found: list[float] = []
    for c in corners(points, python=python):
        before, behind = (math.nextafter(c.place, end) for end in (-math.inf, math.inf))
        if c.top > max(c.first, c.last):  # a degree of one place
            found += (before, c.first, c.place, c.top, behind, c.last)
        elif c.held == c.top:
            found += c.points
        else:
            found += c.jump_at(before if c.held == c.first else behind)
    if len(found) == 2:
        found += [_further(found[0]), found[1]]
    return tuple(found)


def _further(place: float) -> float:
    return place + max(1.0, abs(place))


def has_step(kind: str, parameters: Values) -> bool:
    """Whether a term is a PiShape whose left side has no width."""
    return kind == "pi_shape" and parameters[0] == parameters[1] and math.isfinite(parameters[0])


def as_written(kind: str, parameters: Values, *, python: bool = False) -> Values:
    """Return the parameters for which fuzzylite computes the degrees of the model.

    Args:
        kind: The kind of the term.
        parameters: Its parameters.
        python: Whether the file is for pyfuzzylite.
    """
    if kind == "piecewise":
        return polygon_as_written(parameters, python=python)
    if has_step(kind, parameters):
        before = math.nextafter(parameters[0], -math.inf)
        return (before, before, *parameters[2:])
    return parameters


def tools_differ(points: Values) -> Iterable[tuple[Corner, Corner]]:
    """Yield corners at which fuzzylite and pyfuzzylite take another degree: the first one's and the second one's."""
    both = zip(corners(points, python=False), corners(points, python=True), strict=True)
    return ((own, other) for own, other in both if own.held != other.held)
