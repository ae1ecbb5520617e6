"""MuJoCo model of a scenario, in MuJoCo's XML format MJCF: ground, robots with wheels and casters, drives."""

from __future__ import annotations

import math
from xml.etree import ElementTree as Xml

from dwmr.scenario.model import RigidBody, Robot, Scenario

#: Friction of one robot's chassis on another's [-].
BODY_FRICTION = 0.5


def mjcf(scenario: Scenario) -> str:
    """Return the MuJoCo model of a scenario.

    Robots are bodies `robot0`, `robot1` and so on whose origin is the middle of their axle, with the joints `free0`,
    `right0`, `left0` and drives `drive_right0`, `drive_left0`. A drive is a first-order lag and a limit of the torque.

    Args:
        scenario: All of its robots have a `rigid_body`.

    Source:
        Contacts of wheels are those of spheres, which touch a plane in one point. Elliptic friction cones and an
        implicit integrator with the damping of joints are what MuJoCo's documentation advises for wheels and drives.
    """
    root = Xml.Element("mujoco", model="dwmr")
    option = Xml.SubElement(
        root,
        "option",
        timestep=_text(scenario.run.dt / scenario.run.substeps),
        integrator="implicitfast",
        cone="elliptic",
        impratio="10",
    )
    Xml.SubElement(option, "flag", autoreset="disable")  # a run that diverges is to be seen as one
    Xml.SubElement(root, "compiler", angle="radian")
    world, actuator = Xml.SubElement(root, "worldbody"), Xml.SubElement(root, "actuator")
    Xml.SubElement(world, "geom", name="ground", type="plane", size="0 0 1", condim="3", friction="0 0 0")
    for i, robot in enumerate(scenario.robots.values()):
        if robot.rigid_body is not None:
            _add_robot(world, actuator, i, robot, robot.rigid_body)
    return Xml.tostring(root, encoding="unicode")


def _add_robot(world: Xml.Element, actuator: Xml.Element, i: int, robot: Robot, own: RigidBody) -> None:
    c, s, r = math.cos(robot.theta_0), math.sin(robot.theta_0), robot.wheel_radius
    axle = (robot.x_0 - robot.d * c, robot.y_0 - robot.d * s, r)
    turned = (math.cos(0.5 * robot.theta_0), 0.0, 0.0, math.sin(0.5 * robot.theta_0))
    body = Xml.SubElement(world, "body", name=f"robot{i}", pos=_text(*axle), quat=_text(*turned))
    Xml.SubElement(body, "freejoint", name=f"free{i}")
    _add_chassis(body, robot, own)
    for place, gap in ((own.caster_front, own.caster_gap), (-own.caster_rear, 0.0)):
        Xml.SubElement(
            body, "geom", type="sphere", size=_text(own.caster_radius), condim="3", priority="1",
            pos=_text(place, 0.0, own.caster_radius + gap - r), friction=_text(own.caster_friction, 0.0, 0.0),
        )  # fmt: skip
    limit = robot.actuator.torque_limit
    for side, y in (("right", -robot.half_track), ("left", robot.half_track)):
        _add_wheel(body, f"{side}{i}", y, robot, own)
        Xml.SubElement(
            actuator, "general", name=f"drive_{side}{i}", joint=f"{side}{i}", dyntype="filterexact",
            dynprm=_text(robot.actuator.lag), ctrlrange=_text(-limit, limit),
        )  # fmt: skip


def _add_chassis(body: Xml.Element, robot: Robot, own: RigidBody) -> None:
    """Add what is not wheels: its inertia and centre of mass make those of the robot what the scenario says."""
    outline, r = robot.body, robot.wheel_radius
    front, rear, width = (
        (outline.front, outline.rear, outline.width) if outline else (robot.radius,) * 2 + (2 * robot.radius,)
    )
    half_height = 0.5 * (own.height - own.clearance)
    mass = robot.mass - 2.0 * own.wheel_mass
    x = robot.mass * robot.com_offset / mass
    z = (robot.mass * own.com_height - 2.0 * own.wheel_mass * r) / mass
    wheels = 2.0 * own.wheel_mass * (robot.half_track**2 + (3.0 * r**2 + own.wheel_width**2) / 12.0)
    roll, pitch = (mass / 12.0 * (side**2 + 4.0 * half_height**2) for side in (width, front + rear))
    inertia = (roll, pitch, robot.inertia - wheels - mass * x**2)
    Xml.SubElement(body, "inertial", pos=_text(x, 0.0, z - r), mass=_text(mass), diaginertia=_text(*inertia))
    box = _text(0.5 * (front + rear), 0.5 * width, half_height)
    Xml.SubElement(
        body, "geom", type="box" if outline else "cylinder", size=box if outline else _text(robot.radius, half_height),
        pos=_text(0.5 * (front - rear), 0.0, own.clearance + half_height - r), condim="3",
        friction=_text(BODY_FRICTION, 0.0, 0.0),
    )  # fmt: skip


def _add_wheel(body: Xml.Element, name: str, y: float, robot: Robot, own: RigidBody) -> None:
    """Add a wheel; half of the robot's friction along its way acts in its bearing."""
    r = robot.wheel_radius
    wheel = Xml.SubElement(body, "body", name=name, pos=_text(0.0, y, 0.0))
    Xml.SubElement(
        wheel, "joint", name=name, axis="0 1 0", damping=_text(0.5 * robot.friction.viscous_force * r**2),
        frictionloss=_text(0.5 * robot.friction.coulomb_force * r),
    )  # fmt: skip
    across = own.wheel_mass * (3.0 * r**2 + own.wheel_width**2) / 12.0
    inertia = (across, 0.5 * own.wheel_mass * r**2, across)
    Xml.SubElement(wheel, "inertial", pos="0 0 0", mass=_text(own.wheel_mass), diaginertia=_text(*inertia))
    Xml.SubElement(
        wheel, "geom", type="sphere", size=_text(r), condim="4", priority="1",
        friction=_text(own.wheel_friction, own.wheel_spin_friction, 0.0),
    )  # fmt: skip


def _text(*values: float) -> str:
    return " ".join(f"{value:.17g}" for value in values)
