"""The integrals of `quadrature` for arrays of points: all stretches of a level at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from fuzzyctl.kernels import quadrature

FloatArray = npt.NDArray[np.float64]
#: From places of shape (stretches, nodes) and what else it depends on, of shape (stretches, 1), to degrees.
ArrayFunction = Callable[[FloatArray, tuple[FloatArray, ...]], Any]

#: Points that are integrated at a time: their stretches and nodes take about a megabyte.
PART: Final = 256

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
    own = [np.broadcast_to(m, shape)[..., None] for m in marks]
    return np.sort(np.concatenate((np.broadcast_to(places, (*shape, len(places))), *own), axis=-1), axis=-1)


def moments(
    function: ArrayFunction, places: FloatArray, given: tuple[FloatArray | float, ...]
) -> tuple[FloatArray, FloatArray]:
    """Return first moments and areas; see `quadrature.moments`."""
    shape, flat, ends = _flat(given, places)
    moment, area = np.empty(flat.shape[1]), np.empty(flat.shape[1])
    for start in range(0, flat.shape[1], PART):
        part = slice(start, start + PART)
        moment[part], area[part] = _moments(function, ends[part], flat[:, part])
    return moment.reshape(shape), area.reshape(shape)


def half(
    function: quadrature.SetFunction, places: FloatArray, given: tuple[FloatArray | float, ...]
) -> tuple[FloatArray, FloatArray]:
    """Return where areas are half, and the areas, point by point; see `quadrature.half`."""
    shape, flat, ends = _flat(given, places)
    found = [quadrature.half(function, e, tuple(g)) for g, e in zip(flat.T.tolist(), ends.tolist(), strict=True)]
    both = np.array(found, dtype=np.float64).reshape(-1, 2)
    return both[:, 0].reshape(shape), both[:, 1].reshape(shape)


def _flat(given: tuple[FloatArray | float, ...], places: FloatArray) -> tuple[tuple[int, ...], FloatArray, FloatArray]:
    """Return the common shape of some arrays and of rows of places, and them with one axis of points."""
    shape = np.broadcast_shapes(*(np.shape(g) for g in given), places.shape[:-1])
    count = int(np.prod(shape))
    flat = np.array([np.broadcast_to(g, shape).reshape(count) for g in given]).reshape(len(given), count)
    return shape, flat, np.broadcast_to(places, (*shape, places.shape[-1])).reshape(count, places.shape[-1])


def _moments(function: ArrayFunction, places: FloatArray, given: FloatArray) -> tuple[FloatArray, FloatArray]:
    count = given.shape[1]
    index = np.repeat(np.arange(count), places.shape[1] - 1)
    left, right = places[:, :-1].reshape(-1), places[:, 1:].reshape(-1)
    moment, area, left_over = np.zeros(count), np.zeros(count), np.full(count, quadrature.MOST)
    rough = np.empty(0)
    for level in range(quadrature.DEEPEST + 1):
        center = 0.5 * left + 0.5 * right
        own, about, error = _stretches(function, given[:, index], center, 0.5 * (right - left))
        if level == 0:
            rough = np.asarray(np.bincount(index, own, count), dtype=np.float64)
        left_over -= np.bincount(index, minlength=count)
        open_ = (error > quadrature.OF_ALL * rough[index]) & (error > quadrature.OF_OWN * own)
        open_ &= (left < center) & (center < right) & (left_over[index] > 0) & (level < quadrature.DEEPEST)
        done = ~open_
        area += np.bincount(index[done], own[done], count)
        moment += np.bincount(index[done], (own * center + about)[done], count)
        if not open_.any():
            break
        index = np.repeat(index[open_], 2)
        ends = np.stack((left[open_], center[open_], right[open_]), axis=1)
        left, right = ends[:, :2].reshape(-1), ends[:, 1:].reshape(-1)
    return moment, area


def _stretches(
    function: ArrayFunction, given: FloatArray, center: FloatArray, width: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return areas, moments about the centers, and errors of some stretches; `width` is half of theirs."""
    x = center[:, None] + width[:, None] * _PLACES
    found = np.broadcast_to(function(x, tuple(g[:, None] for g in given)), x.shape)
    values, (left, right) = found[:, :-2], found[:, -2:].T
    area, other = values @ _KRONROD, values @ _GAUSS
    moment, other_moment = values @ (_KRONROD * _NODES), values @ (_GAUSS * _NODES)
    ends = np.abs(left - values @ _LEFT) + np.abs(right - values @ _RIGHT)
    error = np.abs(area - other) + np.abs(moment - other_moment) + quadrature.BEYOND * ends
    return width * area, width * width * moment, width * error
