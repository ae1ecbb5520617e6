"""Simulation of a scenario under one control law: arrays in, compiled loop, named trajectory out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from types import ModuleType
from typing import Any

import numpy as np

from dwmr.control import laws as controllers
from dwmr.control.fuzzy_gains import Known, Rules
from dwmr.control.laws.python_law import reported
from dwmr.control.laws.settings import LawSettings
from dwmr.core.arrays import FloatArray
from dwmr.core.interfaces import Law, Signal, TrackingError
from dwmr.core.jit import COMPILED, collected_errors, first_class_functions
from dwmr.scenario.file import ScenarioFile
from dwmr.scenario.model import Scenario
from dwmr.simulation import loop
from dwmr.simulation.faults import LARGEST, NOT_FINITE, TOO_LARGE
from dwmr.simulation.loop import COLUMNS, SIGNALS
from dwmr.simulation.mujoco_plant import MujocoPlant
from dwmr.simulation.periods import Periods, Simulation, kept_samples
from dwmr.simulation.preflight import check, settings_of
from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, DiagnosticError
from fuzzyctl.experiments.scenario_keys import Places
from fuzzyctl.support import arguments


class LawError(DiagnosticError):
    """Raised when the step of a control law raises an error.

    Attributes:
        period: Number of the control period; those before it are recorded.
        robot: Number of the robot.
    """

    def __init__(self, diagnostic: Diagnostic, period: int, robot: int) -> None:
        super().__init__([diagnostic])
        self.period, self.robot = period, robot


class _WorkingMemory:
    """A copy of the arrays that the loop reads and changes from one period to the next.

    Args:
        periods: Those of the run.
    """

    def __init__(self, periods: Periods) -> None:
        parts = (periods.memory, periods.guard and periods.guard[1])
        self._kept = [(array, array.copy()) for part in parts for array in _arrays(part)]

    def restore(self) -> None:
        """Write the copy back."""
        for array, copy in self._kept:
            array[...] = copy


def _arrays(part: Any) -> Iterator[FloatArray]:
    """Yield the arrays of a named tuple, and of those in it."""
    if isinstance(part, np.ndarray):
        yield part
    elif isinstance(part, tuple):
        for name, one in zip(getattr(part, "_fields", ()), part, strict=True):
            if name != "record":
                yield from _arrays(one)


def decide(periods: Periods, first: int, last: int) -> tuple[int, int, int]:
    """Compute the periods from `first` up to but not including `last`, see `Periods.compute`.

    Raises:
        LawError: When the law raises an error; the periods before are recorded.
        DiagnosticError: When the law cannot be compiled into the loop.
    """
    obstacles, noise = periods.given(first, last)
    if not isinstance(periods.simulation.module, ModuleType):  # text raises no errors
        return periods.compute(first, last, obstacles, noise)
    before = _WorkingMemory(periods)
    try:
        return periods.compute(first, last, obstacles, noise)
    except DiagnosticError as error:
        if periods.planning is not None:  # in Python
            raise _of_plan(periods, *periods.planning, error) from None
        before.restore()
        for k in range(first, last):
            now = obstacles[k - first : k - first + 2] if len(obstacles) > 1 else obstacles
            before = _WorkingMemory(periods)
            try:
                periods.compute(k, k + 1, now, noise[k - first : k - first + 1])
            except DiagnosticError as error:
                raise _in_python(periods, k, now, before, error) from None
        raise  # the law does not raise it again, or was not run


def _of_plan(periods: Periods, period: int, robot: int, error: DiagnosticError) -> LawError:
    """Return the error of a plan, which is made after a period."""
    (diagnostic,), scenario = error.diagnostics, periods.simulation.scenario
    there = f"there, of robot {list(scenario.robots)[robot]}: the plan after t = {period * scenario.run.dt:.6g} s"
    return LawError(replace(diagnostic, facts=(*diagnostic.facts, there)), period, robot)


def _in_python(
    periods: Periods, period: int, obstacles: FloatArray, start: _WorkingMemory, compiled: DiagnosticError
) -> LawError:
    """Return the error of a law in a period as Python, with its line; that of compiled code if they differ."""
    module, memory = periods.simulation.module, periods.memory
    seen, slip, heard = memory.seen.copy(), memory.slip.copy(), memory.heard.copy()
    start.restore()
    memory.slip[...], memory.heard[...] = slip, heard  # measured states before the law is called
    if memory.seen is not memory.plant:
        memory.seen[...] = seen
    step, asked = getattr(module.step, "py_func", module.step), list[TrackingError]()

    def kept(error: TrackingError, *others: Any) -> Any:
        asked.append(error)
        return step(error, *others)

    (diagnostic,) = compiled.diagnostics
    try:
        with (
            reported(periods.simulation.name, Path(str(module.__file__)), "run"),
            np.errstate(divide="raise", invalid="raise"),
        ):
            getattr(loop.decide, "py_func", loop.decide)(
                period, periods.paths, kept, periods.kernels, periods.vehicles, periods.world, memory, obstacles[0],
                obstacles[-1], periods.record, periods.law_record, periods.guard,
            )  # fmt: skip
    except DiagnosticError as python:
        (error_in_python,), kinds = python.diagnostics, (type(compiled.__cause__), type(python.__cause__))
        if kinds == (ZeroDivisionError, FloatingPointError):  # numbers of arrays have other errors
            diagnostic = replace(diagnostic, span=error_in_python.span)
        elif kinds[0] is kinds[1]:
            diagnostic = error_in_python
    robot, error = len(asked) - 1, asked[-1]
    seen_by_law = ", ".join(f"{name} = {value:.6g}" for name, value in zip(error._fields, error, strict=True))
    there = f"there, of robot {list(periods.simulation.scenario.robots)[robot]}: {seen_by_law}"
    return LawError(replace(diagnostic, facts=(*diagnostic.facts, there)), period, robot)


#: The compiled loop returns to Python this often, for the progress display and for Ctrl-C.
PERIODS_AT_A_TIME = 4000
#: In plain Python, and with plans, it returns about this often [s].
PATIENCE = 0.25
#: Records of all laws of a command are kept in memory together; more than this is refused [bytes].
MOST_MEMORY = 2 << 30


@dataclass(frozen=True)
class Stop:
    """Why a run ended before its horizon.

    Attributes:
        t: Time of the control period [s].
        robot: Name of the robot, or an empty string.
        reason: One line.
        mistake: The law's mistake and its line, None where its step raised no error.
    """

    t: float
    robot: str
    reason: str
    mistake: Diagnostic | None = None


@dataclass(frozen=True)
class Trajectory:
    """Records of a run, every control period or every few of them.

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
        positions: `MujocoPlant.positions` of rigid bodies, shape (samples, 9 * robots) [m, rad], or None of equations.
        step: Time from one sample to the next [s]; the last one may follow earlier.
        every: Control periods in it.
    """

    controller: str
    robots: tuple[str, ...]
    t: FloatArray
    values: FloatArray
    law_values: FloatArray
    law_signals: tuple[Signal, ...]
    wall_s: float
    stop: Stop | None = None
    positions: FloatArray | None = None
    step: float = 0.0
    every: int = 1

    def __getitem__(self, name: str) -> FloatArray:
        """Return a signal by name, shape (samples, robots)."""
        if name in COLUMNS:
            return self.values[:, :, COLUMNS[name]]
        return self.law_values[:, :, [s.name for s in self.law_signals].index(name)]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all signals."""
        return tuple(s.name for s in (*SIGNALS, *self.law_signals))


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
    for part in ("gains", "state"):
        if len({len(getattr(law, part)) for law in laws.values()}) > 1:
            with reported(controller, Path(str(module.__file__)), "prepared"):
                raise TypeError(f"Law must have as many {part.removesuffix('s')}s for each robot")
    shapes = {robot: file.shapes.get(robot, file.shape) for robot in file.scenario.robots}
    return Simulation(controller, file.scenario, shapes, module, laws)


