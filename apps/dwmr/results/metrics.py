"""Measures of a run: tracking errors by several definitions, distances, contacts, chattering, avoidance, limits."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection
from functools import cache
from typing import Any

import numpy as np

from dwmr.control import laws
from dwmr.core.arrays import FloatArray
from dwmr.core.geometry import wrap_array
from dwmr.results import lyapunov
from dwmr.results.distances import contact, obstacle_gaps, robot_gaps, safety_measures
from dwmr.scenario.model import FAST, SETTLING, Scenario
from dwmr.scenario.outlines import centres
from dwmr.simulation.simulate import Trajectory

#: Names of two robots, samples, and the gaps between their bodies at these [m].
Pairs = list[tuple[str, str, Any, FloatArray]]


def rmse(error: FloatArray) -> float:
    """Return the root mean square of the samples of an error, of any shape, in the error's unit.

    Source:
        Goto, Bertol, Martins, section 7.
    """
    return float(np.sqrt(np.mean(np.square(error))))


def errors(trajectory: Trajectory, robot: str, frame: str) -> dict[str, FloatArray]:
    """Return the tracking errors of a robot, each of shape (samples,).

    Args:
        trajectory: A run.
        robot: Name of the robot.
        frame: "body" for the robot's frame, Eqs. (4) and (49); "inertial" for x_r − x and y_r − y.

    Returns:
        x_e, y_e [m]; theta_e = θ_r − θ and theta_e_star = θ*_r − θ, wrapped [rad]; theta_e_unwrapped, which counts full
        turns [rad].
    """
    i = trajectory.robots.index(robot)
    theta, theta_r = trajectory["theta"][:, i], trajectory["theta_r"][:, i]
    if frame == "body":
        x_e, y_e = trajectory["x_e"][:, i], trajectory["y_e"][:, i]
    else:
        x_e = trajectory["x_r"][:, i] - trajectory["x"][:, i]
        y_e = trajectory["y_r"][:, i] - trajectory["y"][:, i]
    return {
        "x_e": x_e,
        "y_e": y_e,
        "theta_e": wrap_array(theta_r - theta),
        "theta_e_star": wrap_array(trajectory["theta_r_star"][:, i] - theta),
        "theta_e_unwrapped": np.unwrap(theta_r) - theta,
    }


def printed_frame(scenario: Scenario, robot: str) -> str:
    """Return the frame in which Table 12 measures a robot: inertial for one that follows the reference, else body."""
    return "inertial" if scenario.robots[robot].formation is None else "body"


def measure(trajectory: Trajectory, scenario: Scenario, wanted: Collection[str] | None = None) -> dict[str, Any]:
    """Return the measures of a run as plain data, ready for summary.json.

    A run that stopped early is measured up to its last sample [s] that is finite in all signals; `stopped` says why it
    stopped, and `steps` and `t_end` count all of its periods.

    Args:
        trajectory: A run.
        scenario: Its scenario.
        wanted: Names of the measures, None for all; some cost as much as the run. How the run ended is always there.
    """
    whole, trajectory = trajectory, finite_part(trajectory)
    # numbers of a run that diverged may overflow; infinite ones show as null
    with np.errstate(over="ignore", invalid="ignore"):
        result = {
            name: of() for name, of in _measures(trajectory, scenario).items() if wanted is None or name in wanted
        }
        if wanted is None or {"lyapunov", "drift"} & set(wanted):
            result |= lyapunov.measure(trajectory, scenario)
    if (wanted is None or "safety" in wanted) and scenario.safety is not None:
        result["safety"] = safety_measures(trajectory, scenario, scenario.safety)
    if "g_ais_v" in trajectory.names:
        result["g_ais_min"] = float(min(trajectory["g_ais_v"].min(), trajectory["g_ais_omega"].min()))
    result["steps"] = round(whole.every * whole.t[-1] / whole.step)
    result["record_every"] = whole.every
    result["t_end"] = float(whole.t[-1])
    result["stopped"] = None
    if trajectory.stop is not None:
        stop = trajectory.stop
        result["stopped"] = {"t": stop.t, "robot": stop.robot or None, "reason": stop.reason}
    result["wall_s"] = trajectory.wall_s
    return result


def finite_part(trajectory: Trajectory) -> Trajectory:
    """Return a run up to its last sample that is finite in all signals.

    One that came to its end, or has no such sample, is returned whole.
    """
    if trajectory.stop is None:
        return trajectory
    values, law_values = trajectory.values, trajectory.law_values
    finite = np.flatnonzero(np.isfinite(values).all(axis=(1, 2)) & np.isfinite(law_values).all(axis=(1, 2)))
    if not finite.size:
        return trajectory
    end = int(finite[-1]) + 1
    return dataclasses.replace(trajectory, t=trajectory.t[:end], values=values[:end], law_values=law_values[:end])


def _measures(run: Trajectory, scenario: Scenario) -> dict[str, Callable[[], Any]]:
    """Return how to compute each measure."""
    names = run.robots
    pairs = cache(lambda: list(robot_gaps(run, scenario)))
    to_obstacles = cache(lambda robot: obstacle_gaps(run, scenario, robot))
    return {
        "rmse": lambda: {n: _rmse(run, n, printed_frame(scenario, n)) for n in names},
        "rmse_body": lambda: {n: _rmse(run, n, "body") for n in names},
        "rmse_inertial": lambda: {n: _rmse(run, n, "inertial") for n in names},
        "centre_distance": lambda: {n: _least([distances(run, scenario, n)]) for n in names},
        "obstacle_gap": lambda: {n: _least([to_obstacles(n)]) for n in names},
        "robot_gap": lambda: {n: _least([gaps for a, b, _, gaps in pairs() if n in (a, b)]) for n in names},
        "obstacles_hit": lambda: [hit for n in names for hit in _obstacles_hit(run.t, run.step, n, to_obstacles(n))],
        "robots_hit": lambda: _robots_hit(run, pairs()),
        "arrival": lambda: {n: _arrival(run, scenario, n) for n in names},
        "chattering": lambda: {n: _chattering(run, run.step, n) for n in names},
        "chattering_outside": lambda: _chattering_outside(run, run.step),
        "avoidance_switches": lambda: {n: _switches(run["obstacle"][:, i] >= 0) for i, n in enumerate(names)},
        "avoidance_s": lambda: {n: _share(run["obstacle"][:, i] >= 0) * _span(run) for i, n in enumerate(names)},
        "saturation": lambda: {n: _saturation(run, scenario, n) for n in names},
        "energy": lambda: {n: _energy(run, scenario, n) for n in names},
        "amplification": lambda: _amplification(run, scenario),
        "condition_violated": lambda: {n: _condition_violated(run, scenario, n) for n in names},
    }


def _rmse(trajectory: Trajectory, robot: str, frame: str) -> dict[str, float]:
    return {name: rmse(error) for name, error in errors(trajectory, robot, frame).items()}


def _span(trajectory: Trajectory) -> float:
    return float(trajectory.t[-1] - trajectory.t[0])


def _share(where: Any) -> float:
    return float(np.mean(where))


def distances(trajectory: Trajectory, scenario: Scenario, robot: str) -> FloatArray:
    """Return the distance of a robot's reference point from every obstacle's centre, shape (samples, obstacles) [m].

    Source:
        Goto, Bertol, Martins, Eq. (56).
    """
    i = trajectory.robots.index(robot)
    at = centres(scenario, trajectory.t)
    gap: FloatArray = np.hypot(trajectory["x"][:, i, None] - at[:, :, 0], trajectory["y"][:, i, None] - at[:, :, 1])
    return gap


def _least(gaps: list[FloatArray]) -> float | None:
    """Return the least of some distances, None without any [m]."""
    return min((float(one.min()) for one in gaps if one.size), default=None)


def _obstacles_hit(t: FloatArray, dt: float, robot: str, gaps: FloatArray) -> list[dict[str, Any]]:
    """Return the obstacles that a robot's body touches, from its gaps to them."""
    contacts = [contact(t, dt, gaps[:, a]) for a in range(gaps.shape[1])]
    return [{"robot": robot, "obstacle": a, **one._asdict()} for a, one in enumerate(contacts) if one is not None]


