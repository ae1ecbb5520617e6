"""Bodies of robots in the plane: how far they are from obstacles and from one another."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dwmr.scenario.model import Robot, Scenario

if TYPE_CHECKING:  # they bring the compiler along, which the check of a scenario does without
    from dwmr.core.arrays import FloatArray
    from dwmr.simulation.simulate import Trajectory


class Outline(NamedTuple):
    """A rectangle along the robot with a margin around it: a box has no margin, a disc no rectangle.

    Attributes:
        middle: Middle of the rectangle ahead of the reference point [m].
        half_length, half_width: Half its sides [m].
        margin: Width of the margin [m].
    """

    middle: float
    half_length: float
    half_width: float
    margin: float

    @property
    def reach(self) -> float:
        """Radius of the circle about the middle that encloses the outline [m]."""
        return math.hypot(self.half_length, self.half_width) + self.margin


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


def outline(robot: Robot) -> Outline:
    """Return the outline of a robot: its body, or the disc of radius R_R about the middle of its axle."""
    body = robot.body
    if body is None:
        return Outline(-robot.d, 0.0, 0.0, robot.radius)
    return Outline(0.5 * (body.front - body.rear) - robot.d, 0.5 * (body.front + body.rear), 0.5 * body.width, 0.0)


def poses(trajectory: Trajectory, scenario: Scenario, robot: str) -> FloatArray:
    """Return the middle of a robot's outline and its orientation, shape (3, samples) [m, m, rad]."""
    i = trajectory.robots.index(robot)
    return _pose(scenario.robots[robot], *(trajectory[name][:, i] for name in ("x", "y", "theta")))


def start(robot: Robot) -> FloatArray:
    """Return the middle of a robot's outline and its orientation where it starts, shape (3, 1) [m, m, rad]."""
    return _pose(robot, *(np.array([value]) for value in (robot.x_0, robot.y_0, robot.theta_0)))


def _pose(robot: Robot, x: FloatArray, y: FloatArray, theta: FloatArray) -> FloatArray:
    ahead = outline(robot).middle
    return np.stack([x + ahead * np.cos(theta), y + ahead * np.sin(theta), theta])


def gap_to_point(pose: FloatArray, one: Outline, x: FloatArray | float, y: FloatArray | float) -> FloatArray:
    """Return the signed distance of points from an outline, negative inside [m].

    Args:
        pose: Middle and orientation of the outline, shape (3, samples) [m, m, rad].
        one: The outline.
        x, y: The points, of a shape that fits (samples,) [m].

    Source:
        Outside, the length of the excess over half the sides; inside, the distance to the nearest side.
    """
    c, s, dx, dy = np.cos(pose[2]), np.sin(pose[2]), x - pose[0], y - pose[1]
    along = np.abs(c * dx + s * dy) - one.half_length
    across = np.abs(c * dy - s * dx) - one.half_width
    outside = np.hypot(np.maximum(along, 0.0), np.maximum(across, 0.0))
    gap: FloatArray = outside + np.minimum(np.maximum(along, across), 0.0) - one.margin
    return gap


def gap_between(pose_a: FloatArray, a: Outline, pose_b: FloatArray, b: Outline) -> FloatArray:
    """Return the signed distance between two outlines, the depth of overlap with a minus, shape (samples,) [m].

    Args:
        pose_a, pose_b: Middles and orientations, shape (3, samples) [m, m, rad].
        a, b: The outlines.

    Source:
        Two rectangles are apart where one of their four directions separates them (separating axis theorem); the
        nearest points of two that are apart include a corner of one. The depth of overlap is that along the direction
        in which it is least.
    """
    separation = np.maximum(_separation(pose_a, a, pose_b, b), _separation(pose_b, b, pose_a, a))
    corners = [
        gap_to_point(pose, one, *corner) + one.margin
        for pose, one, other, theirs in ((pose_a, a, b, pose_b), (pose_b, b, a, pose_a))
        for corner in _corners(theirs, other)
    ]
    gap: FloatArray = np.where(separation < 0.0, separation, np.minimum.reduce(corners)) - a.margin - b.margin
    return gap


def _corners(pose: FloatArray, one: Outline) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield the corners of a rectangle."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    for along in (one.half_length, -one.half_length):
        for across in (one.half_width, -one.half_width):
            yield pose[0] + c * along - s * across, pose[1] + s * along + c * across


def _separation(pose: FloatArray, one: Outline, theirs: FloatArray, other: Outline) -> FloatArray:
    """Return by how much the directions of one rectangle separate it from another, the larger of two [m]."""
    c, s, dx, dy = np.cos(pose[2]), np.sin(pose[2]), theirs[0] - pose[0], theirs[1] - pose[1]
    turn_c, turn_s = np.abs(np.cos(theirs[2] - pose[2])), np.abs(np.sin(theirs[2] - pose[2]))
    along = np.abs(c * dx + s * dy) - one.half_length - turn_c * other.half_length - turn_s * other.half_width
    across = np.abs(c * dy - s * dx) - one.half_width - turn_s * other.half_length - turn_c * other.half_width
    larger: FloatArray = np.maximum(along, across)
    return larger


def obstacle_gaps(trajectory: Trajectory, scenario: Scenario, robot: str) -> FloatArray:
    """Return the gap between a robot's body and every obstacle, negative in overlap, shape (samples, obstacles) [m]."""
    pose, body = poses(trajectory, scenario, robot), outline(scenario.robots[robot])
    gaps = [gap_to_point(pose, body, o.x, o.y) - o.radius for o in scenario.obstacles]
    return np.stack(gaps, axis=1) if gaps else np.zeros((len(trajectory.t), 0))


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
