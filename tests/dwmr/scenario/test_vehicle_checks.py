"""Vehicles that cannot do what a scenario asks of them, and commands within what they take."""

import math
import re

import numpy as np
import pytest

from dwmr import find, read
from tests.dwmr.process import here
from tests.dwmr.scenarios import diagnostics, messages, mistakes, run

#: Places of followers as in the paper.
CLOSE = tuple(
    f"robots.{name}.formation.{key}"
    for name, side in (("follower1", 1), ("follower2", -1))
    for key in ("separation=1.25", f"bearing={side * 0.75 * math.pi}")
)
CIRCLE = 'reference={kind="circle",centre_x=0,centre_y=0,radius=2.0,period=60,direction="counter-clockwise"}'


def test_a_path_closer_than_a_car_turns_is_refused_with_place_radii_and_repair():
    limit = math.atan(0.5 / 3.0)
    found = mistakes("ackermann", *CLOSE, CIRCLE, f"robot.vehicle.steering_limit={limit}")
    assert len(found) == 3
    assert found[0].code == "FZ904"
    assert found[0].message == (
        "robots.leader turns on a radius of 3.002 m at the least, and the path has one of 2 m where the reference is "
        "at (2, 0) at t = 0 s"
    )
    assert "3 m at the rear axle, 3.002 m at the reference point 0.1 m ahead of it" in found[0].facts[0]
    assert found[0].help == "set steering_limit to 0.246 rad or more, or widen the path"
    side, centre = 1.25 * math.sqrt(0.5), math.sqrt(2.0**2 - 0.1**2)
    for one, radius in zip(found[1:], (math.hypot(side, centre - side), math.hypot(side, centre + side)), strict=True):
        assert f"its place in the formation has one of {radius:.4g} m" in one.message
    few = mistakes("ackermann", *CLOSE, CIRCLE, "robot.vehicle.steering_limit=0.3")
    assert [one.message.split()[0] for one in few] == ["robots.follower1"]
    assert read(find("ackermann"), (*CLOSE, CIRCLE, "robot.vehicle.steering_limit=0.43"))


def test_a_bend_that_changes_faster_than_a_car_is_steered_is_refused_with_place_rates_and_repair():
    found = mistakes("ackermann", "robot.vehicle.steering_rate=0.01")
    pattern = (
        r"robots\.leader is steered by 0\.01 rad/s at the most, and the path needs (\S+) rad/s where the reference "
        r"is at \(.*\) at t = (\S+) s"
    )
    rate, t = map(float, re.fullmatch(pattern, found[0].message).groups())
    # x = 15 sin 2wt, y = 15 sin wt
    w = 2 * math.pi / 200
    times = np.linspace(t - 0.05, t + 0.1, 301)
    dx, ddx = 30 * w * np.cos(2 * w * times), -60 * w**2 * np.sin(2 * w * times)
    dy, ddy = 15 * w * np.cos(w * times), -15 * w**2 * np.sin(w * times)
    curvature = (dx * ddy - dy * ddx) / np.hypot(dx, dy) ** 3
    axle = np.sign(curvature) / np.sqrt(curvature**-2 - 0.1**2)
    assert rate == pytest.approx(np.abs(np.gradient(np.arctan(0.5 * axle), times)).max(), rel=0.01)
    needed = [float(re.search(r"steering_rate to (\S+) rad/s or more", one.help)[1]) for one in found]
    assert rate <= needed[0] <= rate + 0.001
    read(find("ackermann"), [f"robot.vehicle.steering_rate={max(needed)}"])
    assert mistakes("ackermann", f"robot.vehicle.steering_rate={max(needed) - 0.002}")


def test_a_circle_needs_no_steering():
    assert read(find("ackermann"), [CIRCLE.replace("2.0", "4.0"), "robot.vehicle.steering_rate=1e-6"])


@pytest.mark.parametrize(
    ("name", "overrides", "words"),
    [
        (
            "omnidirectional",
            ["safety={alpha=1,lookahead=0.1,margin=0.1,acceleration=1,angular_acceleration=1,velocity_error=0}"],
            "[safety] plans the two commands of two driven wheels, and robots.leader is omnidirectional, whose third",
        ),
        ("omnidirectional", ["robot.sensors.pose=odometry"], "robot.sensors.pose = 'odometry' counts no way sideways"),
        ("omnidirectional", ["robot.com_offset=0.5"], "robot.inertia = 13.8 kg m² about the centre must be more than"),
        ("ackermann", ["robot.vehicle.wheel=1"], "unknown key robot.vehicle.wheel"),
        ("ackermann", ["robot.vehicle.steering_limit=1.6"], "robot.vehicle.steering_limit must be"),
        ("undisturbed", ['robot.vehicle={kind="tank"}'], "robot.vehicle.kind must be one of"),
        ("undisturbed", ['robot.vehicle={kind="omnidirectional"}'], "robot.vehicle.half_base is missing"),
    ],
)
def test_settings_of_two_wheels_and_unknown_ones_are_refused(name, overrides, words):
    assert words in "\n".join(messages(name, *overrides))


def test_a_law_that_commands_sideways_needs_robots_that_can():
    [found] = diagnostics(run, "undisturbed", "omnidirectional")
    assert found.message.endswith("robots that cannot move sideways are leader, follower1, follower2")


@pytest.mark.parametrize(
    ("override", "curvature", "radius"),
    [
        ("run.seed=1", "", ""),
        ("robot.controllers.ackermann.kappa_max=3", "3", "0.3333"),
        ("robots.leader.controllers.ackermann.kappa_max=1.37", "1.37", "0.7299"),
        ("robots.leader.controllers.ackermann.kappa_max=1.368", "", ""),
    ],
)
def test_a_law_that_asks_for_more_curvature_than_the_steering_gives_is_warned_of(override, curvature, radius):
    found = here("check", "ackermann", "--set", override).stderr
    assert (found == "") == (curvature == "")
    if curvature:
        key = override.partition("=")[0]
        assert f"warning[FZ904]: {key} = {curvature} 1/m asks for a radius of {radius} m, and the car turns on" in found
        assert "= wheelbase / tan(steering_limit) = 0.5 m / tan(0.6 rad) = 0.7308 m at the rear axle" in found
        assert "= help: set kappa_max to 1.368 1/m or less" in found