def _robots_hit(trajectory: Trajectory, pairs: Pairs) -> list[dict[str, Any]]:
    """Return the pairs of robots whose bodies touch."""
    contacts = [((a, b), contact(trajectory.t[near], trajectory.step, gaps)) for a, b, near, gaps in pairs]
    return [{"robots": list(names), **one._asdict()} for names, one in contacts if one is not None]


def _arrival(trajectory: Trajectory, scenario: Scenario, robot: str) -> dict[str, Any]:
    """Return whether a robot is at its place at the end, the time since when [s], and its last distance from it [m].

    The place is that on the reference, for a follower that in the formation. A run that stopped has no arrivals.
    """
    far = np.hypot(*(errors(trajectory, robot, "inertial")[name] for name in ("x_e", "y_e")))
    away = np.flatnonzero(~(far <= scenario.run.arrival))
    first = int(away[-1]) + 1 if away.size else 0
    reached = trajectory.stop is None and first < len(far)
    return {"reached": reached, "t": float(trajectory.t[first]) if reached else None, "distance": float(far[-1])}


def _chattering(trajectory: Trajectory, dt: float, robot: str, where: Any = slice(None)) -> dict[str, float]:
    """Return the mean of |Δv_c|/Δt per channel over all steps or some of them [m/s², rad/s²]."""
    i = trajectory.robots.index(robot)
    result = {}
    for channel, signal in (("v", "v_c"), ("omega", "omega_c")):
        change = np.abs(np.diff(trajectory[signal][:, i]))[where]
        result[channel] = float(change.mean() / dt) if change.size else 0.0
    return result


