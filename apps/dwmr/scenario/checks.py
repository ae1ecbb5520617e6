"""Constraints between several values of a scenario: a flat list of small checks."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import islice
from pathlib import Path

from dwmr.control import laws as controllers
from dwmr.control.rule_files import ROLES
from dwmr.scenario.graph import formation_mistakes, unknown
from dwmr.scenario.guard import safety_mistakes
from dwmr.scenario.mistakes import unknown_role
from dwmr.scenario.model import Communication, RigidBody, Robot, Scenario
from dwmr.scenario.outlines import distance_from
from dwmr.scenario.remarks import MOST_OF_A_KIND, overlaps
from dwmr.scenario.vehicle_limits import others, vehicles
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.experiments.scenario_keys import Places, split_key


def rigid_bodies(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Check the robots and disturbances for run.plant = "mujoco"."""
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
    ahead, height = robot.com_offset, own.height
    tips, repair = "the robot tips, as its centre of mass is", "put the caster beyond the centre of mass"
    for name, unit, is_wrong, why, help_text in (
        ("clearance", "m", own.clearance >= height, f" leaves no chassis below a height of {height:g} m", ""),
        (
            "wheel_mass", "kg", 2.0 * own.wheel_mass >= robot.mass,
            f": two wheels leave no chassis of a robot of {robot.mass:g} kg", "",
        ),
        ("com_height", "m", own.com_height >= height, f" is above the chassis, whose top is at {height:g} m", ""),
        ("caster_front", "m", ahead >= own.caster_front, f": {tips} {ahead:g} m ahead of the axle", repair),
        ("caster_rear", "m", -ahead >= own.caster_rear, f": {tips} {-ahead:g} m behind the axle", repair),
    ):  # fmt: skip
        if is_wrong:
            written = places.resolve(tuple(split_key(f"{key}.{name}")))[0]
            message = f"{written} = {getattr(own, name):g} {unit}{why}"
            yield places.diagnostic("FZ904", written, message, help=help_text)


