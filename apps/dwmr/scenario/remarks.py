"""Warnings about valid scenarios whose runs may differ from what their author expects: a flat list of checks."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations, islice

import numpy as np

from dwmr.core.arrays import Reference
from dwmr.reference.prepared import Shape
from dwmr.scenario.graph import followed
from dwmr.scenario.guard import safety_remarks
from dwmr.scenario.model import Ackermann, Scenario, Window
from dwmr.scenario.outlines import gap_between, gap_to_point, outline, start
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.experiments.scenario_keys import Places

#: Remarks, or mistakes, of one kind that are given; more of them say nothing new.
MOST_OF_A_KIND = 10
#: Places of a path at which its velocities are taken.
_PLACES = 400


def remarks(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Warn of values with surprising effects."""
    for remark in (
        _rounded,
        _together,
        _starts,
        _margin,
        _windows,
        _spared,
        _fast,
        _slow_drives,
        _steered,
        safety_remarks,
    ):
        diagnostics = dict.fromkeys(remark(scenario, places))
        yield from (dataclasses.replace(one, severity="warning") for one in islice(diagnostics, MOST_OF_A_KIND))


def too_slow(scenario: Scenario, shapes: Mapping[str, Shape], places: Places) -> Iterable[Diagnostic]:
    """Warn of robots on a reference that may not move as fast as it does somewhere."""
    paths = {id(one): _along(one, scenario.run.horizon) for one in shapes.values()}
    for name, robot in scenario.robots.items():
        path = paths[id(shapes[name])]
        for key, field, unit in (("v_limit", "v", "m/s"), ("omega_limit", "omega", "rad/s")):
            if robot.formation is not None or (key == "omega_limit" and isinstance(robot.vehicle, Ackermann)):
                continue  # a car is limited by its steering
            speeds = [abs(getattr(there, field)) for _, there in path]
            k, limit = int(np.argmax(np.nan_to_num(speeds, posinf=0.0))), getattr(robot.actuator, key)
            if limit < speeds[k]:
                t, there = path[k]
                message = (
                    f"robots.{name}.actuator.{key} = {limit:g} {unit} is below the {speeds[k]:.4g} {unit} that the "
                    f"path asks for at ({there.x:.4g}, {there.y:.4g}), t = {t:.4g} s: it falls behind or off the path"
                )
                one = places.diagnostic("FZ904", f"robots.{name}.actuator.{key}", message)
                yield dataclasses.replace(one, severity="warning")


def _along(shape: Shape, horizon: float) -> list[tuple[float, Reference]]:
    """Return times and references all along a path."""
    end = min(horizon, shape.end, shape.period or math.inf)
    times = np.linspace(0.0, end, _PLACES, endpoint=False).tolist()
    return list(zip(times, shape.along(times), strict=True))


def overlaps(circles: Sequence[tuple[float, float, float]]) -> Iterable[tuple[int, int, float]]:
    """Give every circle that overlaps one before it: both numbers, the other's first, and their distance.

    Args:
        circles: Centres and radii [m].
    """
    for b, (x, y, radius) in enumerate(circles):
        for a in range(b):
            gap = math.hypot(circles[a][0] - x, circles[a][1] - y)
            if gap < circles[a][2] + radius:
                yield a, b, gap
                break


