"""Discs that guard robots, and what is kept of measured distances."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from dwmr.control.safety_filter import rate_bound
from dwmr.scenario.file import find, read
from dwmr.scenario.guard import disc_radius, room_for_noise
from tests.sizes import examples


def robot(*overrides):
    return read(find("paper-with-limits"), overrides).scenario.robots["leader"]


@pytest.mark.parametrize("lookahead", [0.05, 0.3, 0.9])
def test_they_enclose_the_body_and_touch_its_farthest_corner(lookahead):
    body = robot().body
    corners = [np.hypot(x - lookahead, 0.5 * body.width) for x in (body.front, -body.rear)]
    assert disc_radius(robot(), lookahead) == pytest.approx(max(corners))


def test_they_enclose_the_circle_of_a_robot_without_body():
    without = robot().model_copy(update={"body": None})
    assert disc_radius(without, 0.3) == pytest.approx(0.3 + without.radius)


shares, angles = st.floats(0, 1), st.floats(-math.pi, math.pi)


@settings(max_examples=examples(2000))
@given(st.floats(0.5, 3), st.floats(0, 0.5), st.floats(0.1, 5), st.floats(0.01, 0.5), shares, angles, shares, shares)
def test_true_distances_keep_r_whatever_noise_is_measured(least, noise, speed, rate, share, angle, beyond, sideways):
    period = 0.05
    alpha = rate / period
    kept = float(room_for_noise(alpha, np.array(least), np.array(noise), np.array(speed)))
    assume(kept <= 2.0 * least)
    distance = least + beyond**3 * 2.0  # mostly near
    wrong = noise * math.sqrt(share)
    seen = np.array([distance + wrong * math.cos(angle), wrong * math.sin(angle)])
    measured = math.hypot(*seen)
    along, across = seen / measured, np.array([-seen[1], seen[0]]) / measured
    closing = rate_bound(alpha, measured, kept)
    assume(abs(closing) <= speed)
    left = math.sqrt(speed**2 - closing**2) * (2.0 * sideways - 1.0)
    moved = np.array([distance, 0.0]) + period * (closing * along + left * across)
    assert math.hypot(*moved) >= least - 1e-9
