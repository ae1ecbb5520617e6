"""The safety filter along a recorded run: distances of the guarding discs, moments at which no barrier was kept."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.scenario.guard import levers_of, radii_of, safety_of
from dwmr.scenario.model import SafetySettings, Scenario
from dwmr.scenario.outlines import centres, gap_between, gap_to_point, outline, outline_pose
from dwmr.simulation.simulate import Trajectory


class Contact(NamedTuple):
    """Contact of two bodies, whose gap closed.

    Attributes:
        t: First time [s].
        lasted: Time in contact, all contacts together [s].
        depth: Largest depth of overlap [m].
    """

    t: float
    lasted: float
    depth: float


def poses(trajectory: Trajectory, scenario: Scenario, robot: str) -> FloatArray:
    """Return the middle of a robot's outline and its orientation, shape (3, samples) [m, m, rad]."""
    i = trajectory.robots.index(robot)
    return outline_pose(outline(scenario.robots[robot]), *(trajectory[name][:, i] for name in ("x", "y", "theta")))


def obstacle_gaps(trajectory: Trajectory, scenario: Scenario, robot: str) -> FloatArray:
    """Return the gap between a robot's body and every obstacle, negative in overlap, shape (samples, obstacles) [m]."""
    pose, body = poses(trajectory, scenario, robot), outline(scenario.robots[robot])
    x, y = centres(scenario, trajectory.t).transpose(2, 1, 0)
    radius = np.array([one.radius for one in scenario.obstacles])[:, None]
    return np.ascontiguousarray((gap_to_point(pose, body, x, y) - radius).T)


def robot_gaps(
    trajectory: Trajectory, scenario: Scenario, contacts_only: bool = False
) -> Iterator[tuple[str, str, Any, FloatArray]]:
    """Yield for every pair of robots their names, samples, and the gaps between their bodies at these [m].

    The samples include the least gap and all contacts; at the others the circles about the bodies are farther apart.

    Args:
        trajectory: A run.
        scenario: Its scenario.
        contacts_only: Whether pairs whose circles never overlap are left out.
    """
    bodies = {name: (poses(trajectory, scenario, name), outline(scenario.robots[name])) for name in trajectory.robots}
    for first, second in combinations(trajectory.robots, 2):
        (pose_a, a), (pose_b, b) = bodies[first], bodies[second]
        between = np.sqrt((pose_a[0] - pose_b[0]) ** 2 + (pose_a[1] - pose_b[1]) ** 2)
        nearest = int(np.argmin(between))
        if contacts_only and not between[nearest] <= a.reach + b.reach:
            continue
        least = gap_between(pose_a[:, [nearest]], a, pose_b[:, [nearest]], b)[0]
        close = between <= a.reach + b.reach + max(float(least), 0.0)
        close[nearest] = True
        near = np.flatnonzero(close)
        yield first, second, near, gap_between(pose_a[:, near], a, pose_b[:, near], b)


def meetings(trajectory: Trajectory, scenario: Scenario) -> FloatArray:
    """Return the middles of bodies where they first touch another body or an obstacle, shape (contacts, 2) [m]."""
    middles = {robot: poses(trajectory, scenario, robot)[:2].T for robot in trajectory.robots}
    places = [
        middles[first][near[int(np.argmax(gaps <= 0.0))]]
        for first, _, near, gaps in robot_gaps(trajectory, scenario, contacts_only=True)
        if (gaps <= 0.0).any()
    ]
    for robot in trajectory.robots:
        touched = obstacle_gaps(trajectory, scenario, robot) <= 0.0
        places += list(middles[robot][np.argmax(touched, axis=0)[touched.any(axis=0)]])
    return np.array(places).reshape(-1, 2)


def contact(t: FloatArray, dt: float, gaps: FloatArray) -> Contact | None:
    """Return the contact of two bodies, or None where their gap stays open.

    Args:
        t: Times, shape (samples,) [s].
        dt: Time that a sample stands for [s].
        gaps: Gaps at these times, shape (samples,) [m].
    """
    closed = gaps <= 0.0
    if not closed.any():
        return None
    return Contact(float(t[closed][0]), float(np.count_nonzero(closed) * dt), float(-gaps.min()))


#: A rate of distance below its bound by less is rounding, and the error of the projection [m/s].
TOLERANCE = 1e-6
#: Moments of the same two that are less apart are one [s].
TOGETHER = 0.5


