"""Places of obstacles over time."""

from __future__ import annotations

import math

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.scenario.model import Obstacle, Scenario


def is_moving(scenario: Scenario) -> bool:
    """Return whether some obstacle moves."""
    return any(one.velocity is not None or one.path is not None for one in scenario.obstacles)


def centres(scenario: Scenario, t: FloatArray) -> FloatArray:
    """Return the centres of the obstacles, shape (samples, obstacles, 2) [m].

    Args:
        scenario: A scenario.
        t: Times from 0 on, shape (samples,) [s].
    """
    result = np.empty((len(t), len(scenario.obstacles), 2))
    for a, one in enumerate(scenario.obstacles):
        v_x, v_y = one.velocity or (0.0, 0.0)
        result[:, a, 0], result[:, a, 1] = one.x + v_x * t, one.y + v_y * t
        if one.path is not None:
            times, x, y = _corners(one)
            result[:, a, 0], result[:, a, 1] = np.interp(t, times, x), np.interp(t, times, y)
    return result


def largest_speed(obstacle: Obstacle) -> float:
    """Return the largest speed of an obstacle [m/s]."""
    if obstacle.velocity is not None:
        return math.hypot(*obstacle.velocity)
    times, x, y = _corners(obstacle)
    return float(np.max(np.hypot(np.diff(x), np.diff(y)) / np.diff(times), initial=0.0))


def _corners(obstacle: Obstacle) -> FloatArray:
    """Return times and places between which an obstacle moves in straight lines, shape (3, n) [s, m, m]."""
    return np.array([(0.0, obstacle.x, obstacle.y), *(obstacle.path or ())]).T
