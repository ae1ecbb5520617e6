"""The safety filter in a scenario: its parameters, and the checks of [safety]."""

from __future__ import annotations

import math
from collections.abc import Iterable

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


def discs_of(robot: Robot, settings: SafetySettings) -> FloatArray:
    """Return the discs that enclose a robot's body: centres ahead of the axle and radii, shape (discs, 2) [m]."""
    if settings.discs == 1:
        return np.array([(settings.lookahead, disc_radius(robot, settings.lookahead))])
    body = outline(robot)
    half, middle = 0.5 * body.half_length, body.middle + robot.d
    radius = math.hypot(half, body.half_width) + body.margin
    return np.array([(middle + half, radius), (middle - half, radius)])


def levers_of(scenario: Scenario, settings: SafetySettings) -> FloatArray:
    """Return the centres of the robots' discs ahead of their axles over the lookahead, shape (n, discs) [-]."""
    return np.array([discs_of(one, settings)[:, 0] / settings.lookahead for one in scenario.robots.values()])


def radii_of(scenario: Scenario, settings: SafetySettings) -> list[float]:
    """Return the radii of the robots' discs, then of the obstacles [m]."""
    discs = [float(r) for robot in scenario.robots.values() for r in discs_of(robot, settings)[:, 1]]
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
    lookahead, error, n = settings.lookahead, settings.velocity_error, settings.discs * len(robots)
    ahead = (lookahead * levers_of(scenario, settings)).ravel()
    limits = np.repeat([(r.actuator.v_limit, r.actuator.omega_limit) for r in robots], settings.discs, axis=0)
    commanded = np.hypot(limits[:, 0], ahead * limits[:, 1])
    turning = 0.5 * dt * limits[:, 1] * commanded  # a held command's velocity turns with the robot
    radii = np.array(radii_of(scenario, settings))
    speeds = np.array([*(commanded + error), *(largest_speed(o) for o in obstacles)])
    closing = speeds[:n, None] + speeds
    least = radii[:n, None] + radii + settings.margin + 0.5 * dt * closing
    deviations = [r.noise or Noise() for r in robots for _ in range(settings.discs)]
    turned = np.array([LARGEST_NOISE * one.theta for one in deviations])
    moved = np.array([LARGEST_NOISE * math.hypot(one.x, one.y) for one in deviations])
    noise = np.zeros(len(speeds))
    noise[:n] = moved + turned * np.abs(ahead - np.repeat([r.d for r in robots], settings.discs))
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
    if (scenario.run.record_every or 1) > 1:
        message = f"run.record_every = {scenario.run.record_every}: the measures of [safety] need every control period"
        yield places.diagnostic("FZ904", "run.record_every", message, help="leave it out")
    yield from _noisy(scenario, settings, places)
    yield from _too_close(scenario, settings, places)


def _noisy(scenario: Scenario, settings: SafetySettings, places: Places) -> Iterable[Diagnostic]:
    """Refuse noise that is too large for the proof."""
    safety = safety_of(scenario, settings)
    for robot, name in enumerate(scenario.robots):
        i = robot * settings.discs
        if safety.noise[i] > 0.0 and (safety.kept[i] > 2.0 * safety.least[i]).any():
            k = int(np.argmax(safety.kept[i] / safety.least[i]))
            message = (
                f"robots.{name}.noise moves its guarded point by up to {safety.noise[i]:.3g} m: [safety] would keep "
                f"{safety.kept[i, k]:.4g} m of what is measured, more than twice the {safety.least[i, k]:.4g} m "
                "without noise"
            )
            help_text = "lower the noise; it is cut at 4 standard deviations"
            yield places.diagnostic("FZ904", f"robots.{name}.noise", message, help=help_text)


def _too_close(scenario: Scenario, settings: SafetySettings, places: Places) -> Iterable[Diagnostic]:
    """Refuse robots that start closer to a robot before them or to an obstacle than is kept.

    A start inside of an obstacle is another mistake.
    """
    least, radii, names = safety_of(scenario, settings).least, radii_of(scenario, settings), tuple(scenario.robots)
    discs, robots = settings.discs, tuple(scenario.robots.values())
    points = [point for r in robots for point in _points(r, settings, r.x_0, r.y_0, r.theta_0)]
    points += [np.array([one.x, one.y]) for one in scenario.obstacles]
    others = [(f"robots.{name}", "that one's", range(j * discs, (j + 1) * discs)) for j, name in enumerate(names)]
    rings = [(f"obstacles.{a}", "its centre", [len(names) * discs + a]) for a in range(len(scenario.obstacles))]
    for i, name in enumerate(names):
        outside = [distance_from(one, robots[i]) > one.radius for one in scenario.obstacles]
        free = [ring for ring, is_free in zip(rings, outside, strict=True) if is_free]
        for other, centre, theirs in (*others[:i], *free):
            distance, p, q = min((math.dist(points[p], points[q]), p, q) for p in others[i][2] for q in theirs)
            if distance < least[p, q]:
                message = (
                    f"robots.{name} starts too close to {other} for [safety]: its guarded point is {distance:.4g} m "
                    f"from {centre}, {least[p, q]:.4g} m are kept"
                )
                moved = least[p, q] - radii[p] - radii[q] - settings.margin
                facts = (
                    f"kept are the radii {radii[p]:.4g} m and {radii[q]:.4g} m, the margin {settings.margin:g} m, "
                    f"and {moved:.3g} m that both may move in half a period",
                )
                help_text = "start them farther apart, shorten run.dt, or lower safety.margin or safety.lookahead"
                yield places.diagnostic("FZ904", f"robots.{name}.x_0", message, facts=facts, help=help_text)


def _points(robot: Robot, settings: SafetySettings, x: float, y: float, theta: float) -> list[FloatArray]:
    """Return the centres of the discs of a robot whose reference point is at a posture, each of shape (2,) [m]."""
    places = [Outline(ahead - robot.d, 0.0, 0.0, 0.0) for ahead in discs_of(robot, settings)[:, 0]]
    return [outline_pose(one, *(np.array([v]) for v in (x, y, theta)))[:2, 0] for one in places]


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
    for name, place in ((name, edge) for name, robot in scenario.robots.items() for edge in robot.edges):
        if place.leader is None:
            continue
        robot, leader = scenario.robots[name], scenario.robots[place.leader]
        i, j = names.index(name), names.index(place.leader)
        # both look along x, the leader's axle is at 0
        x, y = place.separation * math.cos(place.bearing), place.separation * math.sin(place.bearing)
        behind, ahead = _points(robot, settings, x, y, 0.0), _points(leader, settings, leader.d, 0.0, 0.0)
        room = []
        for p, q in np.ndindex(settings.discs, settings.discs):
            one, other = i * settings.discs + p, j * settings.discs + q
            rest = float(safety.errors[one] + safety.errors[other]) / settings.alpha
            bound = rest + math.hypot(rest, float(safety.kept[one, other]))  # the rate bound is minus the errors' sum
            room.append((math.dist(behind[p], ahead[q]), bound))
        distance, least = min(room, key=lambda both: both[0] - both[1])
        if distance < least:
            message = (
                f"robots.{name}.formation puts guarded points {distance:.4g} m apart, [safety] keeps {least:.4g} m: "
                f"{name} cannot reach its place behind {place.leader}"
            )
            help_text = "raise the separation or safety.alpha, shorten run.dt, or lower another key of [safety]"
            yield places.diagnostic("FZ904", f"robots.{name}.formation", message, help=help_text)
