"""Vehicles that cannot do what a scenario asks of them."""

import math
import re

import numpy as np
import pytest

from dwmr.control.fuzzy_gains import Rules
from dwmr.scenario.file import find, read
from dwmr.scenario.vehicle_limits import point_radius
from dwmr.simulation import preflight
from fuzzyctl.diagnostics.diagnostic import DiagnosticError


def mistakes(name, *overrides):
    with pytest.raises(DiagnosticError) as error:
        read(find(name), overrides)
    return error.value.diagnostics


#: Places of followers as in the paper.
CLOSE = tuple(
    f"robots.{name}.formation.{key}"
    for name, side in (("follower1", 1), ("follower2", -1))
    for key in ("separation=1.25", f"bearing={side * 0.75 * math.pi}")
)
CIRCLE = 'reference={kind="circle",centre_x=0,centre_y=0,radius=2.0,period=60,direction="counter-clockwise"}'


OWN = "the car turns on one of 0.7308 m at the least: it would leave its way"


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
    assert "its place in the formation has one of 1.422 m" in found[1].message


@pytest.mark.parametrize(("limit", "few"), [(0.3, ["follower1"]), (0.43, [])])
def test_the_repair_is_enough(limit, few):
    arguments = (*CLOSE, CIRCLE, f"robot.vehicle.steering_limit={limit}")
    if not few:
        assert read(find("ackermann"), arguments).scenario.robots["leader"].vehicle.steering_limit == limit
    else:
        assert [one.message.split()[0] for one in mistakes("ackermann", *arguments)] == ["robots.follower1"]


def test_a_bend_that_changes_faster_than_a_car_is_steered_is_refused_with_place_rates_and_repair():
    [leader, *_] = mistakes("ackermann", "robot.vehicle.steering_rate=0.01")
    found = re.fullmatch(
        r"robots\.leader is steered by 0\.01 rad/s at the most, and the path needs (\S+) rad/s where the reference "
        r"is at \(.*\) at t = (\S+) s",
        leader.message,
    )
    rate, t = map(float, found.groups())
    # x = 15 sin 2wt, y = 15 sin wt
    w = 2 * math.pi / 200
    times = np.linspace(t - 0.05, t + 0.1, 301)
    dx, ddx = 30 * w * np.cos(2 * w * times), -60 * w**2 * np.sin(2 * w * times)
    dy, ddy = 15 * w * np.cos(w * times), -15 * w**2 * np.sin(w * times)
    curvature = (dx * ddy - dy * ddx) / np.hypot(dx, dy) ** 3
    axle = np.sign(curvature) / np.sqrt(curvature**-2 - 0.1**2)
    assert rate == pytest.approx(np.abs(np.gradient(np.arctan(0.5 * axle), times)).max(), rel=0.01)
    needed = float(re.search(r"steering_rate to (\S+) rad/s or more", leader.help)[1])
    assert rate <= needed <= rate + 0.001


def test_the_steering_rate_of_the_repair_is_enough():
    found = mistakes("ackermann", "robot.vehicle.steering_rate=0.01")
    needed = max(float(re.search(r"steering_rate to (\S+) rad/s", one.help)[1]) for one in found)
    read(find("ackermann"), [f"robot.vehicle.steering_rate={needed}"])
    assert len(mistakes("ackermann", f"robot.vehicle.steering_rate={needed - 0.002}")) >= 1


def test_a_circle_needs_no_steering():
    assert read(find("ackermann"), [CIRCLE.replace("2.0", "4.0"), "robot.vehicle.steering_rate=1e-6"])


def test_the_place_of_a_follower_has_its_own_radius():
    scenario = read(find("paper")).scenario
    side = 1.25 * math.sqrt(0.5)
    centre = math.sqrt(10.0**2 - 0.1**2)
    assert point_radius(scenario, "leader", -10.0) == 10.0
    assert point_radius(scenario, "follower1", 10.0) == pytest.approx(math.hypot(side, centre - side))
    assert point_radius(scenario, "follower1", -10.0) == pytest.approx(math.hypot(side, centre + side))
    assert point_radius(scenario, "follower2", 10.0) == pytest.approx(math.hypot(side, centre + side))


@pytest.mark.parametrize(
    ("name", "overrides", "words"),
    [
        ("ackermann", ["run.plant=mujoco"], "run.plant = 'mujoco' has bodies with two driven wheels"),
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
        (
            "undisturbed",
            ['robot.vehicle={kind="omnidirectional"}'],
            "robot.vehicle.half_base is missing",
        ),
    ],
)
def test_what_is_made_for_two_wheels_is_refused(name, overrides, words):
    assert words in "\n".join(one.message for one in mistakes(name, *overrides))


def test_a_law_that_commands_sideways_needs_robots_that_can():
    file = read(find("undisturbed"))
    rules = Rules(file.scenario.rules, file.folders, file.places)
    with pytest.raises(DiagnosticError) as error:
        preflight.check(file, ["omnidirectional"], rules)
    [found] = error.value.diagnostics
    assert found.message.endswith("robots that cannot move sideways are leader, follower1, follower2")


@pytest.mark.parametrize(
    ("overrides", "found"),
    [
        ((), []),
        (
            ["robot.controllers.ackermann.kappa_max=3"],
            [f"robot.controllers.ackermann.kappa_max = 3 1/m asks for a radius of 0.3333 m, and {OWN}"],
        ),
        (
            ["robots.leader.controllers.ackermann.kappa_max=1.37"],
            [f"robots.leader.controllers.ackermann.kappa_max = 1.37 1/m asks for a radius of 0.7299 m, and {OWN}"],
        ),
        (["robots.leader.controllers.ackermann.kappa_max=1.368"], []),
    ],
)
def test_a_law_that_asks_for_more_curvature_than_the_steering_gives_is_warned_of(overrides, found):
    file = read(find("ackermann"), overrides)
    rules = Rules(file.scenario.rules, file.folders, file.places)
    preflight.check(file, ["ackermann"], rules)
    assert [d.message for d in rules.warnings] == found
    for one in rules.warnings:
        assert (one.severity, one.help) == ("warning", "set kappa_max to 1.368 1/m or less")
        assert one.facts == ("wheelbase / tan(steering_limit) = 0.5 m / tan(0.6 rad) = 0.7308 m at the rear axle",)
