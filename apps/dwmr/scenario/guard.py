"""The safety filter in a scenario: its parameters, and the checks of [safety]."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from dwmr.core.arrays import FloatArray, Safety
from dwmr.scenario.model import LARGEST_NOISE, Noise, Robot, SafetySettings, Scenario
from dwmr.scenario.outlines import Outline, distance_from, largest_speed, outline, outline_pose
from fuzzyctl.diagnostics.diagnostic import Diagnostic
from fuzzyctl.experiments.scenario_keys import Places


def disc_radius(robot: Robot, lookahead: float) -> float:
    """Return the radius of the disc about the guarded point that encloses a robot's body [m]."""
    body = outline(robot)
    from_point = abs(body.middle + robot.d - lookahead)
    return math.hypot(from_point + body.half_length, body.half_width) + body.margin


def radii_of(scenario: Scenario, settings: SafetySettings) -> list[float]:
    """Return the radii of the robots' discs, then of the obstacles [m]."""
    discs = [disc_radius(robot, settings.lookahead) for robot in scenario.robots.values()]
    return [*discs, *(one.radius for one in scenario.obstacles)]


def room_for_noise(alpha: float, least: FloatArray, noise: FloatArray, speed: FloatArray) -> FloatArray:
    """Return the least measured distances for which true ones do not fall below R [m].

    Args:
        alpha: α [1/s].
        least: R [m].
        noise: By how much measured distances are wrong at most [m].
        speed: Largest speed at which the two approach each other [m/s].

    Source:
        docs/explanation/avoidance.md, "Noise".
    """
    result: FloatArray = least + noise * (1.0 + speed / (alpha * (least + noise)))
    return result


def safety_of(scenario: Scenario, settings: SafetySettings) -> Safety:
    """Return the parameters of the safety filter with some settings."""
    robots, obstacles, dt = tuple(scenario.robots.values()), scenario.obstacles, scenario.run.dt
    lookahead, error, n = settings.lookahead, settings.velocity_error, len(robots)
    limits = np.array([(r.actuator.v_limit, r.actuator.omega_limit) for r in robots])
    commanded = np.hypot(limits[:, 0], lookahead * limits[:, 1])
    turning = 0.5 * dt * limits[:, 1] * commanded  # a held command's velocity turns with the robot
    radii = np.array(radii_of(scenario, settings))
    speeds = np.array([*(commanded + error), *(largest_speed(o) for o in obstacles)])
    closing = speeds[:n, None] + speeds
    least = radii[:n, None] + radii + settings.margin + 0.5 * dt * closing
    deviations = [r.noise or Noise() for r in robots]
    turned = np.array([LARGEST_NOISE * one.theta for one in deviations])
    moved = np.array([LARGEST_NOISE * math.hypot(one.x, one.y) for one in deviations])
    noise = np.zeros(len(speeds))
    noise[:n] = moved + turned * np.array([abs(lookahead - r.d) for r in robots])
    return Safety(
        settings.alpha,
        lookahead,
        settings.acceleration,
        settings.angular_acceleration,
        least,
        room_for_noise(settings.alpha, least, noise[:n, None] + noise, closing),
        noise,
        speeds,
        error + turning + turned * commanded,
        settings.keep_right,
    )


