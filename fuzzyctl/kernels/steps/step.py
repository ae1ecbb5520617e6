"""The step of a controller, compiled: inputs and state in, outputs and the next state out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, final, overload

from fuzzyctl.diagnostics.diagnostic import ArgumentError, UnknownNameError, ValueOutOfBoundsError
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.displayed import Displayed
from fuzzyctl.kernels.backends.arguments import float_array, in_order, input_number, row_array, writable
from fuzzyctl.kernels.backends.columns import require_same_index
from fuzzyctl.kernels.backends.labels import labelled
from fuzzyctl.kernels.backends.python import backend as python_backend
from fuzzyctl.kernels.plan.equations import DT, Equations
from fuzzyctl.kernels.program.scalar import as_number
from fuzzyctl.kernels.promises import Refusals
from fuzzyctl.kernels.steps.program import step_program
from fuzzyctl.support.signatures import InputSignature

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas as pd

    from fuzzyctl.annotations import FloatArray, Frame, Labelled, Numbers, Outputs, Scalar, Vector
    from fuzzyctl.kernels.arrays import Arrays
    from fuzzyctl.kernels.steps.values import StepValues

#: What the time since the step before is.
_TIME: Final = "> 0 s and finite"


@final
class Step(Displayed):
    """A compiled controller without state of its own: the state is the caller's.

    `step(x0, x1, ..., state)` gives the outputs, one number or a tuple, and the next state; a controller without period
    takes `dt=` [s] as well.

    Args:
        equations: What it computes.
        backend: "numba", "numpy" or "python".
        algorithm: How systems are computed, see `compile`.
        values: Takes the values of free numbers, which are the last states; None where there are none.
    """

    __signature__ = InputSignature(
        lambda step: [*step.input_names, "state"], named=lambda step: ["dt"] if step.period is None else []
    )

    def __init__(
        self, equations: Equations, backend: str, algorithm: str = "auto", values: StepValues | None = None
    ) -> None:
        self.equations, self.backend, self._values = equations, backend, values
        self.free_names = equations.free
        self.input_names = equations.inputs
        self.output_names = tuple(name for name, _ in equations.outputs)
        self.state_names = tuple(s.name for s in equations.states)
        self.period = equations.period
        self._algorithm, self._program = algorithm, step_program(equations, algorithm)

    def __reduce__(self) -> tuple[Any, ...]:
        """Compile the step again in another process."""
        return Step, (self.equations, self.backend, self._algorithm, self._values)

    def __repr__(self) -> str:
        return printable(f"Step({', '.join(self.input_names)} -> {', '.join(self.output_names)}; {self.backend})")

    def start(self, values: Mapping[str, Numbers] | None = None, /, **named: Numbers) -> FloatArray:
        """Return the state before the first step, shape (states,); its last entries are the free numbers.

        Args:
            values: Values of free numbers by name; the others are those of the controller.
            named: The same for names that Python can write.

        Raises:
            UnknownNameError: For a name that is not free.
            ValueOutOfBoundsError: For values outside the bounds of their params, or that a system cannot have.
            ArgumentError: For values under which a param or a let has no value, such as a division by 0.
        """
        import numpy as np

        changed = {**(values or {}), **named}
        if self._values is not None:
            return np.array(self._values.state(changed), dtype=np.float64)
        for name in changed:
            raise UnknownNameError("free number", name, self.free_names)
        return np.array([s.start for s in self.equations.states], dtype=np.float64)

    def __call__(
        self, *arguments: Scalar | Vector, dt: float | None = None, **named: Scalar | Vector
    ) -> tuple[Outputs, FloatArray]:
        """Make one step.

        Args:
            arguments: The inputs in order, then the state, shape (states,).
            dt: Time since the step before [s], for a controller without period.
            named: Inputs by their names, and the state, which is called `state`.

        Returns:
            The outputs, a float or a tuple of floats, and the next state, shape (states,).

        Raises:
            ArgumentError: For a wrong number of arguments, one given twice, or one of another type.
            UnknownNameError: For a name that is no input.
            ValueOutOfBoundsError: For a `dt` that is not positive and finite.
            NoRuleFiresError: If no rule of a system fires whose output says `else error`.
        """
        import numpy as np

        if named:
            arguments = in_order((*self.input_names, "state"), arguments, named)
        if len(arguments) != len(self.input_names) + 1:
            names = ", ".join((*self.input_names, "state"))
            raise ArgumentError(f"expected {len(self.input_names) + 1} arguments ({names}), got {len(arguments)}")
        *inputs, state = arguments
        kept = float_array(state, "state")
        self._require_states(kept, ())
        results = np.empty(len(self.output_names) + len(self.state_names))
        point = [input_number(n, x) for n, x in zip(self.input_names, inputs, strict=True)] + self._times(dt)
        # Python warns of overflows of numpy's numbers, not of its own.
        before = writable(kept) if self.backend == "numba" else kept.tolist()
        try:
            self.jit(*point, *([before] if self.state_names else []), results)
        except ArithmeticError as error:
            raise Refusals(self._program, self._argument_names()).translated(error, point) from None
        values = results[: len(self.output_names)].tolist()
        outputs: Any = values[0] if len(values) == 1 else tuple(values)
        return outputs, results[len(self.output_names) :]

    def _times(self, dt: float | None) -> list[float]:
        if self.period is not None:
            if dt is not None:
                raise ArgumentError(f"the controller has a period of {self.period:g} s, so that 'dt' is not given")
            return []
        if dt is None:
            raise ArgumentError("'dt' is missing: the controller has no 'every' line")
        if not 0.0 < as_number(dt) < math.inf:
            raise ValueOutOfBoundsError(DT, dt, _TIME)
        return [as_number(dt)]

    @overload
    def run(
        self, inputs: Frame, state: Vector | None = None, *, dt: Scalar | Vector | None = None
    ) -> tuple[Labelled, FloatArray]: ...
    @overload
    def run(
        self, inputs: Numbers, state: Vector | None = None, *, dt: Scalar | Vector | None = None
    ) -> tuple[FloatArray, FloatArray]: ...
    def run(
        self, inputs: Numbers | Frame, state: Vector | None = None, *, dt: Scalar | Vector | None = None
    ) -> tuple[FloatArray | Labelled, FloatArray]:
        """Make a step for each row of the inputs, one after the other.

        Args:
            inputs: Shape (n, inputs); for one input also (n,). The columns of a data frame are matched by their names.
            state: The state before the first step, shape (states,); None for `start()`.
            dt: Times since the step before [s], one number or shape (n,), for a controller without period.

        Returns:
            The outputs, shape (n,) for one, (n, outputs) for several, of pandas with the index of the inputs, and the
            state after the last step.

        Raises:
            ArgumentError: For arrays of another shape or not of numbers.
            ValueOutOfBoundsError: For a `dt` that is not positive and finite.
            NoRuleFiresError: At the first step where no rule of a system fires whose output says `else error`.
        """
        import numpy as np

        points = np.ascontiguousarray(self._points(inputs, dt, dimensions=2))
        kept = self.start() if state is None else float_array(state, "state").copy()
        self._require_states(kept, ())
        results = np.empty((len(points), len(self.output_names)))
        self._run(points, kept, results)
        outputs = results[:, 0] if results.shape[1] == 1 else results
        return labelled(outputs, self.output_names, inputs), kept

    @overload
    def batch(self, inputs: Frame, states: Frame, *, dt: Numbers | None = None) -> tuple[Labelled, pd.DataFrame]: ...
    @overload
    def batch(self, inputs: Frame, states: Numbers, *, dt: Numbers | None = None) -> tuple[Labelled, FloatArray]: ...
    @overload
    def batch(
        self, inputs: Numbers, states: Numbers, *, dt: Numbers | None = None
    ) -> tuple[FloatArray, FloatArray]: ...
    def batch(
        self, inputs: Numbers | Frame, states: Numbers | Frame, *, dt: Numbers | None = None
    ) -> tuple[FloatArray | Labelled, FloatArray | pd.DataFrame]:
        """Make one step of many copies of the controller side by side.

        Args:
            inputs: Shape (..., inputs); for one input also without that axis. The columns of a data frame are matched
                by their names, here and in `states`.
            states: Shape (..., states).
            dt: Time since the step before [s], one number or shape (...), for a controller without period.

        Returns:
            The outputs, shape (...) for one, (..., outputs) for several, and the next states, shape (..., states). Of
            pandas the outputs have the index of the inputs, the next states that of the states.

        Raises:
            ArgumentError: For arrays of another shape or not of numbers, columns of other names, and inputs and states
                with different row labels.
            ValueOutOfBoundsError: For a `dt` that is not positive and finite.
            NoRuleFiresError: For the first copy where no rule of a system fires whose output says `else error`.
        """
        import numpy as np

        points, rows, shape = self._copies(inputs, states, dt)
        outputs = len(self.output_names)
        results = np.empty((*shape, outputs + len(self.state_names)))
        self._fill(points, rows, results.reshape(-1, results.shape[-1]))
        first = results[..., 0] if outputs == 1 else results[..., :outputs]
        return labelled(first, self.output_names, inputs), labelled(results[..., outputs:], self.state_names, states)

    def gradient(self, inputs: Numbers, states: Numbers, *, dt: Numbers | None = None) -> tuple[FloatArray, FloatArray]:
        """Compute the derivatives of a step by the inputs, then the states, free numbers last; exact but for rounding.

        Args:
            inputs: Shape (..., inputs); for one input also without that axis.
            states: Shape (..., states).
            dt: Time since the step before [s], one number or shape (...), for a controller without period.

        Returns:
            Those of the outputs, shape (..., inputs + states) for one, (..., outputs, inputs + states) for several, and
            those of the next states, shape (..., states, inputs + states). At a kink or a jump they are those of the
            branch that the step takes there. Where an input is NaN no step is made: those of the outputs are NaN.

        Raises:
            ArgumentError: For arrays of another shape or not of numbers.
            ValueOutOfBoundsError: For a `dt` that is not positive and finite.
            NoRuleFiresError: For the first copy where no rule of a system fires whose output says `else error`.
        """
        points, rows, shape = self._copies(inputs, states, dt)
        outputs, kept = len(self.output_names), len(self.state_names)
        derivatives = self._gradient(points, rows).reshape(*shape, outputs + kept, len(self.input_names) + kept)
        return (derivatives[..., 0, :] if outputs == 1 else derivatives[..., :outputs, :]), derivatives[
            ..., outputs:, :
        ]

    @cached_property
    def _gradient(self) -> Arrays:
        from fuzzyctl.kernels.arrays import Arrays
        from fuzzyctl.kernels.steps.gradient import step_gradient

        return Arrays(step_gradient(self.equations), self.backend, self._argument_names())

    def _copies(self, inputs: Any, states: Any, dt: Any) -> tuple[FloatArray, FloatArray | None, tuple[int, ...]]:
        """Return inputs and states of many copies, one in each row, and the shape that the copies are in."""
        import numpy as np

        require_same_index(("inputs", "states", DT), (inputs, states, dt))
        points, kept = self._points(inputs, dt), row_array(self.state_names, states, "states")
        shape = points.shape[:-1]
        self._require_states(kept, shape)
        count = math.prod(shape)
        rows = np.ascontiguousarray(kept).reshape(count, len(self.state_names)) if self.state_names else None
        return np.ascontiguousarray(points).reshape(count, points.shape[-1]), rows, shape

    def _points(self, inputs: Any, dt: Any, dimensions: int | None = None) -> FloatArray:
        """Return the inputs; without a period the times since the step before are a last column."""
        import numpy as np

        points = row_array(self.input_names, inputs, "inputs")
        width = len(self.input_names)
        if width == 1 and (points.ndim == 0 or points.shape[-1] != 1 or points.ndim + 1 == dimensions):
            points = points[..., np.newaxis]
        if points.ndim == 0 or points.shape[-1] != width or points.ndim != (dimensions or points.ndim):
            rows = "n" if dimensions else "..."
            names = ", ".join(self.input_names)
            raise ArgumentError(f"the inputs must have the shape ({rows}, {width}) for {names}, got {points.shape}")
        if self.period is not None or dt is None:
            self._times(dt)
            return points
        times = float_array(dt, DT)
        if times.ndim and times.shape != points.shape[:-1]:
            raise ArgumentError(f"'dt' must be one number or have the shape {points.shape[:-1]}, got {times.shape}")
        fine = (times > 0) & (times < math.inf)
        if not np.all(fine):
            raise ValueOutOfBoundsError(DT, float(times[~fine].flat[0]), _TIME)
        return np.concatenate([points, np.broadcast_to(times, points.shape[:-1])[..., np.newaxis]], axis=-1)

    def _require_states(self, states: FloatArray, shape: tuple[int, ...]) -> None:
        wanted = (*shape, len(self.state_names))
        if states.shape != wanted:
            raise ArgumentError(f"the state must have the shape {wanted}, got {states.shape}")

    @cached_property
    def _fill(self) -> Any:
        """Fill the results of copies side by side."""
        from fuzzyctl.kernels.batch import fill_of

        return fill_of(self._program, self.backend, self._argument_names())

    @cached_property
    def _run(self) -> Any:
        """Fill the results of steps along time, and leave the state in the second argument."""
        if self.backend != "numba":
            return self._run_by_calls
        from fuzzyctl.kernels.backends.numba.batch_loop import sequence
        from fuzzyctl.kernels.batch import fill_by_loop

        return fill_by_loop(sequence(self._program, len(self.output_names)), self._program, self._argument_names())

    def _run_by_calls(self, points: FloatArray, state: FloatArray, results: FloatArray) -> None:
        outputs, kept = len(self.output_names), state.tolist()
        row = [0.0] * (outputs + len(kept))
        for k, point in enumerate(points.tolist()):
            self.jit(*point, *((kept,) if kept else ()), row)
            results[k], kept = row[:outputs], row[outputs:]
        state[:] = kept

    def _argument_names(self) -> tuple[str, ...]:
        return self.input_names if self.period is not None else (*self.input_names, DT)

    @cached_property
    def jit(self) -> Callable[..., Any]:
        """The function (x0, ..., dt, state, results), for use in loops of the caller's own.

        It stores the outputs, then the next state, into `results`, shape (outputs + states,); `dt` is left out for a
        controller with a period, and `state` for one without states.
        """
        if self.backend == "numba":
            from fuzzyctl.kernels.backends.numba import source as numba_backend

            return numba_backend.compile_source(numba_backend.storing_source(self._program))
        source = python_backend.storing_source(self._program)
        return python_backend.compile_source(source, self._program, self._argument_names())
