"""One plant as functions of time, states and inputs, without a loop."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, final

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.diagnostics.suggestions import counted
from fuzzyctl.expr import Call, Number, evaluate, walk
from fuzzyctl.kernels.compile import Backend, compile
from fuzzyctl.model.controller import Controller, Definition, Result, Signal
from fuzzyctl.model.discrete_plant import BEFORE, STAGES
from fuzzyctl.model.loop import TIME
from fuzzyctl.model.plant import Plant
from fuzzyctl.simulation.python_plant import PythonPlant

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]
    Numbers = Sequence[float] | FloatArray


@final
class PlantFunction:
    """Derivatives and outputs of a plant.

    Args:
        plant: A well-formed plant without dead time.
        backend: As for `compile`; a plant in Python is called as it is.

    Raises:
        ArgumentError: For an FMU, and for a plant with dead time, whose state is a function and no vector.
        DiagnosticError: For a file in Python that cannot be executed.
    """

    def __init__(self, plant: Plant, backend: Backend = "python") -> None:
        if not isinstance(plant, Plant):
            raise ArgumentError(f"expected a Plant, got {type(plant).__name__}")
        items: list[Definition | Result] = [*plant.definitions, *plant.derivatives, *plant.results]
        if any(isinstance(e, Call) and e.function == "delay" for item in items for e in walk(item.value)):
            raise ArgumentError(
                f"plant '{plant.name}' has dead time, which is no state: simulate it in a loop, or approximate the "
                "dead time by a transfer function"
            )
        if plant.fmu:
            raise ArgumentError(f"plant '{plant.name}' is an FMU, whose states only it knows: simulate it in a loop")
        self.plant = plant
        self.input_names = tuple(s.name for s in plant.inputs)
        self.state_names = tuple(s.name for s in plant.states)
        self.output_names = tuple(s.name for s in plant.results)
        values = plant.param_values.values
        #: The states at the begin of a run.
        self.start = tuple(evaluate(s.start, values) for s in plant.states)
        self._python = PythonPlant(plant, plant.name, plant.span) if plant.python else None
        self._step = None if plant.python else compile(_as_step(plant), backend)

    def derivative(self, t: float, x: Numbers, u: Numbers) -> FloatArray:
        """Return the derivatives of the states by time, shape (states,); NaN if an input is NaN.

        Args:
            t: Time [s].
            x: States, shape (states,).
            u: Inputs, shape (inputs,).

        Raises:
            ArgumentError: For another number of states or inputs.
            DiagnosticError: For a plant in Python that raises, or returns NaN or another number of values.
        """
        return self._evaluated(t, x, u)[1]

    def output(self, t: float, x: Numbers, u: Numbers) -> FloatArray:
        """Return the outputs, shape (outputs,); arguments and errors are those of `derivative`."""
        return self._evaluated(t, x, u)[0]

    def _evaluated(self, t: float, x: Numbers, u: Numbers) -> tuple[FloatArray, FloatArray]:
        import numpy as np

        try:
            state, inputs = (tuple(float(v) for v in np.atleast_1d(one)) for one in (x, u))
        except (TypeError, ValueError):
            raise ArgumentError(
                f"expected numbers as states and inputs of plant '{self.plant.name}', got {u!r}"
            ) from None
        for what, names, numbers in (("state", self.state_names, state), ("input", self.input_names, inputs)):
            if len(names) != len(numbers):
                expected = f"{counted(len(names), what)} ({', '.join(names) or 'none'})"
                raise ArgumentError(f"expected {expected} of plant '{self.plant.name}', got {len(numbers)}")
        if self._python is not None:
            return np.array(self._python.output(t, state)), np.array(self._python.derivative(t, state, inputs))
        assert self._step is not None
        outputs, rates = self._step(*inputs, t, np.array(state))
        if any(math.isnan(v) for v in inputs):
            rates = np.full(len(state), math.nan)
        return np.atleast_1d(np.array(outputs, dtype=np.float64)), rates

    def advanced(self, t: float, x: Numbers, u: Numbers, time: float, substeps: int = 1) -> FloatArray:
        """Return the states some time later, with inputs held: steps of Runge and Kutta, as `simulate` takes them.

        Args:
            t: Time [s].
            x: States, shape (states,).
            u: Inputs, shape (inputs,).
            time: How much later [s].
            substeps: Steps of integration.
        """
        import numpy as np

        now, step = np.array(x, dtype=np.float64), time / substeps
        for s in range(substeps):
            following, at = now.copy(), now
            for k, (divisor, share) in enumerate(STAGES):
                moment = t + (s + share) * step
                rate = self.derivative(moment * BEFORE if share == 1.0 else moment, at, u)
                following = following + step / divisor * rate
                if k < 3:
                    at = now + STAGES[k + 1][1] * step * rate
            now = following
        return now


def _as_step(plant: Plant) -> Controller:
    """Return a controller whose outputs are those of a plant, and whose next states are its derivatives."""
    shared: dict[str, Any] = {n: getattr(plant, n) for n in ("name", "params", "functions", "definitions", "systems")}
    inputs = (*plant.inputs, Signal(name=TIME))
    return Controller(
        **shared, inputs=inputs, states=plant.states, results=plant.results, updates=plant.derivatives,
        period=Number(1.0), path=plant.path, span=plant.span,
    )  # fmt: skip
