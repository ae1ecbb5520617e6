"""Runs robots that change places behind the safety filter, and counts those that arrive.

python arrivals.py [--seeds N] [--scenes N] [--keep-right SHARE]
    swaps of 2, 4, 6 and 10 robots head-on, and random scenes of 10 robots and 5 obstacles
"""

from __future__ import annotations

import argparse
import math
import shutil
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from dwmr.control.fuzzy_gains import Known
from dwmr.results import metrics
from dwmr.scenario.file import ScenarioFile, read
from dwmr.simulation import simulate

#: The law, in a file beside this one.
LAW = "point"
#: A robot far from all others, at which everybody else has a place: it hardly moves [m, m/s].
FAR, SPEED = 200.0, 0.002
HORIZON = 120.0
SAFETY = (
    "alpha = 2.0, lookahead = 0.3, margin = 0.05, velocity_error = 0.1, acceleration = 2.0, angular_acceleration = 4.0"
)
#: Limits of the robots' commands [m/s, rad/s].
V_LIMIT, OMEGA_LIMIT = 1.0, 1.5
#: Half the side of the square of random scenes, and the least distances of starts and of places [m].
HALF, APART = 10.0, 3.0

Place = tuple[float, float, float]
#: Starts [m, m, rad], goals [m] and round obstacles [m, m, m].
Scene = tuple[list[Place], list[Any], list[Place]]
#: Rules that all scenes of a process share.
KNOWN = Known()


def text(starts: Sequence[Place], goals: Sequence[Any], obstacles: Sequence[Place], keep_right: float) -> str:
    """Return a scenario of robots that drive from starts [m, m, rad] to goals [m], among round obstacles [m, m, m]."""
    lines = [
        'extends = "paper-with-limits"', 'name = "arrivals"', "disturbances = []",
        "load = { mass_factor = 1.0, inertia_factor = 1.0 }",
        f'run = {{ controller = "{LAW}", horizon = {HORIZON}, dt = 0.01, save_every = 2 }}',
        f'reference = {{ kind = "line", start_x = {FAR}, start_y = 0.0, angle = 0.0, speed = {SPEED} }}',
        f"safety = {{ {SAFETY}, keep_right = {keep_right} }}",
        f"[robot.actuator]\nv_limit = {V_LIMIT}\nomega_limit = {OMEGA_LIMIT}",
        f"[robots.leader]\nx_0 = {FAR}\ny_0 = 0.0\ntheta_0 = 0.0\nd = 0.1\navoids_obstacles = false",
    ]  # fmt: skip
    for k, ((x, y, theta), goal) in enumerate(zip(starts, goals, strict=True), 1):
        away = np.subtract(goal, (FAR - 0.1, 0.0))
        lines += [
            f"[robots.follower{k}]", f"x_0 = {x:.6f}", f"y_0 = {y:.6f}", f"theta_0 = {theta:.6f}", "d = 0.3",
            "avoids_obstacles = false",
            f'formation = {{ leader = "leader", separation = {math.hypot(*away):.6f}, '
            f"bearing = {math.atan2(away[1], away[0]):.6f} }}",
        ]  # fmt: skip
    if len(starts) < 2:
        raise ValueError("the scenario that this one extends has two followers")
    rows = ", ".join(f"{{ x = {x:.6f}, y = {y:.6f}, radius = {r:.6f} }}" for x, y, r in obstacles)
    return "\n".join([f"obstacles = [{rows}]", *lines, ""])


def swap(robots: int, seed: int) -> Scene:
    """Return robots on a circle that change places with those opposite, with small deviations."""
    random, radius = np.random.default_rng([robots, seed]), max(5.0, 3.0 * robots / (2.0 * math.pi))
    angles = 2.0 * math.pi * np.arange(robots) / robots + random.normal(0.0, 0.02, robots)
    starts = [(radius * math.cos(a), radius * math.sin(a), a + math.pi + random.normal(0.0, 0.05)) for a in angles]
    return starts, [(-x, -y) for x, y, _ in starts], []


