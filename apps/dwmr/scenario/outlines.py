"""Outlines of a scenario's robots and their initial poses."""

from __future__ import annotations

import math

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.plant.bodies import Outline, outline_pose
from dwmr.scenario.model import Obstacle, Robot


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
