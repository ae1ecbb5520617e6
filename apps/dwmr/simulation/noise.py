"""Measurement noise of the robots' states, drawn before the loop reads it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.scenario.model import LARGEST_NOISE, Scenario

#: What is measured, in the order of the fields of `robot.State`.
MEASURED = ("x", "y", "theta", "v", "omega")


def is_present(scenario: Scenario) -> bool:
    """Return whether some robot measures inexactly."""
    by_wheels = any(r.sensors.pose == "odometry" or r.sensors.encoder_steps for r in scenario.robots.values())
    return by_wheels or bool(_deviations(scenario).any())


def source(scenario: Scenario) -> Callable[[int], FloatArray]:
    """Return a function that draws the noise of the next periods, shape (periods, robots, 5).

    A robot's numbers follow from the seed and its name alone: neither the other robots nor the control law nor how many
    periods are drawn at once change them. Where all robots measure exactly the arrays are empty.
    """
    deviations, n = _deviations(scenario), len(scenario.robots)
    if not is_present(scenario):
        nothing = np.zeros((0, n, len(MEASURED)))
        return lambda periods: nothing
    streams = [np.random.default_rng([scenario.run.seed, *name.encode()]) for name in scenario.robots]

    def draw(periods: int) -> FloatArray:
        drawn = np.stack([one.standard_normal((periods, len(MEASURED))) for one in streams], axis=1)
        result: FloatArray = np.clip(drawn, -LARGEST_NOISE, LARGEST_NOISE) * deviations
        return result

    return draw


def _deviations(scenario: Scenario) -> FloatArray:
    """Return the standard deviations, shape (robots, 5) [m, m, rad, m/s, rad/s]."""
    given = [r.noise for r in scenario.robots.values()]
    return np.array([[getattr(one, name, 0.0) for name in MEASURED] for one in given])