class Pair(NamedTuple):
    """Two discs along a run.

    Attributes:
        robot: Number of the robot of the first one.
        other: Number of another robot, or of an obstacle behind all robots.
        vector: From the other disc's centre to the first one's, shape (samples, 2) [m].
        least: R, the distance of the centres that is kept at samples [m].
        kept: Least measured distance that the filter allows [m].
        noise: By how much that is wrong at most [m].
        speed: Bound of the speed at which they approach each other [m/s].
        touch: Sum of the radii [m].
    """

    robot: int
    other: int
    vector: FloatArray
    least: float
    kept: float
    noise: float
    speed: float
    touch: float

    @property
    def distance(self) -> FloatArray:
        """Distance of the centres, shape (samples,) [m]."""
        return np.hypot(self.vector[:, 0], self.vector[:, 1])


def guarded_points(trajectory: Trajectory, scenario: Scenario, settings: SafetySettings) -> FloatArray:
    """Return the centres of the discs, robot by robot, shape (samples, robots · discs, 2) [m]."""
    offsets = settings.lookahead * levers_of(scenario, settings)
    ahead = (offsets - np.array([scenario.robots[name].d for name in trajectory.robots])[:, None]).ravel()
    x, y, theta = (np.repeat(trajectory[name], settings.discs, axis=1) for name in ("x", "y", "theta"))
    points: FloatArray = np.stack([x + ahead * np.cos(theta), y + ahead * np.sin(theta)], axis=2)
    return points


