"""Discs that guard a scenario's robots, and the parameters of the safety filter."""

from __future__ import annotations

import math

import numpy as np

from dwmr.control.safety_settings import Safety
from dwmr.scenario.model import Robot, SafetySettings, Scenario
from dwmr.scenario.moving import largest_speed
from dwmr.scenario.outlines import outline


def disc_radius(robot: Robot, lookahead: float) -> float:
    """Return the radius of the disc about the guarded point that encloses a robot's body [m]."""
    body = outline(robot)
    from_point = abs(body.middle + robot.d - lookahead)
    return math.hypot(from_point + body.half_length, body.half_width) + body.margin


def radii_of(scenario: Scenario, settings: SafetySettings) -> list[float]:
    """Return the radii of the robots' discs, then of the obstacles [m]."""
    discs = [disc_radius(robot, settings.lookahead) for robot in scenario.robots.values()]
    return [*discs, *(one.radius for one in scenario.obstacles)]


def safety_of(scenario: Scenario, settings: SafetySettings) -> Safety:
    """Return the parameters of the safety filter with some settings."""
    robots, obstacles, dt = tuple(scenario.robots.values()), scenario.obstacles, scenario.run.dt
    lookahead, error, n = settings.lookahead, settings.velocity_error, len(robots)
    limits = np.array([(r.actuator.v_limit, r.actuator.omega_limit) for r in robots])
    commanded = np.hypot(limits[:, 0], lookahead * limits[:, 1])
    turning = 0.5 * dt * limits[:, 1] * commanded  # a held command's velocity turns with the robot
    radii = np.array(radii_of(scenario, settings))
    speeds = np.array([*(commanded + error), *(largest_speed(o) for o in obstacles)])
    least = radii[:n, None] + radii + settings.margin + 0.5 * dt * (speeds[:n, None] + speeds)
    return Safety(
        settings.alpha,
        lookahead,
        settings.acceleration,
        settings.angular_acceleration,
        least,
        speeds,
        error + turning,
    )
