"""Facts about a scenario, computed without a run, for `dwmr show`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from dwmr.control import laws
from dwmr.control.fuzzy_gains import Rules
from dwmr.core.arrays import FloatArray
from dwmr.reference.prepared import Shape
from dwmr.scenario.file import ScenarioFile
from dwmr.scenario.graph import in_order
from dwmr.scenario.model import Robot, Scenario
from dwmr.scenario.outlines import largest_speed

#: Samples of the path, over the horizon or over one round of a closed path that is shorter.
SAMPLES = 4001


def facts(file: ScenarioFile, rules: Rules) -> dict[str, Any]:
    """Return the facts of a scenario as plain data.

    Raises:
        DiagnosticError: When a rule file that it names has mistakes.
    """
    scenario = file.scenario
    span = file.shape.period if 0.0 < file.shape.period < scenario.run.horizon else scenario.run.horizon
    t = np.linspace(0.0, span, SAMPLES)
    path = np.array(file.shape.along(t.tolist()))
    with np.errstate(all="ignore"):  # an overflow shows as infinite
        return _facts(file, rules, t, path)


def _facts(file: ScenarioFile, rules: Rules, t: FloatArray, path: FloatArray) -> dict[str, Any]:
    scenario = file.scenario
    return {
        "name": scenario.name,
        "files": [str(one) for one in file.files],
        "sha256": file.sha256,
        "run": scenario.run.model_dump(),
        "reference": _reference(file, t, path),
        "robots": [_robot(scenario, name, depth) for name, depth in in_order(scenario).items()],
        "formation": scenario.formation.model_dump(),
        "obstacles": [
            {**_obstacle(o.x, o.y, o.radius, file.shape, t, path), **({"speed": speed} if speed else {})}
            for o, speed in ((o, largest_speed(o)) for o in scenario.obstacles)
        ],
        "avoidance": scenario.avoidance.model_dump(),
        **({"safety": scenario.safety.model_dump()} if scenario.safety else {}),
        "disturbances": [one.model_dump() for one in sorted(scenario.disturbances, key=lambda d: d.start)],
        "load": scenario.load.model_dump(),
        "controllers": _controllers(scenario),
        "rules": {role: _rule(rules, role) for role in scenario.rules},
    }


def _robot(scenario: Scenario, name: str, depth: int) -> dict[str, Any]:
    robot = scenario.robots[name]
    edge = next(iter(robot.edges), None)
    several = {"neighbours": [one._asdict() for one in robot.edges]} if len(robot.edges) > 1 else {}
    return {
        "name": name,
        "depth": depth,
        "formation": robot.formation.kind if robot.formation else None,
        "leader": edge.leader if edge else None,
        "separation": edge.separation if edge else None,
        "bearing": edge.bearing if edge else None,
        **several,
        **({"reference": robot.reference.model_dump()} if robot.reference else {}),
        "delay": robot.delay,
        "start": [robot.x_0, robot.y_0, robot.theta_0],
        "d": robot.d,
        "mass": robot.mass,
        "avoids_obstacles": robot.avoids_obstacles,
        "sensors": robot.sensors.model_dump(),
        "noise": robot.noise.model_dump() if robot.noise else None,
    }


def _reference(file: ScenarioFile, t: FloatArray, path: FloatArray) -> dict[str, Any]:
    theta = np.unwrap(path[:, 2])
    rates = np.diff(theta) / np.diff(t)
    steps = np.hypot(np.diff(path[:, 0]), np.diff(path[:, 1]))
    facts = file.scenario.reference.model_dump()
    return {
        **{k: v for k, v in facts.items() if k != "points"},
        "length": float(steps.sum()),
        "time": float(t[-1]),
        "speed": [float(path[:, 3].min()), float(path[:, 3].max())],
        "turn_rate": [float(rates.min()), float(rates.max())],
        "x": [float(path[:, 0].min()), float(path[:, 0].max())],
        "y": [float(path[:, 1].min()), float(path[:, 1].max())],
        "straight_from": file.shape.end if file.shape.end < file.scenario.run.horizon else None,
    }


def _obstacle(x: float, y: float, radius: float, shape: Shape, t: FloatArray, path: FloatArray) -> dict[str, float]:
    """Return an obstacle with the distance of its centre from the path, and when the path is nearest."""
    k = int(np.argmin(np.hypot(path[:, 0] - x, path[:, 1] - y)))
    low, high = float(t[max(k - 1, 0)]), float(t[min(k + 1, len(t) - 1)])

    def gap(time: float) -> float:
        there = shape.at(time)
        return math.hypot(there.x - x, there.y - y)

    while high - low > 1e-6:
        third = (high - low) / 3.0
        low, high = (low, high - third) if gap(low + third) < gap(high - third) else (low + third, high)
    return {"x": x, "y": y, "radius": radius, "from_path": gap(0.5 * (low + high)), "at": 0.5 * (low + high)}


def _controllers(scenario: Scenario) -> dict[str, dict[str, Mapping[str, Any]]]:
    """Return the gains by law and robot."""
    tables: dict[str, dict[str, Mapping[str, Any]]] = {}
    for law in laws_of(scenario.robots.values()):
        for name, robot in scenario.robots.items():
            table = laws.table(robot.controllers, law)[1]
            if table is not None:
                tables.setdefault(law, {})[name] = table
    return tables


def laws_of(robots: Iterable[Robot]) -> tuple[str, ...]:
    """Return the names of the control laws that some robot has gains for."""
    tables: dict[str, None] = {}
    for robot in robots:
        tables |= dict.fromkeys(robot.controllers)
    return tuple(tables)


def _rule(rules: Rules, role: str) -> dict[str, Any]:
    output, count, params, low, high = rules.proved(role)
    facts: dict[str, Any] = {
        "file": str(rules.used[role].path),
        "sha256": rules.used[role].sha256,
        "files": dict(rules.used[role].files),
        "rules": count,
        "params": params,
        "output": output,
        "bounds": [low, high],
    }
    if {"k_h_min", "k_s"} <= params.keys():
        facts["g_ais_min"] = params["k_h_min"] - params["k_s"] * high
    return facts


def common(tables: Mapping[str, Mapping[str, Any]], names: Sequence[str]) -> dict[str, Any]:
    """Return the gains that all robots have in common."""
    first = tables[names[0]]
    return {k: v for k, v in first.items() if all(tables[n].get(k) == v for n in names)}
