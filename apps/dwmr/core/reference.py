"""Posture and velocity of a reference trajectory at one instant."""

from typing import NamedTuple


class Reference(NamedTuple):
    """Posture and velocities of what a robot follows.

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
