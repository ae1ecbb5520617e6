"""Vehicles other than the differential drive: a car that is steered, and a robot on mecanum wheels."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.core.geometry import clamp
from dwmr.core.interfaces import Signal
from dwmr.core.jit import compiled
from dwmr.plant.disturbances import Disturbance, Load, disturbance_since
from dwmr.plant.robot import Body, State, add, body, pd_torques, slewed, smooth_sign

DIFFERENTIAL, ACKERMANN, OMNIDIRECTIONAL = 0, 1, 2

#: Parameters of one vehicle beside those of `robot.ROBOT`; scenario/model.py documents each.
VEHICLE = np.dtype(
    [
        ("kind", "i8"),  # one of the numbers above
        ("wheelbase", "f8"),  # of a car [m]
        ("steering_limit", "f8"),  # [rad]
        ("steering_rate", "f8"),  # [rad/s]
    ],
    align=True,
)

#: Records of every robot if one of them is not a differential drive, in the order of `Vehicles.record`.
SIGNALS = (
    Signal("steering", "rad", "steering angle of a car"),
    Signal("v_y", "m/s", "velocity of an omnidirectional robot to its left"),
)


class Vehicles(NamedTuple):
    """Vehicles of a scenario and what two wheels do not have.

    Attributes:
        own: Records of dtype `VEHICLE`, shape (n,).
        lateral: Column of the law's signals that holds the commanded velocity to the left, -1 without one.
        asked: Commanded steering angle [rad] or sideways torque [N m], shape (n,).
        state: Steering angle [rad] of a car; velocity to the left [m/s], sideways torque behind the actuators' lag
            [N m] and state of the derivative filter [m/s] of an omnidirectional robot, shape (n, 3).
        record: Written, shape (samples, n, len(SIGNALS)).
    """

    own: Any
    lateral: int
    asked: FloatArray
    state: FloatArray
    record: FloatArray


@compiled
def steering(i: int, vehicles: Vehicles) -> float:
    """Return the steering angle of a robot, 0 for one without [rad]."""
    return vehicles.state[i, 0] if vehicles.own[i].kind == ACKERMANN else 0.0


@compiled
def lateral_velocity(i: int, vehicles: Vehicles) -> float:
    """Return the velocity of a robot to its left, 0 for one that cannot move sideways [m/s]."""
    return vehicles.state[i, 0] if vehicles.own[i].kind == OMNIDIRECTIONAL else 0.0


@compiled
def moves_sideways(i: int, vehicles: Vehicles) -> bool:
    """Return whether a robot is commanded in any direction: it can be, and its law does so."""
    return vehicles.lateral >= 0 and vehicles.own[i].kind == OMNIDIRECTIONAL


@compiled
def steering_angle(v: float, omega: float, wheelbase: float, limit: float) -> float:
    """Return the steering angle that gives a velocity command its curvature, within its limit [rad].

    Args:
        v, omega: Velocity command [m/s, rad/s]; one that asks for nothing gets the angle 0.
        wheelbase: [m].
        limit: [rad].
    """
    bend = wheelbase * (omega if v >= 0.0 else -omega)
    return clamp(math.atan2(bend, abs(v)), limit)


@compiled
def drive(
    i: int, v_c: float, v_y_c: float, omega_c: float, seen: FloatArray, robot: Any, dt: float, vehicles: Vehicles,
    filters: FloatArray, targets: FloatArray, torques: FloatArray,
) -> None:  # fmt: skip
    """Turn the velocity command of one vehicle into torques, and the steering angle or sideways torque it asks for.

    Args:
        i: Number of the robot.
        v_c, v_y_c, omega_c: Velocity command: ahead, to the left, turning [m/s, m/s, rad/s].
        seen: State as the robot sees it, fields of `robot.State`.
        robot: Record of dtype `robot.ROBOT`.
        dt: Control period [s].
        vehicles: Its `asked` and the filter in its `state` are written.
        filters, targets, torques: Written, shapes (2,), (3,) and (2,), see `loop.Memory`.
    """
    targets[0] = slewed(v_c, robot.v_limit, targets[0], robot.acceleration, dt)
    targets[1] = slewed(omega_c, robot.omega_limit, targets[1], robot.angular_acceleration, dt)
    e_v, e_omega = targets[0] - seen[3], targets[1] - seen[4]
    vehicle, state = vehicles.own[i], vehicles.state[i]
    if vehicle.kind == ACKERMANN:
        vehicles.asked[i] = steering_angle(v_c, omega_c, vehicle.wheelbase, vehicle.steering_limit)
        e_omega = 0.0  # its rear wheels drive and do not turn it
    torques[0], torques[1], filters[0], filters[1] = pd_torques(e_v, e_omega, filters[0], filters[1], robot, dt)
    if vehicle.kind == OMNIDIRECTIONAL:
        targets[2] = slewed(v_y_c, robot.v_limit, targets[2], robot.acceleration, dt)
        e_y = targets[2] - state[0]
        # each of two equal torques is half of the torque for one force
        half, _, state[2], _ = pd_torques(e_y, 0.0, state[2], 0.0, robot, dt)
        vehicles.asked[i] = clamp(2.0 * half, robot.torque_limit)


@compiled
def advance_vehicle(
    i: int, t: float, s: State, torques: FloatArray, robot: Any, acting: Any, load: Load, dt: float, substeps: int,
    vehicles: Vehicles,
) -> State:  # fmt: skip
    """Move one vehicle by one control period under held commands, with classical Runge-Kutta substeps.

    Args:
        i: Number of the robot.
        vehicles: Its `state` is written.

    Other arguments and the result as for `robot.advance`.
    """
    if vehicles.own[i].kind == ACKERMANN:
        return _advance_car(i, t, s, torques, robot, acting, load, dt, substeps, vehicles)
    return _advance_omnidirectional(i, t, s, torques, robot, acting, load, dt, substeps, vehicles)


@compiled
def _advance_car(
    i: int, t: float, s: State, torques: FloatArray, robot: Any, acting: Any, load: Load, dt: float, substeps: int,
    vehicles: Vehicles,
) -> State:  # fmt: skip
    h, vehicle, shape = dt / substeps, vehicles.own[i], body(t, robot, load)
    first, way = vehicles.state[i, 0], vehicles.asked[i] - vehicles.state[i, 0]
    rate = vehicle.steering_rate if way >= 0.0 else -vehicle.steering_rate
    for k in range(substeps):
        since = k * h
        begin = disturbance_since(t, t + since, acting)
        middle = disturbance_since(t, t + since + 0.5 * h, acting)
        end = disturbance_since(t, t + since + h, acting)
        angle_1, rate_1 = _steered(first, way, rate, since)
        angle_2, rate_2 = _steered(first, way, rate, since + 0.5 * h)
        angle_3, rate_3 = _steered(first, way, rate, since + h)
        k1 = car_derivative(s, torques[0], torques[1], angle_1, rate_1, vehicle.wheelbase, robot, shape, begin)
        k2 = car_derivative(
            add(s, k1, 0.5 * h), torques[0], torques[1], angle_2, rate_2, vehicle.wheelbase, robot, shape, middle
        )
        k3 = car_derivative(
            add(s, k2, 0.5 * h), torques[0], torques[1], angle_2, rate_2, vehicle.wheelbase, robot, shape, middle
        )
        k4 = car_derivative(
            add(s, k3, h), torques[0], torques[1], angle_3, rate_3, vehicle.wheelbase, robot, shape, end
        )
        s = add(add(add(add(s, k1, h / 6.0), k2, h / 3.0), k3, h / 3.0), k4, h / 6.0)
    angle, _ = _steered(first, way, rate, dt)
    vehicles.state[i, 0] = angle
    omega = s.v * math.tan(angle) / vehicle.wheelbase
    return State(s.x, s.y, s.theta, s.v, omega, s.torque_right, s.torque_left)


@compiled
def _steered(first: float, way: float, rate: float, since: float) -> tuple[float, float]:
    """Return a steering angle and its rate some time after a change was commanded [rad, rad/s]."""
    if abs(rate) * since < abs(way):
        return first + rate * since, rate
    return first + way, 0.0


@compiled
def car_derivative(
    s: State, right: float, left: float, angle: float, rate: float, wheelbase: float, robot: Any, shape: Body,
    now: Disturbance,
) -> State:  # fmt: skip
    """Return the time derivative of a car's state; its angular velocity follows from velocity and steering angle.

    With κ = tan(δ) / L the car has one velocity, the energy ½ (m + I κ²) v², and the force F + κ M, so that
    (m + I κ²) dv/dt = F + κ M - I κ dκ/dt v.

    Args:
        s: State.
        right, left: Commanded torques of the rear wheels [N m].
        angle, rate: Steering angle δ of the wheel in the middle of the front axle, and its rate [rad, rad/s].
        wheelbase: L [m].
        robot, shape, now: As for `robot.derivative`.
    """
    tangent = math.tan(angle)
    kappa, kappa_rate = tangent / wheelbase, (1.0 + tangent * tangent) * rate / wheelbase
    turning = kappa * s.v
    v, omega = s.v + now.v, turning + now.omega
    c, sine = math.cos(s.theta), math.sin(s.theta)
    force = (s.torque_right + s.torque_left) * shape.force_per_torque + now.force
    force -= robot.coulomb_force * smooth_sign(s.v, robot.stick_v) + robot.viscous_force * s.v
    torque = now.torque - robot.coulomb_torque * smooth_sign(turning, robot.stick_omega)
    torque -= robot.viscous_torque * turning
    inertia = 1.0 / shape.inverse_inertia
    whole = 1.0 / shape.inverse_mass + inertia * kappa * kappa
    return State(
        v * c - robot.d * omega * sine,
        v * sine + robot.d * omega * c,
        omega,
        (force + kappa * torque - inertia * kappa * kappa_rate * s.v) / whole,
        0.0,
        (right - s.torque_right) * shape.inverse_lag,
        (left - s.torque_left) * shape.inverse_lag,
    )


@compiled
def _advance_omnidirectional(
    i: int, t: float, s: State, torques: FloatArray, robot: Any, acting: Any, load: Load, dt: float, substeps: int,
    vehicles: Vehicles,
) -> State:  # fmt: skip
    h, shape, asked = dt / substeps, body(t, robot, load), vehicles.asked[i]
    u, sideways = vehicles.state[i, 0], vehicles.state[i, 1]
    for k in range(substeps):
        at = t + k * h
        begin, middle = disturbance_since(t, at, acting), disturbance_since(t, at + 0.5 * h, acting)
        end = disturbance_since(t, at + h, acting)
        k1, u1, w1 = omnidirectional_derivative(s, u, sideways, torques, asked, robot, shape, begin)
        k2, u2, w2 = omnidirectional_derivative(
            add(s, k1, 0.5 * h), u + 0.5 * h * u1, sideways + 0.5 * h * w1, torques, asked, robot, shape, middle
        )
        k3, u3, w3 = omnidirectional_derivative(
            add(s, k2, 0.5 * h), u + 0.5 * h * u2, sideways + 0.5 * h * w2, torques, asked, robot, shape, middle
        )
        k4, u4, w4 = omnidirectional_derivative(
            add(s, k3, h), u + h * u3, sideways + h * w3, torques, asked, robot, shape, end
        )
        s = add(add(add(add(s, k1, h / 6.0), k2, h / 3.0), k3, h / 3.0), k4, h / 6.0)
        u += h / 6.0 * (u1 + 2.0 * (u2 + u3) + u4)
        sideways += h / 6.0 * (w1 + 2.0 * (w2 + w3) + w4)
    vehicles.state[i, 0], vehicles.state[i, 1] = u, sideways
    return s


@compiled
def omnidirectional_derivative(
    s: State, u: float, sideways: float, torques: FloatArray, asked: float, robot: Any, shape: Body, now: Disturbance
) -> tuple[State, float, float]:
    """Return the time derivatives of an omnidirectional robot: of its state, velocity to the left, sideways torque.

    Args:
        s: State.
        u: Velocity to the left [m/s].
        sideways: Torque of the wheels that pushes it to the left, behind the actuators' lag [N m].
        torques: Asked of the right and the left wheels, shape (2,) [N m].
        asked: Commanded sideways torque [N m].
        robot, shape, now: As for `robot.derivative`; `half_track` is the lever arm of the wheels.
    """
    v, omega = s.v + now.v, s.omega + now.omega
    c, sine = math.cos(s.theta), math.sin(s.theta)
    left_ahead = u + robot.d * omega
    speed = math.hypot(s.v, u)
    grip = robot.coulomb_force / (speed + robot.stick_v) + robot.viscous_force
    force = (s.torque_right + s.torque_left) * shape.force_per_torque + now.force - grip * s.v
    push = sideways * shape.force_per_torque - grip * u
    torque = (s.torque_right - s.torque_left) * shape.torque_per_torque + now.torque
    torque -= robot.coulomb_torque * smooth_sign(s.omega, robot.stick_omega) + robot.viscous_torque * s.omega
    offset = shape.moment * shape.inverse_mass  # of the centre of mass
    spin = (torque - offset * push) / (1.0 / shape.inverse_inertia - offset * shape.moment)
    return (
        State(
            v * c - left_ahead * sine,
            v * sine + left_ahead * c,
            omega,
            force * shape.inverse_mass + u * s.omega + offset * s.omega * s.omega,
            spin,
            (torques[0] - s.torque_right) * shape.inverse_lag,
            (torques[1] - s.torque_left) * shape.inverse_lag,
        ),
        push * shape.inverse_mass - s.v * s.omega - offset * spin,
        (asked - sideways) * shape.inverse_lag,
    )
