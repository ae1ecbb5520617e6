"""Systems, controllers and plants as `NonlinearIOSystem` of python-control.

python-control has one timebase for all systems that are connected: it does not mix continuous and discrete time. A
loop of a sampled controller and a continuous plant is therefore computed in discrete time, the plant integrated over
each sample time with its inputs held: both get the same `dt`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.interop.numbers import count, positive
from fuzzyctl.interop.packages import required
from fuzzyctl.kernels.compile import compile
from fuzzyctl.model.controller import Controller
from fuzzyctl.model.plant import Plant
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.simulation.plant_function import PlantFunction

#: A period is a multiple of the sample time up to this part of it.
ALIGNED: Final = 1e-6


def nlsys(
    block: FuzzySystem | Controller | Plant, *, dt: float | None = None, substeps: int = 1, name: str | None = None
) -> Any:
    """Return a system, controller or plant as a `control.NonlinearIOSystem`.

    Signals have the names of the block; the docstring of the result has their units and ranges.

    Args:
        block: A system without adaptive or held outputs, which has no state and joins any timebase; a controller, which
            is in discrete time; or a plant without dead time, in continuous time unless `dt` is given.
        dt: Sample time [s]. Of a controller the period must be a multiple of it, and its outputs are held in between;
            a controller without period runs at each sample. A plant is integrated over it with its inputs held.
        substeps: Steps of Runge and Kutta in each sample time of a plant.
        name: Of the system; that of the block if left out.

    Raises:
        MissingPackageError: Where python-control is not installed.
        ArgumentError: For another object, a system with state, a plant with dead time, a sample time that does not
            divide the period, and a controller without any.
        ValueOutOfBoundsError: For a sample time or number of steps that is not positive.
        DiagnosticError: For a plant in Python that cannot be executed; by the system where it raises, or returns NaN or
            another number of values.
    """
    control = required("control", "control")
    dt = None if dt is None else positive("dt", dt, "s")
    count("substeps", substeps)
    if not isinstance(block, FuzzySystem | Controller | Plant):
        raise ArgumentError(f"expected a FuzzySystem, Controller or Plant, got {type(block).__name__}")
    update, output, states, dt = _plant(block, dt, substeps) if isinstance(block, Plant) else _compiled(block, dt)
    nonlinear = control.NonlinearIOSystem(
        update, output, inputs=[s.name for s in block.inputs], outputs=[s.name for s in block.outputs],
        states=states or None, dt=dt, name=block.name if name is None else name,
    )  # fmt: skip
    nonlinear.__doc__ = _described(block)
    return nonlinear


#: Of a time, states, inputs and params; the last are python-control's own and not used.
_Function = Callable[[float, Any, Any, Any], Any]
_Parts = tuple[_Function | None, _Function, list[str], float | None]


def _compiled(block: FuzzySystem | Controller, dt: float | None) -> _Parts:
    step: Any = compile(block, "python")
    if not step.form.moves:
        if step.n_states:
            raise ArgumentError(
                f"system '{block.name}' adapts or holds outputs: call it in a controller, which keeps state"
            )
        return None, lambda t, x, u, _: np.atleast_1d(step(*map(float, u))), [], None
    if step.period is None and dt is None:
        raise ArgumentError(f"controller '{block.name}' has no 'every' line: give its sample time as 'dt'")
    sample = step.period if dt is None else dt
    assert sample is not None
    every = 1 if step.period is None else round(step.period / sample)
    if step.period is not None and not abs(step.period / sample - every) <= ALIGNED * every:
        raise ArgumentError(
            f"controller '{block.name}' runs every {step.period:g} s, which is not a multiple of dt = {sample:g} s"
        )
    states, period = len(step.state_names), None if step.period is not None else sample

    def made(t: float, x: Any, u: Any) -> tuple[Any, Any]:
        """Return the outputs and the next state; between two samples both are those of the last one."""
        if every > 1 and round(t / sample) % every:
            return x[states:], x
        outputs, following = step(*map(float, u), np.asarray(x[:states], dtype=np.float64), dt=period)
        column = np.atleast_1d(np.array(outputs, dtype=np.float64))
        return column, np.concatenate([following, column]) if every > 1 else following

    names = list(step.state_names) + ([f"{name} held" for name in step.output_names] if every > 1 else [])
    update: _Function | None = (lambda t, x, u, _: made(t, x, u)[1]) if names else None
    return update, lambda t, x, u, _: made(t, x, u)[0], names, sample


def _plant(plant: Plant, dt: float | None, substeps: int) -> _Parts:
    function = PlantFunction(plant)

    def derivative(t: float, x: Any, u: Any, _: Any) -> Any:
        return function.derivative(t, x, u)

    def following(t: float, x: Any, u: Any, _: Any) -> Any:
        assert dt is not None
        return function.advanced(t, x, u, dt, substeps)

    def output(t: float, x: Any, u: Any, _: Any) -> Any:
        return function.output(t, x, u)

    return derivative if dt is None else following, output, list(function.state_names), 0 if dt is None else dt


def start(block: FuzzySystem | Controller | Plant, *, dt: float | None = None) -> Any:
    """Return the initial state of a system of `nlsys`, shape (states,); systems have no state, shape (0,).

    Args:
        block: As for `nlsys`.
        dt: As for `nlsys`.

    Raises:
        ArgumentError: As for `nlsys`.
        ValueOutOfBoundsError: As for `nlsys`.
    """
    if isinstance(block, Plant):
        return np.array(PlantFunction(block).start)
    names = _compiled(block, None if dt is None else positive("dt", dt, "s"))[2]
    state = compile(block, "python").start()
    return np.concatenate([state, np.zeros(len(names) - len(state))])


def _described(block: FuzzySystem | Controller | Plant) -> str:
    """Return the signals of a block with their units and ranges, one on a line."""
    lines = [f"{block.name}: {block.title}" if block.title else block.name, ""]
    for what, signals in (("input", block.inputs), ("output", block.outputs)):
        for s in signals:
            low, high = block.range_of(s)
            span = "" if low == -math.inf and high == math.inf else f" in [{low:g}, {high:g}]"
            unit = f" [{s.unit}]" if s.unit else ""
            lines.append(f"{what} {s.name}{f', {s.label}' if s.label else ''}{span}{unit}")
    return "\n".join(lines)
