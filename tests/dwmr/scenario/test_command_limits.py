"""Velocity commands within what robots take."""

import math
import warnings

import numpy as np
import pytest

from dwmr.scenario.file import find, read
from dwmr.scenario.vehicle_limits import limited

LIMITS = ("robot.actuator.v_limit=1.5", "robot.actuator.omega_limit=1.0")


def leader(name, *more):
    return read(find(name), (*LIMITS, *more)).scenario.robots["leader"]


def test_two_wheels_and_mecanum_wheels_are_limited_one_by_one():
    asked = np.array([[2.0, -3.0, -4.0], [-2.0, 0.5, 0.25]])
    for name in ("undisturbed", "omnidirectional"):
        assert limited(asked, leader(name)).tolist() == [[1.5, -1.5, -1.0], [-1.5, 0.5, 0.25]]


def test_a_car_keeps_its_curvature():
    car = leader("ackermann")
    bend = 1.0 / car.vehicle.turning_radius
    asked = np.array([[2.0, 0.0, 0.4], [1.2, 0.0, 1.5], [-2.0, 0.0, 0.4], [0.5, 0.0, -9.0]])
    found = limited(asked, car)
    assert found == pytest.approx(np.array([[1.5, 0, 0.3], [0.8, 0, 1.0], [-1.5, 0, 0.3], [0.5, 0, -0.5 * bend]]))


def test_a_car_that_stands_does_not_turn():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = limited(np.array([[0.0, 0.0, 1.0], [5e-324, 0.0, 1.0]]), leader("ackermann"))
    assert np.abs(found).max() < 1e-300
    assert not np.isnan(found).any()


def test_the_curvature_of_a_car_is_what_its_steering_angle_gives():
    car = leader("ackermann")
    rng = np.random.default_rng(1)
    found = limited(rng.uniform(-3.0, 3.0, (1000, 3)), car)
    assert np.abs(found[:, 0]).max() <= 1.5
    assert np.abs(found[:, 2]).max() <= 1.0 + 1e-12
    angles = np.arctan2(car.vehicle.wheelbase * np.abs(found[:, 2]), np.abs(found[:, 0]))
    assert angles.max() == pytest.approx(car.vehicle.steering_limit)
    assert math.isclose(angles.max(), car.vehicle.steering_limit)
