"""Rigid bodies in MuJoCo in place of the plant's equations."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from importlib import import_module
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.scenario.file import ScenarioFile
from dwmr.scenario.model import DisturbanceSettings, RigidBody, Robot, Scenario
from fuzzyctl.diagnostics.diagnostic import DiagnosticError

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
    """Add the chassis: its inertia and centre of mass give the robot those of the scenario."""
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


class MujocoPlant:
    """Robots of a scenario as rigid bodies, an `interfaces.Plant`.

    Args:
        scenario: A scenario; all of its robots have a `rigid_body`.

    Raises:
        ImportError: Without MuJoCo.
        ValueError: For a model that MuJoCo refuses.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._mujoco: Any = import_module("mujoco")
        if self._mujoco.get_mju_user_warning() is None:  # it would write a file MUJOCO_LOG.TXT
            self._mujoco.set_mju_user_warning(_diverges)
        model = self._mujoco.MjModel.from_xml_string(mjcf(scenario))
        self._unloaded, self._load = model, scenario.load
        self._loaded = self._mujoco.MjModel.from_xml_string(mjcf(_loaded(scenario)))
        self._data = self._mujoco.MjData(model)
        self._robots, self._substeps = list(scenario.robots.values()), scenario.run.substeps
        self._pushes = [
            [d for d in scenario.disturbances if d.robots is None or name in d.robots] for name in scenario.robots
        ]
        count = range(len(self._robots))
        self._bodies = [model.body(f"robot{i}").id for i in count]
        self._places = [int(model.joint(f"free{i}").qposadr[0]) for i in count]
        self._speeds = [int(model.joint(f"free{i}").dofadr[0]) for i in count]
        self._wheels = np.array([[model.joint(f"{s}{i}").dofadr[0] for s in ("right", "left")] for i in count])
        self._drives = np.array([[model.actuator(f"drive_{s}{i}").id for s in ("right", "left")] for i in count])
        self._theta = [robot.theta_0 for robot in self._robots]

    @property
    def positions(self) -> FloatArray:
        """Place and quaternion of each robot's body and angles of its right and left wheel, one robot after the other.

        It is what MuJoCo calls `qpos`, shape (9 * robots,) [m, rad].
        """
        positions: FloatArray = self._data.qpos
        return positions

    def move(self, t: float, torques: FloatArray, state: FloatArray, slip: FloatArray) -> None:
        """Move all robots by one control period, see `interfaces.Plant`."""
        data = self._data
        data.ctrl[self._drives] = torques
        for i, pushes in enumerate(self._pushes):
            force, torque = _push(t, pushes)
            c, s = math.cos(self._theta[i]), math.sin(self._theta[i])
            data.xfrc_applied[self._bodies[i]] = (force * c, force * s, 0.0, 0.0, 0.0, torque)
        model = self._loaded if self._load.start <= t < self._load.stop else self._unloaded
        self._mujoco.mj_step(model, data, self._substeps)
        spins = data.qvel[self._wheels].tolist()
        applied = data.act[self._drives].tolist()
        for i, robot in enumerate(self._robots):
            x, y, _, w, a, b, c = data.qpos[self._places[i] : self._places[i] + 7].tolist()
            v_x, v_y, _, _, _, turning = data.qvel[self._speeds[i] : self._speeds[i] + 6].tolist()
            forward_x, forward_y = 1.0 - 2.0 * (b * b + c * c), 2.0 * (a * b + w * c)
            self._theta[i] += math.remainder(math.atan2(forward_y, forward_x) - self._theta[i], math.tau)
            forward_x, forward_y = math.cos(self._theta[i]), math.sin(self._theta[i])
            right, left = (robot.wheel_radius * spin for spin in spins[i])
            v, omega = 0.5 * (right + left), 0.5 * (right - left) / robot.half_track
            state[i] = (x + robot.d * forward_x, y + robot.d * forward_y, self._theta[i], v, omega, *applied[i])
            slip[i] = (v_x * forward_x + v_y * forward_y - v, turning - omega)


def _diverges(warning: str) -> None:
    """Take note of nothing: the loop says where and when the numbers of a run leave all bounds."""


def require(file: ScenarioFile) -> None:
    """Refuse a scenario for MuJoCo where MuJoCo is not installed, or does not take its robots.

    Raises:
        DiagnosticError: Where it is so.
    """
    if file.scenario.run.plant != "mujoco":
        return
    try:
        MujocoPlant(file.scenario)
    except ImportError as error:
        message = "run.plant = 'mujoco' needs the package mujoco, which is not installed"
        help_text = "pip install 'fuzzyctl[physics]', or set run.plant to 'equations'"
        facts = (str(error),)
    except (RuntimeError, AttributeError) as error:  # it chooses its renderer when it is imported
        message = f"MuJoCo cannot be imported with MUJOCO_GL = {os.environ.get('MUJOCO_GL', '')!r}"
        help_text, facts = "leave MUJOCO_GL unset, or set it to egl", (str(error),)
    except ValueError as error:
        message, facts = "MuJoCo does not load the model of this scenario", (str(error),)
        help_text = "look at the mass, inertia and [robot.rigid_body] of the robots"
    else:
        return
    raise DiagnosticError([file.places.diagnostic("FZ904", "run.plant", message, facts=facts, help=help_text)])


def _loaded(scenario: Scenario) -> Scenario:
    """Return a scenario whose robots have the mass and inertia of the load window."""
    load = scenario.load
    robots = {
        name: one.model_copy(update={"mass": one.mass * load.mass_factor, "inertia": one.inertia * load.inertia_factor})
        for name, one in scenario.robots.items()
    }
    return scenario.model_copy(update={"robots": robots})


def _push(t: float, pushes: Iterable[DisturbanceSettings]) -> tuple[float, float]:
    """Return the force along a robot and the torque about the vertical that act on it at a time [N, N m]."""
    force = torque = 0.0
    for one in pushes:
        if one.start <= t < one.stop:
            shape = math.sin(one.angular_frequency * t + one.phase) if one.kind == "sinusoid" else 1.0
            force, torque = force + shape * one.force, torque + shape * one.torque
    return force, torque
