"""Runs of `experiment` with other bodies and sensors beside Table 13; writes readings.json.

    python docs/explanation/experiment/readings.py [--rows]

takes some minutes and needs the extra `physics`. With --rows it prints the tables of the page from readings.json.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dwmr.control.fuzzy_gains import Rules
from dwmr.core.geometry import wrap_array
from dwmr.results.metrics import measure, rmse
from dwmr.results.paper_tables import TABLE_12_HORIZON, TABLE_13
from dwmr.scenario.file import find, read
from dwmr.simulation import simulate

RESULTS = Path(__file__).with_name("readings.json")
NAMES = ("x_e", "y_e", "theta_e")
NOISE = tuple(f"robot.noise.{name}=0.01" for name in ("x", "y", "theta", "v", "omega"))


def drives(omega_limit: float, angular_acceleration: float) -> tuple[str, ...]:
    """Return the settings of drives that turn no faster than two limits [rad/s, rad/s²]."""
    keys = {"omega_limit": omega_limit, "angular_acceleration": angular_acceleration}
    return tuple(f"robot.actuator.{key}={value:g}" for key, value in keys.items())


#: Limits of drives: angular velocities [rad/s] and accelerations [rad/s²]; the vendor's simulator has 1.74 of both.
TURNING = (0.8, 0.9, 1.0, 1.05, 1.1, 1.2, 1.4, 1.74, 3.0, 6.28)
SLEWING = (1.0, 1.74, 3.0, 5.0, 10.0)
#: A run of the equations for each pair.
GRID = {
    f"the equations, {w:g} rad/s, {a:g} rad/s²": ("run.plant=equations", *drives(w, a))
    for w in TURNING
    for a in SLEWING
}
#: Name of each reading, and its settings of `experiment`.
READINGS: dict[str, tuple[str, ...]] = {
    "the equations": ("run.plant=equations",),
    "as shipped": (),
    "half the step": ("run.substeps=8",),
    "friction of the wheels 0.4": ("robot.rigid_body.wheel_friction=0.4",),
    "friction of the wheels 0.3": ("robot.rigid_body.wheel_friction=0.3",),
    "spin friction 0.02 m": ("robot.rigid_body.wheel_spin_friction=0.02",),
    "leader's velocity from its wheels": ("formation.leader_velocity=wheels",),
    "encoders of 20,000 steps": ("robot.sensors.encoder_steps=20000",),
    "encoders of 2000 steps": ("robot.sensors.encoder_steps=2000",),
    "odometry": ("robot.sensors.pose=odometry",),
    "noise of 1 cm, 0.01 rad, 0.01 m/s, 0.01 rad/s": NOISE,
    "follower1 turned by 2.7 rad at its start": ("robots.follower1.theta_0=2.7",),
    "drives of 1 rad/s, 1.74 rad/s²": drives(1.0, 1.74),
    "drives of 1.05 rad/s, 1.74 rad/s²": drives(1.05, 1.74),
    "drives of 1.05 rad/s, 1.74 rad/s², half the step": (*drives(1.05, 1.74), "run.substeps=8"),
    "drives of 1.1 rad/s, 1.74 rad/s²": drives(1.1, 1.74),
    "drives of 1.2 rad/s, 1.74 rad/s²": drives(1.2, 1.74),
    "drives of 1.74 rad/s, 1.74 rad/s²": drives(1.74, 1.74),
    "drives of 1.74 rad/s, 1.74 rad/s², 0.6 m/s²": (*drives(1.74, 1.74), "robot.actuator.acceleration=0.6"),
    **GRID,
}


def run(overrides: Sequence[str]) -> dict[str, Any]:
    """Return the errors of one run by robot, its contacts, and its largest slip [m/s]."""
    file = read(find("experiment"), overrides)
    rules = Rules(file.scenario.rules, file.folders, file.places)
    trajectory = simulate.run(simulate.prepare(file, "aifqsmc", rules))
    measured = measure(trajectory, file.scenario, ("rmse", "robots_hit"))
    errors = {robot: {name: round(row[name], 5) for name in NAMES} for robot, row in measured["rmse"].items()}
    for i, robot in enumerate(trajectory.robots):
        theta, theta_r = trajectory["theta"][:, i], trajectory["theta_r"][:, i]
        apart = {
            "pi": wrap_array(theta_r) - wrap_array(theta),
            "two_pi": np.mod(theta_r, 2.0 * np.pi) - np.mod(theta, 2.0 * np.pi),
        }
        errors[robot] |= {name: round(rmse(error), 5) for name, error in apart.items()}
        errors[robot]["two_pi_s"] = round(float((np.abs(apart["two_pi"]) > np.pi).sum()) * file.scenario.run.dt, 3)
    return {
        "stopped": trajectory.stop is not None,
        "errors": errors,
        "robots_hit": len(measured["robots_hit"]),
        "slip": round(float(np.abs(trajectory["d_v"]).max()), 3),
    }


def rows(results: dict[str, Any]) -> Iterator[str]:
    """Yield the rows of the page's tables: errors by reading, missing errors of followers, angles by measurement."""
    printed = TABLE_13["aifqsmc"]
    yield _row("Table 13", printed, "")
    for name, one in results.items():
        if name not in GRID:
            yield _row(name, one["errors"], str(one["robots_hit"]))
    yield ""
    for robot in ("follower1", "follower2"):
        for name, symbol, unit in (("x_e", "x_e", "m"), ("y_e", "y_e", "m"), ("theta_e", "θ_e", "rad")):
            table, ours = printed[robot][name], results["as shipped"]["errors"][robot][name]
            more = (table**2 - ours**2) * TABLE_12_HORIZON
            yield f"| {robot} | {symbol} | {table:.3f} {unit} | {ours:.3f} {unit} | {more:.1f} {unit}² s |"
    yield ""
    for name in ("the equations", "as shipped"):
        for robot, row in results[name]["errors"].items():
            cells = [f"{value:.3f}" for value in (printed[robot]["theta_e"], row["theta_e"], row["pi"], row["two_pi"])]
            yield f"| {name} | {robot} | {' | '.join(cells)} | {row['two_pi_s']:.2f} s |"