def _chattering_outside(trajectory: Trajectory, dt: float) -> dict[str, dict[str, float] | None]:
    """Return the chattering of each robot while none avoids, nor within `SETTLING`; None where that is never so."""
    avoids = np.flatnonzero((trajectory["obstacle"] >= 0).any(axis=1))
    steps, margin = np.arange(len(trajectory.t) - 1), round(SETTLING / dt)
    near = np.searchsorted(avoids, steps + 1 + margin, "right") > np.searchsorted(avoids, steps - margin)
    return {n: None if near.all() else _chattering(trajectory, dt, n, ~near) for n in trajectory.robots}


def _switches(avoids: Any) -> dict[str, int]:
    """Return how often an avoidance begins or ends, and how often within `FAST` periods of the switch before."""
    at = np.flatnonzero(np.diff(avoids.astype(np.int8)))
    return {"all": int(at.size), "fast": int((np.diff(at) <= FAST).sum())}


def _saturation(trajectory: Trajectory, scenario: Scenario, robot: str) -> dict[str, float]:
    """Return the shares of time in which the commanded velocities and the torques reach their limits [-]."""
    i, limits = trajectory.robots.index(robot), scenario.robots[robot].actuator
    torque = np.maximum(np.abs(trajectory["torque_right"][:, i]), np.abs(trajectory["torque_left"][:, i]))
    return {
        "v": _share(np.abs(trajectory["v_c"][:, i]) > limits.v_limit),
        "omega": _share(np.abs(trajectory["omega_c"][:, i]) > limits.omega_limit),
        "torque": _share(torque >= limits.torque_limit),
    }


def _energy(trajectory: Trajectory, scenario: Scenario, robot: str) -> float:
    """Return the energy of the commanded torques at two wheels, braking counted as driving [J]."""
    i, wheels = trajectory.robots.index(robot), scenario.robots[robot]
    turning = wheels.half_track * trajectory["omega"][:, i]
    power = sum(
        np.abs(trajectory[f"torque_{side}"][:, i] * (trajectory["v"][:, i] + sign * turning))
        for side, sign in (("right", 1.0), ("left", -1.0))
    )
    return float(np.mean(power)) / wheels.wheel_radius * _span(trajectory)


def _amplification(trajectory: Trajectory, scenario: Scenario) -> dict[str, float | None]:
    """Return the error of each follower over that of its leader, root mean squares of the distances from their places.

    Of several leaders the weighted mean counts. None for leaders without an error.

    Source:
        Swaroop, Hedrick, String stability of interconnected systems, IEEE Transactions on Automatic Control 41, 1996.
    """
    places = zip(trajectory.robots, trajectory["x_e"].T, trajectory["y_e"].T, strict=True)
    far = {name: rmse(np.hypot(x_e, y_e)) for name, x_e, y_e in places}
    ahead = {
        name: sum(one.weight * far[one.leader] for one in robot.edges if one.leader is not None)
        for name, robot in scenario.robots.items()
        if robot.leaders
    }
    return {name: far[name] / before if before > 0.0 else None for name, before in ahead.items()}


def _condition_violated(trajectory: Trajectory, scenario: Scenario, robot: str) -> float:
    """Return the share of time in which λ2/λ3 <= 1/(|d + x_e| + 1) does not hold [-].

    Source:
        Goto, Bertol, Martins, the condition after Eq. (13).
    """
    _, gains = laws.table(scenario.robots[robot].controllers, trajectory.controller)
    lambda_2, lambda_3 = ((gains or {}).get(name) for name in ("lambda_2", "lambda_3"))
    if not isinstance(lambda_2, int | float) or not isinstance(lambda_3, int | float) or lambda_3 <= 0.0:
        return 0.0  # a law without these surfaces
    i = trajectory.robots.index(robot)
    reach = np.abs(scenario.robots[robot].d + trajectory["x_e"][:, i])
    return _share(lambda_2 / lambda_3 > 1.0 / (reach + 1.0))
