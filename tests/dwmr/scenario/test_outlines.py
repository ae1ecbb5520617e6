"""Outlines of the shipped scenario's robots and where they start."""

import numpy as np
import pytest

from dwmr.scenario.file import find, read
from dwmr.scenario.outlines import outline, start

SCENARIO = read(find("paper")).scenario


class TestOutline:
    def test_is_the_body_about_the_axle(self):
        leader = SCENARIO.robots["leader"]
        found = outline(leader)
        assert (found.half_length, found.half_width, found.margin) == pytest.approx((0.4555, 0.34, 0.0))
        assert found.middle + leader.d == pytest.approx(-0.0865)

    def test_of_a_robot_without_a_body_is_the_circle_that_encloses_it(self):
        found = outline(SCENARIO.robots["leader"].model_copy(update={"body": None}))
        assert found == (-0.1, 0.0, 0.0, 0.56)


def test_a_robot_starts_with_its_outline_behind_its_reference_point():
    robot = SCENARIO.robots["leader"].model_copy(update={"x_0": 1.0, "y_0": 2.0, "theta_0": np.pi / 2})
    assert start(robot)[:, 0] == pytest.approx([1.0, 2.0 - 0.1865, np.pi / 2])