def nearness(errors: dict[str, Any]) -> tuple[int, float]:
    """Return how many of nine ratios to Table 13 are within 35 % of 1, and the root mean square of their logarithms."""
    ratios = [errors[robot][name] / row[name] for robot, row in TABLE_13["aifqsmc"].items() for name in NAMES]
    return sum(abs(one - 1.0) <= 0.35 for one in ratios), rmse(np.log(ratios))


def grid_rows(results: dict[str, Any]) -> Iterator[str]:
    """Yield the rows of the tables of limits: ratios within 35 %, root mean square of their logarithms, a θ_e."""
    for name in ("as shipped", *(name for name in results if name.startswith("drives of"))):
        yield f"| {name} | {_cell(results[name]['errors'])} |"
    yield ""
    for w in TURNING:
        cells = [_cell(results[f"the equations, {w:g} rad/s, {a:g} rad/s²"]["errors"]) for a in SLEWING]
        yield f"| {w:g} rad/s | {' | '.join(cells)} |"


def _cell(errors: dict[str, Any]) -> str:
    near, spread = nearness(errors)
    return f"{near}, {spread:.2f}, {errors['follower1']['theta_e']:.3f}"


def _row(name: str, errors: dict[str, Any], last: str) -> str:
    cells = [" ".join(f"{errors[robot][key]:.3f}" for key in NAMES) for robot in TABLE_13["aifqsmc"]]
    return f"| {name} | {' | '.join(cells)} | {last} |"


def main() -> None:
    """Run all readings, or print the rows."""
    if "--rows" in sys.argv[1:]:
        results = json.loads(RESULTS.read_text(encoding="utf-8"))
        print("\n".join((*rows(results), "", *grid_rows(results))))
        return
    done = {name: run(overrides) for name, overrides in READINGS.items()}
    part = RESULTS.with_suffix(".part")
    part.write_text(json.dumps(done, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    part.replace(RESULTS)


if __name__ == "__main__":
    main()
