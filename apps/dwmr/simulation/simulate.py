"""Simulation of a scenario under one control law: arrays in, compiled loop, named trajectory out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from dwmr.control import laws as controllers
from dwmr.control import safety_filter
from dwmr.control.fuzzy_gains import Rules
from dwmr.control.law_text import LATERAL
from dwmr.control.laws.python_law import reported
from dwmr.control.laws.settings import LawSettings
from dwmr.control.obstacle_avoidance import Avoidance
from dwmr.core.arrays import FloatArray
from dwmr.core.interfaces import Law, Plant, Signal
from dwmr.core.jit import COMPILED, collected_errors, first_class, first_class_functions
from dwmr.plant import vehicles
from dwmr.plant.disturbances import DISTURBANCE, Load
from dwmr.plant.robot import ROBOT
from dwmr.reference import compiled
from dwmr.reference.prepared import Shape
from dwmr.scenario.file import ScenarioFile
from dwmr.scenario.guard import safety_of
from dwmr.scenario.model import Robot, Scenario
from dwmr.scenario.moving import centres, is_moving
from dwmr.scenario.vehicle_checks import others
from dwmr.scenario.vehicles import Ackermann, Omnidirectional
from dwmr.simulation import noise
from dwmr.simulation.faults import LARGEST, NOT_FINITE, TOO_LARGE
from dwmr.simulation.loop import COLUMNS, SIGNALS, Memory, World, run_periods
from dwmr.simulation.mujoco_plant import MujocoPlant
from dwmr.simulation.preflight import settings_of
from fuzzyctl.diagnostics.diagnostic import DiagnosticError
from fuzzyctl.experiments.settings.locations import Places

#: The compiled loop returns to Python this often, for the progress display and for Ctrl-C.
PERIODS_AT_A_TIME = 4000
#: In plain Python it returns about this often [s].
PATIENCE = 0.25
#: Records of all laws of a command are kept in memory together; more than this is refused [bytes].
MOST_MEMORY = 2 << 30


@dataclass(frozen=True)
class Stop:
    """Why a run ended before its horizon."""

    t: float
    robot: str
    reason: str


@dataclass(frozen=True)
class Trajectory:
    """What was recorded of a run, every control period.

    Args:
        controller: Name of the control law.
        robots: Names in the order of the arrays' second axis.
        t: Times, shape (samples,) [s].
        values: Signals of `loop.SIGNALS`, shape (samples, robots, signals).
        law_values: Signals of the control law and, where it is on, of the safety filter, shape (samples, robots,
            signals).
        law_signals: Names and units of those.
        wall_s: Computing time of the loop [s].
        stop: Why the run ended early, or None.
    """

    controller: str
    robots: tuple[str, ...]
    t: FloatArray
    values: FloatArray
    law_values: FloatArray
    law_signals: tuple[Signal, ...]
    wall_s: float
    stop: Stop | None = None

    def __getitem__(self, name: str) -> FloatArray:
        """Return a signal by name, shape (samples, robots)."""
        if name in COLUMNS:
            return self.values[:, :, COLUMNS[name]]
        return self.law_values[:, :, [s.name for s in self.law_signals].index(name)]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all signals."""
        return tuple(s.name for s in (*SIGNALS, *self.law_signals))


@dataclass(frozen=True)
class Simulation:
    """A run made ready: checked, proved, its kernels compiled."""

    name: str
    scenario: Scenario
    shape: Shape
    module: Any
    laws: dict[str, Law]

    @property
    def law_signals(self) -> tuple[Signal, ...]:
        """Signals of the control law and, where there are any, of the safety filter or of vehicles."""
        own: tuple[Signal, ...] = tuple(self.module.SIGNALS)
        if self.scenario.safety is not None:
            return (*own, *safety_filter.SIGNALS)
        return (*own, *vehicles.SIGNALS) if others(self.scenario) else own


