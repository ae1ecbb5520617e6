"""Discs that guard a scenario's robots, and the parameters of the safety filter."""

from __future__ import annotations

import math

import numpy as np

from dwmr.control.safety_settings import Safety
from dwmr.core.arrays import FloatArray
from dwmr.scenario.model import LARGEST_NOISE, Noise, Robot, SafetySettings, Scenario
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


def room_for_noise(alpha: float, least: FloatArray, noise: FloatArray, speed: FloatArray) -> FloatArray:
    """Return what is kept of measured distances so that true ones do not fall below R [m].

    Args:
        alpha: α [1/s].
        least: R [m].
        noise: By how much measured distances are wrong at most [m].
        speed: Largest speed at which the two approach each other [m/s].

    Source:
        docs/explanation/avoidance.md, "Noise".
    """
    kept: FloatArray = least + noise * (1.0 + speed / (alpha * (least + noise)))
    return kept


def safety_of(scenario: Scenario, settings: SafetySettings) -> Safety:
    """Return the parameters of the safety filter with some settings."""
    robots, obstacles, dt = tuple(scenario.robots.values()), scenario.obstacles, scenario.run.dt
    lookahead, error, n = settings.lookahead, settings.velocity_error, len(robots)
    limits = np.array([(r.actuator.v_limit, r.actuator.omega_limit) for r in robots])
    commanded = np.hypot(limits[:, 0], lookahead * limits[:, 1])
    turning = 0.5 * dt * limits[:, 1] * commanded  # a held command's velocity turns with the robot
    radii = np.array(radii_of(scenario, settings))
    speeds = np.array([*(commanded + error), *(largest_speed(o) for o in obstacles)])
    closing = speeds[:n, None] + speeds
    least = radii[:n, None] + radii + settings.margin + 0.5 * dt * closing
    deviations = [r.noise or Noise() for r in robots]
    turned = np.array([LARGEST_NOISE * one.theta for one in deviations])
    moved = np.array([LARGEST_NOISE * math.hypot(one.x, one.y) for one in deviations])
    noise = np.zeros(len(speeds))
    noise[:n] = moved + turned * np.array([abs(lookahead - r.d) for r in robots])
    return Safety(
        settings.alpha,
        lookahead,
        settings.acceleration,
        settings.angular_acceleration,
        least,
        room_for_noise(settings.alpha, least, noise[:n, None] + noise, closing),
        noise,
        speeds,
        error + turning + turned * commanded,
    )
