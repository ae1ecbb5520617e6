"""Constraints of scenarios whose robots are rigid bodies in MuJoCo."""

from __future__ import annotations

from collections.abc import Iterable

from dwmr.scenario.model import RigidBody, Robot, Scenario
from dwmr.scenario.vehicle_checks import others
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.experiments.scenario_keys import Places, split_key


def rigid_bodies(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Check what run.plant = "mujoco" needs of the robots and of what disturbs them."""
    if scenario.run.plant != "mujoco":
        return
    refused = others(scenario)  # as vehicles, whatever bodies they have
    missing = [name for name, robot in scenario.robots.items() if robot.rigid_body is None and name not in refused]
    if missing:
        message = f"run.plant = 'mujoco' needs a table rigid_body of each robot; {', '.join(missing)} without one"
        help_text = "extend the scenario 'experiment', or copy its [robot.rigid_body]"
        yield places.diagnostic("FZ903", "run.plant", message, help=help_text)
    for name, robot in scenario.robots.items():
        if robot.rigid_body is not None:
            yield from _body(robot, robot.rigid_body, f"robots.{name}.rigid_body", places)
    yield from _velocities(scenario, places)


def _body(robot: Robot, own: RigidBody, key: str, places: Places) -> Iterable[Diagnostic]:
    clearance, wheel_mass, com_height, caster_front, caster_rear = (
        places.resolve(tuple(split_key(f"{key}.{k}")))[0]
        for k in ("clearance", "wheel_mass", "com_height", "caster_front", "caster_rear")
    )
    if own.clearance >= own.height:
        message = f"{clearance} = {own.clearance:g} m leaves no chassis below a height of {own.height:g} m"
        yield places.diagnostic("FZ904", clearance, message)
    if 2.0 * own.wheel_mass >= robot.mass:
        message = f"{wheel_mass} = {own.wheel_mass:g} kg: two wheels leave no chassis of a robot of {robot.mass:g} kg"
        yield places.diagnostic("FZ904", wheel_mass, message)
    if own.com_height >= own.height:
        message = f"{com_height} = {own.com_height:g} m is above the chassis, whose top is at {own.height:g} m"
        yield places.diagnostic("FZ904", com_height, message)
    for caster, distance, ahead, side in (
        (caster_front, own.caster_front, robot.com_offset, "ahead of"),
        (caster_rear, own.caster_rear, -robot.com_offset, "behind"),
    ):
        if ahead >= distance:
            message = f"{caster} = {distance:g} m: the robot tips, as its centre of mass is {ahead:g} m {side} the axle"
            yield places.diagnostic("FZ904", caster, message, help="put the caster beyond the centre of mass")


def _velocities(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Refuse disturbances that are added to the velocity."""
    units = {"v": "m/s", "omega": "rad/s"}
    given = [(k, part) for k, one in enumerate(scenario.disturbances) for part in units if getattr(one, part)]
    if given:
        k, part = given[0]
        key = f"disturbances.{k}.{part}"
        more = f", and {len(given) - 1} more" if len(given) > 1 else ""
        message = (
            f"{key} = {getattr(scenario.disturbances[k], part):g} {units[part]}{more}: a rigid body takes forces and "
            "torques, no velocity that is added to its own"
        )
        yield places.diagnostic("FZ904", key, message, help=f"set {key} to 0.0, and force or torque in its place")
