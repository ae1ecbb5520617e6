"""Signals of the paper's figures, derived from a recorded run without a new simulation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dwmr.control.formation import separation_and_bearing
from dwmr.control.obstacle_avoidance import Avoidance, avoidance_radius
from dwmr.core.arrays import FloatArray
from dwmr.core.geometry import wrap_array
from dwmr.results import lyapunov
from dwmr.results.metrics import distances
from dwmr.scenario.model import Scenario
from dwmr.scenario.outlines import centres
from dwmr.simulation.simulate import Trajectory

#: Channels of a control law: linear and angular velocity.
CHANNELS = ("v", "omega")


def rate(signal: FloatArray, dt: float) -> FloatArray:
    """Return the backward difference of a signal over its first axis, in its unit per s; 0 at the first sample.

    Args:
        signal: Shape (samples, ...).
        dt: Time from one sample to the next [s].

    Returns:
        The same shape.
    """
    change: FloatArray = np.diff(signal, axis=0, prepend=signal[:1]) / dt
    return change


def chattering(trajectory: Trajectory, channel: str) -> FloatArray:
    """Return |dv_c/dt|, the chattering measure, shape (samples, robots) [m/s² or rad/s²].

    Source:
        Goto, Bertol, Martins, section 7, after reference [43].
    """
    level: FloatArray = np.abs(rate(trajectory[f"{channel}_c"], trajectory.step))
    return level


def velocity_error(trajectory: Trajectory, channel: str) -> FloatArray:
    """Return v_e, the commanded velocity less the actual one, shape (samples, robots).

    Returns:
        [m/s or rad/s].

    Source:
        Goto, Bertol, Martins, section 2: the disturbance of the kinematics of Eq. (6), with its sign changed.
    """
    error: FloatArray = trajectory[f"{channel}_c"] - trajectory[channel] - trajectory[f"d_{channel}"]
    return error


def compensation(trajectory: Trajectory, scenario: Scenario, channel: str) -> FloatArray | None:
    """Return the sliding mode portion of the velocity command, shape (samples, robots), or None for an unknown law.

    Returns:
        −G_AIS sat(σ*), −F(σ*) or −G sign(σ*), whichever the law has [m/s or rad/s].

    Source:
        Goto, Bertol, Martins, Eqs. (11), (20), (77).
    """
    portion = lyapunov.signals(trajectory, scenario).get(f"switching_{channel}")
    return None if portion is None else -portion


def followers(scenario: Scenario) -> tuple[str, ...]:
    """Return the names of the robots that follow another one."""
    return tuple(name for name, robot in scenario.robots.items() if robot.leaders)


def avoiders(scenario: Scenario) -> tuple[str, ...]:
    """Return the names of the robots that avoid obstacles: those on the reference with avoidance switched on."""
    names = (n for n, r in scenario.robots.items() if r.avoids_obstacles and r.formation is None)
    return tuple(names) if scenario.obstacles else ()


def formation_error(trajectory: Trajectory, scenario: Scenario, robot: str) -> tuple[FloatArray, FloatArray]:
    """Return L_ijd − L_ij [m] and Ψ_ijd − Ψ_ij, wrapped [rad], of a follower, each of shape (samples,).

    Of several leaders the first one counts.

    Raises:
        ValueError: For a robot that follows none.

    Source:
        Goto, Bertol, Martins, Eqs. (44), (45) and the aim of section 2.
    """
    wanted = next((one for one in scenario.robots[robot].edges if one.leader is not None), None)
    if wanted is None or wanted.leader is None:
        raise ValueError(f"{robot} follows no robot")
    i, j = trajectory.robots.index(wanted.leader), trajectory.robots.index(robot)
    x, y, theta = trajectory["x"], trajectory["y"], trajectory["theta"]
    measure = np.vectorize(separation_and_bearing, otypes=[np.float64, np.float64])
    separation, bearing = measure(x[:, i], y[:, i], theta[:, i], scenario.robots[wanted.leader].d, x[:, j], y[:, j])
    return wanted.separation - separation, wrap_array(wanted.bearing - bearing)


def avoidance_radii(trajectory: Trajectory, scenario: Scenario, robot: str) -> FloatArray:
    """Return R_d of every obstacle for a robot, whether it is avoided or not, shape (samples, obstacles) [m].

    Source:
        Goto, Bertol, Martins, Eqs. (58)-(63).
    """
    i, settings_of_robot = trajectory.robots.index(robot), scenario.robots[robot]
    x, y, theta, v = (trajectory[name][:, i] for name in ("x", "y", "theta", "v"))
    values = Avoidance(**scenario.avoidance.model_dump())
    gap, at = distances(trajectory, scenario, robot), centres(scenario, trajectory.t)
    radii = np.empty_like(gap)
    for a, one in enumerate(scenario.obstacles):
        closing = v * np.cos(theta - np.arctan2(at[:, a, 1] - y, at[:, a, 0] - x))
        radii[:, a] = [
            avoidance_radius(d, c, one.radius, settings_of_robot.radius, values)
            for d, c in zip(gap[:, a].tolist(), closing.tolist(), strict=True)
        ]
    return radii


def blending(trajectory: Trajectory, scenario: Scenario, robot: str) -> FloatArray:
    """Return the blending vectors U_b, away from the obstacle, and U_f, around it; 0 while no obstacle is avoided.

    The side on which the robot passes is not recorded; it is the one whose sum U has the recorded direction.

    Returns:
        Shape (2, samples, 2) [m].

    Source:
        Goto, Bertol, Martins, Eqs. (65)-(70).
    """
    i = trajectory.robots.index(robot)
    result = np.zeros((2, len(trajectory.t), 2))
    active = np.flatnonzero(trajectory["obstacle"][:, i] >= 0)
    to = centres(scenario, trajectory.t)[active, trajectory["obstacle"][active, i].astype(int)]
    to = to - np.stack([trajectory["x"][active, i], trajectory["y"][active, i]], axis=1)
    back = (1.0 - trajectory["avoidance_radius"][active, i] / np.hypot(to[:, 0], to[:, 1]))[:, None] * to
    around = np.stack([-to[:, 1], to[:, 0]], axis=1)  # l_ia turned by α = π/2
    left, right = back + around, back - around
    wanted = trajectory["theta_r"][active, i]
    off = [np.abs(wrap_array(np.arctan2(u[:, 1], u[:, 0]) - wanted)) for u in (left, right)]
    result[0, active] = back
    result[1, active] = np.where((off[0] <= off[1])[:, None], around, -around)
    return result


def path_orientation(trajectory: Trajectory, robot: str) -> FloatArray:
    """Return θ_r,tt, the direction of the original path, wrapped, shape (samples,) [rad].

    In avoidance only the orientation and the velocity of the reference change; its position stays on the path.
    """
    i = trajectory.robots.index(robot)
    theta = trajectory["theta_r"][:, i]
    if len(theta) < 2:
        return wrap_array(theta)
    along = np.arctan2(np.gradient(trajectory["y_r"][:, i]), np.gradient(trajectory["x_r"][:, i]))
    return wrap_array(np.where(trajectory["obstacle"][:, i] >= 0, along, theta))


def loaded(scenario: Scenario, end: float) -> list[tuple[float, float]]:
    """Return the window of the load, cut at the end of a run; none where it changes neither mass nor inertia [s]."""
    load = scenario.load
    changes = load.mass_factor != 1.0 or load.inertia_factor != 1.0
    return windows([(load.start, load.stop)] if changes else [], end)


def windows(spans: Sequence[tuple[float, float]], end: float) -> list[tuple[float, float]]:
    """Return windows of time cut at the end of a run; those that begin later are left out [s]."""
    return [(start, min(stop, end)) for start, stop in spans if start < min(stop, end)]
