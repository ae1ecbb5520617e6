"""Interfaces of the loop: arguments and results of reference trajectories and control laws, and of other plants.

Implementations are added as files; the loop and its compiled code stay as they are.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, TypeVar

from dwmr.core.arrays import FloatArray, Reference
from dwmr.core.jit import compiled_as, function_type

Function = TypeVar("Function", bound=Callable[..., Any])


class PostureError(NamedTuple):
    """The error of Eq. (6) or (51) and its drift.

    Attributes:
        x_e: Longitudinal error in the robot's frame [m].
        y_e: Lateral error in the robot's frame [m].
        theta_e_star: Wrapped error of the auxiliary orientation, θ*_r − θ [rad].
        drift_x: First row of A_0 [m/s].
        drift_y: Second row of A_0 [m/s].
        drift_theta: Third row of A_0, the auxiliary angular velocity [rad/s].
        d: Distance of the reference point ahead of the wheel axis [m].
    """

    x_e: float
    y_e: float
    theta_e_star: float
    drift_x: float
    drift_y: float
    drift_theta: float
    d: float


class TrackingError(NamedTuple):
    """Inputs of a control law at one instant.

    Attributes:
        x_e, y_e, theta_e_star, drift_x, drift_y, drift_theta, d: As those of `PostureError`.
        theta_e: Wrapped error of the orientation, θ_r − θ; of a follower θ*_r − θ, as it has no other [rad].
        v_r: Velocity of the reference along its orientation θ_r, negative where it goes backwards [m/s].
        omega_r: Turning rate of the reference, 0 in avoidance, where its orientation is that of the way around [rad/s].
        v, omega: Velocities that the robot measures at its wheels [m/s, rad/s].
        t: Time since the start of the run [s].
    """

    x_e: float
    y_e: float
    theta_e_star: float
    drift_x: float
    drift_y: float
    drift_theta: float
    d: float
    theta_e: float
    v_r: float
    omega_r: float
    v: float
    omega: float
    t: float


class Signal(NamedTuple):
    """Name a recorded signal and its unit."""

    name: str
    unit: str
    doc: str


class Law(NamedTuple):
    """A control law made ready for one robot.

    Attributes:
        gains: Flat constants that `step` reads, shape (g,).
        state: Flat initial state, shape (s,).
        kernels: Compiled gain kernels; number and signatures are those declared to `control_law`.
        frozen: Numbers of the states, such as adaptive gains, that keep their values in a period in which limits or the
            safety filter change the command.
        plan: Called in Python after period 0 and each `every`-th one from there on, with the state, which it may
            change, and the robot's record of dtype `ROBOT`; returns 0 or a key of the module's FAULTS. For
            computations that numba does not compile. None for none.
        every: Control periods from one call of `plan` to the next.
    """

    gains: FloatArray
    state: FloatArray
    kernels: tuple[Any, ...]
    frozen: tuple[int, ...] = ()
    plan: Callable[[FloatArray, Any], int] | None = None
    every: int = 1


class Plant(Protocol):
    """A plant that replaces the compiled one of `plant/robot.py`."""

    def move(self, t: float, torques: FloatArray, state: FloatArray, slip: FloatArray) -> None:
        """Move all robots by one control period under held torques.

        Args:
            t: Begin of the period [s].
            torques: Asked of the right and left wheel, shape (n, 2) [N m].
            state: Written, shape (n, 7): fields of `plant.robot.State`; velocities are those of the wheels.
            slip: Written, shape (n, 2): velocities over ground less those of the wheels [m/s, rad/s].
        """


def control_law(*kernels: str) -> Callable[[Function], Function]:
    """Compile a control law to the one signature the loop calls.

    Args:
        kernels: Signatures of the gain kernels the law wants, in order, such as "float64(float64, float64)".

    Returns:
        A decorator for `step(error, dt, gains, state, kernels, next_state, signals) -> (v_c, omega_c, fault)`: the
        commanded velocities [m/s, rad/s] and 0 or a key of the module's FAULTS. It writes the state after the period
        into `next_state` and its records into `signals`, and no other array.
    """

    def signature(types: Any) -> Any:
        array = types.float64[::1]
        error = types.NamedUniTuple(types.float64, len(TrackingError._fields), TrackingError)
        wanted = types.Tuple(tuple(function_type(k) for k in kernels))
        command = types.Tuple((types.float64, types.float64, types.int64))
        return command(error, types.float64, array, array, wanted, array, array)

    return compiled_as(signature, checked=True)


def reference_path(function: Function) -> Function:
    """Compile a reference trajectory `path(t, shape) -> Reference`; shape is a flat array of its constants."""

    def signature(types: Any) -> Any:
        posture = types.NamedUniTuple(types.float64, len(Reference._fields), Reference)
        return posture(types.float64, types.float64[::1])

    return compiled_as(signature)(function)
