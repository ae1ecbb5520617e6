"""Gaps and contacts between robot bodies and obstacles along a recorded run."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.plant.bodies import gap_between, gap_to_point, outline_pose
from dwmr.scenario.model import Scenario
from dwmr.scenario.moving import centres
from dwmr.scenario.outlines import outline
from dwmr.simulation.simulate import Trajectory


class Contact(NamedTuple):
    """Contact of two bodies, whose gap closed.

    Attributes:
        t: First time [s].
        lasted: Time in contact, all contacts together [s].
        depth: Largest depth of overlap [m].
    """

    t: float
    lasted: float
    depth: float


def poses(trajectory: Trajectory, scenario: Scenario, robot: str) -> FloatArray:
    """Return the middle of a robot's outline and its orientation, shape (3, samples) [m, m, rad]."""
    i = trajectory.robots.index(robot)
    return outline_pose(outline(scenario.robots[robot]), *(trajectory[name][:, i] for name in ("x", "y", "theta")))


def obstacle_gaps(trajectory: Trajectory, scenario: Scenario, robot: str) -> FloatArray:
    """Return the gap between a robot's body and every obstacle, negative in overlap, shape (samples, obstacles) [m]."""
    pose, body = poses(trajectory, scenario, robot), outline(scenario.robots[robot])
    x, y = centres(scenario, trajectory.t).transpose(2, 1, 0)
    radius = np.array([one.radius for one in scenario.obstacles])[:, None]
    return np.ascontiguousarray((gap_to_point(pose, body, x, y) - radius).T)


def robot_gaps(trajectory: Trajectory, scenario: Scenario) -> Iterator[tuple[str, str, Any, FloatArray]]:
    """Yield for every pair of robots their names, samples, and the gaps between their bodies at these [m].

    The samples include the least gap and all contacts; at the others the circles about the bodies are farther apart.
    """
    found = {name: (poses(trajectory, scenario, name), outline(scenario.robots[name])) for name in trajectory.robots}
    for first, second in combinations(trajectory.robots, 2):
        (pose_a, a), (pose_b, b) = found[first], found[second]
        between = np.sqrt((pose_a[0] - pose_b[0]) ** 2 + (pose_a[1] - pose_b[1]) ** 2)
        nearest = int(np.argmin(between))
        least = gap_between(pose_a[:, [nearest]], a, pose_b[:, [nearest]], b)[0]
        close = between <= a.reach + b.reach + max(float(least), 0.0)
        close[nearest] = True
        near = np.flatnonzero(close)
        yield first, second, near, gap_between(pose_a[:, near], a, pose_b[:, near], b)


def meetings(trajectory: Trajectory, scenario: Scenario) -> FloatArray:
    """Return the middles of bodies where they first touch another body or an obstacle, shape (contacts, 2) [m]."""
    places = []
    for first, _, near, gaps in robot_gaps(trajectory, scenario):
        if (gaps <= 0.0).any():
            places.append(poses(trajectory, scenario, first)[:2, near[int(np.argmax(gaps <= 0.0))]])
    for robot in trajectory.robots:
        touched = obstacle_gaps(trajectory, scenario, robot) <= 0.0
        samples = np.argmax(touched, axis=0)[touched.any(axis=0)]
        places += list(poses(trajectory, scenario, robot)[:2, samples].T)
    return np.array(places).reshape(-1, 2)


def contact(t: FloatArray, dt: float, gaps: FloatArray) -> Contact | None:
    """Return the contact of two bodies, or None where their gap stays open.

    Args:
        t: Times, shape (samples,) [s].
        dt: Time that a sample stands for [s].
        gaps: Gaps at these times, shape (samples,) [m].
    """
    closed = gaps <= 0.0
    if not closed.any():
        return None
    return Contact(float(t[closed][0]), float(np.count_nonzero(closed) * dt), float(-gaps.min()))
