"""The form of a controller: a step from inputs and state to outputs and the next state."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError, ValueOutOfBoundsError
from fuzzyctl.kernels.backends.arguments import float_array, input_number
from fuzzyctl.kernels.backends.python import backend as python_backend
from fuzzyctl.kernels.forms import Form
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.inference.free import with_named_state
from fuzzyctl.kernels.plan.build import plan
from fuzzyctl.kernels.plan.equations import DT, Equations, Evaluation
from fuzzyctl.kernels.program.program import Program
from fuzzyctl.kernels.promises import Promises
from fuzzyctl.kernels.step_program import named_step, step_program, system_program

if TYPE_CHECKING:
    from fuzzyctl.annotations import FloatArray
    from fuzzyctl.kernels.step_values import StepValues
    from fuzzyctl.model.system import FuzzySystem

#: What the time since the step before is.
_TIME: Final = "> 0 s and finite"


class StepPromises(Promises):
    """The promises of the outputs of systems that a step calls; they are looked at where an output is NaN.

    Args:
        equations: The step, with systems that raise where no rule fires.
        names: Of the arguments of its programs.
    """

    def __init__(self, equations: Equations, names: Sequence[str]) -> None:
        self._equations, self._names = equations, names

    @cached_property
    def _step(self) -> Callable[..., None]:
        program = step_program(self._equations)
        return python_backend.compile_source(python_backend.storing_source(program), program, self._names)

    def check_block(self, points: FloatArray, states: FloatArray | None, results: FloatArray) -> None:
        """Check the results of many steps side by side; the first one that breaks a promise is named.

        Args:
            points: Shape (n, arguments).
            states: Shape (n, states); None without a state.
            results: Shape (n, outputs) or more.

        Raises:
            NoRuleFiresError: Where no rule fires for an output without `else`.
        """
        for row in self._missing(points, results):
            self._replay(points[row : row + 1], None if states is None else states[row])

    def check_run(self, points: FloatArray, state: FloatArray, results: FloatArray) -> None:
        """Check the results of steps along time, from the state before the first one; see `check_block`."""
        missing = self._missing(points, results)
        if len(missing):
            self._replay(points[: missing[-1] + 1], state)

    def _replay(self, points: FloatArray, state: FloatArray | None) -> None:
        """Make some steps along time, and raise `NoRuleFiresError` at the first one that breaks a promise."""
        kept = [] if state is None else state.tolist()
        outputs = len(self._equations.outputs)
        row = [0.0] * (outputs + len(kept))
        for point in points.tolist():
            self._step(*point, *((kept,) if kept else ()), row)
            kept = row[outputs:]

    def _missing(self, points: FloatArray, results: FloatArray) -> Sequence[int]:
        """Return the rows with an output that is NaN though no argument is."""
        import numpy as np

        least = np.minimum.reduce(results, axis=None, initial=np.inf)  # NaN if any is; all is faster than a part
        if least == least:
            return []
        outputs = results[:, : len(self._equations.outputs)]
        return np.flatnonzero(np.isnan(outputs).any(axis=1) & ~np.isnan(points).any(axis=1)).tolist()


def _strict(equations: Equations) -> Equations:
    """Return equations whose systems raise where no rule fires for an output without `else`."""

    def strict(system: FuzzySystem) -> FuzzySystem:
        outputs = tuple(replace(o, otherwise="error") if o.otherwise is None else o for o in system.outputs)
        return replace(system, outputs=outputs) if outputs != system.outputs else system

    body = tuple(replace(e, system=strict(e.system)) if isinstance(e, Evaluation) else e for e in equations.body)
    return replace(equations, body=body)


class StepForm(Form):
    """A controller: equations that give the outputs and the next state.

    Args:
        equations: What a step computes.
        algorithm: How systems are computed, see `compile`.
        values: Takes the values of free numbers, which are the last states; None for a controller without.
        checked: Whether outputs of its systems without `else` that have no value are errors, as they are in systems.
    """

    moves = True

    def __init__(
        self, equations: Equations, algorithm: str = "auto", values: StepValues | None = None, *, checked: bool = False
    ) -> None:
        outputs, kept = [name for name, _ in equations.outputs], [s.name for s in equations.states]
        super().__init__(equations.inputs, outputs, kept, equations.free)
        self.period = equations.period
        self.needs_time = self.period is None and equations.reads_time
        if self.period is None:
            self.argument_names = (*self.input_names, DT)
        self._equations, self._algorithm, self._values = equations, algorithm, values
        self._program = step_program(equations, algorithm)
        strict = _strict(equations) if checked else equations
        self.promises = StepPromises(strict, self.argument_names) if strict != equations else None
        self._checked = checked

    def __reduce__(self) -> tuple[Any, ...]:
        made = partial(StepForm, checked=self._checked)
        return made, (self._equations, self._algorithm, self._values)

    def point(self, backend: str) -> Program:
        """Return the program for one point."""
        return self._program

    def named(self) -> tuple[Program, tuple[str, ...]]:
        """Return the program of all rules with the state as its last arguments, and their names."""

        def point(call: Evaluation) -> Program:
            # Of the programs of a system, the one with all rules has a derivative.
            is_plain = not (call.states or call.free)
            return inference.evaluation(plan(call.system)) if is_plain else system_program(call, "rules")

        return with_named_state(named_step(self._equations, point)[0])

    def start(self, changed: Mapping[str, Any]) -> Sequence[float] | FloatArray:
        """Return the state before the first step, with some free numbers changed."""
        return super().start(changed) if self._values is None else self._values.state(changed)

    def _start(self) -> Sequence[float]:
        return [s.start for s in self._equations.states]

    @property
    def free_bounds(self) -> Sequence[tuple[float, float]]:
        """The ends of the range of each free number."""
        return () if self._values is None else self._values.bounds

    def times(self, dt: Any) -> list[float]:
        """Return the time of one step, checked, as an argument of the programs, or no argument."""
        if self.period is not None:
            if dt is not None:
                raise ArgumentError(f"the controller has a period of {self.period:g} s, so that 'dt' is not given")
            return []
        if dt is None and not self.needs_time:
            return [1.0]  # any time makes the same step
        if dt is None:
            raise ArgumentError("'dt' is missing: the controller has no 'every' line")
        time = dt if type(dt) is float else input_number(DT, dt)
        if not 0.0 < time < math.inf:
            raise ValueOutOfBoundsError(DT, dt, _TIME)
        return [time]

    def with_times(self, points: Any, dt: Any) -> Any:
        """Return points with the times of the steps, checked, as a last column."""
        import numpy as np

        if self.period is not None:
            self.times(dt)
            return points
        shape = points.shape[:-1]
        if dt is None or type(dt) is float:  # the usual case
            times: Any = self.times(dt)[0]
        else:
            times = float_array(dt, DT)
            try:
                shape = np.broadcast_shapes(shape, times.shape)
            except ValueError:
                raise ArgumentError(f"'dt' of shape {times.shape} does not fit points of shape {shape}") from None
            is_time = (times > 0) & (times < math.inf)
            if not np.all(is_time):
                raise ValueOutOfBoundsError(DT, float(times[~is_time].flat[0]), _TIME)
        whole = np.empty((*shape, points.shape[-1] + 1))
        whole[..., :-1], whole[..., -1] = points, times
        return whole