#: A test of each part of a `Law`, and its kind in words.
_PARTS: dict[str, tuple[Callable[[Any], bool], str]] = {
    "gains": (lambda x: isinstance(x, np.ndarray) and x.ndim == 1, "an array of shape (n,)"),
    "state": (lambda x: isinstance(x, np.ndarray) and x.ndim == 1, "an array of shape (n,)"),
    "kernels": (lambda x: isinstance(x, tuple | list), "a tuple"),
    "plan": (lambda x: x is None or callable(x), "a function or None"),
    "every": (lambda x: isinstance(x, int) and x > 0, "a whole number from 1 on"),
}


def _law(module: Any, settings: LawSettings, rules: Rules, robot: str, name: str) -> Law:
    """Return the law of one robot; a user's law may raise or return anything."""
    with reported(name, Path(str(module.__file__)), "prepared"):
        law = module.init(settings, rules, robot)
        if not isinstance(law, Law):
            raise TypeError(f"init returns {type(law).__name__}, not Law")
        for part, (is_valid, kind) in _PARTS.items():
            if not is_valid(value := getattr(law, part)):
                raise TypeError(f"'{part}' of Law must be {kind}, got {value!r:.40}")
        return law


def require_memory(simulations: Sequence[Simulation], places: Places) -> None:
    """Refuse runs whose records do not fit into `MOST_MEMORY` together.

    Raises:
        DiagnosticError: When they do not.
    """
    needed = sum(len(kept_samples(s.scenario.run.steps + 1, s.every)) * s.sample_size for s in simulations)
    if needed <= MOST_MEMORY:
        return
    horizon = simulations[0].scenario.run.horizon
    message = (
        f"run.horizon = {horizon:g} s makes records of {needed / 2**30:.1f} GiB for {len(simulations)} control law"
        f"{'s' if len(simulations) > 1 else ''}; at most {MOST_MEMORY / 2**30:g} GiB are kept"
    )
    help_text = "raise run.record_every, shorten run.horizon, lengthen run.dt, or run one control law at a time"
    raise DiagnosticError([places.diagnostic("FZ904", "run.horizon", message, help=help_text)])


