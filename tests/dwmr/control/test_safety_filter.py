"""The safety filter: what its proof says of commands held over a period, and what it leaves alone."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dwmr.control.safety_filter import Safety, filter_commands, is_near, rate_bound, working_memory
from dwmr.plant.robot import ROBOT
from tests.sizes import examples

DT, LOOKAHEAD, RADIUS, V_LIMIT, OMEGA_LIMIT = 0.02, 0.3, 0.6, 1.0, 1.5
SPEED = math.hypot(V_LIMIT, LOOKAHEAD * OMEGA_LIMIT)


def robots(n):
    found = np.zeros(n, dtype=ROBOT)
    found["d"], found["v_limit"], found["omega_limit"] = 0.1, V_LIMIT, OMEGA_LIMIT
    return found.view(np.recarray)


def safety(n, alpha=2.0, error=0.0, margin=0.05, obstacles=(), acceleration=1e6):
    """Parameters for n robots and obstacles, each with a radius and a speed."""
    radii = np.array([RADIUS] * n + [radius for radius, _ in obstacles])
    speeds = np.array([SPEED + error] * n + [speed for _, speed in obstacles])
    least = radii[:n, None] + radii + margin + 0.5 * DT * (speeds[:n, None] + speeds)
    errors = np.full(n, error + 0.5 * DT * OMEGA_LIMIT * SPEED)
    return Safety(alpha, LOOKAHEAD, acceleration, acceleration, least, least, 0.0 * speeds, speeds, errors)


def filtered(poses, commands, given, now=(), after=()):
    """Commands after the filter, and what it records."""
    poses, n = np.array(poses, dtype=float), len(poses)
    now, after = (np.array(one, dtype=float).reshape(-1, 3) for one in (now, after if len(after) else now))
    memory = working_memory(n, len(now), 1)
    memory.commands[:] = commands
    filter_commands(0, poses, now, after, DT, robots(n), given, memory)
    return memory.commands, memory.record[0]


def points(poses, t=0.0, commands=None):
    """Guarded points of robots that hold their commands for a time, exactly."""
    held = moved(poses, t, commands)
    return np.array([(x + LOOKAHEAD * math.cos(theta), y + LOOKAHEAD * math.sin(theta)) for x, y, theta in held])


def moved(poses, t, commands):
    """Middles of the axles and orientations of robots that hold their commands for a time, exactly."""
    found = []
    for k, (x, y, theta) in enumerate(poses):
        v, omega = (0.0, 0.0) if commands is None else commands[k]
        x, y = x - 0.1 * math.cos(theta), y - 0.1 * math.sin(theta)
        half = 0.5 * omega * t
        chord = v * t * (math.sin(half) / half if abs(half) > 1e-12 else 1.0)
        x, y, theta = x + chord * math.cos(theta + half), y + chord * math.sin(theta + half), theta + omega * t
        found.append((x, y, theta))
    return found


places = st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3.2, 3.2))
asked = st.tuples(st.floats(-3, 3), st.floats(-5, 5))
velocities = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))


@settings(max_examples=examples(1000))
@given(st.lists(st.tuples(places, asked), min_size=3, max_size=3), st.lists(st.tuples(places, velocities), max_size=2))
def test_a_barrier_declines_no_faster_than_alpha_while_commands_are_held(team, obstacles):
    poses, commands = [one for one, _ in team], [one for _, one in team]
    now = np.array([(x, y, 0.4) for (x, y, _), _ in obstacles]).reshape(-1, 3)
    moved = np.array([(*velocity, 0.0) for _, velocity in obstacles]).reshape(-1, 3)
    given = safety(3, obstacles=[(0.4, math.hypot(*velocity)) for _, velocity in obstacles])
    done, record = filtered(poses, commands, given, now, now + DT * moved)
    start = points(poses)
    for t in (0.25 * DT, 0.5 * DT, DT):
        end = points(poses, t, done)
        for i in range(3):
            others = [(j, start[j], end[j]) for j in range(i)]
            others += [(3 + a, now[a, :2], now[a, :2] + t * moved[a, :2]) for a in range(len(now))]
            for other, before, after in others:
                least = given.least[i, other]
                h, h_then = (math.dist(*ends) ** 2 - least**2 for ends in ((start[i], before), (end[i], after)))
                robot_or_obstacle = record[i, 2] if other >= 3 else max(record[i, 2], record[other, 2])
                if h >= 0.0 and robot_or_obstacle == 0.0:
                    assert h_then >= (1.0 - given.alpha * t) * h - 1e-7
    assert (np.abs(done) <= (V_LIMIT + 1e-7, OMEGA_LIMIT + 1e-6)).all()


@settings(max_examples=examples(300))
@given(st.lists(st.tuples(places, asked), min_size=2, max_size=3), st.lists(places, max_size=2))
def test_barriers_of_two_discs_decline_no_faster_either(team, obstacles):
    """Discs 0.14 m ahead of the axle and 0.31 m behind it, each with the velocity of its own centre."""
    poses, n = [one for one, _ in team], len(team)
    ahead = np.array([0.14, -0.31])
    now = np.array([(x, y, 0.4) for x, y, _ in obstacles]).reshape(-1, 3)
    radii = np.array([0.41] * 2 * n + [0.4] * len(now))
    speeds = np.array([math.hypot(V_LIMIT, x * OMEGA_LIMIT) for x in ahead] * n + [0.0] * len(now))
    least = radii[: 2 * n, None] + radii + 0.5 * DT * (speeds[: 2 * n, None] + speeds)
    errors = 0.5 * DT * OMEGA_LIMIT * speeds[: 2 * n]
    given = Safety(2.0, LOOKAHEAD, 1e6, 1e6, least, least, 0.0 * speeds, speeds, errors)
    memory = working_memory(n, len(now), 1, np.tile(ahead / LOOKAHEAD, (n, 1)))
    memory.commands[:] = [one for _, one in team]
    filter_commands(0, np.array(poses), now, now, DT, robots(n), given, memory)
    if (memory.record[0, :, 2] > 0.0).any():
        return

    def centres(t):
        held = moved(poses, t, memory.commands)
        discs = [(x + a * math.cos(theta), y + a * math.sin(theta)) for x, y, theta in held for a in ahead]
        return np.array([*discs, *now[:, :2]])

    before, after = centres(0.0), centres(DT)
    for i in range(2 * n):
        for j in (*range(i - i % 2), *range(2 * n, len(before))):
            h, h_then = (math.dist(c[i], c[j]) ** 2 - least[i, j] ** 2 for c in (before, after))
            if h >= 0.0:
                assert h_then >= (1.0 - 2.0 * DT) * h - 1e-7


def test_robots_that_meet_and_a_robot_before_an_obstacle_turn_right():
    done, _ = filtered([(0, 0, 0.0), (2.0, 0, math.pi)], [(1.0, 0.0), (1.0, 0.0)], safety(2))
    assert done[0, 1] == pytest.approx(done[1, 1])
    assert done[0, 1] < -0.5
    done, _ = filtered([(0, 0, 0.0)], [(1.0, 0.0)], safety(1, obstacles=[(0.5, 0.0)]), [(1.6, 0, 0.5)])
    assert done[0, 1] < -0.5
    without = safety(1, obstacles=[(0.5, 0.0)])._replace(keep_right=0.0)
    done, _ = filtered([(0, 0, 0.0)], [(1.0, 0.0)], without, [(1.6, 0, 0.5)])
    assert done[0, 1] == pytest.approx(0.0)


def test_a_robot_that_follows_another_one_stays_behind_it():
    done, _ = filtered([(0, 0, 0.0), (1.3, 0, 0.0)], [(0.8, 0.0), (0.5, 0.0)], safety(2))
    assert done[0, 0] < 0.8
    assert (np.abs(done[:, 1]) < 0.1).all()


def test_commands_far_from_everything_stay_as_they_are():
    done, record = filtered(
        [(0, 0, 1.0), (9, 9, 2.0)], [(0.4, -0.7), (-0.3, 0.2)], safety(2, obstacles=[(1.0, 0.0)]), [(20, 0, 1)]
    )
    assert done == pytest.approx(np.array([[0.4, -0.7], [-0.3, 0.2]]), abs=1e-12)
    assert record[:, 2:].tolist() == [[0.0, -1.0], [0.0, -1.0]]


def test_a_robot_slows_down_before_an_obstacle_ahead_and_not_one_behind():
    for angle, slower in ((0.0, True), (math.pi, False)):
        done, _ = filtered([(0, 0, angle)], [(1.0, 0.0)], safety(1, obstacles=[(0.5, 0.0)]), [(1.6, 0, 0.5)])
        assert bool(done[0, 0] < 0.5) is slower


def test_a_robot_at_rest_goes_out_of_the_way_of_an_obstacle():
    now, after = [(1.4, 0.0, 0.5)], [(1.4 - 0.4 * DT, 0.0, 0.5)]
    done, record = filtered([(0, 0, 0.0)], [(0.0, 0.0)], safety(1, obstacles=[(0.5, 0.4)]), now, after)
    assert done[0, 0] < -0.1
    assert record[0, 2] == 0.0


def test_what_cannot_be_kept_is_recorded_with_what_it_is_about():
    now, after = [(1.4, 0.0, 0.5), (-8, 0, 0.5)], [(1.4 - 3.0 * DT, 0.0, 0.5), (-8, 0, 0.5)]
    done, record = filtered([(0, 0, 0.0)], [(0.5, 0.0)], safety(1, obstacles=[(0.5, 3.0), (0.5, 0.0)]), now, after)
    assert done[0, 0] == pytest.approx(-V_LIMIT)
    assert record[0, 2] > 1.0
    assert record[0, 3] == 1 + 0  # behind the one robot, obstacle 0


def test_two_robots_give_way_to_each_other_by_the_same_amount():
    done, _ = filtered([(0, 0, 0.0), (2.0, 0, math.pi)], [(1.0, 0.0), (1.0, 0.0)], safety(2))
    assert done[0, 0] == pytest.approx(done[1, 0])
    assert done[0, 0] < 0.5


def test_commands_of_laws_change_as_fast_as_allowed_while_something_is_near():
    given = safety(1, obstacles=[(0.5, 0.0)], acceleration=2.0)
    for x, limited in ((2.5, True), (5.0, False)):
        done, _ = filtered([(0, 0, 0.0)], [(1.0, -1.0)], given, [(x, 0, 0.5)])
        assert done[0] == pytest.approx([2.0 * DT, -2.0 * DT] if limited else [1.0, -1.0])


@settings(max_examples=examples(300))
@given(st.floats(0, 30), st.floats(0, 1), st.floats(0, 1), st.floats(-3.2, 3.2))
def test_what_is_not_near_cannot_break_its_barrier_within_the_time_of_alpha(distance, share, later, angle):
    alpha, least, error, speed = 2.0, 1.5, 0.1, 3.0
    if is_near(alpha, distance, least, error, speed):
        return
    closed = share * speed * later / alpha
    assert math.cos(angle) * speed >= rate_bound(alpha, distance - closed, least) + error


def test_the_rate_bound_is_that_of_the_barrier_and_joins_the_one_inside():
    assert rate_bound(2.0, 3.0, 1.0) == pytest.approx(-2.0 * (9.0 - 1.0) / (2.0 * 3.0))
    assert rate_bound(2.0, 1.0, 1.0) == 0.0
    assert rate_bound(2.0, 0.0, 1.0) == 2.0
