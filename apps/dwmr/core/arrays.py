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
    """Parameters of the filter for n robots, each with the same number of discs, and a obstacles.

    Discs are counted robot by robot, p in all; obstacles come behind them.

    Attributes:
        alpha: Rate α at which the barrier may decline [1/s].
        lookahead: Length l that turns an angular velocity into a velocity; of one disc the distance of its centre ahead
            of the axle [m].
        acceleration: Rate at which the filter lets laws change their commands [m/s²].
        angular_acceleration: The same for turning [rad/s²].
        least: R, least distance of a disc's centre from the other centres at samples, shape (p, p + a) [m].
        kept: The same of measured distances: R and the largest effect of noise, shape (p, p + a) [m].
        noise: How far points are from where they are measured at most, shape (p + a,) [m].
        speeds: Bounds of the speeds of centres and obstacles, shape (p + a,) [m/s].
        errors: Bounds of the difference between a centre's mean velocity in a period and the command at its start,
            shape (p,) [m/s].
        keep_right: Speed to the right of the line of sight, over the closing speed that a barrier takes [-].
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
