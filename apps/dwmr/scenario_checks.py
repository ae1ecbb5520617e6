"""What several values of a scenario must hold together: a flat list of small checks."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from itertools import combinations
from pathlib import Path

from dwmr import controllers
from dwmr.fuzzy_gains import ROLES
from dwmr.places import Places
from dwmr.scenario import Scenario
from dwmr.scenario_mistakes import unknown_role
from fuzzyctl.errors import Diagnostic, did_you_mean

#: A run keeps every sample in memory; more than this many samples of all robots are refused.
MOST_SAMPLES = 5_000_000


def cross_checks(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Check what concerns several keys at once."""
    for check in (_laws, _roles, _obstacles, _starts, _formation, _disturbed, _length):
        yield from check(scenario, places)


def remarks(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Warn of what a run does otherwise than its author may think."""
    for remark in (_rounded, _together):
        for found in remark(scenario, places):
            yield dataclasses.replace(found, severity="warning")


def _laws(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    laws, folder = controllers.names(), Path(places.source.name).parent
    if not controllers.exists(scenario.run.controller, folder):
        yield _unknown(places, "run.controller", scenario.run.controller, "controller", laws)
    for name, robot in scenario.robots.items():
        for law in robot.controllers.__pydantic_extra__ or {}:
            if not controllers.exists(law, folder):
                yield _unknown(places, f"robots.{name}.controllers.{law}", law, "controller", laws)


def _roles(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    for role in scenario.rules:
        if role not in ROLES:
            yield unknown_role(places, role)


def _obstacles(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    reach = scenario.avoidance.largest_radius
    for a, obstacle in enumerate(scenario.obstacles):
        if reach <= obstacle.radius:
            message = (
                f"avoidance.largest_radius = {reach:g} m does not exceed obstacles.{a}.radius = {obstacle.radius:g} m: "
                "no robot would ever avoid it"
            )
            yield places.diagnostic("FZ904", "avoidance.largest_radius", message)
    for (a, one), (b, other) in combinations(enumerate(scenario.obstacles), 2):
        gap, radii = math.hypot(other.x - one.x, other.y - one.y), one.radius + other.radius
        if gap < radii:
            message = (
                f"obstacles.{b} overlaps obstacles.{a}: their centres are {gap:.4g} m apart, their radii make "
                f"{radii:.4g} m"
            )
            help_text = "put one larger obstacle in their place"
            yield places.diagnostic("FZ904", f"obstacles.{b}", message, help=help_text)


def _starts(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    for name, robot in scenario.robots.items():
        for a, obstacle in enumerate(scenario.obstacles):
            gap = math.hypot(obstacle.x - robot.x_0, obstacle.y - robot.y_0)
            if gap <= obstacle.radius:
                message = (
                    f"robots.{name} starts inside obstacles.{a}: ({robot.x_0:g}, {robot.y_0:g}) is {gap:.4g} m from "
                    f"its centre, its radius is {obstacle.radius:g} m"
                )
                yield places.diagnostic("FZ904", f"robots.{name}.x_0", message)


def _formation(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    names = tuple(scenario.robots)
    for name, robot in scenario.robots.items():
        if robot.formation is None:
            continue
        key, leader = f"robots.{name}.formation.leader", robot.formation.leader
        if leader not in names:
            yield _unknown(places, key, leader, "robot", names)
        elif leader == name:
            yield places.diagnostic("FZ904", key, f"{key} = {leader!r}: a robot cannot follow itself")
        elif circle := _circle(scenario, name):
            message = f"{key} leads back to {name}: {' -> '.join(circle)}; some robot must follow the reference"
            yield places.diagnostic("FZ904", key, message)
        elif robot.avoids_obstacles:
            key = f"robots.{name}.avoids_obstacles"
            message = f"{key} = true, but {name} follows {leader}: only a robot on the reference avoids"
            yield places.diagnostic("FZ904", key, message)
        if robot.delay != 0.0:
            key = f"robots.{name}.delay"
            message = (
                f"{key} = {robot.delay:g} s, but {name} follows {leader}: only a robot on the reference has a delay"
            )
            yield places.diagnostic("FZ904", key, message)


def _circle(scenario: Scenario, name: str) -> tuple[str, ...]:
    """Return the way from a robot over its leaders back to itself, or nothing."""
    way = [name]
    formation = scenario.robots[name].formation
    while formation is not None and formation.leader in scenario.robots:
        if formation.leader in way:
            return (*way, name) if formation.leader == name else ()
        way.append(formation.leader)
        formation = scenario.robots[formation.leader].formation
    return ()


def _disturbed(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    names = tuple(scenario.robots)
    for k, one in enumerate(scenario.disturbances):
        for robot_name in one.robots or ():
            if robot_name not in names:
                yield _unknown(places, f"disturbances.{k}.robots", robot_name, "robot", names)


def _length(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    samples = scenario.run.steps * len(scenario.robots)
    if samples > MOST_SAMPLES:
        message = (
            f"run.horizon = {scenario.run.horizon:g} s makes {samples:,} samples; at most {MOST_SAMPLES:,} are kept"
        )
        yield places.diagnostic("FZ904", "run.horizon", message, help="shorten run.horizon or lengthen run.dt")


def _rounded(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    run = scenario.run
    reached = run.steps * run.dt
    if abs(reached - run.horizon) > 1e-9 * run.horizon:
        message = (
            f"run.horizon = {run.horizon:g} s is no multiple of run.dt = {run.dt:g} s: the run ends at {reached:.6g} s"
        )
        yield places.diagnostic("FZ904", "run.horizon", message)


def _together(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Find robots that are sent to one place."""
    taken: dict[object, str] = {}
    for name, robot in scenario.robots.items():
        formation = robot.formation
        goal = formation or robot.delay
        if goal in taken:
            where = f"the same place behind {formation.leader}" if formation else "the same place of the reference"
            message = f"robots.{name} and robots.{taken[goal]} are sent to {where}"
            help_text = "give one another separation or bearing" if formation else "give one a delay, or a leader"
            key = f"robots.{name}.formation" if formation else f"robots.{name}"
            yield places.diagnostic("FZ904", key, message, help=help_text)
        taken.setdefault(goal, name)


def _unknown(places: Places, key: str, name: str, kind: str, known: tuple[str, ...]) -> Diagnostic:
    message = f"{key} names an unknown {kind} {name!r}"
    return places.diagnostic(
        "FZ904", key, message, facts=(f"there are {', '.join(known)}",), help=did_you_mean(name, known)
    )
