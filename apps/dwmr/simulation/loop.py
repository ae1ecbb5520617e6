"""Compiled loop: references, avoidance, control law, inner loop and plant of all robots, period after period.

`decide` turns measured states into wheel torques; `move` is the plant of `plant/robot.py`. Another plant takes
the place of `move` only, see `interfaces.Plant`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from dwmr.control.formation import (
    behind_sideways,
    follower_error,
    follower_position,
    mixed,
    tracking_error,
    trajectory_error,
    with_leaders_orientation,
)
from dwmr.control.obstacle_avoidance import Avoidance, avoid, towards
from dwmr.control.safety_filter import CHANGED, Filter, filter_commands
from dwmr.core.arrays import FloatArray, Reference, Safety
from dwmr.core.interfaces import PostureError, Signal
from dwmr.core.jit import compiled
from dwmr.plant.disturbances import Load, disturbance, measure
from dwmr.plant.robot import State, state_of
from dwmr.plant.vehicles import V_Y, drive, move
from dwmr.simulation.faults import fault_of

#: Records of every robot at every sample, in the order of the columns that `_record` fills.
SIGNALS = (
    Signal("x", "m", "reference point"),
    Signal("y", "m", "reference point"),
    Signal("theta", "rad", "orientation, not wrapped"),
    Signal("v", "m/s", "linear velocity from the wheels"),
    Signal("omega", "rad/s", "angular velocity from the wheels"),
    Signal("x_r", "m", "reference position"),
    Signal("y_r", "m", "reference position"),
    Signal("theta_r", "rad", "reference orientation, as modified in avoidance"),
    Signal("v_r", "m/s", "reference linear velocity, as modified in avoidance"),
    Signal("theta_r_star", "rad", "auxiliary reference orientation"),
    Signal("x_e", "m", "longitudinal error in the robot's frame"),
    Signal("y_e", "m", "lateral error in the robot's frame"),
    Signal("v_c", "m/s", "commanded linear velocity, before its limit"),
    Signal("omega_c", "rad/s", "commanded angular velocity, before its limit"),
    Signal("torque_right", "N m", "commanded torque of the right wheel"),
    Signal("torque_left", "N m", "commanded torque of the left wheel"),
    Signal("d_v", "m/s", "velocity-equivalent disturbance"),
    Signal("d_omega", "rad/s", "velocity-equivalent disturbance"),
    Signal("obstacle", "-", "index of the obstacle being avoided, -1 for none"),
    Signal("avoidance_radius", "m", "variable radius R_d of that obstacle, 0 for none"),
)
COLUMNS = {signal.name: k for k, signal in enumerate(SIGNALS)}


class World(NamedTuple):
    """Constants of a run.

    Attributes:
        dt: Control period [s].
        substeps: Integration steps in one period.
        shapes: Constants of all reference trajectories, shape (paths, c).
        robots: Records of dtype `ROBOT`, shape (n,).
        edges: Places of the followers in the formation, records of dtype `EDGE`, shape (e,).
        acting: Disturbances, records of dtype `DISTURBANCE`, shape (n, m).
        load: Change of mass and inertia.
        avoidance: Parameters of the avoidance.
        gains: Constants of the control law, shape (n, g).
        frozen: 1 for each of its states that rests while the robot's command is changed, shape (n, s).
        known_slip: 1 where followers know the velocity of their leader over ground, 0 where that of its wheels.
        measures_exactly: Whether the measured states are the true ones.
        other_plant: Whether the caller of the loop moves the robots, by an `interfaces.Plant`.
        every: Control periods from one recorded sample to the next.
        delay: Age of the messages of leaders in control periods.
        lateral: Column of the law's signals that holds the commanded velocity to the left, -1 without one.
    """

    dt: float
    substeps: int
    shapes: FloatArray
    robots: Any
    edges: Any
    acting: Any
    load: Load
    avoidance: Avoidance
    gains: FloatArray
    frozen: FloatArray
    known_slip: float
    measures_exactly: bool
    other_plant: bool
    every: int
    delay: int
    lateral: int


class Memory(NamedTuple):
    """Memory from one period to the next; the loop writes it.

    Attributes:
        plant: Fields of `State`, shape (n, 7).
        slip: Velocities over ground less those of the wheels, shape (n, 2) [m/s, rad/s].
        seen: The plant's state as the robots measure it; where they measure exactly it is the array `plant` itself.
        heard: Leaders' measured states and slip as their followers know them from messages, shape (n, 9).
        sent: The latest messages, by period modulo their number, shape (delay + 1, n, 9).
        wheels, odometry: Memory of the sensors, shapes (n, 6) and (n, 3), see `sensors.measure`.
        theta_star: Auxiliary orientations θ*_r, shape (n,) [rad].
        filters: States of the derivative filters, shape (n, 2) [m/s, rad/s].
        targets: Velocities that the drives are set to, ahead, turning and to the left, shape (n, 3) [m/s, rad/s, m/s].
        sides: Latched sides of avoidance, shape (n, a).
        law: States of the control law, shape (n, s).
        next_law: The same after the period.
        torques: Commanded torques of the right and left wheel, shape (n, 2) [N m].
        changed: 1 for each robot whose command in this period limits or the safety filter changed, shape (n,).
        own: Numbers of each vehicle, see `vehicles.OWN`, shape (n, 5).
        record: Recorded ones of these, the first columns, shape (samples, n, columns).
    """

    plant: FloatArray
    slip: FloatArray
    seen: FloatArray
    heard: FloatArray
    sent: FloatArray
    wheels: FloatArray
    odometry: FloatArray
    theta_star: FloatArray
    filters: FloatArray
    targets: FloatArray
    sides: FloatArray
    law: FloatArray
    next_law: FloatArray
    torques: FloatArray
    changed: FloatArray
    own: FloatArray
    record: FloatArray


class Target(NamedTuple):
    """Where a robot should be and how it should move, with the obstacle that changes this, if any."""

    x: float
    y: float
    theta: float
    v: float
    omega: float
    obstacle: float
    avoidance_radius: float


@compiled
def run_periods(
    first: int,
    last: int,
    paths: Any,
    step: Any,
    kernels: Any,
    vehicles: Any,
    world: World,
    memory: Memory,
    obstacles: FloatArray,
    noise: FloatArray,
    record: FloatArray,
    law_record: FloatArray,
    guard: tuple[Safety, Filter] | None,
) -> tuple[int, int, int]:
    """Run the control periods from `first` up to but not including `last`.

    Args:
        first, last: Numbers of control periods; time is number · dt.
        paths: The reference trajectories, see `interfaces.reference_path`.
        step: Control law, see `interfaces.control_law`.
        kernels: Gain kernels of the law, one tuple per robot.
        vehicles: Functions of each robot, see `vehicles.Vehicle`; None if all are differential drives.
        world: Constants.
        memory: Read and written.
        obstacles: Centres and radii of the obstacles at these periods and the one after, shape (last - first + 1, a, 3)
            [m]; shape (1, a, 3) if all stay in place.
        noise: Added to the measured x, y, theta, v, omega [m, m, rad, m/s, rad/s], and 1 for a robot whose message is
            lost, shape (last - first, n, 6); shape (0, n, 6) if all measure exactly and all messages arrive at once.
        record: Written, shape (samples, n, len(SIGNALS)); see `row_of` for the samples.
        law_record: Written, shape (samples, n, signals of the law).
        guard: Safety filter and its memory, None for none; numba compiles the loop once for each.

    Returns:
        Number of the period reached, robot and fault: 0 for none, a key of the law's FAULTS, `faults.NOT_FINITE` or
            `faults.TOO_LARGE`.
    """
    moving = 1 if obstacles.shape[0] > 1 else 0
    for k in range(first, last):
        t = k * world.dt
        now, after = obstacles[moving * (k - first)], obstacles[moving * (k - first + 1)]
        if not world.measures_exactly:
            measure(noise[k - first], memory.plant, world.robots, world.dt, memory.wheels, memory.odometry, memory.seen)
        if not world.other_plant:
            _slip(t, world, memory)
        if not world.measures_exactly:
            _tell(k, noise[k - first], world, memory)
        robot, fault = decide(k, paths, step, kernels, vehicles, world, memory, now, after, record, law_record, guard)
        if fault != 0:
            return k, robot, fault
        if not world.other_plant:
            _move(t, vehicles, world, memory)
    return last, -1, 0


@compiled
def row_of(period: int, every: int, samples: int) -> int:
    """Return the row of a period in a record of every `every`-th period; the last row has the latest of the others."""
    return period // every if period % every == 0 else samples - 1


@compiled
def decide(
    period: int,
    paths: Any,
    step: Any,
    kernels: Any,
    vehicles: Any,
    world: World,
    memory: Memory,
    now: FloatArray,
    after: FloatArray,
    record: FloatArray,
    law_record: FloatArray,
    guard: tuple[Safety, Filter] | None,
) -> tuple[int, int]:
    """Compute the torques of all robots from measured states, before any of them moves.

    Args:
        period: Number of the control period.
        now, after: Centres and radii of the obstacles at its begin and its end, shape (a, 3) [m].

    Other arguments as for `run_periods`.

    Returns:
        Robot and fault, as `run_periods` does.
    """
    n, t = world.robots.shape[0], period * world.dt
    row = row_of(period, world.every, record.shape[0])
    faulty, first_fault = -1, 0
    for i in range(n):
        state = state_of(memory.plant[i])
        reference = _reference(t, i, paths, world)
        target = _aim(i, reference, now, world, memory)
        seen = error = _error(i, reference, target, memory.plant, memory.plant, memory.slip, world, memory)
        if not world.measures_exactly:
            heard = memory.heard
            seen = _error(i, reference, target, memory.seen, heard, heard[:, 7:], world, memory)
        measured, robot, theta = memory.seen[i], world.robots[i], target.theta - memory.seen[i, 2]
        if robot.sideways != 0 and target.obstacle >= 0.0:
            seen = towards(seen)
        view = tracking_error(
            seen, robot.first == robot.last, theta, target.v, target.omega, measured[3], measured[4], t
        )
        v_c, omega_c, fault = step(
            view, world.dt, world.gains[i], memory.law[i], kernels[i], memory.next_law[i], law_record[row, i]
        )
        memory.changed[i] = 1.0 if abs(v_c) > robot.v_limit or abs(omega_c) > robot.omega_limit else 0.0
        for c in range(memory.record.shape[2]):
            memory.record[row, i, c] = memory.own[i, c]
        if guard is None:
            v_y_c = law_record[row, i, world.lateral] if world.lateral >= 0 else 0.0
            _drive(i, v_c, v_y_c, omega_c, vehicles, world, memory)
        else:
            guard[1].commands[i, 0], guard[1].commands[i, 1] = v_c, omega_c
        _record(record[row, i], state, target, error, v_c, omega_c, memory, i)
        memory.theta_star[i] += world.dt * seen.drift_theta
        fault = fault_of(fault, state, v_c, omega_c)
        if fault != 0 and first_fault == 0:
            faulty, first_fault = i, fault
    if guard is not None:
        _keep_safe(row, now, after, guard, vehicles, world, memory, record[row])
    if first_fault != 0:  # only now, so that the last row is whole
        return faulty, first_fault
    for i in range(n):
        for k in range(memory.law.shape[1]):  # a quarter of the compiling time of an assignment of slices
            if memory.changed[i] == 0.0 or world.frozen[i, k] == 0.0:
                memory.law[i, k] = memory.next_law[i, k]
    return -1, 0


@compiled
def _keep_safe(
    row: int, now: FloatArray, after: FloatArray, guard: tuple[Safety, Filter], vehicles: Any, world: World,
    memory: Memory, record: FloatArray,
) -> None:  # fmt: skip
    """Filter the commands of all robots together, then turn them into torques, which are written into the record."""
    safety, its_memory = guard
    filter_commands(row, memory.seen, now, after, world.dt, world.robots, safety, its_memory)
    for i in range(world.robots.shape[0]):
        v, omega = its_memory.commands[i, 0], its_memory.commands[i, 1]
        change = abs(v - record[i, 12]) + abs(omega - record[i, 13])
        memory.changed[i] = 1.0 if change > CHANGED else 0.0
        _drive(i, v, 0.0, omega, vehicles, world, memory)
        record[i, 14], record[i, 15] = memory.torques[i, 0], memory.torques[i, 1]


@compiled
def _tell(period: int, noise: FloatArray, world: World, memory: Memory) -> None:
    """Send measured state and slip of every robot, and receive the message of a delay before if it is not lost."""
    count = memory.sent.shape[0]
    for i in range(memory.heard.shape[0]):
        for c in range(9):
            value = memory.seen[i, c] if c < 7 else memory.slip[i, c - 7]
            memory.sent[period % count, i, c] = value
            if noise[i, 5] == 0.0 and (period >= world.delay or period == 0):
                memory.heard[i, c] = memory.sent[max(period - world.delay, 0) % count, i, c]


@compiled
def _reference(t: float, i: int, paths: Any, world: World) -> Reference:
    """Return the reference of a robot at a time [s]."""
    robot = world.robots[i]
    here: Reference = paths[robot.path](t - robot.delay, world.shapes[robot.path])
    return here


@compiled
def _aim(i: int, reference: Reference, obstacles: FloatArray, world: World, memory: Memory) -> Target:
    """Return the target of one robot; a robot on a reference avoids obstacles by its measured state.

    Source:
        Goto, Bertol, Martins, Eqs. (70), (71) for a robot on the reference; Eq. (47) for a follower.
    """
    robot = world.robots[i]
    if robot.first < robot.last:
        return _place(i, reference, world, memory)
    theta_r, v_r, omega_r, obstacle, reach = reference.theta, reference.v, reference.omega, -1, 0.0
    if robot.avoids != 0:
        s = state_of(memory.seen[i])
        obstacle, direction, reach = avoid(
            s.x, s.y, s.theta, s.v, robot.radius, obstacles, memory.sides[i], world.avoidance
        )
        if obstacle >= 0:
            theta_r, v_r, omega_r = direction, world.avoidance.slowdown * v_r, 0.0
    return Target(reference.x, reference.y, theta_r, v_r, omega_r, float(obstacle), reach)


@compiled
def _leader(
    j: int, body: Reference, states: FloatArray, slip: FloatArray, share: float, world: World
) -> tuple[Reference, float]:
    """Return posture, velocities and `d` of robot `j`, or for -1 of the body of a virtual structure.

    Args:
        states, slip: Of all robots.
        share: Of the slip that counts.
    """
    if j < 0:
        return body, 0.0
    s = state_of(states[j])
    v, omega = s.v + share * slip[j, 0], s.omega + share * slip[j, 1]
    return Reference(s.x, s.y, s.theta, v, omega), world.robots[j].d


@compiled
def _place(i: int, body: Reference, world: World, memory: Memory) -> Target:
    """Return the target of a follower, the weighted mean of its places in the formation."""
    x_r = y_r = v_r = 0.0
    for e in range(world.robots[i].first, world.robots[i].last):
        edge = world.edges[e]
        lead, d = _leader(edge.leader, body, memory.plant, memory.slip, 1.0, world)
        x, y = follower_position(lead.x, lead.y, lead.theta, d, edge.separation, edge.bearing)
        x_r, y_r, v_r = x_r + edge.weight * x, y_r + edge.weight * y, v_r + edge.weight * lead.v
    # theta_jr = theta_i of Eq. (47) cannot be kept in a turn; the auxiliary orientation takes its place
    return Target(x_r, y_r, memory.theta_star[i], v_r, 0.0, -1.0, 0.0)


@compiled
def _error(
    i: int, body: Reference, target: Target, plant: FloatArray, leaders: FloatArray, slip: FloatArray,
    world: World, memory: Memory,
) -> PostureError:  # fmt: skip
    """Return the tracking error of one robot.

    Args:
        i: Number of the robot.
        body: Its reference, along which a virtual structure moves.
        target: Where it should be; a follower's place is computed anew from its leaders' states.
        plant: States of all robots as they are or as they are seen, shape (n, 7).
        leaders: The same as their followers know them, shape (n, 7 or more).
        slip: That of leaders as their followers know it, shape (n, 2).
        world, memory: As for `run_periods`.

    Source:
        Goto, Bertol, Martins, Eqs. (4)-(6), (72) for a robot on the reference; Eqs. (47)-(51) for a follower, whose
        errors and drifts are linear in the place and velocity that a leader implies.
    """
    robot, theta_star, s = world.robots[i], memory.theta_star[i], state_of(plant[i])
    if robot.first == robot.last:
        return trajectory_error(s.x, s.y, s.theta, target.x, target.y, target.theta, theta_star, target.v, robot.d)
    mean = _edge_error(i, robot.first, body, s, leaders, slip, world, memory)
    share, theta_e = world.edges[robot.first].weight, mean.theta_e_star
    for e in range(robot.first + 1, robot.last):
        one = _edge_error(i, e, body, s, leaders, slip, world, memory)
        mean, share = mixed(mean, share, one, world.edges[e].weight, theta_e), 1.0
    return mean


@compiled
def _edge_error(
    i: int, e: int, body: Reference, s: State, leaders: FloatArray, slip: FloatArray, world: World, memory: Memory
) -> PostureError:
    """Return the tracking error of a robot from one of its places; arguments as for `_error`."""
    edge, theta_star = world.edges[e], memory.theta_star[i]
    lead, d = _leader(edge.leader, body, leaders, slip, world.known_slip, world)
    error = follower_error(
        lead.x, lead.y, lead.theta, lead.v, lead.omega, d, s.x, s.y, s.theta, theta_star, world.robots[i].d,
        edge.separation, edge.bearing,
    )  # fmt: skip
    if edge.leader >= 0 and memory.own[edge.leader, V_Y] != 0.0:
        error = behind_sideways(error, memory.own[edge.leader, V_Y], lead.theta, s.theta, theta_star)
    if world.robots[i].sideways != 0:
        error = with_leaders_orientation(error, lead.theta, lead.omega, s.theta)
    return error


@compiled
def _drive(i: int, v_c: float, v_y_c: float, omega_c: float, vehicles: Any, world: World, memory: Memory) -> None:
    """Turn the velocity command of a robot into commands of its drives."""
    drive(
        i, v_c, v_y_c, omega_c, vehicles, memory.seen[i], world.robots[i], world.dt, memory.own[i], memory.filters[i],
        memory.targets[i], memory.torques[i],
    )  # fmt: skip


@compiled
def _slip(t: float, world: World, memory: Memory) -> None:
    """Write the slip of the plant of `plant/robot.py`: its velocity-equivalent disturbances, d̃_0 of Eq. (6)."""
    for i in range(memory.slip.shape[0]):
        now = disturbance(t, world.acting[i])
        memory.slip[i, 0], memory.slip[i, 1] = now.v, now.omega


@compiled
def _move(t: float, vehicles: Any, world: World, memory: Memory) -> None:
    """Advance all robots by one period that begins at a time [s], under held torques."""
    for i in range(memory.plant.shape[0]):
        move(
            i, t, vehicles, memory.plant[i], memory.torques[i], world.robots[i], world.acting[i], world.load, world.dt,
            world.substeps, memory.own[i],
        )  # fmt: skip


@compiled
def _record(
    row: FloatArray, s: State, target: Target, error: PostureError, v_c: float, omega_c: float, memory: Memory, i: int
) -> None:
    row[0], row[1], row[2], row[3], row[4] = s.x, s.y, s.theta, s.v, s.omega
    row[5], row[6], row[7], row[8] = target.x, target.y, target.theta, target.v
    row[9], row[10], row[11] = memory.theta_star[i], error.x_e, error.y_e
    row[12], row[13], row[14], row[15] = v_c, omega_c, memory.torques[i, 0], memory.torques[i, 1]
    row[16], row[17], row[18], row[19] = memory.slip[i, 0], memory.slip[i, 1], target.obstacle, target.avoidance_radius
