"""Programs over arrays: what kernels have besides their outputs, such as degrees and gradients."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError
from fuzzyctl.kernels.backends import blocks
from fuzzyctl.kernels.backends.arguments import float_array, point_array
from fuzzyctl.kernels.backends.labels import labelled
from fuzzyctl.kernels.inference import inference
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.program.passes.differentiate import differentiated
from fuzzyctl.kernels.program.program import Program, Refuse
from fuzzyctl.kernels.promises import Promises

if TYPE_CHECKING:
    import numpy.typing as npt

    from fuzzyctl.kernels.backends.blocks import Fill

    FloatArray = npt.NDArray[np.float64]


def fill_of(program: Program, backend: str, plan: Plan) -> Fill:
    """Return what fills the results of a program at many points."""
    names = tuple(i.name for i in plan.inputs)
    if backend == "numpy":
        from fuzzyctl.kernels.backends.numpy import backend as numpy_backend

        return numpy_backend.compile_batch(program, names)
    from fuzzyctl.kernels.batch import fill_by_loop, fill_by_storing

    if backend == "python":
        from fuzzyctl.kernels.backends.python import backend as python_backend

        source = python_backend.storing_source(program)
        return fill_by_storing(python_backend.compile_source(source, program, names))
    from fuzzyctl.kernels.backends.numba.batch_loop import loop

    refused = [s.output for s in program.body if isinstance(s, Refuse)]
    return fill_by_loop(loop(program), refused, Promises(plan, known=True))


class Arrays:
    """Evaluates a program at many points.

    Args:
        program: The program; its arguments are the inputs.
        backend: "numba", "numpy" or "python".
        plan: What it belongs to.
    """

    def __init__(self, program: Program, backend: str, plan: Plan) -> None:
        self._width, self.takes_rows = len(program.results), bool(program.state)
        self._names = tuple(i.name for i in plan.inputs)
        self._fill = fill_of(program, backend, plan)

    def __call__(self, points: Any, rows: FloatArray | None = None) -> FloatArray:
        """Evaluate.

        Args:
            points: Shape (..., inputs).
            rows: What the program takes as an array, shape (..., length); it broadcasts with the points.

        Returns:
            Shape (..., results).

        Raises:
            ArgumentError: For arrays of another shape or not of numbers.
        """
        array = float_array(point_array(self._names, points), "points")
        if array.ndim == 0 or array.shape[-1] != len(self._names):
            wanted = f"(..., {len(self._names)}) for {', '.join(self._names)}"
            raise ArgumentError(f"points must have the shape {wanted}, got {array.shape}")
        shape = array.shape[:-1]
        if rows is not None:
            shape = broadcast(shape, rows)
            rows = np.ascontiguousarray(np.broadcast_to(rows, (*shape, rows.shape[-1]))).reshape(-1, rows.shape[-1])
        count = math.prod(shape)
        flat = np.ascontiguousarray(np.broadcast_to(array, (*shape, array.shape[-1]))).reshape(count, array.shape[-1])
        results = np.empty((count, self._width))
        blocks.run(self._fill, flat, rows, results)
        return results.reshape(*shape, self._width)


def broadcast(shape: tuple[int, ...], rows: FloatArray) -> tuple[int, ...]:
    """Return the shape of points with rows of numbers, or raise `ArgumentError`."""
    try:
        return np.broadcast_shapes(shape, rows.shape[:-1])
    except ValueError:
        raise ArgumentError(f"values of shape {rows.shape} do not broadcast with points of shape {shape}") from None


def by_name(plan: Plan, degrees: FloatArray, points: Any) -> dict[str, dict[str, Any]]:
    """Return the degrees of a plan, shape (..., degrees), by variable and term, with the row labels of the points."""
    found: dict[str, dict[str, Any]] = {}
    for k, d in enumerate(plan.degrees):
        found.setdefault(plan.variable(d.variable).name, {})[d.term] = labelled(degrees[..., k], [d.term], points)
    return found


def input_gradient(plan: Plan) -> Program:
    """Return the program of the derivatives of all outputs by all inputs."""
    names = tuple(x.name for x in inference.raw_names(plan))
    return differentiated(inference.evaluation(plan), names)


def jacobian(rows: FloatArray, outputs: int) -> FloatArray:
    """Return derivatives, shape (..., outputs · arguments), as (..., arguments) for one output, else with its axis."""
    return rows if outputs == 1 else rows.reshape(*rows.shape[:-1], outputs, rows.shape[-1] // outputs)
