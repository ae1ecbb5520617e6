"""Measures of a run in numpy: numbers from recorded signals."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

#: Part of the window at its end over which the steady-state error is a mean.
STEADY: Final = 0.05
#: Samples this part of a step beside the ends of a window belong to it.
BESIDE: Final = 1e-6


@dataclass(frozen=True)
class Window:
    """The samples of a run that count.

    Args:
        t: Their times, shape (n,) [s].
        signals: Operands of the measure, each of shape (n,).
        settings: Its settings.
    """

    t: FloatArray
    signals: tuple[FloatArray, ...]
    settings: Mapping[str, float]

    @property
    def y(self) -> FloatArray:
        """The first signal."""
        return self.signals[0]

    @property
    def error(self) -> FloatArray:
        """The reference less the first signal."""
        return self.signals[1] - self.signals[0]

    @property
    def jump(self) -> float:
        """How far the last value of the reference is from the first value of the signal; NaN for nothing."""
        jump = float(self.signals[1][-1] - self.y[0])
        return jump if jump else math.nan

    @property
    def progress(self) -> FloatArray:
        """The signal on a scale from its first value, 0, to the last value of the reference, 1."""
        progress: FloatArray = (self.y - self.y[0]) / self.jump
        return progress

    def integral(self, values: FloatArray) -> float:
        """Return the integral over time by the trapezoidal rule."""
        return float(np.dot(values[1:] + values[:-1], np.diff(self.t))) / 2.0

    @property
    def length(self) -> float:
        """How long it lasts [s]."""
        return float(self.t[-1] - self.t[0])


def measured(name: str, t: FloatArray, signals: tuple[FloatArray, ...], settings: Mapping[str, float]) -> float:
    """Compute a measure.

    Args:
        name: One of `model.loop.MEASURES`.
        t: Times of the samples, shape (n,) [s].
        signals: Its operands, each of shape (n,).
        settings: Its settings, `begin` and `end` among them.

    Returns:
        Its value; NaN where there are fewer than two samples, or no step that it could be a part of.
    """
    begin, end = settings["begin"], settings["end"]
    if len(t) == 0:
        return math.nan
    if begin > t[0] or end < t[-1]:
        beside = BESIDE * float(t[1] - t[0]) if len(t) > 1 else 0.0
        first, last = np.searchsorted(t, [begin - beside, end + beside])
        t, signals = t[first:last], tuple(s[first:last] for s in signals)
    if len(t) < 2:
        return math.nan
    return _MEASURES[name](Window(t, signals, settings))


def between(t: FloatArray, begin: float, end: float) -> npt.NDArray[np.bool_]:
    """Return which samples lie from a time to another one, a hair beside them included, shape (n,)."""
    beside = BESIDE * float(t[1] - t[0]) if len(t) > 1 else 0.0
    mask: npt.NDArray[np.bool_] = (t >= begin - beside) & (t <= end + beside)
    return mask


def overshoot(w: Window) -> float:
    """Return how far the signal goes beyond the last value of the reference, as a part of the step to it."""
    return max(float(np.max(w.progress)) - 1.0, 0.0) if w.jump == w.jump else math.nan


def rise_time(w: Window) -> float:
    """Return the time between the first samples at two parts of the step, on straight lines between samples."""
    if w.jump != w.jump:
        return math.nan
    low, high = (_reached(w, w.settings[n]) for n in ("low", "high"))
    return high - low if math.isfinite(high) else math.inf


def _reached(w: Window, level: float) -> float:
    """Return when a part of the step is reached first; inf for never."""
    above = w.progress >= level
    k = int(np.argmax(above))
    if not above[k]:
        return math.inf
    return float(w.t[0]) if k == 0 else _crossing(w.t, w.progress, k, level)


def _crossing(t: FloatArray, values: FloatArray, k: int, level: float) -> float:
    """Return when a signal crosses a level between the samples k - 1 and k."""
    before, after = float(values[k - 1]), float(values[k])
    return float(t[k - 1] + (t[k] - t[k - 1]) * ((level - before) / (after - before)))


def settling(w: Window) -> float:
    """Return the time from the first sample until the signal stays within a band around the end of the reference."""
    if w.jump != w.jump:
        return math.nan
    distance = np.abs(w.progress - 1.0)
    outside = np.flatnonzero(~(distance <= w.settings["band"]))
    if len(outside) == 0:
        return 0.0
    k = int(outside[-1]) + 1
    if k == len(distance):
        return math.inf
    side = 1.0 + math.copysign(w.settings["band"], float(w.progress[k - 1]) - 1.0)
    return _crossing(w.t, w.progress, k, side) - float(w.t[0])


def steady_state_error(w: Window) -> float:
    """Return the mean error over the end of the window."""
    last = w.t >= w.t[-1] - STEADY * w.length * (1.0 + BESIDE)
    return float(np.mean(w.error[last]))


_MEASURES: Final[Mapping[str, Callable[[Window], float]]] = {
    "overshoot": overshoot,
    "rise_time": rise_time,
    "settling": settling,
    "steady_state_error": steady_state_error,
    "iae": lambda w: w.integral(np.abs(w.error)),
    "ise": lambda w: w.integral(w.error**2),
    "itae": lambda w: w.integral((w.t - w.t[0]) * np.abs(w.error)),
    "integral": lambda w: w.integral(w.y),
    "effort": lambda w: w.integral(w.y**2),
    "maximum": lambda w: float(np.max(w.y)),
    "minimum": lambda w: float(np.min(w.y)),
    "final": lambda w: float(w.y[-1]),
    "mean": lambda w: w.integral(w.y) / w.length,
    "rms": lambda w: math.sqrt(w.integral(w.y**2) / w.length),
}
