"""Frames, angles and distances in the plane."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from dwmr.core.jit import compiled


@compiled
def wrap(angle: float) -> float:
    """Bring an angle into (−π, π] [rad]."""
    return angle - 2.0 * math.pi * math.ceil((angle - math.pi) / (2.0 * math.pi))


def wrap_array(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bring angles of any shape into (−π, π], as `wrap` does for one [rad]."""
    wrapped: NDArray[np.float64] = angles - 2.0 * math.pi * np.ceil((angles - math.pi) / (2.0 * math.pi))
    return wrapped


@compiled
def to_body(x: float, y: float, theta: float) -> tuple[float, float]:
    """Turn a vector of the inertial frame into the frame of a body with orientation theta.

    Args:
        x, y: Components in the inertial frame [m].
        theta: Orientation of the body [rad].

    Returns:
        Components along and across the body [m].

    Source:
        Goto, Bertol, Martins, Eq. (4), first two rows.
    """
    c, s = math.cos(theta), math.sin(theta)
    return c * x + s * y, -s * x + c * y


@compiled
def clamp(value: float, limit: float) -> float:
    """Keep a value inside [−limit, limit], in the value's own unit."""
    return max(-limit, min(limit, value))


@compiled
def sign(value: float) -> float:
    """Return −1, 0 or 1; sign(0) = 0, so that the switching control of Eq. (11) rests on the surface."""
    if value > 0.0:
        return 1.0
    if value < 0.0:
        return -1.0
    return 0.0
