"""Runs five robots among five moving obstacles behind the safety filter, and counts collisions and infeasible moments.

python crowds.py [--scenes N] [--seed N] [--law LAW]
    draws random scenes and prints what became of them
python crowds.py --free [--scenes N] [--seed N] [--law LAW]
    counts those in which somebody is touched without the filter
python crowds.py --scene K [--seed N] [--law LAW]
    prints the scenario of one of them, to be run with dwmr
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from dwmr.control.fuzzy_gains import Rules
from dwmr.results.distances import obstacle_gaps, robot_gaps, safety_measures
from dwmr.scenario.file import ScenarioFile, read
from dwmr.simulation import simulate

ROBOTS = OBSTACLES = 5
#: Half the side of the square in which all begin [m].
HALF = 8.0
HORIZON = 30.0
#: Settings of the filter of all scenes.
SAFETY = {
    "alpha": 2.0, "lookahead": 0.3, "margin": 0.05, "velocity_error": 0.1,
    "acceleration": 2.0, "angular_acceleration": 4.0,
}  # fmt: skip
#: Least distance at the start: between robots, and between a robot and an obstacle's surface [m].
ROBOTS_APART, FROM_OBSTACLE = 3.0, 2.0
#: Limits of the robots' commands [m/s, rad/s].
V_LIMIT, OMEGA_LIMIT = 1.0, 1.5
FASTEST_OBSTACLE = 0.4


def scene(number: int, seed: int = 0, law: str = "aifqsmc") -> str:
    """Return the text of a random scenario: robots that change places, obstacles on straight and bent ways."""
    random = np.random.default_rng([seed, number])
    robots, obstacles = _starts(random)
    goal = random.uniform(-HALF, HALF, 2)
    speed = random.uniform(0.3, 0.6)
    lines = [
        'extends = "paper-with-limits"', f'name = "crowd-{seed}-{number}"',
        f'run = {{ controller = "{law}", horizon = {HORIZON}, save_every = 4 }}',
        f'reference = {{ kind = "waypoints", points = [{_point(robots[0])}, {_point(goal)}], '
        f"speed = {speed:.3f} }}",
        "disturbances = []", "load = { mass_factor = 1.0, inertia_factor = 1.0 }",
        f"safety = {{ {', '.join(f'{key} = {value}' for key, value in SAFETY.items())} }}",
    ]  # fmt: skip
    names = ["leader", *(f"follower{k}" for k in range(1, ROBOTS))]
    for k, (name, place) in enumerate(zip(names, robots, strict=True)):
        lines += [
            f"[robots.{name}]", f"x_0 = {place[0]:.3f}", f"y_0 = {place[1]:.3f}",
            f"theta_0 = {random.uniform(-math.pi, math.pi):.3f}", f"d = {0.1 if k == 0 else 0.4}",
            "avoids_obstacles = false",
            f"actuator = {{ v_limit = {V_LIMIT}, omega_limit = {OMEGA_LIMIT} }}",
        ]  # fmt: skip
        if k:
            bearing = 2.0 * math.pi * (k - 1 + random.uniform(-0.2, 0.2)) / (ROBOTS - 1)
            separation = random.uniform(2.2, 3.5)
            lines.append(
                f'formation = {{ leader = "leader", separation = {separation:.3f}, bearing = {bearing - math.pi:.3f} }}'
            )
    for x, y, radius in obstacles:
        lines += ["[[obstacles]]", f"x = {x:.3f}", f"y = {y:.3f}", f"radius = {radius:.3f}", _way(random, x, y)]
    return "\n".join([*lines, ""])


def _starts(random: np.random.Generator) -> tuple[list[Any], list[Any]]:
    """Draw places of robots, and places and radii of obstacles, away from one another."""
    robots: list[Any] = []
    while len(robots) < ROBOTS:
        one = random.uniform(-HALF, HALF, 2)
        if all(math.dist(one, other) > ROBOTS_APART for other in robots):
            robots.append(one)
    obstacles: list[Any] = []
    while len(obstacles) < OBSTACLES:
        x, y = random.uniform(-1.5 * HALF, 1.5 * HALF, 2)
        radius = random.uniform(0.2, 0.6)
        away = all(math.dist((x, y), other) > radius + FROM_OBSTACLE for other in robots)
        if away and all(math.dist((x, y), other[:2]) > radius + other[2] for other in obstacles):
            obstacles.append((x, y, radius))
    return robots, obstacles


def _way(random: np.random.Generator, x: float, y: float) -> str:
    """Draw the way of an obstacle: straight on, or through three places."""
    if random.random() < 0.5:
        angle, speed = random.uniform(-math.pi, math.pi), random.uniform(0.05, FASTEST_OBSTACLE)
        return f"velocity = [{speed * math.cos(angle):.3f}, {speed * math.sin(angle):.3f}]"
    t, moments = 0.0, []
    for _ in range(3):
        to = random.uniform(-HALF, HALF, 2)
        t += max(math.dist((x, y), to), 0.1) / random.uniform(0.1, FASTEST_OBSTACLE)
        x, y = to
        moments.append(f"[{t:.3f}, {x:.3f}, {y:.3f}]")
    return f"path = [{', '.join(moments)}]"


def _point(place: Sequence[float]) -> str:
    return f"[{place[0]:.3f}, {place[1]:.3f}]"


def read_scene(number: int, seed: int, law: str) -> ScenarioFile:
    """Read a scene as `dwmr` reads a file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"crowd-{number}.toml")
        path.write_text(scene(number, seed, law), encoding="utf-8")
        return read(path)