def prepare(file: ScenarioFile, controller: str, rules: Rules) -> Simulation:
    """Make a run ready.

    Args:
        file: The scenario.
        controller: Name of the control law.
        rules: Rule files of the scenario.

    Raises:
        DiagnosticError: At the first mistake; `checks.check` finds all of them, and faster.
    """
    module = controllers.find(controller, file.path.parent, rules)
    laws = {
        robot: _law(module, settings_of(file, robot, controller, module), rules, robot, controller)
        for robot in file.scenario.robots
    }
    return Simulation(controller, file.scenario, file.shape, module, laws)


def _law(module: Any, settings: LawSettings, rules: Rules, robot: str, name: str) -> Law:
    """Return the law of one robot; a law of one's own may raise or return anything."""
    with reported(name, Path(str(module.__file__)), "prepared"):
        law = module.init(settings, rules, robot)
        if not isinstance(law, Law):
            raise TypeError(f"init returns {type(law).__name__}, not Law")
    return law


def require_memory(simulations: Sequence[Simulation], places: Places) -> None:
    """Refuse runs whose records do not fit into `MOST_MEMORY` together.

    Raises:
        DiagnosticError: When they do not.
    """
    needed = sum(
        8 * (s.scenario.run.steps + 1) * len(s.laws) * (len(SIGNALS) + len(s.law_signals)) for s in simulations
    )
    if needed <= MOST_MEMORY:
        return
    horizon = simulations[0].scenario.run.horizon
    message = (
        f"run.horizon = {horizon:g} s makes records of {needed / 2**30:.1f} GiB for {len(simulations)} control law"
        f"{'s' if len(simulations) > 1 else ''}; at most {MOST_MEMORY / 2**30:g} GiB are kept"
    )
    help_text = "shorten run.horizon, lengthen run.dt, or run one control law at a time"
    raise DiagnosticError([places.diagnostic("FZ904", "run.horizon", message, help=help_text)])


def run(simulation: Simulation, report: Callable[[int], None] | None = None) -> Trajectory:
    """Run a simulation to its horizon, or to the sample at which it has to stop.

    Args:
        simulation: From `prepare`.
        report: Called with the number of periods done: 0 when all is compiled, then every `PERIODS_AT_A_TIME` or
            `PATIENCE`. A KeyboardInterrupt ends the run and keeps what is done.

    Raises:
        KeyboardInterrupt: When it comes before anything is done.
        DiagnosticError: When the law raises an error.
    """
    scenario, module = simulation.scenario, simulation.module
    names = tuple(scenario.robots)
    laws = [simulation.laws[n] for n in names]
    world, memory = _world(simulation, laws), _memory(simulation, laws)
    samples = scenario.run.steps + 1
    record = np.zeros((samples, len(names), len(SIGNALS)))
    law_record = np.zeros((samples, len(names), len(module.SIGNALS)))
    guard = None
    if scenario.safety is not None:
        room = safety_filter.working_memory(len(names), len(scenario.obstacles), samples)
        guard = (safety_of(scenario, scenario.safety), room)
    driven = _vehicles(scenario, module, samples)
    path, step = first_class(compiled.PATHS[simulation.shape.path]), first_class(module.step)
    draw = noise.source(scenario)
    kernels = tuple(tuple(first_class(k) for k in law.kernels) for law in laws)
    reached, robot, fault, wall_s = 0, -1, 0, 0.0
    interrupted = False
    plant = _other_plant(scenario)
    chunk = PERIODS_AT_A_TIME if COMPILED and plant is None else 1

    def decided(first: int, last: int) -> tuple[int, int, int]:
        file = Path(str(module.__file__))
        with reported(simulation.name, file, "run", only_own=last > 0):
            obstacles = _obstacles(scenario, first, last)
            done = run_periods(
                first, last, path, step, kernels, world, memory, obstacles, draw(last - first),
                record, law_record, guard, driven,
            )  # fmt: skip
        if raised:  # by the law's step: errors of compiled code name no line
            with reported(simulation.name, file, "run"):
                raise raised[0]
        return done

    def periods(first: int, last: int) -> tuple[int, int, int]:
        if plant is None or last == 0:
            return decided(first, last)
        for k in range(first, last):
            done = decided(k, k + 1)
            if done[2] != 0:
                break
            plant.move(k * scenario.run.dt, memory.torques, memory.plant, memory.slip)
        return done

    with first_class_functions(), collected_errors() as raised:
        try:
            periods(0, 0)  # compiles, or loads from cache
            if report is not None:
                report(0)
            while reached < samples and fault == 0:
                began = perf_counter()
                last = min(reached + chunk, samples)
                reached, robot, fault = periods(reached, last)
                took = perf_counter() - began
                wall_s += took
                if chunk < PERIODS_AT_A_TIME and took < 0.5 * PATIENCE:
                    chunk = min(2 * chunk, PERIODS_AT_A_TIME)
                if report is not None:
                    report(reached)
        except KeyboardInterrupt:
            if reached == 0:
                raise
            interrupted = reached < samples
    kept = reached + 1 if fault else reached
    t: FloatArray = np.arange(kept, dtype=np.float64) * scenario.run.dt
    stop = None
    if fault:
        stop = Stop(float(t[-1]), names[robot], _reason(fault, record[reached, robot], module))
    elif interrupted:
        stop = Stop(float(t[-1]), "", "interrupted")
    if guard is not None:
        law_record = np.concatenate([law_record, guard[1].record], axis=2)
    if driven is not None:
        law_record = np.concatenate([law_record, driven.record], axis=2)
    signals = simulation.law_signals
    return Trajectory(simulation.name, names, t, record[:kept], law_record[:kept], signals, wall_s, stop)


