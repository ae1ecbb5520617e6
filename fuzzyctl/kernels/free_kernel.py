"""Kernels some of whose numbers are arguments: one compilation for all their values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, final, overload

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError, UnknownNameError
from fuzzyctl.diagnostics.terminal import printable
from fuzzyctl.displayed import Displayed
from fuzzyctl.kernels.arrays import Arrays, broadcast, by_name, jacobian
from fuzzyctl.kernels.backends import blocks
from fuzzyctl.kernels.backends.arguments import float_array, in_order, input_number, point_array, writable
from fuzzyctl.kernels.backends.labels import labelled
from fuzzyctl.kernels.backends.python import backend as python_backend
from fuzzyctl.kernels.batch import fill_of
from fuzzyctl.kernels.free_values import FreeValues
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.inference.free import free_program, with_values_as_array
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.plan.free import free_plan
from fuzzyctl.kernels.program.passes.differentiate import differentiated
from fuzzyctl.kernels.program.program import Program
from fuzzyctl.kernels.promises import Promises, Refusals
from fuzzyctl.model.system import FuzzySystem
from fuzzyctl.support.signatures import InputSignature

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas as pd

    from fuzzyctl.annotations import FloatArray, Frames, Labelled, Numbers, Outputs, Points

    #: Of the free numbers: shape (..., free), or by name those that differ from the system's.
    Values = Numbers | Mapping[str, Numbers]


@final
class FreeKernel(Displayed):
    """A compiled system some of whose numbers are arguments.

    `kernel(x0, x1, ..., values)` takes the inputs in order, then the values of the free numbers, an array of shape
    (free,) or a mapping by name; names that a mapping leaves out have the values of the system.

    Args:
        system: A well-formed system without state.
        names: Of the free numbers, see `model.free_numbers`.
        backend: "numba", "numpy" or "python".

    Raises:
        UnknownNameError: For a name that the system does not have.
        ArgumentError: For a name given twice, a number that must be known beforehand, and a system with a state.
    """

    __signature__ = InputSignature(lambda kernel: [*kernel.input_names, "values"])

    def __init__(self, system: FuzzySystem, names: Sequence[str], backend: str) -> None:
        self._origin = system, tuple(names)
        self._free = free_plan(system, names)
        self.plan, self.backend, self.free_names = self._free.plan, backend, self._free.names
        if self.plan.initial_state:
            raise ArgumentError("a system with adaptive outputs, or outputs that say 'else hold', has no free numbers")
        self.input_names = tuple(i.name for i in self.plan.inputs)
        self.output_names = tuple(o.name for o in self.plan.outputs)
        self._values = FreeValues(self._free)
        self._promises = Promises(self.plan, known=False)
        self._program = self._over_values(inference.evaluation)
        self._refusals = Refusals(self._program, self.input_names)

    def __reduce__(self) -> tuple[Any, ...]:
        """A kernel in another process is made anew there."""
        return FreeKernel, (*self._origin, self.backend)

    def __repr__(self) -> str:
        inputs, outputs = ", ".join(self.input_names), ", ".join(self.output_names)
        return printable(f"FreeKernel({inputs} -> {outputs}; {len(self.free_names)} free; {self.backend})")

    def initial_values(self, changed: Mapping[str, Numbers] | None = None) -> FloatArray:
        """Return the values that the system itself has, some of them changed.

        Args:
            changed: New values by name; `OUTPUT.weights` stands for all of them, one number or an array.

        Returns:
            Shape (free,).

        Raises:
            UnknownNameError: For a name that is not free.
            ValueOutOfBoundsError: As for each call.
        """
        return self._values.of(changed or {})

    def __call__(self, *arguments: Values, **named: Values) -> Outputs:
        """Evaluate at one point.

        Args:
            arguments: The inputs in order, then the values.
            named: The same by name; the values are called `values`.

        Returns:
            A float, or a tuple for several outputs.

        Raises:
            ArgumentError: For a wrong number of arguments, or one of another type.
            ValueOutOfBoundsError: For values outside the bounds of their params, or that the system cannot have.
            NoRuleFiresError: Where no rule fires for an output that says `else error` or has no `else`.
        """
        names = (*self.input_names, "values")
        if named:
            arguments = in_order(names, arguments, named)
        if len(arguments) != len(names):
            raise ArgumentError(f"expected {len(names)} arguments ({', '.join(names)}), got {len(arguments)}")
        point = [input_number(n, x) for n, x in zip(self.input_names, arguments, strict=False)]
        values = self._values.of(arguments[-1])
        if values.ndim != 1:
            raise ArgumentError(f"the values must have the shape ({len(values)},) here; kernel.batch takes arrays")
        try:
            result: Outputs = self.jit(*point, writable(values) if self.backend == "numba" else values.tolist())
        except ArithmeticError as error:
            raise self._refusals.translated(error, point) from None
        self._promises.check(point, result)
        return result

    @overload
    def batch(self, points: Frames, values: Values, *, parallel: bool = True) -> Labelled: ...
    @overload
    def batch(
        self, points: Points | Frames, values: Values, *, out: FloatArray | None = None, parallel: bool = True
    ) -> FloatArray: ...
    def batch(
        self, points: Points | Frames, values: Values, *, out: FloatArray | None = None, parallel: bool = True
    ) -> FloatArray | Labelled:
        """Evaluate at many points.

        Args:
            points: Shape (..., inputs), or columns by name, as `Kernel.batch` takes them.
            values: Shape (..., free), which broadcasts with the points; (free,) for one vector for all; or a mapping.
            out: A contiguous array of float64 of the result's shape to write to; None for a new one.
            parallel: Whether all cores may be used; they are where the work is worth it.

        Returns:
            Shape (...) for one output, (..., outputs) for several; of pandas where the points are, see `Kernel.batch`.

        Raises:
            ArgumentError: For arrays of another shape or not of numbers.
            ValueOutOfBoundsError: As for one point.
            NoRuleFiresError: For the first point where no rule fires for an output without a value there.
        """
        array, width = self._points(points), len(self.output_names)
        given = self._values.of(values)
        shape = broadcast(array.shape[:-1], given)
        count = math.prod(shape)
        flat = np.ascontiguousarray(np.broadcast_to(array, (*shape, array.shape[-1]))).reshape(count, -1)
        rows = np.broadcast_to(given, (*shape, given.shape[-1])).reshape(count, given.shape[-1])
        results = blocks.results_for(out, shape if width == 1 else (*shape, width), flat, rows)
        target = np.asarray(results).reshape(count, width)
        if self.backend == "numba":
            blocks.run_compiled(self._checked_fill, flat, rows, target, parallel=parallel)
        else:
            blocks.run(self._checked_fill, flat, rows, target)
        return results if out is not None else labelled(results, self.output_names, points)

    def _points(self, points: Any) -> FloatArray:
        array = float_array(point_array(self.input_names, points), "points")
        if array.ndim == 0 or array.shape[-1] != len(self.input_names):
            wanted = f"(..., {len(self.input_names)}) for {', '.join(self.input_names)}"
            raise ArgumentError(f"points must have the shape {wanted}, got {array.shape}")
        return array

    def _checked_fill(self, points: FloatArray, rows: FloatArray | None, results: FloatArray) -> None:
        self._fill(points, rows, results)
        self._promises.check_block(points, None, results)

    @cached_property
    def _fill(self) -> Any:
        return fill_of(self._program, self.backend, self.input_names)

    @cached_property
    def jit(self) -> Callable[..., Any]:
        """The function (x0, ..., values) itself, for use in loops of the caller's own.

        It does not check the values: see `initial_values`, which does. With numba it is of type float64(float64, ...,
        float64[::1]), a tuple for several outputs.
        """
        if self.backend == "numba":
            from fuzzyctl.kernels.backends.numba import source as numba_backend

            return numba_backend.compile_source(numba_backend.evaluation_source(self._program))
        source = python_backend.evaluation_source(self._program)
        return python_backend.compile_source(source, self._program, self.input_names)

    @overload
    def degrees(self, points: Frames, values: Values) -> dict[str, dict[str, pd.Series[float]]]: ...
    @overload
    def degrees(self, points: Points, values: Values) -> dict[str, dict[str, FloatArray]]: ...
    def degrees(
        self, points: Points | Frames, values: Values
    ) -> dict[str, dict[str, FloatArray]] | dict[str, dict[str, pd.Series[float]]]:
        """Compute the degrees of all terms that rules read; see `Kernel.degrees`."""
        return by_name(self.plan, self._degrees(points, self._values.of(values)), points)

    @overload
    def strengths(self, points: Frames, values: Values) -> pd.DataFrame: ...
    @overload
    def strengths(self, points: Points, values: Values) -> FloatArray: ...
    def strengths(self, points: Points | Frames, values: Values) -> FloatArray | pd.DataFrame:
        """Compute how far each rule is active, shape (..., rules); see `Kernel.strengths`."""
        return labelled(self._strengths(points, self._values.of(values)), range(len(self.plan.rules)), points)

    @overload
    def gradient(
        self, points: Frames, values: Values, *, by: Literal["inputs", "values"] = "inputs"
    ) -> pd.DataFrame | FloatArray: ...
    @overload
    def gradient(self, points: Points, values: Values, *, by: Literal["inputs", "values"] = "inputs") -> FloatArray: ...
    def gradient(
        self, points: Points | Frames, values: Values, *, by: Literal["inputs", "values"] = "inputs"
    ) -> FloatArray | pd.DataFrame:
        """Compute the derivatives of the outputs.

        Args:
            points: Shape (..., inputs).
            values: Shape (..., free), which broadcasts with the points; or a mapping.
            by: "inputs" or "values": what the derivatives are taken by.

        Returns:
            Shape (..., inputs) or (..., free) for one output, with the axis of the outputs before the last one for
            several. At a kink it is the derivative of the branch that the program takes there. For one output of pandas
            a DataFrame with the index of the points.

        Raises:
            UnknownNameError: For another `by`.
            ArgumentError: For arrays of another shape.
        """
        known = {
            "inputs": lambda: (self._by_inputs, self.input_names),
            "values": lambda: (self._by_values, self.free_names),
        }
        if by not in known:
            raise UnknownNameError("derivative by", by, known)
        derivatives, names = known[by]()
        found = jacobian(derivatives(points, self._values.of(values)), len(self.output_names))
        return labelled(found, names, points)

    @cached_property
    def _degrees(self) -> Arrays:
        return self._arrays(self._over_values(inference.degrees))

    @cached_property
    def _strengths(self) -> Arrays:
        return self._arrays(self._over_values(inference.activations))

    @cached_property
    def _by_inputs(self) -> Arrays:
        return self._gradient(tuple(x.name for x in inference.raw_names(self.plan)))

    @cached_property
    def _by_values(self) -> Arrays:
        return self._gradient(tuple(x.name for x in self._free.trace.arguments))

    def _gradient(self, by: tuple[str, ...]) -> Arrays:
        program = differentiated(free_program(self._free), by)
        return self._arrays(with_values_as_array(program, self._free.trace.arguments))

    def _over_values(self, write: Callable[[Plan], Program]) -> Program:
        return with_values_as_array(free_program(self._free, write), self._free.trace.arguments)

    def _arrays(self, program: Program) -> Arrays:
        return Arrays(program, self.backend, self.input_names)
