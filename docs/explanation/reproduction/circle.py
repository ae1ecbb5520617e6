"""Runs the formation on a circle that it starts far from, and prints what AIFQSMC's gain and error become.

python circle.py
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TypeVar

import numpy as np

from dwmr.control.fuzzy_gains import Rules
from dwmr.scenario.file import ScenarioFile, read
from dwmr.scenario.model import Obstacle
from dwmr.simulation import simulate

T = TypeVar("T", float, np.ndarray)
Starts = Mapping[str, tuple[float, float, float]]

SCENARIO = Path(__file__).with_name("circle.toml")
#: When the errors are looked at: at the end of the run of 200 s [s].
LATE = 150.0
VARIANTS: dict[str, tuple[str, tuple[str, ...]]] = {
    "as it is": ("aifqsmc", ()),
    "drives of 1 ms lag": ("aifqsmc", ("robot.actuator.lag=0.001",)),
    "k_h that does not adapt": ("aifqsmc_without_adaptation", ()),
    "control period of 1 ms": ("aifqsmc", ("run.dt=0.001",)),
}
#: Starts near the circle for the turned scenes: x_0, y_0 [m], theta_0 [rad].
NEAR = {
    "leader": (7.0, 0.0, 0.5 * math.pi),
    "follower1": (8.0, -2.0, 0.5 * math.pi),
    "follower2": (6.0, -2.0, 0.5 * math.pi),
}
#: A place beside the circle [m], passed at 15 s, and the angles by which the scene is turned [rad].
OBSTACLE = (0.2, 8.3)
ANGLES = (0.7, 1.0)


def run(file: ScenarioFile, law: str) -> simulate.Trajectory:
    """Run a scenario under a control law."""
    return simulate.run(simulate.prepare(file, law, Rules(file.scenario.rules, file.folders, file.places)))


def late(law: str, overrides: tuple[str, ...]) -> dict[str, float]:
    """Return the last k̂_h of the leader [rad/s], follower1's largest |x_e| [m] and its share of time at a limit."""
    file = read(SCENARIO, overrides)
    trajectory = run(file, law)
    seen, leader, follower = (trajectory.t >= LATE, *map(trajectory.robots.index, ("leader", "follower1")))
    limit = file.scenario.robots["follower1"].actuator.torque_limit
    torques = np.abs([trajectory[name][seen, follower] for name in ("torque_right", "torque_left")])
    return {
        "k_h": float(trajectory["k_h_omega"][-1, leader]),
        "x_e": float(np.abs(trajectory["x_e"][seen, follower]).max()),
        "at_limit": float((torques >= limit).any(axis=0).mean()),
    }


def turned_by(angle: float, law: str, starts: Starts) -> simulate.Trajectory:
    """Run the scene with one obstacle, all of it turned about the origin by an angle [rad]."""
    file = read(SCENARIO, [f"reference.start_angle={angle!r}", "run.horizon=30.0"])
    robots = {}
    for name, start in starts.items():
        x_0, y_0 = turned(start[0], start[1], angle)
        place = {"x_0": x_0, "y_0": y_0, "theta_0": start[2] + angle}
        robots[name] = file.scenario.robots[name].model_copy(update=place)
    x, y = turned(*OBSTACLE, angle)
    scene = {"robots": robots, "obstacles": (Obstacle(x=x, y=y, radius=0.5),)}
    return run(dataclasses.replace(file, scenario=file.scenario.model_copy(update=scene)), law)


def turned(x: T, y: T, angle: float) -> tuple[T, T]:
    """Return a place turned about the origin [m]."""
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


def differences(law: str, starts: Starts) -> Iterator[float]:
    """Yield by how much the paths of turned scenes differ up to 15 s and up to 30 s, after turning them back [m]."""
    usual = turned_by(0.0, law, starts)
    gaps = []
    for angle in ANGLES:
        other = turned_by(angle, law, starts)
        x, y = turned(usual["x"], usual["y"], angle)
        gaps.append(np.hypot(x - other["x"], y - other["y"]).max(axis=1))
    for until in (15.0, 30.0):
        yield max(float(gap[usual.t <= until].max()) for gap in gaps)


def main() -> None:
    """Print both tables."""
    for name, (law, overrides) in VARIANTS.items():
        one = late(law, overrides)
        print(
            f"{name}: the leader's k_h is {one['k_h']:.1f} rad/s, follower1's |x_e| up to {one['x_e']:.3f} m, a wheel "
            f"of it at its torque limit for {100.0 * one['at_limit']:.0f} % of the time",
            flush=True,
        )
    robots = read(SCENARIO).scenario.robots
    far = {name: (robot.x_0, robot.y_0, robot.theta_0) for name, robot in robots.items()}
    for where, starts in (("near", NEAR), ("far", far)):
        for law in ("aifqsmc", "fcafsmc", "smc"):
            first, later = differences(law, starts)
            print(
                f"turned, begun {where}, {law}: paths differ by up to {first:.0e} m in 15 s, {later:.0e} m in 30 s",
                flush=True,
            )


if __name__ == "__main__":
    main()