def _rounded(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    run = scenario.run
    reached = run.steps * run.dt
    if abs(reached - run.horizon) > 1e-9 * run.horizon:
        message = f"run.horizon = {run.horizon:g} s is not a multiple of run.dt = {run.dt:g} s"
        message += f": the run ends at {reached:.6g} s"
        yield places.diagnostic("FZ904", "run.horizon", message)


def _together(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Find robots that are sent to one place."""
    robots: dict[object, str] = {}
    for name, robot in scenario.robots.items():
        formation = robot.formation
        goal = formation or (robot.reference, robot.delay)
        if goal in robots:
            behind = f"the same place behind {followed(scenario, name)}"
            where = behind if formation else "the same place of the reference"
            message = f"robots.{name} and robots.{robots[goal]} are sent to {where}"
            help_text = "give one another separation or bearing" if formation else "give one a delay, or a leader"
            key = f"robots.{name}.formation" if formation else f"robots.{name}"
            yield places.diagnostic("FZ904", key, message, help=help_text)
        robots.setdefault(goal, name)


def _starts(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Find bodies that begin inside one another, or inside an obstacle."""
    outlines = {name: (start(robot), outline(robot)) for name, robot in scenario.robots.items()}
    circles = {name: (float(pose[0, 0]), float(pose[1, 0]), one.reach) for name, (pose, one) in outlines.items()}
    for a, b in combinations(outlines, 2):
        (x_a, y_a, reach_a), (x_b, y_b, reach_b) = circles[a], circles[b]
        if math.hypot(x_a - x_b, y_a - y_b) < reach_a + reach_b:
            depth = -float(gap_between(*outlines[a], *outlines[b])[0])
            if depth > 0.0:
                message = f"robots.{b} starts inside robots.{a}: their bodies overlap by {depth:.2g} m"
                bodies = scenario.run.plant == "mujoco"
                why = "bodies that overlap are thrown apart" if bodies else "robots do not see one another"
                yield places.diagnostic("FZ904", f"robots.{b}.x_0", message, help=why)
    x, y, radius = (np.array([getattr(one, key) for one in scenario.obstacles]) for key in ("x", "y", "radius"))
    for name, robot in scenario.robots.items():
        depths = radius - gap_to_point(*outlines[name], x, y)
        # where the reference point is inside as well, that is a mistake
        for k in np.flatnonzero((depths > 0.0) & (np.hypot(x - robot.x_0, y - robot.y_0) > radius)):
            message = f"the body of robots.{name} starts inside obstacles.{k}: they overlap by {depths[k]:.2g} m"
            yield places.diagnostic("FZ904", f"robots.{name}.x_0", message)


def _margin(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Find robots for which the bound of the avoidance radius takes the safety margin away."""
    settings = scenario.avoidance
    largest = max((one.radius for one in scenario.obstacles), default=0.0)
    for name, robot in scenario.robots.items():
        wanted = largest + robot.radius + settings.margin
        if robot.avoids_obstacles and scenario.obstacles and settings.largest_radius < wanted:
            message = (
                f"avoidance.largest_radius = {settings.largest_radius:g} m cuts the safety margin: obstacle "
                f"{largest:g} m, robots.{name}.radius = {robot.radius:g} m and avoidance.margin = "
                f"{settings.margin:g} m make {wanted:g} m"
            )
            yield places.diagnostic("FZ904", "avoidance.largest_radius", message)


def _windows(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Find disturbances, and a load, that begin only when the run is over."""
    end = scenario.run.steps * scenario.run.dt
    if places.given("run", "horizon"):  # a run cut short on the command line is cut short on purpose
        return
    windows: list[tuple[str, Window]] = [(f"disturbances.{k}", one) for k, one in enumerate(scenario.disturbances)]
    changed = (scenario.load.mass_factor, scenario.load.inertia_factor) != (1.0, 1.0)
    for key, window in [*windows, *([("load", scenario.load)] if changed else [])]:
        _, span, argument = places.resolve(tuple(f"{key}.start".split(".")))
        # windows taken over from another scenario are not mistakes of one that runs shorter
        if window.start > end and (argument or (span is not None and span.source is places.source)):
            message = f"{key}.start = {window.start:g} s comes after the end of the run at {end:g} s: it never acts"
            yield places.diagnostic("FZ904", f"{key}.start", message)


def _spared(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Find lists of robots that name none, or one twice."""
    for k, one in enumerate(scenario.disturbances):
        key = f"disturbances.{k}.robots"
        if one.robots == ():
            message = f"{key} = [] names no robot: the disturbance never acts"
            yield places.diagnostic("FZ904", key, message, help="leave the key out for all robots")
        for name in dict.fromkeys(n for n in one.robots or () if (one.robots or ()).count(n) > 1):
            yield places.diagnostic("FZ904", key, f"{key} names {name} twice; it acts on it once")


def _fast(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Find sinusoids that the steps of the integration cannot follow."""
    step = scenario.run.dt / scenario.run.substeps
    for k, one in enumerate(scenario.disturbances):
        if one.kind == "sinusoid" and one.angular_frequency * step > math.pi:
            key = f"disturbances.{k}.angular_frequency"
            message = (
                f"{key} = {one.angular_frequency:g} rad/s is beyond π/h = {math.pi / step:.4g} rad/s of integration "
                f"steps of h = {step:g} s: the run sees a slower one"
            )
            yield places.diagnostic("FZ904", key, message, help="raise run.substeps or shorten run.dt")


def _slow_drives(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Find drives that follow the commands of the safety filter with less acceleration than it has."""
    for key, unit in (("acceleration", "m/s²"), ("angular_acceleration", "rad/s²")) if scenario.safety else ():
        rate = getattr(scenario.safety, key)
        for name, robot in scenario.robots.items():
            limit = getattr(robot.actuator, key)
            if limit is not None and limit < rate:
                message = (
                    f"robots.{name}.actuator.{key} = {limit:g} {unit} is below safety.{key} = {rate:g} {unit}: "
                    "barriers may be missed"
                )
                help_text = f"set safety.{key} to {limit:g} {unit} or less"
                yield places.diagnostic("FZ904", f"robots.{name}.actuator.{key}", message, help=help_text)


def _steered(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Find cars with a limit of angular acceleration, which their steering has in place of the drives."""
    for name, robot in scenario.robots.items():
        if isinstance(robot.vehicle, Ackermann) and robot.actuator.angular_acceleration is not None:
            key = f"robots.{name}.actuator.angular_acceleration"
            message = f"{key} has no effect: robots.{name} is a car, which its steering turns"
            yield places.diagnostic("FZ904", key, message, help=f"set robots.{name}.vehicle.steering_rate")