def run(number: int, seed: int, law: str, free: bool = False) -> tuple[ScenarioFile, simulate.Trajectory]:
    """Run a scene, if wanted without the filter."""
    file = read_scene(number, seed, law)
    if free:
        file = dataclasses.replace(file, scenario=file.scenario.model_copy(update={"safety": None}))
    prepared = dataclasses.replace(
        _prepared(law), scenario=file.scenario, shapes=dict.fromkeys(file.scenario.robots, file.shape)
    )
    return file, simulate.run(prepared)


@cache
def _prepared(law: str) -> simulate.Simulation:
    """Return a scene made ready; its laws are those of all scenes, whose robots have the same gains."""
    file = read_scene(0, 0, law)
    return simulate.prepare(file, law, Rules(file.scenario.rules, file.folders, file.places))


def outcome(number: int, seed: int, law: str) -> dict[str, Any]:
    """Run a scene: its collisions [robot, other, time], moments of violated barriers, and least gaps."""
    file, trajectory = run(number, seed, law)
    scenario = file.scenario
    barriers = safety_measures(trajectory, scenario, scenario.safety)
    hits, least = contacts(file, trajectory)
    return {
        "scene": number, "stopped": trajectory.stop is not None, "least_gap": least, "hits": hits,
        "unexplained": [hit for hit in hits if not _explained(hit, barriers)],
        "infeasible": barriers["infeasible"], "missed": barriers["missed"],
        "disc_gap": min(barriers["disc_gap"].values()), "acts": float(np.mean(list(barriers["acts"].values()))),
    }  # fmt: skip


def touched(number: int, seed: int, law: str) -> bool:
    """Run a scene without the filter; return whether a robot is touched."""
    return bool(contacts(*run(number, seed, law, free=True))[0])


def contacts(file: ScenarioFile, trajectory: simulate.Trajectory) -> tuple[list[tuple[str, str, float]], float]:
    """Return the contacts with their first times [s], and the least gap between bodies [m]."""
    scenario, hits, least = file.scenario, [], math.inf
    for a, b, near, gaps in robot_gaps(trajectory, scenario):
        least = min(least, float(gaps.min()))
        if (gaps <= 0.0).any():
            hits.append((a, b, float(trajectory.t[near][gaps <= 0.0][0])))
    for name in trajectory.robots:
        gaps = obstacle_gaps(trajectory, scenario, name)
        least = min(least, float(gaps.min()))
        for o in np.flatnonzero((gaps <= 0.0).any(axis=0)):
            hits.append((name, f"obstacles.{o}", float(trajectory.t[int(np.argmax(gaps[:, o] <= 0.0))])))
    return hits, least


def _explained(hit: tuple[str, str, float], barriers: dict[str, Any]) -> bool:
    """Return whether a moment of the same two was recorded before they touched."""
    return any(
        {one["robot"], one["with"]} == {*hit[:2]} and one["t"] <= hit[2]
        for one in (*barriers["infeasible"], *barriers["missed"])
    )


def main() -> None:
    """Run one scene, or count collisions of many."""
    options = argparse.ArgumentParser()
    for name, default in (("scenes", 1000), ("seed", 0), ("scene", -1)):
        options.add_argument(f"--{name}", type=int, default=default)
    options.add_argument("--law", default="aifqsmc")
    options.add_argument("--free", action="store_true")
    chosen = options.parse_args()
    if chosen.scene >= 0:
        print(scene(chosen.scene, chosen.seed, chosen.law))
        return
    with ProcessPoolExecutor() as pool:
        work = partial(touched if chosen.free else outcome, seed=chosen.seed, law=chosen.law)
        outcomes: list[Any] = list(pool.map(work, range(chosen.scenes), chunksize=10))
    if chosen.free:
        print(f"{len(outcomes)} scenes without the filter: somebody is touched in {sum(outcomes)}")
    else:
        print(described(outcomes))


def described(outcomes: Sequence[dict[str, Any]]) -> str:
    """Describe the scenes."""
    touched = [one for one in outcomes if one["hits"]]
    lines = [
        f"{len(outcomes)} scenes, filter acting {100 * np.mean([one['acts'] for one in outcomes]):.1f} % of the time",
        f"collisions in {len(touched)} scenes; without a moment recorded before in "
        f"{sum(bool(one['unexplained']) for one in outcomes)}",
        f"stopped early: {sum(one['stopped'] for one in outcomes)}",
    ]
    for kind in ("infeasible", "missed"):
        here = [one for one in outcomes if one[kind]]
        count, lasted = sum(len(one[kind]) for one in here), sum(m["lasted"] for one in here for m in one[kind])
        lines.append(f"{kind}: {count} moments in {len(here)} scenes, {lasted:.1f} s in all")
    others = [one for one in outcomes if not one["infeasible"] and not one["missed"]]
    if others:
        gap, disc = min(one["least_gap"] for one in others), min(one["disc_gap"] for one in others)
        lines.append(
            f"in the {len(others)} other scenes: least gap between bodies {gap:.3f} m, between discs {disc:.4f} m "
            f"(kept: {SAFETY['margin']:g} m)"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    main()
