"""Measures of a run: tracking errors by several definitions, distances, contacts, chattering, avoidance, limits."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Iterable
from functools import cache
from typing import Any

import numpy as np

from dwmr.control import laws
from dwmr.core.arrays import FloatArray
from dwmr.core.geometry import wrap_array
from dwmr.results import lyapunov
from dwmr.results.distances import contact, obstacle_gaps, robot_gaps, safety_measures
from dwmr.scenario.model import Robot, Scenario
from dwmr.scenario.outlines import centres
from dwmr.simulation.simulate import Trajectory

#: Duration of the runs behind Table 12 [s] (section 7); errors of a shorter run are no counterpart of it.
TABLE_12_HORIZON = 200.0

#: Goto, Bertol, Martins, Table 12: RMSE of x_e [m], y_e [m], theta_e [rad] with disturbances and obstacles.
TABLE_12: dict[str, dict[str, dict[str, float]]] = {
    controller: {
        robot: dict(zip(("x_e", "y_e", "theta_e"), row, strict=True))
        for robot, row in zip(("leader", "follower1", "follower2"), rows, strict=True)
    }
    for controller, rows in {
        "smc": ((3.2309, 3.4591, 4.0197), (0.8302, 2.3546, 0.4170), (0.7973, 1.9537, 0.4404)),
        "aifqsmc": ((0.5399, 0.6988, 0.2327), (0.1298, 0.1340, 0.0318), (0.1008, 0.1114, 0.0206)),
        "fcafsmc": ((0.4519, 0.5694, 0.2546), (0.1806, 0.1883, 0.0528), (0.1456, 0.1693, 0.0427)),
    }.items()
}


#: The same, Table 13: AIFQSMC in Gazebo, to which no disturbance was added.
TABLE_13: dict[str, dict[str, dict[str, float]]] = {
    "aifqsmc": {
        "leader": {"x_e": 0.4604, "y_e": 0.5881, "theta_e": 0.2205},
        "follower1": {"x_e": 0.1532, "y_e": 0.2428, "theta_e": 0.1987},
        "follower2": {"x_e": 0.0999, "y_e": 0.1560, "theta_e": 0.0349},
    }
}

TABLES = {12: TABLE_12, 13: TABLE_13}

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
    stopped, and `steps` and `t_end` count all of its samples.

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
    result["steps"] = len(whole.t) - 1
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
        "obstacles_hit": lambda: [
            hit for n in names for hit in _obstacles_hit(run.t, scenario.run.dt, n, to_obstacles(n))
        ],
        "robots_hit": lambda: _robots_hit(run, scenario, pairs()),
        "chattering": lambda: {n: _chattering(run, scenario.run.dt, n) for n in names},
        "avoidance_s": lambda: {n: _share(run["obstacle"][:, i] >= 0) * _span(run) for i, n in enumerate(names)},
        "saturation": lambda: {n: _saturation(run, scenario, n) for n in names},
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


def _robots_hit(trajectory: Trajectory, scenario: Scenario, pairs: Pairs) -> list[dict[str, Any]]:
    """Return the pairs of robots whose bodies touch."""
    contacts = [((a, b), contact(trajectory.t[near], scenario.run.dt, gaps)) for a, b, near, gaps in pairs]
    return [{"robots": list(names), **one._asdict()} for names, one in contacts if one is not None]


def _chattering(trajectory: Trajectory, dt: float, robot: str) -> dict[str, float]:
    """Return the mean of |Δv_c|/Δt per channel [m/s², rad/s²]."""
    i = trajectory.robots.index(robot)
    result = {}
    for channel, signal in (("v", "v_c"), ("omega", "omega_c")):
        change = np.abs(np.diff(trajectory[signal][:, i]))
        result[channel] = float(change.mean() / dt) if change.size else 0.0
    return result


def _saturation(trajectory: Trajectory, scenario: Scenario, robot: str) -> dict[str, float]:
    """Return the shares of time in which the commanded velocities and the torques reach their limits [-]."""
    i, limits = trajectory.robots.index(robot), scenario.robots[robot].actuator
    torque = np.maximum(np.abs(trajectory["torque_right"][:, i]), np.abs(trajectory["torque_left"][:, i]))
    return {
        "v": _share(np.abs(trajectory["v_c"][:, i]) > limits.v_limit),
        "omega": _share(np.abs(trajectory["omega_c"][:, i]) > limits.omega_limit),
        "torque": _share(torque >= limits.torque_limit),
    }


def _condition_violated(trajectory: Trajectory, scenario: Scenario, robot: str) -> float:
    """Return the share of time in which λ2/λ3 <= 1/(|d + x_e| + 1) does not hold [-].

    Source:
        Goto, Bertol, Martins, the condition after Eq. (13).
    """
    _, settings = laws.table(scenario.robots[robot].controllers, trajectory.controller)
    lambda_2, lambda_3 = getattr(settings, "lambda_2", None), getattr(settings, "lambda_3", None)
    if lambda_2 is None or lambda_3 is None:  # a law without these surfaces
        return 0.0
    i = trajectory.robots.index(robot)
    reach = np.abs(scenario.robots[robot].d + trajectory["x_e"][:, i])
    return _share(lambda_2 / lambda_3 > 1.0 / (reach + 1.0))


#: Keys of a robot that the paper prints; the others are fitted to its table.
_PRINTED = ("x_0", "y_0", "theta_0", "d", "radius", "avoids_obstacles", "formation", "delay", "sensors", "noise")
#: Keys of a robot that its errors do not depend on, or by design may differ: the measures' outline, the gains.
_FREE = ("body", "controllers")
#: Numbers of the paper's tables by the shipped scenario of their runs.
_TABLES = {
    "paper": 12,
    "paper-with-limits": 12,
    "paper-constant-gain": 12,
    "paper-ideal-loop": 12,
    "undisturbed": 13,
    "experiment": 13,
}
#: Keys that are listed before the rest is counted.
_MOST_SHOWN = 4


def differences(scenario: Scenario, fitted: bool = False, shipped: str = "paper") -> tuple[str, ...]:
    """Return the keys in which a run is not the paper's, its gains and rule files aside.

    Args:
        scenario: The scenario.
        fitted: Whether unprinted values may differ: amplitudes, bodies and drives.
        shipped: Name of the scenario that is the paper's run.
    """
    from dwmr.scenario.file import find, read

    paper = read(find(shipped)).scenario
    keys = [
        key
        for key in ("reference", "formation", "obstacles", "avoidance", "load")
        if getattr(scenario, key) != getattr(paper, key)
    ]
    keys += [f"run.{key}" for key in ("horizon", "plant") if getattr(scenario.run, key) != getattr(paper.run, key)]
    if _disturbances(scenario, fitted) != _disturbances(paper, fitted):
        keys.append("disturbances")
    return (*keys, *_robots(scenario, paper, fitted))


def beside(scenario: Scenario) -> tuple[int | None, str]:
    """Return the number of the paper's table that errors are shown beside, and why of none where one is expected."""
    number = _TABLES.get(scenario.name)
    if number is None or scenario.run.horizon < TABLE_12_HORIZON:
        return None, ""
    keys = differences(scenario, shipped=scenario.name)
    return (None, f"Table {number} is left out, it speaks of another run: {said(keys)}") if keys else (number, "")


