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


def ahead(x: float, y: float, theta: float, d: float) -> tuple[float, float]:
    """Return the point at a distance d ahead of a posture, behind it where d is negative [m]."""
    return x + d * math.cos(theta), y + d * math.sin(theta)


def quaternion(theta: float) -> tuple[float, float, float, float]:
    """Return the unit quaternion (x, y, z, w) of a turn about the vertical axis [rad]."""
    return 0.0, 0.0, math.sin(0.5 * theta), math.cos(0.5 * theta)


def yaw(x: float, y: float, z: float, w: float) -> float:
    """Return the turn about the vertical axis of a unit quaternion, in [−π, π] [rad]: the last of roll, pitch, yaw."""
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


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
