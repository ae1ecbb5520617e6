"""Safety filter: the velocity commands nearest to those of the laws that keep robots apart and away from obstacles.

Each robot is guarded by a disc about a point ahead of its axle, whose velocity its two commands determine. The barrier
h = |z|² − R² of two discs with the vector z between their centres stays positive where the commands keep
dh/dt >= −α h; docs/explanation/avoidance.md has the proof for commands held over a control period.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from dwmr.control.projection import ActiveSet, HalfSpaces, active_set, half_spaces, project
from dwmr.core.arrays import FloatArray, Safety
from dwmr.core.geometry import clamp
from dwmr.core.interfaces import Signal
from dwmr.core.jit import compiled

#: Signals of the filter for every robot at every sample, after those of the control law.
SIGNALS = (
    Signal("safe_v", "m/s", "linear velocity command after the safety filter"),
    Signal("safe_omega", "rad/s", "angular velocity command after the safety filter"),
    Signal("safe_shortfall", "m/s", "closing speed by which the safety filter misses its worst constraint, 0 for none"),
    Signal("safe_conflict", "-", "what that one is about: index of a robot, or of an obstacle behind them, else -1"),
)

#: Commands that the filter changes by less are unchanged but for rounding [m/s and rad/s].
CHANGED = 1e-6


class Filter(NamedTuple):
    """Working memory of the filter.

    Attributes:
        commands: Linear and angular velocity command of each robot, shape (n, 2) [m/s, rad/s]: the law's, then the
            filter's.
        levers: Centres of the discs ahead of the axle, over the lookahead, shape (n, discs) [-].
        points: Centres of the discs and headings, shape (n · discs, 3) [m, m, rad].
        wanted: Velocities of the guarded points along and across their robots that the law asks for, shape (n, 2)
            [m/s].
        turned: Their changes by `_keep_right`, shape (n, 2) [m/s].
        safe: The same after the filter, those of the period before at first, shape (n, 2) [m/s].
        spaces: Constraints on these.
        tangents: Coefficients of the speeds to the right of the lines of sight, shape (m, 4), as the normals [-].
        obstacles: Number of the obstacle that each constraint is about, -1 for none, shape (m,).
        active: Working memory of the projection.
        record: Recorded values, in the order of `SIGNALS`, shape (samples, n, 4).
    """

    commands: FloatArray
    levers: FloatArray
    points: FloatArray
    wanted: FloatArray
    turned: FloatArray
    safe: FloatArray
    spaces: HalfSpaces
    tangents: FloatArray
    obstacles: Any
    active: ActiveSet
    record: FloatArray


def working_memory(n: int, obstacles: int, samples: int, levers: FloatArray | None = None) -> Filter:
    """Return working memory for some robots and obstacles, and a record of some samples.

    Args:
        n: Number of robots.
        obstacles: Number of obstacles.
        samples: Number of recorded samples.
        levers: As in `Filter`; None for one disc about each robot's point `lookahead` ahead of the axle.
    """
    levers = np.ones((n, 1)) if levers is None else levers
    discs = levers.size
    most = 4 * n + discs * (discs - 1) // 2 + discs * obstacles
    points, tangents = np.zeros((discs, 3)), np.zeros((most, 4))
    commands, wanted, turned, safe = np.zeros((4, n, 2))
    about, record = np.full(most, -1, dtype=np.int64), np.zeros((samples, n, len(SIGNALS)))
    spaces, active = half_spaces(most), active_set(n)
    return Filter(commands, levers, points, wanted, turned, safe, spaces, tangents, about, active, record)


@compiled
def rate_bound(alpha: float, distance: float, least: float) -> float:
    """Return the least rate of the distance of two discs' centres for which dh/dt >= −α h [m/s].

    Args:
        alpha: α [1/s].
        distance: |z| [m].
        least: R [m].

    Source:
        h = |z|² − R², dh/dt = 2 |z| d|z|/dt; inside of R the slower −α (|z| − R), which has no pole.
    """
    if distance <= least:
        return alpha * (least - distance)
    return -alpha * (distance - least) * (distance + least) / (2.0 * distance)


@compiled
def is_near(alpha: float, distance: float, least: float, error: float, speed: float) -> bool:
    """Return whether two could break their barrier, or could do so after approaching each other for a time 1/α.

    Args:
        alpha, distance, least: As for `rate_bound`.
        error: Sum of their errors [m/s].
        speed: Sum of their speeds [m/s].
    """
    return rate_bound(alpha, distance - speed / alpha, least) + error > -speed


@compiled
def filter_commands(
    row: int,
    poses: FloatArray,
    now: FloatArray,
    after: FloatArray,
    dt: float,
    robots: Any,
    safety: Safety,
    memory: Filter,
) -> None:
    """Replace the commands in memory by the nearest safe ones within the robots' limits.

    Args:
        row: Row of the record.
        poses: Reference points and orientations of the robots in the first three columns, shape (n, ...) [m, m, rad].
        now, after: Centres and radii of the obstacles now and a control period later, shape (a, 3) [m].
        dt: Control period [s].
        robots: Records of dtype `ROBOT`, shape (n,).
        safety: Parameters.
        memory: Read and written.
    """
    n, lookahead = robots.shape[0], safety.lookahead
    for i in range(n):
        theta, discs = poses[i, 2], memory.levers.shape[1]
        for disc in range(discs):
            ahead, p = lookahead * memory.levers[i, disc] - robots[i].d, i * discs + disc
            memory.points[p, 0] = poses[i, 0] + ahead * math.cos(theta)
            memory.points[p, 1] = poses[i, 1] + ahead * math.sin(theta)
            memory.points[p, 2] = theta
        memory.wanted[i, 0] = clamp(memory.commands[i, 0], robots[i].v_limit)
        memory.wanted[i, 1] = lookahead * clamp(memory.commands[i, 1], robots[i].omega_limit)
    count = _limits(robots, safety, memory.spaces)
    hard = count
    count = _apart(count, safety, memory)
    count = _away(count, now, after, dt, safety, memory)
    _keep_right(hard, count, safety.keep_right, memory)
    _hold_back(hard, count, dt, safety, memory)
    project(memory.wanted, memory.spaces, count, hard, memory.active, memory.safe)
    record = memory.record[row]
    for i in range(n):
        memory.commands[i, 0], memory.commands[i, 1] = memory.safe[i, 0], memory.safe[i, 1] / lookahead
        record[i, 0], record[i, 1] = memory.commands[i, 0], memory.commands[i, 1]
        record[i, 2], record[i, 3] = 0.0, -1.0
    for k in range(hard, count):
        by, obstacle = memory.spaces.shortfalls[k], memory.obstacles[k]
        for side in range(2):
            i, other = memory.spaces.robots[k, side], memory.spaces.robots[k, 1 - side]
            if by > record[i, 2]:
                record[i, 2], record[i, 3] = by, n + obstacle if obstacle >= 0 else other


@compiled
def _hold_back(first: int, count: int, dt: float, safety: Safety, memory: Filter) -> None:
    """Let commands change only as fast as allowed where a constraint about their robot is left."""
    wanted, safe, robots = memory.wanted, memory.safe, memory.spaces.robots
    most = dt * safety.acceleration, dt * safety.lookahead * safety.angular_acceleration
    for i in range(wanted.shape[0]):
        near = False
        for row in range(first, count):
            near = near or robots[row, 0] == i or robots[row, 1] == i
        if near:
            part = 1.0
            for axis in range(2):
                part = min(part, most[axis] / max(abs(wanted[i, axis] - safe[i, axis]), 1e-300))
            for axis in range(2):  # by the same part, for a limit of each would change the direction
                wanted[i, axis] = safe[i, axis] + part * (wanted[i, axis] - safe[i, axis])


@compiled
def _keep_right(first: int, count: int, share: float, memory: Filter) -> None:
    """Turn the closing speed that constraints will take from robots to their right.

    Args:
        first, count: Rows of the constraints.
        share: Speed to the right of the line of sight, relative to that by which the wanted velocities break a
            constraint; robots share it as they share the constraint.
        memory: Read, and `wanted` and `turned` written.
    """
    wanted, turned, spaces, tangents = memory.wanted, memory.turned, memory.spaces, memory.tangents
    for i in range(wanted.shape[0]):
        turned[i, 0] = turned[i, 1] = 0.0
    for row in range(first, count):
        a, b, normal = spaces.robots[row, 0], spaces.robots[row, 1], spaces.normals[row]
        one = -normal[0] * wanted[a, 0] - normal[1] * wanted[a, 1]
        other = -normal[2] * wanted[b, 0] - normal[3] * wanted[b, 1]
        by, faster = spaces.bounds[row] + one + other, max(one, other)
        if by > 0.0 and one + other > 0.0:
            # who follows a robot that drives away in front of it does not pass it
            met = min(1.0, (one + other) / faster)
            by *= share * met * met * (1.0 if a == b else 0.5)
            for axis in range(2):
                turned[a, axis] += by * tangents[row, axis]
                turned[b, axis] += by * tangents[row, 2 + axis]
    for i in range(wanted.shape[0]):
        wanted[i, 0] += turned[i, 0]
        wanted[i, 1] += turned[i, 1]


@compiled
def _limits(robots: Any, safety: Safety, spaces: HalfSpaces) -> int:
    """Write the limits of the commands; return how many."""
    count = 0
    for i in range(robots.shape[0]):
        for axis in range(2):
            limit = robots[i].v_limit if axis == 0 else safety.lookahead * robots[i].omega_limit
            for side in range(2):
                _write(spaces, count, i, i, -limit)
                spaces.normals[count, axis] = 1.0 - 2.0 * side
                count += 1
    return count


@compiled
def _write(spaces: HalfSpaces, k: int, a: int, b: int, bound: float) -> None:
    """Write a constraint without its normals."""
    spaces.robots[k, 0], spaces.robots[k, 1], spaces.bounds[k] = a, b, bound
    for c in range(4):
        spaces.normals[k, c] = 0.0


@compiled
def _direction(dx: float, dy: float, distance: float) -> tuple[float, float]:
    """Return a unit vector; any where two points are one."""
    return (dx / distance, dy / distance) if distance > 1e-9 else (1.0, 0.0)


@compiled
def _face(k: int, side: int, p: int, x: float, y: float, memory: Filter) -> None:
    """Write normal and tangent of a constraint for one of its discs, which a unit vector points to."""
    point, discs = memory.points[p], memory.levers.shape[1]
    lever = memory.levers[p // discs, p % discs]
    c, s = math.cos(point[2]), math.sin(point[2])
    along, across = c * x + s * y, c * y - s * x
    memory.spaces.normals[k, 2 * side], memory.spaces.normals[k, 2 * side + 1] = along, lever * across
    memory.tangents[k, 2 * side], memory.tangents[k, 2 * side + 1] = -across, lever * along


@compiled
def _apart(count: int, safety: Safety, memory: Filter) -> int:
    """Write the constraints between robots that some commands within the limits could break; return how many rows."""
    points, discs = memory.points, memory.levers.shape[1]
    for i in range(points.shape[0]):
        for j in range(i - i % discs):
            dx, dy = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1]
            distance = math.hypot(dx, dy)
            error, speed = safety.errors[i] + safety.errors[j], safety.speeds[i] + safety.speeds[j]
            least = safety.kept[i, j]
            if not is_near(safety.alpha, distance, least, error, speed):
                continue
            _write(memory.spaces, count, i // discs, j // discs, rate_bound(safety.alpha, distance, least) + error)
            memory.obstacles[count] = -1
            x, y = _direction(dx, dy, distance)
            _face(count, 0, i, x, y, memory)
            _face(count, 1, j, -x, -y, memory)
            count += 1
    return count


@compiled
def _away(count: int, now: FloatArray, after: FloatArray, dt: float, safety: Safety, memory: Filter) -> int:
    """Write the constraints between robots and obstacles that commands could break; return how many rows."""
    points, discs, n = memory.points, memory.levers.shape[1], memory.points.shape[0]
    for i in range(n):
        for a in range(now.shape[0]):
            dx, dy = points[i, 0] - now[a, 0], points[i, 1] - now[a, 1]
            distance = math.hypot(dx, dy)
            x, y = _direction(dx, dy, distance)
            # the obstacle's mean velocity in the coming period is known
            along = (x * (after[a, 0] - now[a, 0]) + y * (after[a, 1] - now[a, 1])) / dt
            least, error = safety.kept[i, n + a], safety.errors[i]
            if not is_near(safety.alpha, distance, least, error, safety.speeds[i] + safety.speeds[n + a]):
                continue
            robot, bound = i // discs, rate_bound(safety.alpha, distance, least) + error + along
            _write(memory.spaces, count, robot, robot, bound)
            memory.obstacles[count] = a
            for c in range(2, 4):
                memory.tangents[count, c] = 0.0
            _face(count, 0, i, x, y, memory)
            count += 1
    return count
