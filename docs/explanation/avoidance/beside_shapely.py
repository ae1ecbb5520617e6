"""Holds collisions and gaps of random crowds to shapely: polygons and their distances at every sample.

python beside_shapely.py [--scenes N] [--seed N] [--law LAW]

Needs `pip install shapely`; shapely's side does not use dwmr's geometry.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import crowds

from dwmr.results.distances import obstacle_gaps, robot_gaps


def polygons(shapely: Any, trajectory: Any, scenario: Any, robot: str) -> Any:
    """Return the body of a robot at every sample, as polygons, shape (samples,)."""
    i, one = trajectory.robots.index(robot), scenario.robots[robot]
    x, y, theta = (trajectory[key][:, i] for key in ("x", "y", "theta"))
    c, s, half = np.cos(theta), np.sin(theta), 0.5 * one.body.width
    corners = [(one.body.front, half), (-one.body.rear, half), (-one.body.rear, -half), (one.body.front, -half)]
    places = [(x + (a - one.d) * c - b * s, y + (a - one.d) * s + b * c) for a, b in corners]
    return shapely.polygons(np.array(places).transpose(2, 0, 1))


def way(one: Any, t: float) -> tuple[float, float]:
    """Return the place of an obstacle at a time [s]."""
    if one.velocity is not None:
        return one.x + t * one.velocity[0], one.y + t * one.velocity[1]
    begin = (0.0, one.x, one.y)
    for end in one.path or ():
        if t <= end[0]:
            share = (t - begin[0]) / (end[0] - begin[0])
            return begin[1] + share * (end[1] - begin[1]), begin[2] + share * (end[2] - begin[2])
        begin = end
    return begin[1], begin[2]


def differences(shapely: Any, number: int, seed: int, law: str, free: bool) -> tuple[float, int, int]:
    """Return the largest difference of gaps [m], and the numbers of pairs judged otherwise and of pairs that touch."""
    file, trajectory = crowds.run(number, seed, law, free)
    scenario, largest, otherwise, touching = file.scenario, 0.0, 0, 0
    bodies = {name: polygons(shapely, trajectory, scenario, name) for name in trajectory.robots}
    near_ones = robot_gaps(trajectory, scenario)
    pairs = [(gaps, shapely.distance(bodies[a][near], bodies[b][near])) for a, b, near, gaps in near_ones]
    for a, one in enumerate(scenario.obstacles):
        centres = shapely.points([way(one, float(t)) for t in trajectory.t])
        for name in trajectory.robots:
            theirs = shapely.distance(bodies[name], centres) - one.radius
            pairs.append((obstacle_gaps(trajectory, scenario, name)[:, a], theirs))
    for gaps, theirs in pairs:
        apart = (gaps > 0.0) & (theirs > 0.0)
        largest = max(largest, float(np.abs(gaps - theirs)[apart].max(initial=0.0)))
        touches = bool((gaps <= 0.0).any())
        touching += touches
        otherwise += touches != bool((theirs <= 0.0).any())
    return largest, otherwise, touching


def main() -> None:
    """Compare the gaps of some scenes with shapely's."""
    try:
        import shapely
    except ImportError:
        sys.exit("shapely is missing: pip install shapely")
    options = argparse.ArgumentParser()
    options.add_argument("--scenes", type=int, default=50)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--law", default="aifqsmc")
    chosen = options.parse_args()
    for free in (False, True):
        results = np.array([differences(shapely, k, chosen.seed, chosen.law, free) for k in range(chosen.scenes)])
        print(
            f"{chosen.scenes} scenes {'without' if free else 'with'} the filter, shapely {shapely.__version__}: gaps "
            f"differ by {results[:, 0].max():.1e} m at most, {int(results[:, 1].sum())} pairs are judged otherwise, "
            f"{int(results[:, 2].sum())} touch",
            flush=True,
        )


if __name__ == "__main__":
    main()
