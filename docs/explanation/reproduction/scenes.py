"""Runs the leader of the paper's scenario among random obstacles and counts the scenes in which it comes too close.

python scenes.py [--law LAW] [--obstacles N] [--apart M] [--aside M] [--scenes N] [--seed N]
"""

from __future__ import annotations

import argparse
import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np

from dwmr import simulate
from dwmr.fuzzy_gains import Rules
from dwmr.metrics import distances
from dwmr.scenario import Obstacle
from dwmr.scenario_file import find, read

#: Radius of every obstacle [m].
RADIUS = 0.5
#: r_a + R_R, the distance at which the robot touches the obstacle [m].
CLOSEST = RADIUS + 0.56
#: Obstacles nearer to the start than this are in the robot's way before it has found the path [m].
FROM_START = 6.0
START = (-1.0, 1.0)
#: Draws after which a scene is begun anew.
MOST_DRAWS = 300

Place = tuple[float, float]


def beside_path(t: float, aside: float) -> Place:
    """Return the place beside the paper's eight [m]: `t` is the time on the path [s], `aside` to its left [m]."""
    w = 2.0 * math.pi / 200.0
    x, y = 15.0 * math.sin(2.0 * w * t), 15.0 * math.sin(w * t)
    ahead = math.atan2(math.cos(w * t), 2.0 * math.cos(2.0 * w * t))
    return x - aside * math.sin(ahead), y + aside * math.cos(ahead)


def are_apart(places: Sequence[Place], apart: float) -> bool:
    """Return whether obstacles are `apart` from each other [m] and away from the start."""
    pairs = ((a, b) for k, a in enumerate(places) for b in places[:k])
    return all(math.dist(a, START) > FROM_START for a in places) and all(math.dist(a, b) >= apart for a, b in pairs)


def scene(random: np.random.Generator, count: int, apart: float, aside: float) -> list[Place]:
    """Draw the places of some obstacles: anywhere along the path, up to `aside` beside it, at least `apart` [m]."""
    places: list[Place] = []
    tried = 0
    while len(places) < count:
        one = beside_path(float(random.uniform(0.0, 200.0)), float(random.uniform(-aside, aside)))
        tried += 1
        if are_apart([*places, one], apart):
            places.append(one)
        elif tried > MOST_DRAWS:  # those that are there leave no room for another one
            places, tried = [], 0
    return places


def leader_alone(law: str) -> Callable[[Sequence[Place]], float]:
    """Return a function that runs the leader around obstacles, disturbed as in the paper: its least distance [m]."""
    file = read(find("paper"))
    robots = {"leader": file.scenario.robots["leader"]}
    file = dataclasses.replace(file, scenario=file.scenario.model_copy(update={"robots": robots}))
    prepared = simulate.prepare(file, law, Rules(file.scenario.rules, file.folders, file.places))

    def clearance(places: Sequence[Place]) -> float:
        obstacles = tuple(Obstacle(x=x, y=y, radius=RADIUS) for x, y in places)
        scenario = file.scenario.model_copy(update={"obstacles": obstacles})
        trajectory = simulate.run(dataclasses.replace(prepared, scenario=scenario))
        return float(distances(trajectory, scenario, "leader").min())

    return clearance


def main() -> None:
    """Count, and print the nearest scene."""
    options = argparse.ArgumentParser()
    options.add_argument("--law", default="aifqsmc")
    options.add_argument("--obstacles", type=int, default=4)
    options.add_argument("--apart", type=float, default=14.0)
    options.add_argument("--aside", type=float, default=0.75)
    options.add_argument("--scenes", type=int, default=600)
    options.add_argument("--seed", type=int, default=0)
    given = options.parse_args()
    random, clearance = np.random.default_rng(given.seed), leader_alone(given.law)
    found = [clearance(scene(random, given.obstacles, given.apart, given.aside)) for _ in range(given.scenes)]
    close = sum(one < CLOSEST for one in found)
    print(f"{close} of {given.scenes} scenes closer than {CLOSEST:g} m; the nearest {min(found):.3f} m")


if __name__ == "__main__":
    main()