def safety_mistakes(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Refuse a rate that a period cannot follow, and starts at which barriers are broken already."""
    settings, dt = scenario.safety, scenario.run.dt
    if settings is None:
        return
    most = 0.5 if (safety_of(scenario, settings).noise > 0.0).any() else 1.0
    if settings.alpha * dt > most:
        message = (
            f"safety.alpha = {settings.alpha:g} 1/s times run.dt = {dt:g} s exceeds {most:g}: a barrier could be jumped"
        )
        help_text = f"set safety.alpha to {most / dt:g} 1/s or less"
        yield places.diagnostic("FZ904", "safety.alpha", message, help=help_text)
    yield from _noisy(scenario, settings, places)
    help_text = "start them farther apart, shorten run.dt, or lower safety.margin or safety.lookahead"
    for one in _starts(scenario, settings):
        if one.distance < one.least:
            message = (
                f"robots.{one.name} starts too close to {one.other} for [safety]: its guarded point is "
                f"{one.distance:.4g} m from {one.what}, {one.least:.4g} m are kept"
            )
            moved = one.least - sum(one.radii) - settings.margin
            facts = (
                f"kept are the radii {one.radii[0]:.4g} m and {one.radii[1]:.4g} m, the margin {settings.margin:g} m, "
                f"and {moved:.3g} m that both may move in half a period",
            )
            yield places.diagnostic("FZ904", f"robots.{one.name}.x_0", message, facts=facts, help=help_text)


def _noisy(scenario: Scenario, settings: SafetySettings, places: Places) -> Iterable[Diagnostic]:
    """Refuse noise that is too large for the proof."""
    safety = safety_of(scenario, settings)
    for i, name in enumerate(scenario.robots):
        if safety.noise[i] > 0.0 and (safety.kept[i] > 2.0 * safety.least[i]).any():
            k = int(np.argmax(safety.kept[i] / safety.least[i]))
            message = (
                f"robots.{name}.noise moves its guarded point by up to {safety.noise[i]:.3g} m: [safety] would keep "
                f"{safety.kept[i, k]:.4g} m of what is measured, more than twice the {safety.least[i, k]:.4g} m "
                "without noise"
            )
            help_text = "lower the noise; it is cut at 4 standard deviations"
            yield places.diagnostic("FZ904", f"robots.{name}.noise", message, help=help_text)


class Start(NamedTuple):
    """Two that keep apart, at the start.

    Attributes:
        name: The robot.
        other: Key of the other robot or of the obstacle.
        what: The other's centre, in words.
        distance: Of the robot's guarded point from it [m].
        least: R [m].
        radii: Of the two discs [m].
    """

    name: str
    other: str
    what: str
    distance: float
    least: float
    radii: tuple[float, float]


def _starts(scenario: Scenario, settings: SafetySettings) -> Iterator[Start]:
    """Yield each robot with the robots before it and all obstacles; a start inside of one is another mistake."""
    least, radii, names = safety_of(scenario, settings).least, radii_of(scenario, settings), tuple(scenario.robots)
    points = [_point(robot, settings, robot.x_0, robot.y_0, robot.theta_0) for robot in scenario.robots.values()]
    others = [(f"robots.{name}", "that one's", point) for name, point in zip(names, points, strict=True)]
    others += [(f"obstacles.{a}", "its centre", np.array([o.x, o.y])) for a, o in enumerate(scenario.obstacles)]
    for i, name in enumerate(names):
        for j in (*range(i), *range(len(names), len(others))):
            other, what, place = others[j]
            obstacle = scenario.obstacles[j - len(names)] if j >= len(names) else None
            if obstacle is not None and distance_from(obstacle, scenario.robots[name]) <= obstacle.radius:
                continue
            distance = math.dist(points[i], place)
            yield Start(name, other, what, distance, float(least[i, j]), (radii[i], radii[j]))


def _point(robot: Robot, settings: SafetySettings, x: float, y: float, theta: float) -> FloatArray:
    """Return the guarded point of a robot whose reference point is at a posture, shape (2,) [m]."""
    ahead = Outline(settings.lookahead - robot.d, 0.0, 0.0, 0.0)
    place: FloatArray = outline_pose(ahead, *(np.array([one]) for one in (x, y, theta)))[:2, 0]
    return place


def safety_remarks(scenario: Scenario, places: Places) -> Iterable[Diagnostic]:
    """Warn of settings that the robots cannot follow, and of formations and obstacles that barriers do not allow."""
    settings = scenario.safety
    if settings is None:
        return
    yield from _beyond_drives(scenario, settings, places)
    yield from _beyond_error(scenario, settings, places)
    yield from _too_narrow(scenario, settings, places)
    for name, robot in scenario.robots.items():
        if robot.sensors.pose == "odometry":
            message = (
                f"robots.{name} knows its place by odometry, whose error has no bound: [safety] keeps the "
                "distances that are measured, not the true ones"
            )
            yield places.diagnostic("FZ904", f"robots.{name}.sensors.pose", message)
    slowest = min(scenario.robots, key=lambda name: scenario.robots[name].actuator.v_limit)
    limit = scenario.robots[slowest].actuator.v_limit
    for a, one in enumerate(scenario.obstacles):
        speed = largest_speed(one)
        if speed > limit:
            message = (
                f"obstacles.{a} moves at up to {speed:.4g} m/s, robots.{slowest} at {limit:g} m/s at most: "
                "it may run into it, whatever the filter does"
            )
            yield places.diagnostic("FZ904", f"obstacles.{a}", message)


def _beyond_drives(scenario: Scenario, settings: SafetySettings, places: Places) -> Iterable[Diagnostic]:
    """Find rates that the wheel torques cannot follow, and a barrier that asks for more than those rates."""
    load, robots = scenario.load, scenario.robots
    force = {name: 2.0 * one.actuator.torque_limit / one.wheel_radius for name, one in robots.items()}
    for key, unit, able in (
        ("acceleration", "m/s²", {n: force[n] / (r.mass * max(1.0, load.mass_factor)) for n, r in robots.items()}),
        (
            "angular_acceleration",
            "rad/s²",
            {n: force[n] * r.half_track / (r.inertia * max(1.0, load.inertia_factor)) for n, r in robots.items()},
        ),
    ):
        rate, weakest = getattr(settings, key), min(able, key=lambda name: able[name])
        if rate > able[weakest]:
            message = (
                f"safety.{key} = {rate:g} {unit} is beyond what the wheels give robots.{weakest}: "
                f"{able[weakest]:.3g} {unit}"
            )
            yield places.diagnostic("FZ904", f"safety.{key}", message)
    fastest = max(robots, key=lambda name: robots[name].actuator.v_limit)
    limit = robots[fastest].actuator.v_limit
    if settings.alpha * limit > settings.acceleration * (1.0 + 1e-9):
        message = (
            f"safety.alpha = {settings.alpha:g} 1/s brakes robots.{fastest} from its {limit:g} m/s with up to "
            f"{settings.alpha * limit:.4g} m/s², beyond safety.acceleration = {settings.acceleration:g} m/s²"
        )
        help_text = f"set safety.alpha to {settings.acceleration / limit:.3g} 1/s or less"
        yield places.diagnostic("FZ904", "safety.alpha", message, help=help_text)


def _beyond_error(scenario: Scenario, settings: SafetySettings, places: Places) -> Iterable[Diagnostic]:
    """Find the disturbance that moves guarded points most, where that is more than `velocity_error` allows for."""
    moved = [0.0 if d.robots == () else math.hypot(d.v, settings.lookahead * d.omega) for d in scenario.disturbances]
    if moved and max(moved) > settings.velocity_error:
        k = moved.index(max(moved))
        message = (
            f"disturbances.{k} moves guarded points at {moved[k]:.3g} m/s, beyond safety.velocity_error = "
            f"{settings.velocity_error:g} m/s: barriers may be missed"
        )
        yield places.diagnostic("FZ904", f"disturbances.{k}", message)


def _too_narrow(scenario: Scenario, settings: SafetySettings, places: Places) -> Iterable[Diagnostic]:
    """Find followers whose place in the formation is nearer to their leader than the barrier lets them rest."""
    safety, names = safety_of(scenario, settings), list(scenario.robots)
    for name, robot in scenario.robots.items():
        if robot.formation is None:
            continue
        leader = scenario.robots[robot.formation.leader]
        i, j, place = names.index(name), names.index(robot.formation.leader), robot.formation
        # both look along x, the leader's axle is at 0
        x, y = place.separation * math.cos(place.bearing), place.separation * math.sin(place.bearing)
        distance = math.dist(_point(robot, settings, x, y, 0.0), _point(leader, settings, leader.d, 0.0, 0.0))
        rest = (float(safety.errors[i]) + float(safety.errors[j])) / settings.alpha
        least = rest + math.hypot(rest, float(safety.kept[i, j]))  # the rate bound is minus the errors' sum
        if distance < least:
            message = (
                f"robots.{name}.formation puts guarded points {distance:.4g} m apart, [safety] keeps {least:.4g} m: "
                f"{name} cannot reach its place behind {place.leader}"
            )
            help_text = "raise the separation or safety.alpha, shorten run.dt, or lower another key of [safety]"
            yield places.diagnostic("FZ904", f"robots.{name}.formation", message, help=help_text)