def run(simulation: Simulation, report: Callable[[int], None] | None = None) -> Trajectory:
    """Run a simulation to its horizon, or to the sample at which it has to stop.

    Args:
        simulation: From `prepare`.
        report: Called with the number of periods done: 0 when all is compiled, then every `PERIODS_AT_A_TIME` or
            `PATIENCE`. A KeyboardInterrupt ends the run and keeps the computed part, as an error of the law does.

    Raises:
        KeyboardInterrupt: When it comes before anything is done.
        DiagnosticError: When the law raises an error before anything is done.
    """
    periods = Periods(simulation)
    plant = _other_plant(simulation.scenario)
    positions = None if plant is None else np.empty((len(periods.record), plant.positions.size))
    with first_class_functions(), collected_errors() as periods.raised:
        computed, wall_s, stop = _computed(periods, report or (lambda _: None), plant, positions)
    law_record, dt = np.concatenate([periods.law_record, periods.memory.record], axis=2), simulation.scenario.run.dt
    if periods.guard is not None:
        law_record = np.concatenate([law_record, periods.guard[1].record], axis=2)
    records = [periods.record, law_record, *(() if positions is None else (positions,))]
    numbers = periods.recorded(computed, records)
    t: FloatArray = numbers.astype(np.float64) * dt
    record, law_record, *rest = (one[: len(numbers)] for one in records)
    return Trajectory(
        simulation.name, tuple(simulation.scenario.robots), t, record, law_record, simulation.law_signals,
        wall_s, stop, rest[0] if rest else None, periods.every * dt, periods.every,
    )  # fmt: skip


