"""Discs that guard a scenario's robots, and the parameters of the safety filter."""

from __future__ import annotations

import math

import numpy as np

from dwmr.control.safety_filter import Safety
from dwmr.scenario.model import Robot, SafetySettings, Scenario
from dwmr.scenario.moving import largest_speed
from dwmr.scenario.outlines import outline


def disc_radius(robot: Robot, lookahead: float) -> float:
    """Return the radius of the disc about the guarded point that encloses a robot's body [m]."""
    body = outline(robot)
    from_point = abs(body.middle + robot.d - lookahead)
    return math.hypot(from_point + body.half_length, body.half_width) + body.margin


def safety_of(scenario: Scenario, settings: SafetySettings) -> Safety:
    """Return the parameters of the safety filter with some settings."""
    robots = tuple(scenario.robots.values())
    lookahead, error = settings.lookahead, settings.velocity_error
    limits = np.array([(r.actuator.v_limit, r.actuator.omega_limit) for r in robots])
    speeds = np.hypot(limits[:, 0], lookahead * limits[:, 1])
    turning = 0.5 * scenario.run.dt * limits[:, 1] * speeds  # a held command's velocity turns with the robot
    return Safety(
        settings.alpha,
        lookahead,
        settings.acceleration,
        settings.angular_acceleration,
        settings.margin,
        np.array([disc_radius(r, lookahead) for r in robots]),
        speeds + error,
        error + turning,
        np.array([largest_speed(o) for o in scenario.obstacles]),
    )
