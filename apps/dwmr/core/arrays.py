"""Arrays and tuples of numbers that compiled code shares with the code that prepares it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Reference(NamedTuple):
    """Posture and velocities of the reference of a robot.

    Attributes:
        x, y: Position [m].
        theta: Orientation [rad].
        v: Linear velocity [m/s].
        omega: Angular velocity [rad/s].
    """

    x: float
    y: float
    theta: float
    v: float
    omega: float


class Safety(NamedTuple):
    """Parameters of the filter for n robots and a obstacles, which come behind them.

    Attributes:
        alpha: Rate α at which the barrier may decline [1/s].
        lookahead: Distance of the guarded point ahead of the axle [m].
        acceleration: Rate at which the filter lets laws change their commands [m/s²].
        angular_acceleration: The same for turning [rad/s²].
        least: R, least distance of a robot's guarded point from the other centres at samples, shape (n, n + a) [m].
        kept: The same of measured distances: R and the largest effect of noise, shape (n, n + a) [m].
        noise: How far points are from where they are measured at most, shape (n + a,) [m].
        speeds: Bounds of the speeds of guarded points and obstacles, shape (n + a,) [m/s].
        errors: Bounds of the difference between a guarded point's mean velocity in a period and the command at its
            start, shape (n,) [m/s].
        keep_right: Speed to the right of what is in the way, relative to the closing speed that a barrier takes [-].
    """

    alpha: float
    lookahead: float
    acceleration: float
    angular_acceleration: float
    least: FloatArray
    kept: FloatArray
    noise: FloatArray
    speeds: FloatArray
    errors: FloatArray
    keep_right: float = 1.0
