"""The node against a stub of rclpy: when it commands, when it stops the robots, and what it says."""

import math

import numpy as np
import pytest

from dwmr.ros.node import FormationNode, Settings, StoppedError
from dwmr.simulation.simulate import Stop
from tests.dwmr.ros.stub import Node, Odometry, Twist, odometry


class Commands:
    """Commands that count periods."""

    dt, has_ended = 0.1, False

    def __init__(self):
        self.seen = []

    def decide(self, measured):
        self.seen.append(measured)
        if len(self.seen) == 5:
            raise StoppedError(Stop(0.4, "b", "it fell over"))
        return np.array([[1.0, 0.0, 2.0], [3.0, 0.25, 4.0]])


@pytest.fixture
def node():
    return Node()


@pytest.fixture
def commands():
    return Commands()


@pytest.fixture
def formation(node, commands):
    settings = Settings("odom", "base_link", 0.5, False)
    return FormationNode(node, ("a", "b"), commands, settings, (Odometry, Twist), "sensor data")


def hear(node, **changes):
    for name in ("a", "b"):
        node.callbacks[f"{name}/odom"](changes.get(name, odometry(node.now, 1.0, 2.0, 0.5, 0.3, 0.1, v_y=-0.2)))


def last(node):
    return [node.published[f"{name}/cmd_vel"][-1] for name in ("a", "b")]


def test_commands_come_at_the_period_and_odometry_computes_nothing(node, formation, commands):
    assert node.subscribed == {"a/odom": Odometry, "b/odom": Odometry}
    assert [(period, callback) for period, callback in node.timers] == [(0.1, formation.tick)]
    hear(node)
    hear(node)
    assert commands.seen == []
    formation.tick()
    assert last(node) == [(1.0, 2.0), (3.0, 4.0)]
    assert commands.seen[0][0] == pytest.approx((1.0, 2.0, 0.5, 0.3, 0.1, -0.2))
    assert [node.sideways[f"{name}/cmd_vel"] for name in ("a", "b")] == [[0.0], [0.25]]


def test_without_odometry_robots_stand_and_the_log_names_the_topics_once(node, formation, commands):
    formation.tick()
    formation.tick()
    assert node.published["a/cmd_vel"] == [(0.0, 0.0)] * 2
    assert node.logged == [("warning", "robots stopped: no odometry on a/odom; no odometry on b/odom")]
    assert commands.seen == []


def test_old_odometry_of_one_robot_stops_all_and_the_run_waits(node, formation, commands):
    hear(node)
    formation.tick()
    node.now = 0.6
    node.callbacks["a/odom"](odometry(node.now, 0.0, 0.0, 0.0))
    formation.tick()
    assert last(node) == [(0.0, 0.0)] * 2
    assert node.logged[-1][1] == "robots stopped: no odometry on b/odom with a stamp within 0.5 s of now"
    hear(node)
    formation.tick()
    assert len(commands.seen) == 2
    assert node.logged[-1] == ("info", "odometry of all robots is there: the run goes on")


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (odometry(0.0, 0, 0, 0, frame="map"), "b/odom is in the frame 'map', expected 'odom'"),
        (odometry(0.0, 0, 0, 0, child="imu"), "b/odom is of the frame 'imu', expected 'base_link'"),
        (odometry(0.0, 0, 0, 0, child="a/base_link"), "b/odom is of the frame 'a/base_link', expected 'base_link'"),
        (odometry(0.0, math.nan, 0, 0), "a number in b/odom is not finite"),
        (odometry(0.0, 0, 0, 0, v=math.inf), "a number in b/odom is not finite"),
        (odometry(0.0, 0, 0, math.nan), "the orientation in b/odom is no unit quaternion"),
        (odometry(9.0, 0, 0, 0), "no odometry on b/odom with a stamp within 0.5 s of now"),
    ],
)
def test_odometry_that_cannot_be_used_stops_all(node, formation, commands, wrong, message):
    hear(node, b=wrong)
    formation.tick()
    assert node.logged == [("warning", f"robots stopped: {message}")]
    assert last(node) == [(0.0, 0.0)] * 2
    assert commands.seen == []


def test_the_frame_of_a_robot_may_have_its_name(node, formation, commands):
    hear(node, b=odometry(0.0, 0, 0, 0, child="b/base_link"))
    formation.tick()
    assert node.logged == []


def test_a_fault_of_the_law_ends_the_run_with_zeros(node, formation):
    hear(node)
    for _ in range(6):
        formation.tick()
    assert (formation.has_ended, formation.failed) == (True, True)
    assert len(node.published["a/cmd_vel"]) == 5
    assert last(node) == [(0.0, 0.0)] * 2
    assert node.logged[-1] == ("error", "robots stopped: robot b at t = 0.400 s: it fell over")


def test_a_stamp_that_two_periods_see_is_reported_once_for_each_robot(node, formation):
    for now in (0.0, 0.1, 0.2, 0.3):
        node.now = now
        hear(node, b=odometry(0.0, 0, 0, 0))
        formation.tick()
    repeat = "two control periods of 0.1 s see one stamp of b/odom: publish it as often, or raise run.dt"
    assert node.logged == [("warning", repeat)]


def test_a_period_that_comes_late_is_reported_once(node, formation, commands):
    for now in (0.0, 0.1, 0.26, 0.5):
        node.now = now
        hear(node)
        formation.tick()
    late = [said for severity, said in node.logged if severity == "warning"]
    assert late == [
        "0.16 s since the last period, 0.1 s expected: this computer is too slow for it, or the clock jumped; "
        "what is computed falls behind"
    ]


def test_the_end_of_the_run_stops_the_robots(node, formation, commands):
    hear(node)
    commands.has_ended = True
    formation.tick()
    assert (formation.has_ended, formation.failed) == (True, False)
    assert node.published["b/cmd_vel"] == [(3.0, 4.0), (0.0, 0.0)]
