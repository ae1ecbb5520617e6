"""Plants for the solvers of scipy: right-hand sides f(t, x)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.model.plant import Plant
from fuzzyctl.simulation.plant_function import PlantFunction

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]


def rhs(plant: Plant, inputs: Any = ()) -> Callable[[float, FloatArray], FloatArray]:
    """Return the right-hand side f(t, x) of a plant, as `scipy.integrate.solve_ivp` takes it.

    A continuous control law, such as a fuzzy system, is the function `inputs`. A sampled controller is not: its outputs
    are held between samples, so a period is integrated at a time, which `fuzzyctl.simulate(solver=...)` does.

    Args:
        plant: A well-formed plant without dead time.
        inputs: Constant inputs, shape (inputs,), one number for one input; or a function of the time [s] and the
            states, shape (states,), that returns them.

    Returns:
        A function of the time [s] and the states, shape (states,), with the derivatives of the states by time, shape
        (states,).

    Raises:
        ArgumentError: For a plant with dead time, or another object; by the function for another number of inputs.
        DiagnosticError: By the function, where a plant in Python raises, or returns NaN or another number of values.
    """
    function = PlantFunction(plant)

    def derivative(t: float, x: FloatArray) -> FloatArray:
        return function.derivative(t, x, inputs(t, x) if callable(inputs) else inputs)

    return derivative


def start(plant: Plant) -> FloatArray:
    """Return the states of a plant at the begin of a run, shape (states,)."""
    import numpy as np

    if not isinstance(plant, Plant):
        raise ArgumentError(f"expected a Plant, got {type(plant).__name__}")
    return np.array(PlantFunction(plant).start)
