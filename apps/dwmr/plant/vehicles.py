"""Kinds of vehicles, a pair of compiled functions each: a differential drive, a steered car, four mecanum wheels.

The loop calls `drive` and `move` and knows no kind.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

from dwmr.core.arrays import FloatArray
from dwmr.core.geometry import clamp
from dwmr.core.interfaces import Signal
from dwmr.core.jit import compiled, compiled_as, first_class, record_type
from dwmr.plant.disturbances import DISTURBANCE, Disturbance, Load, disturbance_since
from dwmr.plant.robot import ROBOT, Body, State, add, advance, body, pd_torques, slewed, smooth_sign, state_of, write

#: Numbers of one vehicle that two wheels do not have, a row of `loop.Memory.own`: steering angle of a car [rad];
#: velocity to the left [m/s], sideways torque behind the actuators' lag [N m] and state of the derivative filter [m/s]
#: of four mecanum wheels; commanded steering angle [rad] or sideways torque [N m].
STEERING, V_Y, SIDEWAYS, FILTER, ASKED = range(5)
OWN = 5
#: Records of every robot if one of them is not a differential drive: the first columns of those.
SIGNALS = (
    Signal("steering", "rad", "steering angle of a car"),
    Signal("v_y", "m/s", "velocity of an omnidirectional robot to its left"),
)


class Vehicle(NamedTuple):
    """Functions of a kind of vehicle.

    Attributes:
        drive: Turns a velocity command into torques, see `drive_differential`.
        advance: Moves a robot by one control period, see `advance_differential`.
    """

    drive: Callable[..., None]
    advance: Callable[..., None]


@cache
def vehicle(kind: str) -> Vehicle:
    """Return the functions of a kind of vehicle, compiled, as values that the loop can be given."""
    turn, advance = _FUNCTIONS[kind]
    return Vehicle(first_class(compiled_as(_drive_signature)(turn)), first_class(compiled_as(_move_signature)(advance)))


def _drive_signature(types: Any) -> Any:
    number, array = types.float64, types.float64[::1]
    return types.void(number, number, number, array, record_type(ROBOT), number, array, array, array, array)


def _move_signature(types: Any) -> Any:
    number, array = types.float64, types.float64[::1]
    acting, load = record_type(DISTURBANCE)[::1], types.NamedUniTuple(number, len(Load._fields), Load)
    return types.void(number, array, array, record_type(ROBOT), acting, load, number, types.int64, array)


def drive_differential(
    v_c: float, v_y_c: float, omega_c: float, seen: FloatArray, robot: Any, dt: float, own: FloatArray,
    filters: FloatArray, targets: FloatArray, torques: FloatArray,
) -> None:  # fmt: skip
    """Turn the velocity command of a robot and the velocities seen at its wheels into torques.

    Args:
        v_c, v_y_c, omega_c: Velocity command: ahead, to the left, turning [m/s, m/s, rad/s].
        seen: State as the robot sees it, fields of `robot.State`.
        robot: Record of dtype `robot.ROBOT`.
        dt: Control period [s].
        own: The vehicle's numbers, see `OWN`; read and written.
        filters, targets, torques: Written, shapes (2,), (3,) and (2,), see `loop.Memory`.
    """
    _drive_wheels(v_c, omega_c, True, seen, robot, dt, filters, targets, torques)


@compiled
def _drive_wheels(
    v_c: float, omega_c: float, turns: bool, seen: FloatArray, robot: Any, dt: float, filters: FloatArray,
    targets: FloatArray, torques: FloatArray,
) -> None:  # fmt: skip
    """Turn a velocity command into torques of the right and left wheels, which turn the robot or do not."""
    targets[0] = slewed(v_c, robot.v_limit, targets[0], robot.acceleration, dt)
    targets[1] = slewed(omega_c, robot.omega_limit, targets[1], robot.angular_acceleration, dt)
    e_v, e_omega = targets[0] - seen[3], targets[1] - seen[4] if turns else 0.0
    torques[0], torques[1], filters[0], filters[1] = pd_torques(e_v, e_omega, filters[0], filters[1], robot, dt)


def advance_differential(
    t: float, plant: FloatArray, torques: FloatArray, robot: Any, acting: Any, load: Load, dt: float, substeps: int,
    own: FloatArray,
) -> None:  # fmt: skip
    """Move a robot by one control period under held commands.

    Args:
        t: Start of the period [s].
        plant: Fields of `robot.State`, shape (7,); written.
        torques: Commanded torques of the right and left wheel, shape (2,) [N m].
        robot, acting, load, dt, substeps: As for `robot.advance`.
        own: The vehicle's numbers, see `OWN`; read and written.
    """
    write(plant, advance(t, state_of(plant), torques[0], torques[1], robot, acting, load, dt, substeps))


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


def _drive_car(
    v_c: float, v_y_c: float, omega_c: float, seen: FloatArray, robot: Any, dt: float, own: FloatArray,
    filters: FloatArray, targets: FloatArray, torques: FloatArray,
) -> None:  # fmt: skip
    own[ASKED] = steering_angle(v_c, omega_c, robot.wheelbase, robot.steering_limit)
    _drive_wheels(v_c, omega_c, False, seen, robot, dt, filters, targets, torques)


def _advance_car(
    t: float, plant: FloatArray, torques: FloatArray, robot: Any, acting: Any, load: Load, dt: float, substeps: int,
    own: FloatArray,
) -> None:  # fmt: skip
    h, s, shape = dt / substeps, state_of(plant), body(t, robot, load)
    first, way = own[STEERING], own[ASKED] - own[STEERING]
    rate = robot.steering_rate if way >= 0.0 else -robot.steering_rate
    for k in range(substeps):
        since = k * h
        begin = disturbance_since(t, t + since, acting)
        middle = disturbance_since(t, t + since + 0.5 * h, acting)
        end = disturbance_since(t, t + since + h, acting)
        angle_1, rate_1 = _steered(first, way, rate, since)
        angle_2, rate_2 = _steered(first, way, rate, since + 0.5 * h)
        angle_3, rate_3 = _steered(first, way, rate, since + h)
        k1 = car_derivative(s, torques[0], torques[1], angle_1, rate_1, robot, shape, begin)
        k2 = car_derivative(add(s, k1, 0.5 * h), torques[0], torques[1], angle_2, rate_2, robot, shape, middle)
        k3 = car_derivative(add(s, k2, 0.5 * h), torques[0], torques[1], angle_2, rate_2, robot, shape, middle)
        k4 = car_derivative(add(s, k3, h), torques[0], torques[1], angle_3, rate_3, robot, shape, end)
        s = add(add(add(add(s, k1, h / 6.0), k2, h / 3.0), k3, h / 3.0), k4, h / 6.0)
    angle, _ = _steered(first, way, rate, dt)
    own[STEERING] = angle
    omega = s.v * math.tan(angle) / robot.wheelbase
    write(plant, State(s.x, s.y, s.theta, s.v, omega, s.torque_right, s.torque_left))


@compiled
def _steered(first: float, way: float, rate: float, since: float) -> tuple[float, float]:
    """Return a steering angle and its rate some time after a change was commanded [rad, rad/s]."""
    if abs(rate) * since < abs(way):
        return first + rate * since, rate
    return first + way, 0.0


@compiled
def car_derivative(
    s: State, right: float, left: float, angle: float, rate: float, robot: Any, shape: Body, now: Disturbance
) -> State:  # fmt: skip
    """Return the time derivative of a car's state; its angular velocity follows from velocity and steering angle.

    With κ = tan(δ) / L the car has one velocity, the energy ½ (m + I κ²) v², and the force F + κ M, so that
    (m + I κ²) dv/dt = F + κ M - I κ dκ/dt v.

    Args:
        s: State.
        right, left: Commanded torques of the rear wheels [N m].
        angle, rate: Steering angle δ of the wheel in the middle of the front axle, and its rate [rad, rad/s].
        robot, shape, now: As for `robot.derivative`; L is the wheelbase.
    """
    tangent = math.tan(angle)
    kappa, kappa_rate = tangent / robot.wheelbase, (1.0 + tangent * tangent) * rate / robot.wheelbase
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


def _drive_omnidirectional(
    v_c: float, v_y_c: float, omega_c: float, seen: FloatArray, robot: Any, dt: float, own: FloatArray,
    filters: FloatArray, targets: FloatArray, torques: FloatArray,
) -> None:  # fmt: skip
    _drive_wheels(v_c, omega_c, True, seen, robot, dt, filters, targets, torques)
    targets[2] = slewed(v_y_c, robot.v_limit, targets[2], robot.acceleration, dt)
    # each of two equal torques is half of the torque for one force
    half, _, own[FILTER], _ = pd_torques(targets[2] - own[V_Y], 0.0, own[FILTER], 0.0, robot, dt)
    own[ASKED] = clamp(2.0 * half, robot.torque_limit)


def _advance_omnidirectional(
    t: float, plant: FloatArray, torques: FloatArray, robot: Any, acting: Any, load: Load, dt: float, substeps: int,
    own: FloatArray,
) -> None:  # fmt: skip
    h, s, shape = dt / substeps, state_of(plant), body(t, robot, load)
    u, sideways, asked = own[V_Y], own[SIDEWAYS], own[ASKED]
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
    own[V_Y], own[SIDEWAYS] = u, sideways
    write(plant, s)


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


_drive_inlined, _advance_inlined = compiled(drive_differential), compiled(advance_differential)


@compiled
def drive(
    i: int, v_c: float, v_y_c: float, omega_c: float, vehicles: Any, seen: FloatArray, robot: Any, dt: float,
    own: FloatArray, filters: FloatArray, targets: FloatArray, torques: FloatArray,
) -> None:  # fmt: skip
    """Turn the velocity command of robot `i` into torques, see `drive_differential`.

    `vehicles` has a `Vehicle` for each robot. It is None if all are differential drives, whose functions numba inlines.
    """
    if vehicles is None:
        _drive_inlined(v_c, v_y_c, omega_c, seen, robot, dt, own, filters, targets, torques)
    else:
        vehicles[i].drive(v_c, v_y_c, omega_c, seen, robot, dt, own, filters, targets, torques)


@compiled
def move(
    i: int, t: float, vehicles: Any, plant: FloatArray, torques: FloatArray, robot: Any, acting: Any, load: Load,
    dt: float, substeps: int, own: FloatArray,
) -> None:  # fmt: skip
    """Move robot `i` by one control period, see `advance_differential` and `drive`."""
    if vehicles is None:
        _advance_inlined(t, plant, torques, robot, acting, load, dt, substeps, own)
    else:
        vehicles[i].advance(t, plant, torques, robot, acting, load, dt, substeps, own)


#: Functions by kind, as a scenario names it.
_FUNCTIONS = {
    "differential": (drive_differential, advance_differential),
    "ackermann": (_drive_car, _advance_car),
    "omnidirectional": (_drive_omnidirectional, _advance_omnidirectional),
}
