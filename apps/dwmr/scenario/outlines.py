"""Outlines of robots, their distances, and places of obstacles over time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.scenario.model import Obstacle, Robot, Scenario


def is_moving(scenario: Scenario) -> bool:
    """Return whether some obstacle moves."""
    return any(one.velocity is not None or one.path is not None for one in scenario.obstacles)


def centres(scenario: Scenario, t: FloatArray) -> FloatArray:
    """Return the centres of the obstacles, shape (samples, obstacles, 2) [m].

    Args:
        scenario: A scenario.
        t: Times from 0 on, shape (samples,) [s].
    """
    result = np.empty((len(t), len(scenario.obstacles), 2))
    for a, one in enumerate(scenario.obstacles):
        v_x, v_y = one.velocity or (0.0, 0.0)
        result[:, a, 0], result[:, a, 1] = one.x + v_x * t, one.y + v_y * t
        if one.path is not None:
            times, x, y = _waypoints(one)
            result[:, a, 0], result[:, a, 1] = np.interp(t, times, x), np.interp(t, times, y)
    return result


def largest_speed(obstacle: Obstacle) -> float:
    """Return the largest speed of an obstacle [m/s]."""
    if obstacle.velocity is not None:
        return math.hypot(*obstacle.velocity)
    times, x, y = _waypoints(obstacle)
    return float(np.max(np.hypot(np.diff(x), np.diff(y)) / np.diff(times), initial=0.0))


def _waypoints(obstacle: Obstacle) -> FloatArray:
    """Return times and places between which an obstacle moves in straight lines, shape (3, n) [s, m, m]."""
    return np.array([(0.0, obstacle.x, obstacle.y), *(obstacle.path or ())]).T


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


def outline_pose(body: Outline, x: FloatArray, y: FloatArray, theta: FloatArray) -> FloatArray:
    """Return the middle of an outline and its orientation, shape (3, samples) [m, m, rad].

    Args:
        body: The outline.
        x, y: Reference point of the robot, shape (samples,) [m].
        theta: Orientation of the robot, shape (samples,) [rad].
    """
    return np.stack([x + body.middle * np.cos(theta), y + body.middle * np.sin(theta), theta])


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


def distance_from(obstacle: Obstacle, robot: Robot) -> float:
    """Return the distance of a robot's reference point from an obstacle's centre where both start [m]."""
    return math.hypot(obstacle.x - robot.x_0, obstacle.y - robot.y_0)


def outline(robot: Robot) -> Outline:
    """Return the outline of a robot: its body, or the disc of radius R_R about the middle of its axle."""
    body = robot.body
    if body is None:
        return Outline(-robot.d, 0.0, 0.0, robot.radius)
    return Outline(0.5 * (body.front - body.rear) - robot.d, 0.5 * (body.front + body.rear), 0.5 * body.width, 0.0)


def start(robot: Robot) -> FloatArray:
    """Return the middle of a robot's outline and its orientation where it starts, shape (3, 1) [m, m, rad]."""
    return outline_pose(outline(robot), *(np.array([value]) for value in (robot.x_0, robot.y_0, robot.theta_0)))
