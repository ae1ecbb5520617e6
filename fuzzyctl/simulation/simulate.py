"""Simulation of a loop in one call, with an estimate of the error of integration."""

from __future__ import annotations

import dataclasses
from typing import Final, Literal

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError, Diagnostic, UnknownNameError
from fuzzyctl.model.loop import Loop
from fuzzyctl.simulation.dead_times import dead_times
from fuzzyctl.simulation.experiment import Experiment, LoopBackend, Progress
from fuzzyctl.simulation.run import Run
from fuzzyctl.simulation.settings import with_settings
from fuzzyctl.simulation.stops import signals_without_value

#: Solver of compiled runs: the classical method of Runge and Kutta.
RK4: Final = "RK4"
#: What `simulate` takes as a solver.
Solver = Literal["RK4", "RK45", "DOP853", "Radau", "BDF", "LSODA"]
#: Steps of integration up to which generated Python is done in a second.
SHORT: Final = 20_000
#: Part of the range that a state runs through up to which the error of integration is no warning.
ACCURATE: Final = 1e-3


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
        params: Values of params of the loop, or of its blocks: `BLOCK.PARAM`, or `PARAM` where no other block has it.

    Returns:
        The run; its `error` holds the largest difference of each state from a run with half the step, or a tenth of
        the tolerances of a solver of scipy.

    Raises:
        DiagnosticError: For a loop that cannot be run.
        UnknownNameError: For a name of no param, backend or solver.
        ValueOutOfBoundsError: For a value of a param that is no finite number.
        ArgumentError: For an argument of another type, and a solver of scipy with dead time or substeps.
    """
    if not isinstance(loop, Loop):
        raise ArgumentError(f"expected a Loop, got {type(loop).__name__}")
    loop = with_settings(loop, params) if params else loop
    experiment = Experiment(loop, backend, record_calls=record_calls)
    if solver != RK4:
        from fuzzyctl.simulation.solvers import SOLVERS, solved

        if solver not in SOLVERS:
            raise UnknownNameError("solver", solver, (RK4, *SOLVERS))
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
    found = signals_without_value(run)
    for name, error in run.error.items():
        values = run[name]
        span = float(np.max(values) - np.min(values))
        if error > ACCURATE * span and error > ACCURATE * 1e-9:
            finer = "half the step of integration" if run.substeps else "a tenth of the tolerances"
            message = f"state '{name}' changes by {error:.3g} with {finer}"
            facts = (f"that is {error / span:.2g} of the range that it runs through",) if span else ()
            help_text = f"take more substeps: --substeps {4 * run.substeps}; for a stiff plant: --solver Radau"
            help_text = help_text if run.substeps else "take another solver, or RK4 with many --substeps"
            found.append(
                Diagnostic("FZ706", message, severity="warning", facts=facts, help=help_text, file=run.loop.path)
            )
    return found