def _vehicles(scenario: Scenario, module: Any, samples: int) -> vehicles.Vehicles | None:
    """Return what drives other than by two wheels, None for nothing."""
    found = others(scenario)
    if not found:
        return None
    n = len(scenario.robots)
    own = np.zeros(n, dtype=vehicles.VEHICLE)
    for row, name in zip(own, scenario.robots, strict=True):
        match found.get(name):
            case Ackermann() as car:
                row["kind"] = vehicles.ACKERMANN
                for key in ("wheelbase", "steering_limit", "steering_rate"):
                    row[key] = getattr(car, key)
            case Omnidirectional():
                row["kind"] = vehicles.OMNIDIRECTIONAL
    lateral = next((k for k, one in enumerate(module.SIGNALS) if one.name == LATERAL), -1)
    record = np.zeros((samples, n, len(vehicles.SIGNALS)))
    return vehicles.Vehicles(own.view(np.recarray), lateral, np.zeros(n), np.zeros((n, 3)), record)


def _obstacles(scenario: Scenario, first: int, last: int) -> FloatArray:
    """Return the obstacles at some periods and the one after them, once where none moves, as the loop takes them."""
    count = last - first + 1 if is_moving(scenario) else 1
    radii = np.broadcast_to([one.radius for one in scenario.obstacles], (count, len(scenario.obstacles)))
    places = centres(scenario, scenario.run.dt * np.arange(first, first + count, dtype=np.float64))
    return np.ascontiguousarray(np.concatenate([places, radii[:, :, None]], axis=2))


def _other_plant(scenario: Scenario) -> Plant | None:
    """Return what moves the robots, None for the equations, which the loop has in itself."""
    if scenario.run.plant == "equations":
        return None
    return MujocoPlant(scenario)


def _reason(fault: int, row: FloatArray, module: Any) -> str:
    if fault == TOO_LARGE:
        units = {s.name: s.unit for s in SIGNALS}
        far = [
            f"{name} is beyond {most:g} {units[name]}"
            for name, most in LARGEST.items()
            if abs(row[COLUMNS[name]]) > most
        ]
        return f"{', '.join(far)}: the run diverged"
    if fault != NOT_FINITE:
        return str(module.FAULTS[fault])
    bad = [s.name for s, value in zip(SIGNALS, row, strict=True) if not np.isfinite(value)]
    return f"{', '.join(bad) or 'state'} is not finite: the run diverged"


