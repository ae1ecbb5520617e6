"""Velocity commands within what a robot takes."""

from __future__ import annotations

import math

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.scenario.model import Robot
from dwmr.scenario.vehicles import Ackermann


def limited(asked: FloatArray, robot: Robot) -> FloatArray:
    """Return velocity commands within the limits of a robot.

    A car gets the curvature that is asked for, or that of its steering at the stop, whatever its velocity is cut to; at
    rest it does not turn.

    Args:
        asked: Velocities ahead, to the left, and turning, shape (..., 3) [m/s, m/s, rad/s].
        robot: Its settings.

    Returns:
        Same shape.
    """
    v, omega = robot.actuator.v_limit, robot.actuator.omega_limit
    result: FloatArray = np.clip(asked, (-v, -v, -omega), (v, v, omega))
    if isinstance(robot.vehicle, Ackermann):
        ahead, bend = asked[..., 0], math.tan(robot.vehicle.steering_limit) / robot.vehicle.wheelbase
        with np.errstate(over="ignore"):  # of a car that nearly stands
            curvature = np.divide(asked[..., 2], ahead, out=np.zeros_like(ahead), where=ahead != 0.0)
        curvature = np.clip(curvature, -bend, bend)
        slower = np.minimum(v, omega / np.maximum(np.abs(curvature), omega / v))
        result[..., 0] = np.clip(ahead, -slower, slower)
        result[..., 2] = curvature * result[..., 0]
    return result
