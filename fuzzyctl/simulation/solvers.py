"""Plants integrated by scipy's adaptive solvers between two samples."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, Literal, get_args

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic
from fuzzyctl.kernels.backends.python import backend as python_backend
from fuzzyctl.kernels.program.program import Program
from fuzzyctl.model.discrete_plant import BEFORE
from fuzzyctl.simulation.experiment import Experiment, Progress
from fuzzyctl.simulation.run import Run
from fuzzyctl.simulation.stops import interrupted, left

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

#: Names of the solvers, as scipy's `solve_ivp` has them.
ScipySolver = Literal["RK45", "DOP853", "Radau", "BDF", "LSODA"]
SOLVERS: Final = get_args(ScipySolver)
#: Tolerances of a step: a part of the state, and an absolute one.
RELATIVE: Final = 1e-8
ABSOLUTE: Final = 1e-10
#: Evaluations of the derivatives between two samples after which a solver has given up; LSODA does not end by itself
#: where a state goes to infinity.
EVALUATIONS: Final = 100_000


class _GaveUpError(Exception):
    """A solver took more evaluations than it may."""


def solved(
    experiment: Experiment,
    solver: ScipySolver,
    *,
    relative: float = RELATIVE,
    absolute: float = ABSOLUTE,
    precision: float = 1.0,
    progress: Progress | None = None,
) -> Run:
    """Simulate a loop with an adaptive solver.

    Args:
        experiment: The loop.
        solver: One of `SOLVERS`.
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
    free = list(experiment.nominal.values())
    x = np.array([s.start for s in equations.plant_states], dtype=np.float64)
    c = [s.start for s in equations.states]
    width, held = len(equations.signals), len(experiment.programs.held)
    record = np.empty((experiment.samples, width))
    stopped = None
    done = 0
    try:
        for k, t in enumerate(experiment.times.tolist()):
            stopped = _outside(experiment, x, k, record)
            if stopped is not None:
                break
            flags = [1.0 if k % n == 0 else 0.0 for n in equations.rates.values()]
            found = sample([t, *x.tolist(), *free, *experiment.given[k].tolist(), *flags], c)
            record[k], inputs, c = found[:width], found[width : width + held], found[width + held :]
            done = k + 1
            if done < experiment.samples:
                end, tolerances = t + experiment.step, (relative / precision, absolute / precision)
                following = _integrated(derivative, solver, t, end, x, [*free, *inputs], *tolerances)
                if isinstance(following, Diagnostic):
                    stopped = replace(following, span=experiment.loop.span)
                    break
                x = following
            if progress is not None and done % 100 == 0:
                progress(done, experiment.samples)
    except KeyboardInterrupt:
        stopped = interrupted(experiment.loop, done * experiment.step)
    return experiment.result(record[:done], np.array(free), 0, stopped, solver)


def _function(program: Program) -> Callable[[list[float], list[float]], list[float]]:
    """Return the function (arguments, state) of a program that returns its results."""
    source = python_backend.storing_source(program)
    store = python_backend.compile_source(source, program, program.arguments)
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
            kept = experiment.equations.states
            return left(state, value, time, experiment.loop, positions, record[:sample], kept)
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
