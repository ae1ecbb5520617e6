"""Control periods of a run: the arrays of the compiled loop, and calls of it for some periods."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dwmr.control import safety_filter
from dwmr.control.law_text import LATERAL
from dwmr.control.laws.python_law import reported
from dwmr.control.obstacle_avoidance import Avoidance
from dwmr.core.arrays import FloatArray
from dwmr.core.geometry import wrap
from dwmr.core.interfaces import Law, Signal, reference_path
from dwmr.core.jit import first_class
from dwmr.plant import vehicles
from dwmr.plant.disturbances import DISTURBANCE, Load
from dwmr.plant.robot import EDGE, ROBOT
from dwmr.reference.prepared import CURVES, Shape
from dwmr.scenario.guard import levers_of, safety_of
from dwmr.scenario.model import LARGEST_NOISE, Omnidirectional, Robot, Scenario
from dwmr.scenario.outlines import centres, is_moving
from dwmr.scenario.vehicle_limits import others
from dwmr.simulation.loop import SIGNALS, Memory, World, row_of, run_periods

#: A record of all signals at all periods that takes more is thinned out [bytes].
LARGEST_RECORD = 100_000_000


def kept_samples(samples: int, every: int) -> NDArray[np.int64]:
    """Return the numbers of the samples that are kept: every `every`-th from the first on, and the last."""
    return np.union1d(np.arange(0, samples, every), [samples - 1])


@dataclass(frozen=True)
class Simulation:
    """A run made ready: checked, proved, its kernels compiled."""

    name: str
    scenario: Scenario
    shapes: Mapping[str, Shape]
    module: Any
    laws: dict[str, Law]

    @property
    def law_signals(self) -> tuple[Signal, ...]:
        """Signals of the control law and, where there are any, of the safety filter or of vehicles."""
        signals: tuple[Signal, ...] = tuple(self.module.SIGNALS)
        if self.scenario.safety is not None:
            return (*signals, *safety_filter.SIGNALS)
        return (*signals, *vehicles.SIGNALS) if others(self.scenario) else signals

    @property
    def sample_size(self) -> int:
        """Memory of one recorded sample [bytes]; of rigid bodies their positions are recorded, too."""
        positions = 9 * (self.scenario.run.plant != "equations")
        return 8 * len(self.laws) * (len(SIGNALS) + len(self.law_signals) + positions)

    @property
    def every(self) -> int:
        """Control periods from one recorded sample to the next.

        The measures of the safety filter need each of them, see `checks`.
        """
        run = self.scenario.run
        if run.record_every is not None or self.scenario.safety is not None:
            return run.record_every or 1
        return -(-(run.steps + 1) * self.sample_size // LARGEST_RECORD)


class Periods:
    """The control periods of a run; they are computed in order, some at a time.

    Args:
        simulation: A prepared run.
        measured: Whether the caller writes states as sensors measure them, so that the scenario's noise and
            odometry are left out; nothing but the caller moves the robots then.

    Attributes:
        simulation: A prepared run.
        total: Number of all periods.
        world, memory: Constants and memory of the loop.
        every: Control periods from one recorded sample to the next; only the last one is kept for a caller that writes
            states.
        record: Signals of `loop.SIGNALS`, shape (samples, robots, signals).
        law_record: Those of the control law.
        guard: Safety filter and its memory, None without one.
        paths, kernels: Reference trajectories, and of each robot a tuple of the law's gain kernels, as the loop takes
            them: the last ones are repeated.
        vehicles: Functions of each robot, None if all are differential drives.
        plans: Number of the robot, control periods from one plan to the next, and function of each plan.
        raised: Errors of compiled code, from `jit.collected_errors`.
        planning: Period and number of the robot for which a plan is made, None while none is.
    """

    def __init__(self, simulation: Simulation, *, measured: bool = False) -> None:
        scenario, names = simulation.scenario, tuple(simulation.scenario.robots)
        laws = [simulation.laws[n] for n in names]
        exactly = measured or not measures_inexactly(scenario)
        self.simulation, self.total = simulation, scenario.run.steps + 1
        self.every = self.total if measured else simulation.every
        samples = len(kept_samples(self.total, self.every))
        self.world = _world(simulation, laws, exactly, measured or scenario.run.plant != "equations", self.every)
        self.memory = _memory(simulation, laws, exactly, samples)
        self.record: FloatArray = np.zeros((samples, len(names), len(SIGNALS)))
        self.law_record: FloatArray = np.zeros((samples, len(names), len(simulation.module.SIGNALS)))
        self.guard = None
        if scenario.safety is not None:
            levers = levers_of(scenario, scenario.safety)
            room = safety_filter.working_memory(len(names), len(scenario.obstacles), samples, levers)
            self.guard = (safety_of(scenario, scenario.safety), room)
        self.raised: list[BaseException] = []
        self.planning: tuple[int, int] | None = None
        self._step = first_class(simulation.module.step)
        paths = {id(one): one.path for one in simulation.shapes.values()}
        self.paths = _padded([first_class(PATHS[one]) for one in paths.values()])
        self._draw = noise_source(scenario)
        self.kernels = _padded([tuple(first_class(k) for k in law.kernels) for law in laws])
        kinds = [one.vehicle.kind if one.vehicle else "differential" for one in scenario.robots.values()]
        self.vehicles = _padded([vehicles.vehicle(kind) for kind in kinds]) if others(scenario) else None
        self.plans = [(i, law.every, law.plan) for i, law in enumerate(laws) if law.plan is not None]

    def row(self, period: int) -> int:
        """Return the row of a period in the records, see `loop.row_of`."""
        return row_of(period, self.every, len(self.record))

    def recorded(self, computed: int, records: Sequence[FloatArray]) -> NDArray[np.int64]:
        """Return the recorded ones of some periods, and bring the last one into its row.

        Args:
            computed: Number of the periods.
            records: Arrays whose first axis counts the samples; written.
        """
        numbers = kept_samples(computed, self.every)
        for one in records:
            one[len(numbers) - 1] = one[self.row(computed - 1)]
        return numbers

    def given(self, first: int, last: int) -> tuple[FloatArray, FloatArray]:
        """Return the obstacles at the periods from `first` up to but not including `last`, and draw their noise.

        Both are as `loop.run_periods` takes them.
        """
        return _obstacles(self.simulation.scenario, first, last), self._draw(last - first)

    def compute(self, first: int, last: int, obstacles: FloatArray, noise: FloatArray) -> tuple[int, int, int]:
        """Compute the periods from `first` up to but not including `last`, see `loop.run_periods`.

        Where another plant moves the robots, it moves them after each period. The law's plans are made between calls of
        the compiled loop, and take effect in the next period. No periods: it is only compiled.

        Args:
            first, last: Numbers of control periods.
            obstacles, noise: From `given`.

        Raises:
            DiagnosticError: When the law raises an error, or cannot be compiled into the loop.
        """
        simulation = self.simulation
        name, file = simulation.name, Path(str(simulation.module.__file__))
        self.raised.clear()
        with reported(name, file, "run", only_own=last > 0):
            for begin, end in pairwise([first, *self._breaks(first, last), last]):
                now = obstacles[begin - first : end - first + 1] if len(obstacles) > 1 else obstacles
                done = run_periods(
                    begin, end, self.paths, self._step, self.kernels, self.vehicles, self.world, self.memory, now,
                    noise[begin - first : end - first], self.record, self.law_record, self.guard,
                )  # fmt: skip
                if done[2] == 0 and not self.raised and self.plans:
                    with reported(name, file, "run"):
                        done = self._plan(end)
                if done[2] != 0 or self.raised:
                    break
        if self.raised:  # by the law's step: errors of compiled code name no line
            with reported(name, file, "run"):
                raise self.raised[0]
        return done

    def _breaks(self, first: int, last: int) -> list[int]:
        """Return the numbers of periods between two others before which a plan is made."""
        breaks = (range(first + 1 + -first % every, last, every) for _, every, _ in self.plans)
        return sorted(set().union(*breaks))

    def _plan(self, reached: int) -> tuple[int, int, int]:
        """Make the plans of the period before one; return a period, a robot and a fault as `run_periods` does."""
        for i, every, plan in self.plans:
            if reached > 0 and (reached - 1) % every == 0:
                self.planning = reached - 1, i
                fault = plan(self.memory.law[i], self.world.robots[i])
                if not isinstance(fault, int | np.integer):
                    raise TypeError(f"a plan returns {fault!r:.40}, not 0 or a key of FAULTS")
                self.planning = None
                if fault != 0:
                    return reached - 1, i, int(fault)
        return reached, -1, 0


def _padded(items: list[Any]) -> tuple[Any, ...]:
    """Return a tuple that repeats the last item until there are eight or a multiple.

    The loop, which numba compiles for each length of a tuple, is then compiled once for all small formations.
    """
    return tuple(items + items[-1:] * (-len(items) % 8))


def _obstacles(scenario: Scenario, first: int, last: int) -> FloatArray:
    """Return the obstacles at some periods and the one after them, once if all rest, as the loop takes them."""
    count = last - first + 1 if is_moving(scenario) else 1
    radii = np.broadcast_to([one.radius for one in scenario.obstacles], (count, len(scenario.obstacles)))
    places = centres(scenario, scenario.run.dt * np.arange(first, first + count, dtype=np.float64))
    return np.ascontiguousarray(np.concatenate([places, radii[:, :, None]], axis=2))


def _world(simulation: Simulation, laws: list[Law], measures_exactly: bool, other_plant: bool, every: int) -> World:
    scenario = simulation.scenario
    robots = records(scenario)
    shapes = {id(one): one.constants for one in simulation.shapes.values()}
    padded = np.zeros((len(shapes), max(map(len, shapes.values()))))
    for row, constants in zip(padded, shapes.values(), strict=True):
        row[: len(constants)] = constants
    lateral, last = next((k for k, one in enumerate(simulation.module.SIGNALS) if one.name == LATERAL), -1), 0
    for record, (name, robot) in zip(robots, scenario.robots.items(), strict=True):
        record["first"], last = last, last + len(robot.edges)
        record["last"], record["path"] = last, list(shapes).index(id(simulation.shapes[name]))
        record["sideways"] = lateral >= 0 and isinstance(robot.vehicle, Omnidirectional)
    return World(
        scenario.run.dt,
        scenario.run.substeps,
        padded,
        robots,
        _edges(scenario).view(np.recarray),
        _acting(scenario).view(np.recarray),
        Load(scenario.load.start, scenario.load.stop, scenario.load.mass_factor, scenario.load.inertia_factor),
        Avoidance(**scenario.avoidance.model_dump()),
        np.array([law.gains for law in laws]),
        _frozen(scenario, laws),
        float(scenario.formation.leader_velocity == "ground"),
        measures_exactly,
        other_plant,
        every,
        delay_of(scenario),
        lateral,
    )


def records(scenario: Scenario) -> Any:
    """Return the constants of all robots, records of dtype `ROBOT`, shape (n,)."""
    robots = np.zeros(len(scenario.robots), dtype=ROBOT)
    for row, robot in zip(robots, scenario.robots.values(), strict=True):
        for name, value in _constants(robot).items():
            row[name] = value
    return robots.view(np.recarray)


def _frozen(scenario: Scenario, laws: list[Law]) -> FloatArray:
    """Return 1 for each state that rests while the command is changed, shape (n, s)."""
    frozen = np.zeros((len(laws), max(len(law.state) for law in laws)))
    for row, law, robot in zip(frozen, laws, scenario.robots.values(), strict=True):
        guarded = scenario.safety is not None
        if guarded if robot.conditional_adaptation is None else robot.conditional_adaptation:
            row[list(law.frozen)] = 1.0
    return frozen


def _edges(scenario: Scenario) -> Any:
    """Return the places of all followers, robot by robot."""
    names = {name: i for i, name in enumerate(scenario.robots)}
    edges = [
        (-1 if one.leader is None else names[one.leader], one.separation, one.bearing, one.weight)
        for robot in scenario.robots.values()
        for one in robot.edges
    ]
    return np.array(edges, dtype=EDGE)


def _constants(robot: Robot) -> dict[str, float]:
    """Return the fields of a `ROBOT` record that follow from the robot alone."""
    as_accelerations = robot.inner_loop.torque_reading == "acceleration"
    accelerations = {name: getattr(robot.actuator, name) for name in ("acceleration", "angular_acceleration")}
    derived = {name: math.inf if one is None else one for name, one in accelerations.items()} | {
        "pd_mass": robot.mass if as_accelerations else 1.0,
        "pd_inertia": robot.inertia if as_accelerations else 1.0,
        "avoids": int(robot.avoids_obstacles),
        "odometry": int(robot.sensors.pose == "odometry"),
        "encoder_steps": robot.sensors.encoder_steps,
    }
    if isinstance(robot.vehicle, Omnidirectional):  # the lever arm of a mecanum wheel
        derived["half_track"] = robot.half_track + robot.vehicle.half_base
    tables = (robot, robot.friction, robot.actuator, robot.inner_loop, *([robot.vehicle] if robot.vehicle else []))
    wanted = set(ROBOT.names or ())
    values = {name: getattr(t, name) for t in tables for name in type(t).model_fields if name in wanted}
    return values | derived


def _acting(scenario: Scenario) -> Any:
    """Return every disturbance for every robot, with zero amplitudes for a spared robot."""
    acting = np.zeros((len(scenario.robots), len(scenario.disturbances)), dtype=DISTURBANCE)
    for i, name in enumerate(scenario.robots):
        for k, one in enumerate(scenario.disturbances):
            frequency = one.angular_frequency if one.kind == "sinusoid" else 0.0
            share = 1.0 if one.robots is None or name in one.robots else 0.0
            amplitudes = [share * a for a in (one.v, one.omega, one.force, one.torque)]
            acting[i, k] = (one.start, one.stop, frequency, one.phase, *amplitudes)
    return acting


def _memory(simulation: Simulation, laws: list[Law], measures_exactly: bool, samples: int) -> Memory:
    scenario = simulation.scenario
    robots = list(scenario.robots.values())
    n = len(robots)
    plant = np.zeros((n, 7))
    plant[:, :3] = [(r.x_0, r.y_0, r.theta_0) for r in robots]
    law = np.array([law.state for law in laws]).reshape(n, -1)
    seen = plant if measures_exactly else plant.copy()
    theta_star = np.array(first_directions(simulation, plant[:, 2]))
    sides = np.zeros((n, len(scenario.obstacles)))
    filters, slip, torques = np.zeros((3, n, 2))
    wheels, odometry = np.zeros((n, 6)), plant[:, :3].copy()
    heard, delay = np.concatenate([seen, slip], axis=1), 0 if measures_exactly else delay_of(scenario)
    return Memory(
        plant,
        slip,
        seen,
        heard,
        np.repeat(heard[None], delay + 1, axis=0),
        wheels,
        odometry,
        theta_star,
        filters,
        np.zeros((n, 3)),
        sides,
        law,
        law.copy(),
        torques,
        np.zeros(n),
        np.zeros((n, vehicles.OWN)),
        np.zeros((samples, n, len(vehicles.SIGNALS) if others(scenario) else 0)),
    )


def first_directions(simulation: Simulation, theta: FloatArray) -> list[float]:
    """Return θ*_r(0) of all robots: of a reference, or the mean of a follower's leaders [rad].

    Args:
        simulation: A prepared run.
        theta: Orientations of the robots at the start, shape (n,) [rad].
    """
    names, directions = list(simulation.scenario.robots), []
    for name, robot in simulation.scenario.robots.items():
        along = simulation.shapes[name].at(-robot.delay).theta
        each = [along if one.leader is None else theta[names.index(one.leader)] for one in robot.edges] or [along]
        turns = [one.weight * wrap(angle - each[0]) for one, angle in zip(robot.edges, each, strict=False)]
        directions.append(float(each[0] + sum(turns)))
    return directions


#: Measured signals, in the order of the fields of `robot.State`.
MEASURED = ("x", "y", "theta", "v", "omega")


def delay_of(scenario: Scenario) -> int:
    """Return the age of the messages of leaders in control periods."""
    return round(scenario.communication.delay / scenario.run.dt)


def measures_inexactly(scenario: Scenario) -> bool:
    """Return whether some robot measures inexactly, or knows its leader's state late."""
    if delay_of(scenario) > 0 or scenario.communication.loss > 0.0:
        return True
    by_wheels = any(r.sensors.pose == "odometry" or r.sensors.encoder_steps for r in scenario.robots.values())
    return by_wheels or bool(_deviations(scenario).any())