def pairs(trajectory: Trajectory, scenario: Scenario, settings: SafetySettings) -> Iterator[Pair]:
    """Yield the discs of each robot with those of the robots before it and with all obstacles."""
    safety, radii, discs = safety_of(scenario, settings), radii_of(scenario, settings), settings.discs
    points, obstacles = guarded_points(trajectory, scenario, settings), centres(scenario, trajectory.t)
    n, robots = points.shape[1], len(trajectory.robots)
    others = np.concatenate([points, obstacles], axis=1)
    for i in range(n):
        for other in (*range(i - i % discs), *range(n, others.shape[1])):
            least, measured = float(safety.least[i, other]), float(safety.kept[i, other])
            noise, speed = (float(both[i] + both[other]) for both in (safety.noise, safety.speeds))
            vector, touch = points[:, i] - others[:, other], radii[i] + radii[other]
            about = other // discs if other < n else robots + other - n
            yield Pair(i // discs, about, vector, least, measured, noise, speed, touch)


def rate_bounds(alpha: float, distance: FloatArray, least: float) -> FloatArray:
    """Return `safety_filter.rate_bound` of many distances [m/s]."""
    outside = np.maximum(distance, least)
    bounds: FloatArray = alpha * (np.maximum(least - distance, 0.0) - (outside**2 - least**2) / (2.0 * outside))
    return bounds


def true_rate_bounds(alpha: float, pair: Pair) -> FloatArray:
    """Return the least rate of the true distance at each sample that keeps to the barrier, whatever was measured [m/s].

    Source:
        docs/explanation/avoidance.md, "Noise": z · w >= |ẑ| n̂ · w − δ |w|, for the worst |ẑ| from |z| − δ to |z| + δ.
    """
    distance = pair.distance
    if pair.noise == 0.0:
        return rate_bounds(alpha, distance, pair.kept)
    measured = [np.maximum(distance + sign * pair.noise, 0.0) for sign in (-1.0, 1.0)]
    least = np.minimum(*(one * rate_bounds(alpha, one, pair.kept) for one in measured))
    bounds: FloatArray = (least - pair.noise * pair.speed) / distance
    return bounds


def missed(pair: Pair, alpha: float, dt: float) -> FloatArray:
    """Return by how much the mean rate of the distance in the period after each sample lies below its bound.

    Args:
        pair: Two discs.
        alpha: α of the barrier [1/s].
        dt: Control period [s].

    Returns:
        Shape (samples - 1,) [m/s], 0 where it does not; also where the two move faster than their speeds allow so near
        to each other that R does not make up for it.
    """
    step, distances = np.diff(pair.vector, axis=0) / dt, pair.distance
    distance = distances[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.sum(step * pair.vector[:-1], axis=1) / distance
        bound = true_rate_bounds(alpha, pair)[:-1]
    too_fast = np.hypot(step[:, 0], step[:, 1]) - pair.speed
    too_fast[np.minimum(distance, distances[1:]) >= pair.least + 0.5 * dt * too_fast] = 0.0
    short: FloatArray = np.maximum(bound - rate, too_fast)
    return np.where(short > TOLERANCE, short, 0.0)


def safety_measures(trajectory: Trajectory, scenario: Scenario, settings: SafetySettings) -> dict[str, Any]:
    """Return what became of the safety filter as plain data.

    Returns:
        `acts`: share of time in which the filter changed a robot's command [-]; `disc_gap`: least distance between a
        robot's disc and another one [m]; `infeasible`: moments at which no command within the limits kept a barrier;
        `missed`: all others at which the velocities that followed did not keep it. Each moment has `robot`, `with`,
        time `t`, duration `lasted` [s], place `x`, `y` of the robot's guarded point [m] and the largest amount `by`
        [m/s].
    """
    names = [*trajectory.robots, *(f"obstacles.{a}" for a in range(len(scenario.obstacles)))]
    shortfall, conflict = trajectory["safe_shortfall"], trajectory["safe_conflict"]
    points = guarded_points(trajectory, scenario, settings)
    gaps: dict[str, float | None] = dict.fromkeys(trajectory.robots)
    failures: dict[str, list[dict[str, Any]]] = {"infeasible": [], "missed": []}
    late_by: dict[tuple[int, int], FloatArray] = {}
    for pair in pairs(trajectory, scenario, settings):
        i, other = pair.robot, pair.other
        ends = [i] if other >= len(trajectory.robots) else [i, other]
        gap = float(np.min(pair.distance)) - pair.touch
        for name in (names[end] for end in ends):
            least = gaps[name]
            gaps[name] = gap if least is None else min(least, gap)
        late = np.append(missed(pair, settings.alpha, scenario.run.dt), 0.0)
        late_by[i, other] = np.maximum(late_by.get((i, other), 0.0), late)
    for (i, other), late in late_by.items():
        lowered = np.where(conflict[:, i] == other, shortfall[:, i], 0.0)
        if other < len(trajectory.robots):
            lowered = np.maximum(lowered, np.where(conflict[:, other] == i, shortfall[:, other], 0.0))
        late[lowered > 0.0] = 0.0  # missed on purpose
        for kind, amounts in (("infeasible", lowered), ("missed", late)):
            for one in moments(trajectory.t, amounts):
                x, y = points[one.pop("sample"), i * settings.discs]
                about = {"robot": names[i], "with": names[other]}
                failures[kind].append({**about, **one, "x": float(x), "y": float(y)})
    return {
        "acts": {name: _acts(trajectory, scenario, name) for name in trajectory.robots},
        "disc_gap": gaps,
        **{kind: sorted(each, key=lambda one: float(one["t"])) for kind, each in failures.items()},
    }


def moments(t: FloatArray, amounts: FloatArray) -> list[dict[str, Any]]:
    """Return the spans of time in which an amount is positive: `t`, `lasted` [s], `by`, and the first `sample`.

    Args:
        t: Times, shape (samples,) [s].
        amounts: Shape (samples,).
    """
    active = np.flatnonzero(amounts > 0.0)
    if not active.size:
        return []
    period = float(t[1] - t[0]) if len(t) > 1 else 0.0
    return [
        {
            "t": float(t[one[0]]), "lasted": float(t[one[-1]] - t[one[0]]) + period,
            "by": float(amounts[one].max()), "sample": int(one[0]),
        }
        for one in np.split(active, np.flatnonzero(np.diff(t[active]) > TOGETHER) + 1)
    ]  # fmt: skip


def _acts(trajectory: Trajectory, scenario: Scenario, robot: str) -> float:
    """Return the share of time in which the filter changes a robot's command [-]."""
    i, limits = trajectory.robots.index(robot), scenario.robots[robot].actuator
    v = np.clip(trajectory["v_c"][:, i], -limits.v_limit, limits.v_limit)
    omega = np.clip(trajectory["omega_c"][:, i], -limits.omega_limit, limits.omega_limit)
    changed = np.abs(trajectory["safe_v"][:, i] - v) + np.abs(trajectory["safe_omega"][:, i] - omega) > TOLERANCE
    return float(np.mean(changed))
