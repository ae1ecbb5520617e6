"""Discs that guard robots."""

import numpy as np
import pytest

from dwmr.scenario.file import find, read
from dwmr.scenario.guard import disc_radius


def robot(*overrides):
    return read(find("paper-with-limits"), overrides).scenario.robots["leader"]


@pytest.mark.parametrize("lookahead", [0.05, 0.3, 0.9])
def test_they_enclose_the_body_and_touch_its_farthest_corner(lookahead):
    body = robot().body
    corners = [np.hypot(x - lookahead, 0.5 * body.width) for x in (body.front, -body.rear)]
    assert disc_radius(robot(), lookahead) == pytest.approx(max(corners))


def test_they_enclose_the_circle_of_a_robot_without_body():
    given = robot().model_copy(update={"body": None})
    assert disc_radius(given, 0.3) == pytest.approx(0.3 + given.radius)