def _velocities(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Refuse disturbances that are added to the velocity."""
    units = {"v": "m/s", "omega": "rad/s"}
    velocities = [(k, part) for k, one in enumerate(scenario.disturbances) for part in units if getattr(one, part)]
    if velocities:
        k, part = velocities[0]
        key = f"disturbances.{k}.{part}"
        more = f", and {len(velocities) - 1} more" if len(velocities) > 1 else ""
        message = (
            f"{key} = {getattr(scenario.disturbances[k], part):g} {units[part]}{more}: a rigid body takes forces and "
            "torques, no velocity that is added to its own"
        )
        yield places.diagnostic("FZ904", key, message, help=f"set {key} to 0.0, and force or torque in its place")


#: A run keeps every sample in memory; more than this many samples of all robots are refused.
MOST_SAMPLES = 20_000_000
#: Longest stable step of the classical Runge-Kutta method, in time constants: the real z < 0 at which
#: |1 + z + z²/2 + z³/6 + z⁴/24| = 1.
STABLE_STEP = 2.785


def cross_checks(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Check values of several keys together; of mistakes of one kind the first ones are reported."""
    checks = (
        _laws, _roles, _obstacles, _starts, formation_mistakes, _messages, _disturbed, _length, _steps, rigid_bodies,
        safety_mistakes, vehicles,
    )  # fmt: skip
    for check in checks:
        yield from islice(dict.fromkeys(check(scenario, places)), MOST_OF_A_KIND)


def _laws(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Refuse laws that are neither shipped nor beside the scenario, each where it is named first."""
    names, folder = controllers.names(), Path(places.source.name).parent
    named = {scenario.run.controller: "run.controller"}
    for name, robot in scenario.robots.items():
        for law in robot.controllers:
            named.setdefault(law, f"robots.{name}.controllers.{law}")
    for law, key in named.items():
        if not controllers.exists(law, folder):
            beside = f"there is no {law}.fz or {law}.py beside the scenario"
            yield unknown(places, key, law, "controller", names, (beside,) if law.isidentifier() else ())


def _roles(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Refuse roles that no law uses; a user's law may have more roles, see `preflight`."""
    tables = {law for robot in scenario.robots.values() for law in robot.controllers}
    if all(controllers.base(law) in controllers.PAPER for law in {scenario.run.controller, *tables}):
        yield from (unknown_role(places, role) for role in scenario.rules if role not in ROLES)


def _obstacles(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    reach = scenario.avoidance.largest_radius
    for a, obstacle in enumerate(scenario.obstacles):
        if reach <= obstacle.radius:
            message = (
                f"avoidance.largest_radius = {reach:g} m does not exceed obstacles.{a}.radius = {obstacle.radius:g} m: "
                "no robot would ever avoid it"
            )
            yield places.diagnostic("FZ904", "avoidance.largest_radius", message)
    circles = [(one.x, one.y, one.radius) for one in scenario.obstacles]
    for a, b, gap in overlaps(circles):
        message = (
            f"obstacles.{b} overlaps obstacles.{a}: their centres are {gap:.4g} m apart, their radii make "
            f"{circles[a][2] + circles[b][2]:.4g} m"
        )
        yield places.diagnostic("FZ904", f"obstacles.{b}", message, help="put one larger obstacle in their place")


def _starts(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    for name, robot in scenario.robots.items():
        for a, obstacle in enumerate(scenario.obstacles):
            gap = distance_from(obstacle, robot)
            if gap <= obstacle.radius:
                message = (
                    f"robots.{name} starts inside obstacles.{a}: ({robot.x_0:g}, {robot.y_0:g}) is {gap:.4g} m from "
                    f"its centre, its radius is {obstacle.radius:g} m"
                )
                yield places.diagnostic("FZ904", f"robots.{name}.x_0", message)


def _messages(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Refuse messages late or lost if a leader may move sideways, which they do not tell."""
    if scenario.communication != Communication() and others(scenario):
        message = "communication is for robots with two driven wheels, and a robot has another vehicle"
        yield places.diagnostic("FZ904", "communication", message, help="leave [communication] out")


def _disturbed(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    names = tuple(scenario.robots)
    for k, one in enumerate(scenario.disturbances):
        for robot_name in one.robots or ():
            if robot_name not in names:
                yield unknown(places, f"disturbances.{k}.robots", robot_name, "robot", names)


def _length(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    samples = scenario.run.steps * len(scenario.robots)
    if samples > MOST_SAMPLES:
        message = (
            f"run.horizon = {scenario.run.horizon:g} s makes {samples:,} samples; at most {MOST_SAMPLES:,} are kept"
        )
        yield places.diagnostic("FZ904", "run.horizon", message, help="shorten run.horizon or lengthen run.dt")


def _steps(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Refuse integration steps under which a rate of the plant grows instead of declining."""
    for name, robot in scenario.robots.items():
        mass = robot.mass * min(1.0, scenario.load.mass_factor)
        inertia = robot.inertia * min(1.0, scenario.load.inertia_factor)
        for key, lag, what in (
            ("actuator.lag", robot.actuator.lag, "the lag of the torques"),
            ("friction.viscous_force", _ratio(mass, robot.friction.viscous_force), "the decline of the velocity"),
            ("friction.viscous_torque", _ratio(inertia, robot.friction.viscous_torque), "the decline of turning"),
        ):
            step = scenario.run.dt / scenario.run.substeps
            if step > STABLE_STEP * lag:
                yield _unstable(scenario, places, f"robots.{name}.{key}", lag, what)


def _ratio(mass: float, friction: float) -> float:
    """Return the time constant of viscous friction [s]."""
    return mass / friction if friction > 0.0 else math.inf


def _unstable(scenario: Scenario, places: Places, key: str, lag: float, what: str) -> Diagnostic:
    run = scenario.run
    step, longest = run.dt / run.substeps, STABLE_STEP * lag
    needed = math.ceil(run.dt / longest) if run.dt < 1000.0 * longest else math.inf
    message = (
        f"run.dt / run.substeps = {step:.4g} s is too long an integration step for {what} of {lag:.4g} s: beyond "
        f"{longest:.4g} s numbers grow that should decline"
    )
    more = needed <= 1000
    facts = (f"a step of the Runge-Kutta method is stable up to {STABLE_STEP:g} time constants",)
    help_text = (
        f"set run.substeps to {needed} or more" if more else f"shorten run.dt to {1000.0 * longest:.3g} s or less"
    )
    resolved, _, _ = places.resolve(tuple(split_key(key)))
    where = "run.substeps" if places.given("run", "substeps") else "run.dt" if places.given("run", "dt") else key
    return places.diagnostic("FZ904", where, f"{resolved}: {message}", facts=facts, help=help_text)