def said(keys: tuple[str, ...]) -> str:
    """Return that some keys are not the paper's."""
    text = ", ".join(keys[:_MOST_SHOWN])
    more = f" and {len(keys) - _MOST_SHOWN} more" if len(keys) > _MOST_SHOWN else ""
    verb = "is" if len(keys) == 1 and keys[0] not in ("obstacles", "disturbances") else "are"
    return f"{text}{more} {verb} not the paper's"


def _disturbances(scenario: Scenario, fitted: bool) -> list[Any]:
    if not fitted:
        return list(scenario.disturbances)
    return [(one.kind, one.start, one.stop, one.robots) for one in scenario.disturbances]


def _robots(scenario: Scenario, paper: Scenario, fitted: bool) -> Iterable[str]:
    """Give the keys of the paper's robots that differ, and the names of robots that it has not."""
    keys = _PRINTED if fitted else tuple(k for k in Robot.model_fields if k not in _FREE)
    for name in dict.fromkeys((*paper.robots, *scenario.robots)):
        if name not in paper.robots or name not in scenario.robots:
            yield f"robots.{name}"
            continue
        mine, theirs = scenario.robots[name], paper.robots[name]
        yield from (f"robots.{name}.{key}" for key in keys if getattr(mine, key) != getattr(theirs, key))
