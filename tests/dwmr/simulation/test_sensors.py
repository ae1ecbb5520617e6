"""Odometry and encoders: exact where wheels do not slip, blind to slip, in steps of their own."""

import math

import numpy as np
import pytest

from dwmr.plant.disturbances import measure
from dwmr.plant.robot import ROBOT
from tests.dwmr.scenarios import shared

DT = 0.005


def reckoned(speeds, steps=0.0, d=0.1, odometry=1):
    """What one robot sees after each of some periods, from the velocities (v, omega) at their begins."""
    robots = np.zeros(1, dtype=ROBOT)
    robots["half_track"], robots["wheel_radius"], robots["d"] = 0.268, 0.13, d
    robots["odometry"], robots["encoder_steps"] = odometry, steps
    plant, wheels, odometry, seen = (np.zeros((1, k)) for k in (7, 6, 3, 7))
    odometry[0, 0] = d  # the axle starts at the origin
    rows = []
    for v, omega in speeds:
        plant[0, 3:5] = v, omega
        measure(np.zeros((1, 5)), plant, robots.view(np.recarray), DT, wheels, odometry, seen)
        rows.append(seen[0, :5].copy())
    return np.array(rows)


def test_odometry_goes_along_a_circle():
    v, omega = 0.8, 0.5
    turn = 2.0 * math.pi / omega
    speeds = [(v, omega)] * (round(turn / DT) + 1)
    rows = reckoned(speeds)
    # the speeds begin with a jump; a trapezoid sees half of it
    angle = rows[:, 2]
    assert angle[-1] == pytest.approx(2.0 * math.pi, abs=2 * omega * DT)
    x, y = rows[:, 0] - 0.1 * np.cos(angle), rows[:, 1] - 0.1 * np.sin(angle)
    assert np.hypot(x, y - v / omega) == pytest.approx(np.full(len(rows), v / omega), abs=1e-5)


def test_encoders_count_whole_steps():
    rows = reckoned([(0.5, 0.1)] * 400, steps=1000.0)
    step = 2.0 * math.pi * 0.13 / 1000.0
    for side in (1.0, -1.0):
        counted = (rows[:, 3] + side * 0.268 * rows[:, 4]) * DT / step
        assert counted == pytest.approx(np.round(counted), abs=1e-6)
    assert rows[100:, 3].mean() == pytest.approx(0.5, rel=0.01)
    assert rows[100:, 3].std() > 0.01
    assert np.array_equal(reckoned([(0.5, 0.1)] * 9)[:, 3], np.full(9, 0.5))


def test_a_robot_with_an_exact_posture_ignores_its_odometry():
    assert not reckoned([(0.5, 0.1)] * 9, odometry=0)[:, :3].any()


def run(*overrides):
    return shared("paper", "aifqsmc", "run.horizon=12", *overrides)[1]


def test_without_slip_odometry_changes_little_and_with_slip_much():
    pushed = 'disturbances=[{kind="constant",start=2,stop=9,v=%g,omega=0,force=0,torque=0}]'
    for push, least, most in ((0.0, 0.0, 5e-3), (0.3, 0.5, 10.0)):
        exact, blind = (run(pushed % push, *more) for more in ([], ["robot.sensors.pose=odometry"]))
        assert least <= np.abs(exact["x"] - blind["x"]).max() <= most


def test_coarse_encoders_move_the_torques():
    fine, coarse = (run(f"robot.sensors.encoder_steps={n}") for n in (10**9, 2000))
    assert (
        np.abs(np.diff(coarse["torque_right"], axis=0)).mean()
        > 2 * np.abs(np.diff(fine["torque_right"], axis=0)).mean()
    )