def _computed(
    periods: Periods, report: Callable[[int], None], plant: MujocoPlant | None, positions: FloatArray | None
) -> tuple[int, float, Stop | None]:
    """Compute all periods; return how many are recorded, the computing time [s], and why the run ended early."""
    simulation, samples = periods.simulation, periods.total
    dt, names = simulation.scenario.run.dt, tuple(simulation.scenario.robots)
    chunk = PERIODS_AT_A_TIME if COMPILED and plant is None and not periods.plans else 1
    reached, wall_s, began = 0, 0.0, 0.0
    try:
        decide(periods, 0, 0)  # compiles, or loads from cache
        report(0)
        while reached < samples:
            began = perf_counter()
            reached, robot, fault = _some(periods, reached, min(reached + chunk, samples), plant, positions)
            took = perf_counter() - began
            wall_s += took
            if chunk < PERIODS_AT_A_TIME and took < 0.5 * PATIENCE:
                chunk = min(2 * chunk, PERIODS_AT_A_TIME)
            report(reached)
            if fault != 0:
                reason = reason_of(fault, periods.record[periods.row(reached), robot], simulation.module)
                return reached + 1, wall_s, Stop(reached * dt, names[robot], reason)
    except KeyboardInterrupt:
        if reached == 0:
            raise
        return reached, wall_s, Stop((reached - 1) * dt, "", "interrupted")
    except LawError as error:
        if error.period == 0:
            raise
        (mistake,) = error.diagnostics
        return (
            error.period if periods.every == 1 else (error.period - 1) // periods.every * periods.every + 1,
            wall_s + perf_counter() - began,
            Stop(error.period * dt, names[error.robot], mistake.facts[0], mistake),
        )
    return reached, wall_s, None


def _some(
    periods: Periods, first: int, last: int, plant: MujocoPlant | None, positions: FloatArray | None
) -> tuple[int, int, int]:
    """Compute some periods, see `Periods.decide`; rigid bodies move after each, and their positions are kept."""
    if plant is None or positions is None:
        return decide(periods, first, last)
    dt, memory = periods.simulation.scenario.run.dt, periods.memory
    for k in range(first, last):
        positions[periods.row(k)] = plant.positions
        done = decide(periods, k, k + 1)
        if done[2] != 0:
            break
        plant.move(k * dt, memory.torques, memory.plant, memory.slip)
    return done


def _other_plant(scenario: Scenario) -> MujocoPlant | None:
    """Return the plant, None for the equations, which are part of the loop."""
    if scenario.run.plant == "equations":
        return None
    return MujocoPlant(scenario)


def reason_of(fault: int, row: FloatArray, module: Any) -> str:
    """Return why a run ends.

    Args:
        fault: From `loop.run_periods`.
        row: Signals of the robot in the last period, shape (len(SIGNALS),).
        module: The control law.
    """
    if fault == TOO_LARGE:
        units = {s.name: s.unit for s in SIGNALS}
        far = [
            f"{name} is beyond {most:g} {units[name]}"
            for name, most in LARGEST.items()
            if abs(row[COLUMNS[name]]) > most
        ]
        return f"{', '.join(far)}: the run diverged"
    if fault != NOT_FINITE:
        return str(module.FAULTS.get(fault, f"fault {fault}, which the law's FAULTS do not name"))
    bad = [s.name for s, value in zip(SIGNALS, row, strict=True) if not np.isfinite(value)]
    return f"{', '.join(bad) or 'state'} is not finite: the run diverged"


def simulate(
    file: ScenarioFile, controller: str = "", folders: Sequence[str | Path] = (), known: Known | None = None
) -> Trajectory:
    """Prove the rule files and the control law of a scenario, and run it.

    Args:
        file: The scenario, from `dwmr.read`.
        controller: Name of the control law; the scenario's own by default.
        folders: Folders whose rule files replace those of the same name.
        known: Proofs and compiled code to share with other runs.

    Raises:
        DiagnosticError: For an unknown control law, and a mistake in a rule file or in the law.
        ArgumentError: For arguments of other types.
    """
    if not isinstance(file, ScenarioFile):
        raise ArgumentError(f"expected a scenario from dwmr.read, got {file!r:.80}")
    if isinstance(folders, str | Path):
        raise ArgumentError("'folders' must be a list of folders")
    controller = arguments.instance("'controller'", str, "the name of a control law", controller)
    name = controller or file.scenario.run.controller
    rules = Rules(file.scenario.rules, (*map(Path, folders), *file.folders), file.places, known)
    check(file, [name], rules)
    return run(prepare(file, name, rules))
