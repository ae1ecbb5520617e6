"""Places of obstacles over time, discs that guard robots, and the distances kept of measured ones."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from dwmr import find, read
from dwmr.control.safety_filter import rate_bound
from dwmr.scenario.guard import disc_radius, room_for_noise
from dwmr.scenario.outlines import centres, is_moving, largest_speed, outline, start
from tests.sizes import examples

STILL = "{x=1,y=2,radius=0.5}"
STRAIGHT = "{x=-9,y=2,radius=0.5,velocity=[0.5,-1.0]}"
BENT = "{x=0,y=9,radius=0.5,path=[[2,4,9],[4,4,5]]}"
LEADER = read(find("paper-with-limits")).scenario.robots["leader"]


def scenario(*obstacles):
    return read(find("paper"), [f"obstacles=[{','.join(obstacles)}]"]).scenario


def test_they_rest_go_straight_on_or_along_a_path():
    moving = scenario(STILL, STRAIGHT, BENT)
    found = centres(moving, np.array([0.0, 1.0, 3.0, 9.0]))
    assert found[:, 0].tolist() == [[1.0, 2.0]] * 4
    assert found[:, 1].tolist() == [[-9.0, 2.0], [-8.5, 1.0], [-7.5, -1.0], [-4.5, -7.0]]
    assert found[:, 2].tolist() == [[0.0, 9.0], [2.0, 9.0], [4.0, 7.0], [4.0, 5.0]]
    assert [largest_speed(one) for one in moving.obstacles] == pytest.approx([0.0, np.hypot(0.5, 1.0), 2.0])
    assert is_moving(moving)
    assert not is_moving(scenario(STILL))


class TestOutline:
    def test_is_the_body_about_the_axle_or_the_circle_that_encloses_a_robot(self):
        found = outline(LEADER)
        assert (found.half_length, found.half_width, found.margin) == pytest.approx((0.4555, 0.34, 0.0))
        assert found.middle + LEADER.d == pytest.approx(-0.0865)
        assert outline(LEADER.model_copy(update={"body": None})) == (-0.1, 0.0, 0.0, 0.56)

    def test_starts_behind_the_reference_point(self):
        robot = LEADER.model_copy(update={"x_0": 1.0, "y_0": 2.0, "theta_0": np.pi / 2})
        assert start(robot)[:, 0] == pytest.approx([1.0, 2.0 - 0.1865, np.pi / 2])


@pytest.mark.parametrize("lookahead", [0.05, 0.9])
def test_discs_enclose_the_body_and_touch_its_farthest_corner(lookahead):
    body = LEADER.body
    corners = [np.hypot(x - lookahead, 0.5 * body.width) for x in (body.front, -body.rear)]
    assert disc_radius(LEADER, lookahead) == pytest.approx(max(corners))
    without = LEADER.model_copy(update={"body": None})
    assert disc_radius(without, lookahead) == pytest.approx(lookahead + without.radius)


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
