"""Limits of an axis that a few peaks do not crush; the cut peaks are listed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

#: Shares of the time below and above which values count as peaks.
QUANTILES = (0.005, 0.995)
#: How many times larger the whole range is than the usual one before peaks are cut off.
CRUSHED = 2.5
#: How many times larger than the median of all lines' ranges one is that does not set the limits.
WILD = 10.0
#: The largest number in single precision.
LARGEST = (2.0 - 2.0**-23) * 2.0**127
#: Lines whose peaks are listed one by one.
MOST_SAID = 3


class Line(NamedTuple):
    """A line as it was recorded: its name, times [s] and values, both of shape (samples,)."""

    name: str
    t: FloatArray
    values: FloatArray


class Limits(NamedTuple):
    """The limits of the axis, those that hold every value, and a note on the cut peaks."""

    shown: tuple[float, float]
    whole: tuple[float, float]
    note: str


def whole(values: FloatArray) -> tuple[float, float]:
    """Return limits around all values that can be drawn, with some room; -1 and 1 without any."""
    seen = _drawn(values)
    return _with_room(float(seen.min()), float(seen.max()), 0.04) if seen.size else (-1.0, 1.0)


def of(lines: Sequence[Line], *, is_log: bool = False) -> Limits:
    """Return the limits of a panel.

    Args:
        lines: The lines of the axis.
        is_log: Whether its axis is logarithmic: then it holds every value, all of them positive.
    """
    every = np.concatenate([line.values for line in lines])
    if is_log:
        seen = _drawn(every)
        ends = (float(seen.min()) / 1.2, float(seen.max()) * 1.2) if seen.size else (0.1, 1.0)
        return Limits(ends, ends, "")
    least, greatest = whole(every)
    usual = [np.quantile(seen, QUANTILES) for line in lines if (seen := _drawn(line.values)).size]
    if not usual:
        return Limits((least, greatest), (least, greatest), "")
    spans = np.array([high - low for low, high in usual])
    typical = float(np.median(spans[spans > 0.0])) if (spans > 0.0).any() else 0.0
    if typical == 0.0:  # a pulse on lines that rest is not a peak
        return Limits((least, greatest), (least, greatest), "")
    tame = [ends for ends, span in zip(usual, spans, strict=True) if span <= WILD * typical] or usual
    low, high = _with_room(float(min(a for a, _ in tame)), float(max(b for _, b in tame)), 0.3)
    low, high = max(low, least), min(high, greatest)
    if greatest - least <= CRUSHED * (high - low):
        return Limits((least, greatest), (least, greatest), "")
    return Limits((low, high), (least, greatest), _said(lines, low, high))


def _drawn(values: FloatArray) -> FloatArray:
    """Return the values that a line on a page shows: finite ones, in single precision."""
    finite: FloatArray = values[np.abs(values) <= LARGEST]
    return finite


def _with_room(low: float, high: float, share: float) -> tuple[float, float]:
    room = share * (high - low) or 0.1 * abs(high) or 1.0
    return low - room, high + room


def _said(lines: Sequence[Line], low: float, high: float) -> str:
    """Return which lines leave the limits: for each its greatest distance from them, when, and for how long."""
    beyond = []
    for line in lines:
        outside = np.fmax(low - line.values, line.values - high)
        if (outside > 0.0).any():
            k = int(np.nanargmax(outside))
            share = 100.0 * float((outside > 0.0).mean())
            text = f"{line.name} {line.values[k]:.3g} at {line.t[k]:.2f} s (beyond for {share:.2g} % of the time)"
            beyond.append((float(outside[k]), text))
    beyond.sort(key=lambda one: -one[0])
    rest = len(beyond) - MOST_SAID
    text = "; ".join(text for _, text in beyond[:MOST_SAID])
    return f"Peaks cut off: {text}{f'; {rest} more lines' if rest > 0 else ''}."