def noise_source(scenario: Scenario) -> Callable[[int], FloatArray]:
    """Return a function that draws noise and losses of the next periods, shape (periods, robots, 6), see `loop`.

    A robot's numbers follow from the seed and its name alone: neither the other robots nor the control law nor how many
    periods are drawn at once change them. Where all robots measure exactly the arrays are empty.
    """
    deviations, n = _deviations(scenario), len(scenario.robots)
    if not measures_inexactly(scenario):
        nothing = np.zeros((0, n, len(MEASURED) + 1))
        return lambda periods: nothing
    streams = [np.random.default_rng([scenario.run.seed, *name.encode()]) for name in scenario.robots]
    # no byte of a name is 256
    messages = [np.random.default_rng([scenario.run.seed, 256, *name.encode()]) for name in scenario.robots]

    def draw(periods: int) -> FloatArray:
        drawn = np.stack([one.standard_normal((periods, len(MEASURED))) for one in streams], axis=1)
        lost = np.stack([one.random((periods, 1)) < scenario.communication.loss for one in messages], axis=1)
        noise: FloatArray = np.clip(drawn, -LARGEST_NOISE, LARGEST_NOISE) * deviations
        return np.concatenate([noise, lost.astype(np.float64)], axis=2)

    return draw


def _deviations(scenario: Scenario) -> FloatArray:
    """Return the standard deviations, shape (robots, 5) [m, m, rad, m/s, rad/s]."""
    settings = [r.noise for r in scenario.robots.values()]
    return np.array([[getattr(one, name, 0.0) for name in MEASURED] for one in settings])


#: Compiled curves by name.
PATHS = {name: reference_path(curve) for name, curve in CURVES.items()}
