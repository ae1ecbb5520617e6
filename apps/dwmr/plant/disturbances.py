"""Disturbances on the velocities and on the forces, and the change of load, as functions of time."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from dwmr.core.jit import compiled

#: One disturbance acting on one robot; amplitudes are zero for a robot it spares.
DISTURBANCE = np.dtype(
    [
        ("start", "f8"),  # [s]
        ("stop", "f8"),  # [s]
        ("angular_frequency", "f8"),  # [rad/s]; 0 is a constant
        ("v", "f8"),  # [m/s]
        ("omega", "f8"),  # [rad/s]
        ("force", "f8"),  # [N]
        ("torque", "f8"),  # [N m]
    ]
)


class Load(NamedTuple):
    """Change of mass and inertia.

    Attributes:
        start, stop: When it acts [s].
        mass_factor, inertia_factor: Loaded over nominal value [-].
    """

    start: float
    stop: float
    mass_factor: float
    inertia_factor: float


class Disturbance(NamedTuple):
    """Sum of all disturbances on one robot at one time.

    Attributes:
        v: Velocity-equivalent d̃_0v of Eq. (6) [m/s].
        omega: Velocity-equivalent d̃_0ω of Eq. (6) [rad/s].
        force: Along the robot [N].
        torque: About the axle centre [N m].
    """

    v: float
    omega: float
    force: float
    torque: float


@compiled
def disturbance(t: float, acting: Any) -> Disturbance:
    """Add up the disturbances acting on a robot at a time [s], see `disturbance_since`."""
    return disturbance_since(t, t, acting)


@compiled
def disturbance_since(began: float, t: float, acting: Any) -> Disturbance:
    """Add up the disturbances acting on a robot in a control period.

    Args:
        began: Start of the period [s]. What acts then acts until its end: a jump inside an integration step would cost
            the integrator its order.
        t: Time [s].
        acting: Records of dtype `DISTURBANCE`, shape (n,).

    Source:
        Goto, Bertol, Martins, section 7: the windows and kinds; the amplitudes are not printed.
    """
    v = omega = force = torque = 0.0
    for k in range(acting.shape[0]):
        one = acting[k]
        if one.start <= began < one.stop:
            shape = 1.0
            if one.angular_frequency != 0.0:
                shape = math.sin(one.angular_frequency * t)
            v += shape * one.v
            omega += shape * one.omega
            force += shape * one.force
            torque += shape * one.torque
    return Disturbance(v, omega, force, torque)
