"""Runs swaps of robots behind the safety filter and under ORCA, and prints arrivals and gaps of both.

python beside_orca.py [--seeds N]
    needs `pip install pyrvo`, the library RVO2
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

import arrivals

from dwmr.results import metrics
from dwmr.scenario.guard import disc_radius

#: Share of the distance by which the law approaches its place in a second [1/s], and its largest speed [m/s].
RATE, LARGEST = 0.8, 0.5
#: Period [s], time over which ORCA keeps robots apart [s], and turn to the right of preferred velocities [rad].
DT, AHEAD, RIGHT = 0.01, 4.0, 0.1


def orca(scene: arrivals.Scene, radius: float, arrival: float, right: float = 0.0) -> dict[str, Any]:
    """Move discs that can take every velocity from starts to goals by ORCA.

    Args:
        scene: Starts and goals.
        radius: Of the discs [m].
        arrival: Distance from its goal within which a disc has arrived [m].
        right: Angle by which preferred velocities are turned to the right [rad].

    Returns:
        Number that arrived, when the last one did [s], least gap of the discs [m].
    """
    import pyrvo

    starts, goals, _ = scene
    simulator = pyrvo.RVOSimulator()
    simulator.set_time_step(DT)
    simulator.set_agent_defaults(15.0, len(starts), AHEAD, AHEAD, radius, arrivals.V_LIMIT, (0.0, 0.0))
    for x, y, _ in starts:
        simulator.add_agent((x, y))
    count, (c, s) = round(arrivals.HORIZON / DT), (math.cos(right), math.sin(right))
    places, gap = np.array([start[:2] for start in starts]), math.inf
    last, goals = np.zeros(len(starts)), np.array(goals)
    pairs = np.triu_indices(len(starts), 1)
    for k in range(count):
        way = goals - places
        far = np.hypot(way[:, 0], way[:, 1])
        last[far > arrival] = (k + 1) * DT
        between = places[pairs[0]] - places[pairs[1]]
        gap = min(gap, float(np.hypot(between[:, 0], between[:, 1]).min()) - 2.0 * radius)
        wanted = way * (RATE * np.minimum(1.0, LARGEST / np.maximum(RATE * far, 1e-9)))[:, None]
        for i, (v_x, v_y) in enumerate(wanted.tolist()):
            simulator.set_agent_pref_velocity(i, (c * v_x + s * v_y, c * v_y - s * v_x))
        simulator.do_step()
        now = [simulator.get_agent_position(i) for i in range(len(starts))]
        places = np.array([(one.x, one.y) for one in now])
    arrived = last < count * DT
    return {"arrived": int(arrived.sum()), "last": max(last[arrived].tolist(), default=math.nan), "gap": gap}


def filtered(scene: arrivals.Scene) -> tuple[dict[str, Any], float, float]:
    """Run a scene behind the filter; return its measures, the radius of its discs, and the radius of arrival [m]."""
    file, trajectory = arrivals.run(scene)
    settings = file.scenario.safety
    assert settings is not None
    measures = metrics.measure(trajectory, file.scenario, ("arrival", "safety"))
    reached = [one["t"] for name, one in measures["arrival"].items() if name != "leader" and one["reached"]]
    gap = min(one for name, one in measures["safety"]["disc_gap"].items() if name != "leader")
    radius = disc_radius(file.scenario.robots["follower1"], settings.lookahead)
    outcome = {"arrived": len(reached), "last": max(reached, default=math.nan), "gap": gap}
    return outcome, radius, file.scenario.run.arrival


def each(robots: int, seed: int) -> dict[str, dict[str, Any]]:
    """Return the measures of a swap behind the filter and under ORCA."""
    scene = arrivals.swap(robots, seed)
    first, radius, arrival = filtered(scene)
    turned = orca(scene, radius, arrival, RIGHT)
    return {"filter": first, "ORCA": orca(scene, radius, arrival), f"ORCA, {RIGHT} rad to the right": turned}


def main() -> None:
    """Print a table."""
    options = argparse.ArgumentParser()
    options.add_argument("--seeds", type=int, default=8)
    seeds = range(options.parse_args().seeds)
    for robots in (2, 4, 6):
        runs = [each(robots, seed) for seed in seeds]
        for title in runs[0]:
            outcomes = [one[title] for one in runs]
            arrived = sum(one["arrived"] for one in outcomes)
            last, gap = max(one["last"] for one in outcomes), min(one["gap"] for one in outcomes)
            after = f", the last one after {last:.1f} s" if arrived else ""
            print(
                f"{robots} robots, {title}: {arrived} of {robots * len(seeds)} arrive{after}; least gap between discs "
                f"{gap:.3f} m",
                flush=True,
            )


if __name__ == "__main__":
    main()
