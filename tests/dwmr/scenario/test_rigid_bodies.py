"""Scenarios for MuJoCo that say too little, or what no rigid body can do."""

import pytest

from dwmr import find, read
from tests.dwmr.scenarios import messages

#: Scenario, overrides, and how the messages begin.
REFUSED = [
    ("undisturbed", ["run.plant=mujoco"],
     ["run.plant = 'mujoco' needs a table rigid_body of each robot; leader, follower1, follower2"]),
    ("experiment", ["disturbances=[{kind='constant',start=0,stop=1,v=0.1,omega=0.2,force=0,torque=0}]"],
     ["disturbances.0.v = 0.1 m/s, and 1 more: a rigid body takes forces"]),
    ("experiment", ["robot.rigid_body.clearance=0.5", "robots.leader.rigid_body.wheel_mass=60"],
     ["robot.rigid_body.clearance = 0.5 m leaves no chassis below a height of 0.48 m",
      "robots.leader.rigid_body.wheel_mass = 60 kg: two wheels leave no chassis of a robot of 120 kg"]),
    ("experiment", ["robot.rigid_body.caster_rear=0.05", "robot.rigid_body.com_height=0.5"],
     ["robot.rigid_body.caster_rear = 0.05 m: the robot tips, as its centre of mass is 0.0865 m behind",
      "robot.rigid_body.com_height = 0.5 m is above the chassis, whose top is at 0.48 m"]),
    ("experiment", ["robots.leader.com_offset=0.26"],
     ["robot.rigid_body.caster_front = 0.25 m: the robot tips, as its centre of mass is 0.26 m ahead"]),
    ("ackermann", ["run.plant=mujoco"], ["run.plant = 'mujoco' has bodies with two driven wheels"]),
]  # fmt: skip


@pytest.mark.parametrize(("name", "overrides", "words"), REFUSED)
def test_are_refused(name, overrides, words):
    for message, wanted in zip(sorted(messages(name, *overrides)), sorted(words), strict=True):
        assert message.startswith(wanted)


def test_a_scenario_of_equations_may_have_them():
    assert read(find("experiment"), ["run.plant=equations"]).scenario.run.plant == "equations"


@pytest.mark.parametrize(("plant", "words"), [("mujoco", "are thrown apart"), ("equations", "do not see one another")])
def test_robots_that_start_in_one_another_are_warned_of_what_follows(plant, words):
    inside = ["robots.follower1.x_0=-0.9", "robots.follower1.y_0=1.1"]
    (found,) = read(find("experiment"), [f"run.plant={plant}", *inside]).warnings
    assert found.message.startswith("robots.follower1 starts inside robots.leader")
    assert words in found.help
