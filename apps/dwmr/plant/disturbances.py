"""Disturbances on the velocities and on the forces, and the change of load, as functions of time."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.core.jit import compiled

#: One disturbance acting on one robot; amplitudes are zero for a robot it spares.
DISTURBANCE = np.dtype(
    [
        ("start", "f8"),  # [s]
        ("stop", "f8"),  # [s]
        ("angular_frequency", "f8"),  # [rad/s]; 0 is a constant
        ("phase", "f8"),  # [rad]
        ("v", "f8"),  # [m/s]
        ("omega", "f8"),  # [rad/s]
        ("force", "f8"),  # [N]
        ("torque", "f8"),  # [N m]
    ],
    align=True,
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
        began: Start of the period [s]. Disturbances that act then act until its end: a jump inside an integration
            step would cost the integrator its order.
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
                shape = math.sin(one.angular_frequency * t + one.phase)
            v += shape * one.v
            omega += shape * one.omega
            force += shape * one.force
            torque += shape * one.torque
    return Disturbance(v, omega, force, torque)


@compiled
def measure(
    noise: FloatArray,
    plant: FloatArray,
    robots: Any,
    dt: float,
    wheels: FloatArray,
    odometry: FloatArray,
    seen: FloatArray,
) -> None:
    """Write the measured states of the robots at the begin of a control period.

    Args:
        noise: Of x, y, theta, v, omega in this period, shape (n, 5) [m, m, rad, m/s, rad/s].
        plant: State of the robots, fields of `robot.State`, shape (n, 7).
        robots: Records of dtype `ROBOT`, shape (n,).
        dt: Control period [s].
        wheels: Ways of the right and left wheel's rim, its speeds, and the ways that encoders say, shape (n, 6)
            [m, m/s, m]; written.
        odometry: Posture of the reference point by odometry, shape (n, 3) [m, m, rad]; written.
        seen: Written, as `plant`.
    """
    for i in range(noise.shape[0]):
        ahead, turned = _read_encoders(plant[i, 3], plant[i, 4], robots[i], dt, wheels[i])
        _reckon(ahead, turned, robots[i].d, odometry[i])
        for k in range(3):
            seen[i, k] = noise[i, k] + (odometry[i, k] if robots[i].odometry != 0 else plant[i, k])
        coarse = robots[i].encoder_steps > 0.0
        seen[i, 3] = noise[i, 3] + (ahead / dt if coarse else plant[i, 3])
        seen[i, 4] = noise[i, 4] + (turned / dt if coarse else plant[i, 4])


@compiled
def _read_encoders(v: float, omega: float, robot: Any, dt: float, wheels: FloatArray) -> tuple[float, float]:
    """Return by how much a robot went ahead and turned in the last period, as its encoders say [m, rad]."""
    right, left = v + robot.half_track * omega, v - robot.half_track * omega
    wheels[0] += 0.5 * dt * (wheels[2] + right)
    wheels[1] += 0.5 * dt * (wheels[3] + left)
    wheels[2], wheels[3] = right, left
    way_right, way_left = wheels[0], wheels[1]
    if robot.encoder_steps > 0.0:
        step = 2.0 * math.pi * robot.wheel_radius / robot.encoder_steps
        way_right, way_left = step * math.floor(way_right / step), step * math.floor(way_left / step)
    of_right, of_left = way_right - wheels[4], way_left - wheels[5]
    wheels[4], wheels[5] = way_right, way_left
    return 0.5 * (of_right + of_left), 0.5 * (of_right - of_left) / robot.half_track


@compiled
def _reckon(ahead: float, turned: float, d: float, odometry: FloatArray) -> None:
    """Move a posture along an arc; the axle is d behind its point."""
    theta = odometry[2]
    x, y = odometry[0] - d * math.cos(theta), odometry[1] - d * math.sin(theta)
    x += ahead * math.cos(theta + 0.5 * turned)
    y += ahead * math.sin(theta + 0.5 * turned)
    theta += turned
    odometry[0], odometry[1], odometry[2] = x + d * math.cos(theta), y + d * math.sin(theta), theta