def crowd(number: int, robots: int = 10, obstacles: int = 5) -> Scene:
    """Return a random scene."""
    random = np.random.default_rng([7, number])
    round_ones = _places(random, obstacles, 3.0, ())
    rings = [(x, y, float(random.uniform(0.2, 0.6))) for x, y in round_ones]
    starts, goals = (_places(random, robots, APART, rings) for _ in range(2))
    return [(x, y, float(random.uniform(-math.pi, math.pi))) for x, y in starts], goals, rings


def _places(random: np.random.Generator, count: int, apart: float, rings: Sequence[Place]) -> list[Any]:
    """Draw places away from one another and from obstacles."""
    places: list[Any] = []
    while len(places) < count:
        one = tuple(float(value) for value in random.uniform(-HALF, HALF, 2))
        free = all(math.dist(one, ring[:2]) > ring[2] + 2.0 for ring in rings)
        if free and all(math.dist(one, other) > apart for other in places):
            places.append(one)
    return places


def run(scene: Scene, keep_right: float = 1.0) -> tuple[ScenarioFile, simulate.Trajectory]:
    """Run a scene as `dwmr` runs a file."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(Path(__file__).with_name(f"{LAW}.fz"), folder)
        path = Path(folder, "arrivals.toml")
        path.write_text(text(*scene, keep_right), encoding="utf-8")
        file = read(path)
        return file, simulate.simulate(file, LAW, known=KNOWN)


def outcome(scene: Scene, keep_right: float = 1.0) -> dict[str, Any]:
    """Run a scene: how many robots arrive, when the last one does [s], the least gap between bodies [m], moments."""
    file, trajectory = run(scene, keep_right)
    wanted = ("arrival", "obstacle_gap", "robot_gap", "safety")
    measures = metrics.measure(trajectory, file.scenario, wanted)
    arrivals = [one for name, one in measures["arrival"].items() if name != "leader"]
    gaps = [gap for kind in wanted[1:3] for gap in measures[kind].values() if gap is not None]
    return {
        "robots": len(arrivals), "arrived": sum(one["reached"] for one in arrivals), "gap": min(gaps),
        "last": max((one["t"] for one in arrivals if one["reached"]), default=math.nan),
        "moments": sum(len(measures["safety"][kind]) for kind in ("infeasible", "missed")),
    }  # fmt: skip


def described(title: str, outcomes: Sequence[dict[str, Any]]) -> str:
    """Describe scenes of one kind."""
    whole = sum(one["arrived"] == one["robots"] for one in outcomes)
    robots, arrived, moments = (sum(one[key] for one in outcomes) for key in ("robots", "arrived", "moments"))
    return (
        f"{title}: all arrive in {whole} of {len(outcomes)}, {arrived} of {robots} robots, the last one after "
        f"{max(one['last'] for one in outcomes):.1f} s; least gap {min(one['gap'] for one in outcomes):.3f} m, "
        f"{moments} moments without a barrier"
    )


def main() -> None:
    """Count arrivals."""
    options = argparse.ArgumentParser()
    options.add_argument("--seeds", type=int, default=8)
    options.add_argument("--scenes", type=int, default=100)
    options.add_argument("--keep-right", type=float, default=1.0)
    chosen = options.parse_args()
    kinds = {f"{n} robots head-on": [swap(n, seed) for seed in range(chosen.seeds)] for n in (2, 4, 6, 10)}
    kinds["10 robots, 5 obstacles"] = [crowd(number) for number in range(chosen.scenes)]
    with ProcessPoolExecutor() as pool:
        for title, scenes in kinds.items():
            if scenes:
                work = partial(outcome, keep_right=chosen.keep_right)
                print(described(title, list(pool.map(work, scenes, chunksize=4))), flush=True)


if __name__ == "__main__":
    main()
