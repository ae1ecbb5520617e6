"""Simulation of a loop in one call, by RK4 or a solver of scipy, with an estimate of the error of integration."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final, Literal, get_args

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, UnknownNameError
from fuzzyctl.kernels.program import scalar
from fuzzyctl.kernels.program.program import Program
from fuzzyctl.model.discrete_plant import BEFORE
from fuzzyctl.model.loop import Loop
from fuzzyctl.simulation.dead_times import dead_times
from fuzzyctl.simulation.experiment import Experiment, LoopBackend, Progress
from fuzzyctl.simulation.loop_params import with_settings
from fuzzyctl.simulation.run import Run
from fuzzyctl.simulation.stops import interrupted, left, signals_without_value

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

#: Solver of compiled runs: the classical method of Runge and Kutta.
RK4: Final = "RK4"
#: What `simulate` takes as a solver.
Solver = Literal["RK4", "RK45", "DOP853", "Radau", "BDF", "LSODA"]
SOLVERS: Final = get_args(Solver)
#: Steps of integration up to which generated Python is done in a second.
SHORT: Final = 20_000
#: Part of the range that a state runs through up to which the error of integration is not a warning.
ACCURATE: Final = 1e-3
#: Tolerances of a step: a part of the state, and an absolute one.
RELATIVE: Final = 1e-8
ABSOLUTE: Final = 1e-10
#: Evaluations of the derivatives between two samples after which a solver has given up; LSODA does not end by itself
#: where a state goes to infinity.
EVALUATIONS: Final = 100_000


def simulate(
    loop: Loop,
    *,
    backend: LoopBackend = "auto",
    solver: Solver = RK4,
    substeps: int = 1,
    progress: Progress | None = None,
    record_calls: bool = False,
    **params: float,
) -> Run:
    """Simulate a loop.

    `Experiment` compiles a loop once for many runs.

    Args:
        loop: A well-formed loop.
        backend: "numba", "python" for generated Python, or "auto": numba for long runs where it can be imported.
        solver: "RK4" with steps of fixed length, compiled; or "RK45", "DOP853", "Radau", "BDF", "LSODA" of scipy.
        substeps: Steps of RK4 between two samples.
        progress: Called now and then with the number of samples done, and of all.
        record_calls: Whether the inputs of systems are recorded, too, as `BLOCK.SYSTEM.INPUT`.
        params: Values of params of the loop, or of its blocks: `BLOCK.PARAM`, or `PARAM` where no other block has it;
            starts of states, as `BLOCK.STATE`, and values of disturbances.

    Returns:
        The run; its `error` holds the largest difference of each state from a run with half the step, or a tenth of
        the tolerances of a solver of scipy.

    Raises:
        DiagnosticError: For a loop that cannot be run.
        UnknownNameError: For a name of no param, backend or solver.
        ValueOutOfBoundsError: For a value of a param that is not a finite number.
        ArgumentError: For an argument of another type, and a solver of scipy with dead time or substeps.
    """
    if not isinstance(loop, Loop):
        raise ArgumentError(f"expected a Loop, got {type(loop).__name__}")
    loop = with_settings(loop, params) if params else loop
    experiment = Experiment(loop, backend, record_calls=record_calls)
    if solver != RK4:
        if solver not in SOLVERS:
            raise UnknownNameError("solver", solver, SOLVERS)
        if substeps != 1:
            raise ArgumentError(f"'substeps' are steps of RK4: the solver {solver} chooses its own")
        run = solved(experiment, solver, progress=progress)
        return run if run.stopped is not None else _with_error(run, solved(experiment, solver, precision=10.0))
    if backend == "auto" and experiment.samples * dead_times(experiment.equations, substeps).steps <= SHORT:
        experiment.backend = "python"  # which is done before numba has compiled
    run = experiment.run(substeps=substeps, progress=progress)
    if run.stopped is not None or not run.plant_states:
        return run
    return _with_error(run, experiment.run(substeps=2 * run.substeps))


def _with_error(run: Run, finer: Run) -> Run:
    code = "" if finer.stopped is None else finer.stopped.code
    if code == "FZ713":  # an FMU that does not survive a second run
        return dataclasses.replace(run, stopped=finer.stopped)
    return run if code == "FZ707" else dataclasses.replace(run, error=differences(run, finer))


def differences(run: Run, finer: Run) -> dict[str, float]:
    """Return the largest difference of each state of the plants between two runs; infinite where one was stopped."""
    if len(run) != len(finer):
        return dict.fromkeys(run.plant_states, float("inf"))
    return {name: float(np.max(np.abs(run[name] - finer[name]))) for name in run.plant_states}


def warnings(run: Run) -> list[Diagnostic]:
    """Return a warning for each state whose error of integration is large, and for a signal that is not a number."""
    remarks = signals_without_value(run)
    for name, error in run.error.items():
        values = run[name]
        span = float(np.max(values) - np.min(values))
        if error > ACCURATE * span and error > ACCURATE * 1e-9:
            finer = "half the step of integration" if run.substeps else "a tenth of the tolerances"
            message = f"state '{name}' changes by {error:.3g} with {finer}"
            facts = (f"that is {error / span:.2g} of the range that it runs through",) if span else ()
            help_text = f"take more substeps: --substeps {4 * run.substeps}; for a stiff plant: --solver Radau"
            help_text = help_text if run.substeps else "take another solver, or RK4 with many --substeps"
            remarks.append(
                Diagnostic("FZ706", message, severity="warning", facts=facts, help=help_text, file=run.loop.path)
            )
    return remarks


class _GaveUpError(Exception):
    """A solver took more evaluations than it may."""


def solved(
    experiment: Experiment,
    solver: Solver,
    *,
    relative: float = RELATIVE,
    absolute: float = ABSOLUTE,
    precision: float = 1.0,
    progress: Progress | None = None,
) -> Run:
    """Simulate a loop with an adaptive solver.

    Args:
        experiment: The loop.
        solver: One of `SOLVERS` but RK4.
        relative: Tolerance of a step as a part of the state.
        absolute: Tolerance of a step in the units of the state.
        precision: What both tolerances are divided by.
        progress: Called now and then.

    Raises:
        ArgumentError: For a loop with dead time, a plant in Python or an FMU.
    """
    equations = experiment.equations
    if equations.delays or equations.externals:
        in_python = any(e.plant.python for e in equations.externals)
        what = "dead time" if equations.delays else "a plant in Python" if in_python else "an FMU"
        raise ArgumentError(f"a loop with {what} takes the solver RK4, not {solver}")
    sample, derivative = (_function(p) for p in (experiment.programs.sample, experiment.programs.derivative))
    free = [value for name, value in experiment.nominal.items() if name in equations.free]
    x = np.array([s.start for s in equations.plant_states], dtype=np.float64)
    c = [s.start for s in equations.states]
    width, input_count = len(equations.signals), len(experiment.programs.held)
    record = np.empty((experiment.samples, width))
    stopped = None
    done = 0
    try:
        for k, t in enumerate(experiment.times.tolist()):
            stopped = _outside(experiment, x, k, record)
            if stopped is not None:
                break
            flags = [1.0 if k % n == 0 else 0.0 for n in equations.rates.values()]
            results = sample([t, *x.tolist(), *free, *experiment.given[k].tolist(), *flags], c)
            record[k], inputs, c = results[:width], results[width : width + input_count], results[width + input_count :]
            done = k + 1
            if done < experiment.samples:
                end, tolerances = t + experiment.step, (relative / precision, absolute / precision)
                following = _integrated(derivative, solver, t, end, x, [*free, *inputs], *tolerances)
                if isinstance(following, Diagnostic):
                    stopped = dataclasses.replace(following, span=experiment.loop.span)
                    break
                x = following
            if progress is not None and done % 100 == 0:
                progress(done, experiment.samples)
    except KeyboardInterrupt:
        stopped = interrupted(experiment.loop, done * experiment.step)
    return experiment.result(record[:done], np.array(list(experiment.nominal.values())), 0, stopped, solver)


def _function(program: Program) -> Callable[[list[float], list[float]], list[float]]:
    """Return the function (arguments, state) of a program that returns its results."""
    source = scalar.storing_source(program)
    store = scalar.compile_source(source, program, program.arguments)
    count = len(program.results)

    def call(arguments: list[float], state: list[float]) -> list[float]:
        results = [0.0] * count
        store(*arguments, *([state] if program.state else []), results)
        return results

    return call


def _outside(experiment: Experiment, x: FloatArray, sample: int, record: FloatArray) -> Diagnostic | None:
    """Return the diagnostic of the first state that has left its range."""
    for state, value in zip(experiment.equations.plant_states, x.tolist(), strict=True):
        if not state.holds(value):
            time, positions = sample * experiment.step, experiment.positions
            memory = experiment.equations.states
            return left(state, value, time, experiment.loop, positions, record[:sample], memory)
    return None


def _integrated(
    derivative: Callable[[list[float], list[float]], list[float]],
    solver: str,
    begin: float,
    end: float,
    x: FloatArray,
    given: list[Any],
    relative: float,
    absolute: float,
) -> FloatArray | Diagnostic:
    """Return the states at the end of a period, or the diagnostic of a solver that gives up."""
    from scipy import integrate

    if not len(x):
        return x
    last = end * BEFORE
    evaluations = itertools.count()

    def rates(t: float, y: FloatArray) -> list[float]:
        if next(evaluations) == EVALUATIONS:
            raise _GaveUpError(f"it computed the derivatives {EVALUATIONS:,} times since the sample before")
        return derivative([min(t, last), *y.tolist(), *given], [])[: len(x)]

    method = getattr(integrate, solver)(rates, begin, x, end, rtol=relative, atol=absolute)
    reason = None
    try:
        while method.status == "running":
            reason = method.step()
    except (_GaveUpError, ValueError) as error:  # scipy refuses matrices with numbers that are not finite
        reason = str(error)
    if method.status == "finished":
        return np.asarray(method.y)
    step = "it made no step" if method.step_size is None else f"its last step was {method.step_size:.3g} s"
    facts = (f"the sample before was at t = {begin:.6g} s", step, *([reason] if reason else []))
    help_text = "a state may go to infinity there, or leave the domain of its derivative; RK4 shows its course"
    return Diagnostic("FZ701", f"solver {solver} gave up at t = {method.t:.6g} s", facts=facts, help=help_text)
