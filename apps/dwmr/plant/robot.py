"""The plant: a differential-drive robot with its PD inner loop, actuator lag, friction and limits."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.core.geometry import clamp
from dwmr.core.jit import compiled
from dwmr.plant.disturbances import Disturbance, Load, disturbance_since

#: Parameters of one robot; scenario.py documents each with its source.
ROBOT = np.dtype(
    [
        ("mass", "f8"),  # [kg]
        ("inertia", "f8"),  # about the axle centre [kg m²]
        ("com_offset", "f8"),  # of the centre of mass ahead of the axle, negative behind [m]
        ("d", "f8"),  # of the reference point ahead of the axle [m]
        ("half_track", "f8"),  # [m]
        ("radius", "f8"),  # R_R that encloses the robot [m]
        ("wheel_radius", "f8"),  # [m]
        ("coulomb_force", "f8"),  # [N]
        ("coulomb_torque", "f8"),  # [N m]
        ("viscous_force", "f8"),  # [N s/m]
        ("viscous_torque", "f8"),  # [N m s/rad]
        ("stick_v", "f8"),  # velocity over which Coulomb friction changes sign [m/s]
        ("stick_omega", "f8"),  # [rad/s]
        ("lag", "f8"),  # of the actuators [s]
        ("torque_limit", "f8"),  # of one wheel [N m]
        ("v_limit", "f8"),  # [m/s]
        ("omega_limit", "f8"),  # [rad/s]
        ("acceleration", "f8"),  # with which commands reach the inner loop, infinite for none [m/s²]
        ("angular_acceleration", "f8"),  # [rad/s²]
        ("k_p_v", "f8"),
        ("k_p_omega", "f8"),
        ("k_d_v", "f8"),
        ("k_d_omega", "f8"),
        ("n_v", "f8"),  # derivative filter [1/s]
        ("n_omega", "f8"),  # [1/s]
        ("pd_mass", "f8"),  # multiplies the PD output: nominal mass, or 1 where gains are read as forces
        ("pd_inertia", "f8"),
        ("first", "i8"),  # its places in the formation are those from the first up to but not including the last;
        ("last", "i8"),  # without any it follows a reference
        ("path", "i8"),  # row of its reference among all
        ("avoids", "i8"),  # 1 if it avoids obstacles
        ("odometry", "i8"),  # 1 if it knows its posture by odometry only
        ("encoder_steps", "f8"),  # of one turn of a wheel, 0 for exact wheels
        ("delay", "f8"),  # behind the reference, for a robot that follows it [s]
        ("sideways", "i8"),  # 1 if its law commands it in any direction
        ("wheelbase", "f8"),  # of a car [m]
        ("steering_limit", "f8"),  # [rad]
        ("steering_rate", "f8"),  # [rad/s]
    ],
    align=True,
)


#: A place that a follower is to keep.
EDGE = np.dtype(
    [
        ("leader", "i8"),  # index of the robot it is relative to, −1 for the body of a virtual structure
        ("separation", "f8"),  # [m]
        ("bearing", "f8"),  # [rad]
        ("weight", "f8"),  # share in the follower's place
    ],
    align=True,
)


class State(NamedTuple):
    """State of one robot, and equally its time derivative.

    Attributes:
        x, y: Reference point [m].
        theta: Orientation, not wrapped [rad].
        v: Linear velocity of the axle centre [m/s].
        omega: Angular velocity [rad/s].
        torque_right, torque_left: Wheel torques behind the actuator lag [N m].
    """

    x: float
    y: float
    theta: float
    v: float
    omega: float
    torque_right: float
    torque_left: float


@compiled
def state_of(plant: FloatArray) -> State:
    """Return the state in a row of `loop.Memory.plant`."""
    return State(plant[0], plant[1], plant[2], plant[3], plant[4], plant[5], plant[6])


@compiled
def write(plant: FloatArray, s: State) -> None:
    """Write a state into such a row."""
    plant[0], plant[1], plant[2], plant[3], plant[4] = s.x, s.y, s.theta, s.v, s.omega
    plant[5], plant[6] = s.torque_right, s.torque_left


@compiled
def velocity(state: State, acting: Disturbance) -> tuple[float, float]:
    """Return the velocities with which a robot really moves, v + d̃_0 of Eq. (6) [m/s, rad/s]."""
    return state.v + acting.v, state.omega + acting.omega


class Body(NamedTuple):
    """Constants of a robot with its load and drives during one control period.

    Attributes:
        inverse_mass: [1/kg].
        inverse_inertia: About the axle centre [1/(kg m²)].
        moment: Mass times offset of the centre of mass [kg m].
        force_per_torque: Force of one wheel torque [1/m].
        torque_per_torque: Turning torque of one wheel torque [-].
        inverse_lag: [1/s].
    """

    inverse_mass: float
    inverse_inertia: float
    moment: float
    force_per_torque: float
    torque_per_torque: float
    inverse_lag: float


@compiled
def body(t: float, robot: Any, load: Load) -> Body:
    """Return the body of a robot at a time [s]; the load changes at the ends of control periods only.

    Source:
        Goto, Bertol, Martins, section 7: load on mass and inertia. The force map of the wheels [1/r 1/r; b/r −b/r]
        takes the place of the printed velocity map in both plant and PD.
    """
    mass, inertia = robot.mass, robot.inertia
    if load.start <= t < load.stop:
        mass *= load.mass_factor
        inertia *= load.inertia_factor
    return Body(
        1.0 / mass,
        1.0 / inertia,
        mass * robot.com_offset,
        1.0 / robot.wheel_radius,
        robot.half_track / robot.wheel_radius,
        1.0 / robot.lag,
    )


@compiled
def smooth_sign(value: float, width: float) -> float:
    """Return value / (|value| + width): a sign that an explicit integrator can follow through standstill [-]."""
    return value / (abs(value) + width)


@compiled
def derivative(
    state: State, command_right: float, command_left: float, robot: Any, shape: Body, now: Disturbance
) -> State:
    """Return the time derivative of a robot's state.

    Args:
        state: State of the robot.
        command_right, command_left: Commanded wheel torques [N m].
        robot: Record of dtype `ROBOT`.
        shape: Its body under the present load.
        now: Sum of the disturbances on this robot.

    Source:
        Goto, Bertol, Martins, Eq. (46) for the kinematics; Eqs. (1), (6) for the structure. The printed inertia I − m
        d² is negative for the followers' d, so the plant has an inertia about the axle and another Coriolis term.
    """
    v, omega = velocity(state, now)
    c, s = math.cos(state.theta), math.sin(state.theta)
    force = (state.torque_right + state.torque_left) * shape.force_per_torque + now.force
    torque = (state.torque_right - state.torque_left) * shape.torque_per_torque + now.torque
    force -= robot.coulomb_force * smooth_sign(state.v, robot.stick_v) + robot.viscous_force * state.v
    torque -= robot.coulomb_torque * smooth_sign(state.omega, robot.stick_omega) + robot.viscous_torque * state.omega
    coupling = shape.moment * state.omega
    return State(
        v * c - robot.d * omega * s,
        v * s + robot.d * omega * c,
        omega,
        (force + coupling * state.omega) * shape.inverse_mass,
        (torque - coupling * state.v) * shape.inverse_inertia,
        (command_right - state.torque_right) * shape.inverse_lag,
        (command_left - state.torque_left) * shape.inverse_lag,
    )


@compiled
def add(state: State, rate: State, h: float) -> State:
    """Return state + h · rate."""
    return State(
        state.x + h * rate.x,
        state.y + h * rate.y,
        state.theta + h * rate.theta,
        state.v + h * rate.v,
        state.omega + h * rate.omega,
        state.torque_right + h * rate.torque_right,
        state.torque_left + h * rate.torque_left,
    )


@compiled
def advance(
    t: float,
    state: State,
    command_right: float,
    command_left: float,
    robot: Any,
    acting: Any,
    load: Load,
    dt: float,
    substeps: int,
) -> State:
    """Move a robot by one control period under held torque commands, with classical Runge-Kutta substeps.

    Args:
        t: Start of the period [s].
        acting: Disturbances on this robot, records of dtype `DISTURBANCE`.
        dt: Control period [s].
        substeps: Integration steps in one period.

    Other arguments as `derivative`.
    """
    h = dt / substeps
    shape = body(t, robot, load)
    for k in range(substeps):
        at = t + k * h
        begin, middle = disturbance_since(t, at, acting), disturbance_since(t, at + 0.5 * h, acting)
        k1 = derivative(state, command_right, command_left, robot, shape, begin)
        k2 = derivative(add(state, k1, 0.5 * h), command_right, command_left, robot, shape, middle)
        k3 = derivative(add(state, k2, 0.5 * h), command_right, command_left, robot, shape, middle)
        end = disturbance_since(t, at + h, acting)
        k4 = derivative(add(state, k3, h), command_right, command_left, robot, shape, end)
        state = add(add(add(add(state, k1, h / 6.0), k2, h / 3.0), k3, h / 3.0), k4, h / 6.0)
    return state


@compiled
def slewed(command: float, limit: float, before: float, rate: float, dt: float) -> float:
    """Return the velocity that drives with a limit of acceleration are set to in a period.

    Args:
        command: Velocity command [m/s, rad/s].
        limit: Of its size, in its unit.
        before: Velocity of the period before, in its unit.
        rate: Limit of acceleration, in its unit per s; infinite for none.
        dt: Control period [s].
    """
    wanted, step = clamp(command, limit), rate * dt
    return wanted if abs(wanted - before) <= step else before + clamp(wanted - before, step)


@compiled
def pd_torques(
    e_v: float, e_omega: float, filter_v: float, filter_omega: float, robot: Any, dt: float
) -> tuple[float, float, float, float]:
    """Return the wheel torques of the inner loop.

    Args:
        e_v, e_omega: Velocity errors v_c − v [m/s, rad/s].
        filter_v, filter_omega: States of the derivative filters, in the unit of the errors.
        robot: Record of dtype `ROBOT`.
        dt: Control period [s].

    Returns:
        Right and left wheel torque [N m] within the limit, and the filter states after the period.

    Source:
        Goto, Bertol, Martins, Eqs. (2), (75) with C(s) = k_p + k_d N / (1 + N/s). The force map of the wheels takes the
        place of the printed velocity map; plant and PD use the same one, so it cancels except at the torque limit.
    """
    u_v = robot.k_p_v * e_v + robot.k_d_v * robot.n_v * (e_v - filter_v)
    u_omega = robot.k_p_omega * e_omega + robot.k_d_omega * robot.n_omega * (e_omega - filter_omega)
    force, torque = robot.pd_mass * u_v, robot.pd_inertia * u_omega
    common, difference = 0.5 * robot.wheel_radius * force, 0.5 * robot.wheel_radius * torque / robot.half_track
    right, left = clamp(common + difference, robot.torque_limit), clamp(common - difference, robot.torque_limit)
    # exact for an error held over the period
    filter_v += (1.0 - math.exp(-robot.n_v * dt)) * (e_v - filter_v)
    filter_omega += (1.0 - math.exp(-robot.n_omega * dt)) * (e_omega - filter_omega)
    return right, left, filter_v, filter_omega