def _world(simulation: Simulation, laws: list[Law]) -> World:
    scenario = simulation.scenario
    robots = np.zeros(len(scenario.robots), dtype=ROBOT)
    names = list(scenario.robots)
    for row, robot in zip(robots, scenario.robots.values(), strict=True):
        for name, value in _constants(robot, names).items():
            row[name] = value
    settings = scenario.avoidance
    return World(
        scenario.run.dt,
        scenario.run.substeps,
        simulation.shape.constants,
        robots.view(np.recarray),
        _acting(scenario).view(np.recarray),
        Load(scenario.load.start, scenario.load.stop, scenario.load.mass_factor, scenario.load.inertia_factor),
        Avoidance(
            settings.margin, settings.largest_radius, settings.kappa, settings.gamma, settings.rho, settings.slowdown
        ),
        np.array([law.gains for law in laws]),
        float(scenario.formation.leader_velocity == "ground"),
        not noise.is_present(scenario),
        scenario.run.plant != "equations",
    )


def _constants(robot: Robot, names: list[str]) -> dict[str, float]:
    """Return the fields of a `ROBOT` record."""
    as_accelerations = robot.inner_loop.torque_reading == "acceleration"
    formation = robot.formation
    own = {
        "pd_mass": robot.mass if as_accelerations else 1.0,
        "pd_inertia": robot.inertia if as_accelerations else 1.0,
        "separation": formation.separation if formation else 0.0,
        "bearing": formation.bearing if formation else 0.0,
        "leader": names.index(formation.leader) if formation else -1,
        "avoids": int(robot.avoids_obstacles),
        "odometry": int(robot.sensors.pose == "odometry"),
        "encoder_steps": robot.sensors.encoder_steps,
    }
    if isinstance(robot.vehicle, Omnidirectional):  # the lever arm of a mecanum wheel
        own["half_track"] = robot.half_track + robot.vehicle.half_base
    tables = (robot, robot.friction, robot.actuator, robot.inner_loop)
    wanted = set(ROBOT.names or ())
    given = {name: getattr(t, name) for t in tables for name in type(t).model_fields if name in wanted}
    return given | own


def _acting(scenario: Scenario) -> Any:
    """Return every disturbance for every robot, with zero amplitudes where a robot is spared."""
    acting = np.zeros((len(scenario.robots), len(scenario.disturbances)), dtype=DISTURBANCE)
    for i, name in enumerate(scenario.robots):
        for k, one in enumerate(scenario.disturbances):
            frequency = one.angular_frequency if one.kind == "sinusoid" else 0.0
            share = 1.0 if one.robots is None or name in one.robots else 0.0
            amplitudes = [share * a for a in (one.v, one.omega, one.force, one.torque)]
            acting[i, k] = (one.start, one.stop, frequency, *amplitudes)
    return acting


def _memory(simulation: Simulation, laws: list[Law]) -> Memory:
    scenario = simulation.scenario
    robots = list(scenario.robots.values())
    n = len(robots)
    plant = np.zeros((n, 7))
    plant[:, :3] = [(r.x_0, r.y_0, r.theta_0) for r in robots]
    law = np.array([law.state for law in laws]).reshape(n, -1)
    seen = plant.copy() if noise.is_present(scenario) else plant
    theta_star = np.array([_first_direction(simulation, r) for r in robots])
    sides = np.zeros((n, len(scenario.obstacles)))
    filters, slip, torques = np.zeros((3, n, 2))
    wheels, odometry = np.zeros((n, 6)), plant[:, :3].copy()
    return Memory(plant, slip, seen, wheels, odometry, theta_star, filters, sides, law, law.copy(), torques)


def _first_direction(simulation: Simulation, robot: Robot) -> float:
    """Return θ*_r(0): the reference's own direction, for a follower that of its leader [rad]."""
    if robot.formation is not None:
        return simulation.scenario.robots[robot.formation.leader].theta_0
    return float(simulation.shape.at(-robot.delay).theta)
