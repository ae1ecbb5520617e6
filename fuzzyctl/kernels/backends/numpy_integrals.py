"""Adaptive quadrature over arrays of points: all stretches of a level at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields
from functools import partial
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from fuzzyctl.kernels.backends import blocks
from fuzzyctl.kernels.program import quadrature
from fuzzyctl.records import record

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]
BoolArray = npt.NDArray[np.bool_]
#: From places of shape (stretches, nodes) and what else it depends on, of shape (stretches, 1), to degrees.
ArrayFunction = Callable[[FloatArray, tuple[FloatArray, ...]], Any]
#: The same to the values of `program.Crossings`.
CrossingFunction = Callable[[FloatArray, tuple[FloatArray, ...]], tuple[Any, ...]]

#: Points that are integrated at a time, at most.
PART: Final = 256
#: Numbers of a stretch at the same time, besides the arguments of its set.
_OF_STRETCH: Final = 10
#: Arrays of the degrees at all nodes of some stretches, besides those that the set itself needs.
_OF_NODES: Final = 4


@record(frozen=True)
class SetFunction:
    """A set that is integrated.

    Args:
        degrees: At places.
        arrays: How many arrays of the shape of the places it needs at the same time.
    """

    degrees: ArrayFunction
    arrays: int

    def __call__(self, x: FloatArray, given: tuple[FloatArray, ...]) -> Any:
        """Return the degrees at places of shape (stretches, nodes)."""
        return self.degrees(x, given)


_POSITIVE: Final = np.array(quadrature.NODES)
_NODES: Final = np.concatenate((-_POSITIVE, [0.0], _POSITIVE[::-1]))
#: Nodes and both ends.
_PLACES: Final = np.concatenate((_NODES, [-quadrature.END, quadrature.END]))
_KRONROD: Final = np.array((*quadrature.KRONROD, quadrature.KRONROD_MIDDLE, *quadrature.KRONROD[::-1]))
_GAUSS: Final = np.array((*quadrature.GAUSS, quadrature.GAUSS_MIDDLE, *quadrature.GAUSS[::-1]))
_EVEN, _ODD = np.array(quadrature.EVEN), np.array(quadrature.ODD)
#: The polynomial through the nodes, at the left and the right end.
_LEFT: Final = np.concatenate((_EVEN + _ODD, [quadrature.EVEN_MIDDLE], (_EVEN - _ODD)[::-1]))
_RIGHT: Final = np.concatenate((_EVEN - _ODD, [quadrature.EVEN_MIDDLE], (_EVEN + _ODD)[::-1]))


def marked(places: FloatArray, marks: tuple[FloatArray | float, ...]) -> FloatArray:
    """Return places that rise, of shape (places,), and marks among them, of shape (..., places)."""
    if not marks:
        return places
    shape = np.broadcast_shapes(*(np.shape(m) for m in marks))
    rows = [np.broadcast_to(m, shape)[..., None] for m in marks]
    return np.sort(np.concatenate((np.broadcast_to(places, (*shape, len(places))), *rows), axis=-1), axis=-1)


def moments(
    function: ArrayFunction, places: FloatArray, given: tuple[FloatArray | float, ...]
) -> tuple[FloatArray, FloatArray]:
    """Return first moments and areas; see `quadrature.moments`."""
    return _in_parts(_moments, function, places, given)


def half(
    function: ArrayFunction, places: FloatArray, given: tuple[FloatArray | float, ...]
) -> tuple[FloatArray, FloatArray]:
    """Return where areas are half, and the areas; see `quadrature.half`."""
    return _in_parts(_half, function, places, given)


def jumps(
    function: ArrayFunction, crossing: CrossingFunction, places: FloatArray, given: tuple[FloatArray | float, ...]
) -> tuple[FloatArray, FloatArray]:
    """Return the parts of jumps in the derivatives of first moments and areas; see `quadrature.jumps`."""
    return _in_parts(partial(_jumps, crossing), function, places, given)


def _in_parts(
    integrate: Callable[[ArrayFunction, FloatArray, FloatArray], tuple[FloatArray, FloatArray]],
    function: ArrayFunction,
    places: FloatArray,
    given: tuple[FloatArray | float, ...],
) -> tuple[FloatArray, FloatArray]:
    """Integrate some points at a time."""
    shape, flat, ends = _flat(given, places)
    first, area = np.empty(flat.shape[1]), np.empty(flat.shape[1])
    size = _part(ends, flat)
    for start in range(0, flat.shape[1], size):
        part = slice(start, start + size)
        first[part], area[part] = integrate(function, ends[part], flat[:, part])
    return first.reshape(shape), area.reshape(shape)


def _memory() -> int:
    """Return how many numbers stretches may be at a time, and as many the nodes of some of them: two fifths each."""
    return blocks.COMPUTED * 2 // (5 * 8)


def _part(ends: FloatArray, given: FloatArray) -> int:
    """Return how many points are taken at a time: as many as their stretches have room."""
    numbers = (_OF_STRETCH + len(given)) * int(ends.shape[1] - 1)
    return max(min(PART, _memory() // max(numbers, 1)), 1)


def _flat(given: tuple[FloatArray | float, ...], places: FloatArray) -> tuple[tuple[int, ...], FloatArray, FloatArray]:
    """Return the common shape of some arrays and of rows of places, and them with one axis of points."""
    shape = np.broadcast_shapes(*(np.shape(g) for g in given), places.shape[:-1])
    count = int(np.prod(shape))
    flat = np.array([np.broadcast_to(g, shape).reshape(count) for g in given]).reshape(len(given), count)
    return shape, flat, np.broadcast_to(places, (*shape, places.shape[-1])).reshape(count, places.shape[-1])


@record(frozen=True)
class _Stretches:
    """Stretches that are halved no more, of several points.

    Args:
        point: The point of each.
        left: Where it begins.
        right: Where it ends.
        area: Its area.
        about: Its moment about its center.
    """

    point: IntArray
    left: FloatArray
    right: FloatArray
    area: FloatArray
    about: FloatArray

    def taken(self, which: BoolArray | IntArray) -> _Stretches:
        """Return some of them, in the order given."""
        return _Stretches(*(getattr(self, f.name)[which] for f in fields(self)))

    @classmethod
    def joined(cls, parts: Sequence[_Stretches]) -> _Stretches:
        """Return all stretches of some parts."""
        return cls(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(cls)))


def _levels(
    function: ArrayFunction, places: FloatArray, given: FloatArray, crossing: CrossingFunction | None = None
) -> Iterator[_Stretches]:
    """Yield the stretches that are halved no more, those of a length at once; with crossings those of `jumps`."""
    count = given.shape[1]
    index = np.repeat(np.arange(count), places.shape[1] - 1)
    left, right = places[:, :-1].reshape(-1), places[:, 1:].reshape(-1)
    left_over, left_over_of_jumps = np.full(count, quadrature.MOST), np.full(count, quadrature.MOST)
    rough = np.empty(0)
    rounded = quadrature.ROUNDED * np.maximum(abs(places[:, 0]), abs(places[:, -1]))
    for level in range(quadrature.DEEPEST + 1):
        center = 0.5 * left + 0.5 * right
        value, about, error = _stretches(function, given[:, index], center, 0.5 * (right - left))
        if level == 0:
            rough = np.asarray(np.bincount(index, np.abs(value), count), dtype=np.float64)
        moves = (
            np.zeros(len(index), bool) if crossing is None else _speeds(crossing, left, right, given[:, index]) != 0.0
        )
        left_over -= np.bincount(index[~moves], minlength=count)
        left_over_of_jumps -= np.bincount(index[moves], minlength=count)
        open_ = (error > quadrature.OF_ALL * rough[index]) & (error > quadrature.OF_OWN * np.abs(value))
        open_ &= error * (right - left) > rounded[index] * np.abs(value)
        open_ = np.where(moves, left_over_of_jumps[index] > 0, open_ & (left_over[index] > 0))
        open_ &= (left < center) & (center < right) & (level < quadrature.DEEPEST)
        yield _Stretches(index, left, right, value, about).taken(~open_)
        if not open_.any():
            break
        index = np.repeat(index[open_], 2)
        ends = np.stack((left[open_], center[open_], right[open_]), axis=1)
        left, right = ends[:, :2].reshape(-1), ends[:, 1:].reshape(-1)


def _moments(function: ArrayFunction, places: FloatArray, given: FloatArray) -> tuple[FloatArray, FloatArray]:
    count = given.shape[1]
    moment, area = np.zeros(count), np.zeros(count)
    for level in _levels(function, places, given):
        area += np.bincount(level.point, level.area, count)
        center = 0.5 * level.left + 0.5 * level.right
        moment += np.bincount(level.point, level.area * center + level.about, count)
    return moment, area


def _jumps(
    crossing: CrossingFunction, function: ArrayFunction, places: FloatArray, given: FloatArray
) -> tuple[FloatArray, FloatArray]:
    count = given.shape[1]
    moment, area = np.zeros(count), np.zeros(count)
    for level in _levels(function, places, given, crossing):
        depends = given[:, level.point]
        moved = _speeds(crossing, level.left, level.right, depends)
        height = _degrees(function, level.left, depends) - _degrees(function, level.right, depends)
        share = np.where(np.isfinite(moved), moved, 0.0) * height
        area += np.bincount(level.point, share, count)
        moment += np.bincount(level.point, share * (0.5 * level.left + 0.5 * level.right), count)
    return moment, area


def _speeds(crossing: CrossingFunction, left: FloatArray, right: FloatArray, given: FloatArray) -> FloatArray:
    """Return how fast jumps between the ends of some stretches move; see `quadrature.speed`."""
    depends = tuple(given)
    here, there = (np.array([np.broadcast_to(v, x.shape) for v in crossing(x, depends)]) for x in (left, right))
    speeds = np.zeros(left.shape)
    for k in reversed(range(0, len(here), 4)):
        (one, a, *slopes), (other, b, *others) = here[k : k + 4], there[k : k + 4]
        by_place, by_argument = np.where(slopes[0] == 0.0, others, slopes)
        is_unknown = (np.abs(a - b) >= quadrature.CONTINUOUS) | (by_place == 0.0)
        speeds = np.where(one == other, speeds, np.where(is_unknown, np.inf, -by_argument / by_place))
    return speeds


def _degrees(function: ArrayFunction, x: FloatArray, given: FloatArray) -> FloatArray:
    """Return the degrees at one place of each stretch."""
    degrees = np.broadcast_to(function(x[:, None], tuple(g[:, None] for g in given)), (len(x), 1))
    return degrees[:, 0]


def _half(function: ArrayFunction, places: FloatArray, given: FloatArray) -> tuple[FloatArray, FloatArray]:
    all_of_them = _Stretches.joined(list(_levels(function, places, given)))
    row = _Row(all_of_them.taken(np.lexsort((all_of_them.left, all_of_them.point))), given.shape[1])
    wanted = 0.5 * row.whole
    before, at = row.reached((1.0 - quadrature.SLACK) * wanted)
    _, beyond = row.reached((1.0 + quadrature.SLACK) * wanted)
    gap = beyond.left > at.right
    place = 0.5 * at.right + 0.5 * beyond.left
    inside = np.flatnonzero(~gap)
    place[inside] = _within(function, given[:, inside], at.taken(inside), (wanted - before)[inside])
    return place, row.whole


class _Row:
    """The stretches of each point in a row from the left, and the areas up to their ends.

    Args:
        stretches: All stretches, by point and place.
        count: How many points there are; each has a stretch.
    """

    def __init__(self, stretches: _Stretches, count: int) -> None:
        self.stretches = stretches
        self.first = np.searchsorted(stretches.point, np.arange(count))
        nth = np.arange(len(stretches.point)) - self.first[stretches.point]
        areas = np.zeros((count, int(nth.max(initial=0)) + 1))
        areas[stretches.point, nth] = stretches.area
        self.up_to = np.cumsum(areas, axis=1)
        self.whole: FloatArray = self.up_to[:, -1].copy()

    def reached(self, bound: FloatArray) -> tuple[FloatArray, _Stretches]:
        """Return the areas before the stretches within which areas come to bounds, and these; see `quadrature.summed`.

        Where the area never does, the stretch is the end of the last one.
        """
        count = len(bound)
        is_over = self.up_to >= bound[:, None]
        nth, never = np.argmax(is_over, axis=1), ~is_over.any(axis=1)
        before = np.where(nth > 0, self.up_to[np.arange(count), nth - 1], 0.0)
        area = self.stretches.taken(self.first + nth)
        if never.any():
            last = np.append(self.first[1:], len(self.stretches.point)) - 1
            end = self.stretches.right[last]
            left, right = (np.where(never, end, side) for side in (area.left, area.right))
            area = _Stretches(area.point, left, right, np.where(never, 0.0, area.area), area.about)
        return np.where(never, self.whole, before), area


def _within(function: ArrayFunction, given: FloatArray, at: _Stretches, wanted: FloatArray) -> FloatArray:
    """Return up to where stretches have some area; see `quadrature.within`."""
    nothing = (wanted <= 0.0) | (at.area <= 0.0)
    places = np.where(nothing, at.left, at.right)
    open_ = np.flatnonzero(~nothing & ~(wanted >= at.area))
    low, high = at.left.copy(), at.right.copy()
    places[open_] = (at.left + (at.right - at.left) * (wanted / at.area))[open_]
    for _ in range(quadrature.STEPS):
        if not len(open_):
            break
        own, place, left = given[:, open_], places[open_], at.left[open_]
        area, _, _ = _stretches(function, own, 0.5 * left + 0.5 * place, 0.5 * (place - left))
        beyond = area - wanted[open_]
        over = beyond > 0.0
        high[open_[over]], low[open_[~over]] = place[over], place[~over]
        degree = _degrees(function, place, own)
        following = np.where(degree > 0.0, place - beyond / degree, high[open_])
        is_inside = (low[open_] < following) & (following < high[open_])
        following = np.where(is_inside, following, 0.5 * low[open_] + 0.5 * high[open_])
        near = np.abs(following - place) <= quadrature.NEAR * (at.right - at.left)[open_]
        places[open_] = following
        open_ = open_[~near]
    return places


def _stretches(
    function: ArrayFunction, given: FloatArray, center: FloatArray, width: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return areas, moments about the centers, and errors of some stretches; `width` is half of theirs."""
    arrays = function.arrays if isinstance(function, SetFunction) else 0
    size = max(_memory() // (len(_PLACES) * (_OF_NODES + arrays)), 1)
    if len(center) <= size:
        return _some_stretches(function, given, center, width)
    sums = np.empty((3, len(center)))
    for start in range(0, len(center), size):
        part = slice(start, start + size)
        sums[:, part] = _some_stretches(function, given[:, part], center[part], width[part])
    return sums[0], sums[1], sums[2]


def _some_stretches(
    function: ArrayFunction, given: FloatArray, center: FloatArray, width: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Do the same for few at a time."""
    x = center[:, None] + width[:, None] * _PLACES
    degrees = np.broadcast_to(function(x, tuple(g[:, None] for g in given)), x.shape)
    values, (left, right) = degrees[:, :-2], degrees[:, -2:].T
    area, other = values @ _KRONROD, values @ _GAUSS
    moment, other_moment = values @ (_KRONROD * _NODES), values @ (_GAUSS * _NODES)
    ends = np.abs(left - values @ _LEFT) + np.abs(right - values @ _RIGHT)
    error = np.abs(area - other) + np.abs(moment - other_moment) + quadrature.BEYOND * ends
    return width * area, width * width * moment, width * error
