"""Many points at a time: outputs of arrays of any shape, and other results such as degrees and gradients."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError, NoRuleFiresError
from fuzzyctl.expr import Number
from fuzzyctl.kernels.backends import blocks
from fuzzyctl.kernels.backends.arguments import float_array, labelled, state_after, states_along
from fuzzyctl.kernels.forms import Promises, Refusals
from fuzzyctl.kernels.free_values import with_values_as_array
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.program import scalar
from fuzzyctl.kernels.program.derivatives import differentiated
from fuzzyctl.kernels.program.program import Program

if TYPE_CHECKING:
    import numpy.typing as npt

    from fuzzyctl.kernels.backends.blocks import Fill
    from fuzzyctl.kernels.forms import Form

    FloatArray = npt.NDArray[np.float64]
    #: Fills results; returns -1, or the number of kinds of refusals · the first point that was refused + the kind.
    Loop = Callable[[FloatArray, FloatArray | None, FloatArray], int]


def evaluated(
    form: Form, fill: Fill, points: Any, rows: FloatArray | None, out: Any, *, compiled: bool, parallel: bool
) -> FloatArray:
    """Evaluate at many points, see `Kernel.batch`.

    Args:
        form: What to compute.
        fill: Computes some points.
        points: Shape (..., arguments), of any type of numbers and any layout.
        rows: Shape (..., states), which broadcasts with the points; None without a state.
        out: The array for the results, None for a new one.
        compiled: Whether `fill` needs no lock of the interpreter.
        parallel: Whether several threads may share the work then.

    Returns:
        Shape (...) for one number, (..., numbers) for several.
    """
    shape = points.shape[:-1]
    if rows is not None and rows.ndim > 1 and rows.shape[:-1] != shape:
        shape = broadcast(shape, rows)
        points = np.broadcast_to(points, (*shape, points.shape[-1]))
    count = math.prod(shape)
    if points.flags.c_contiguous or points.size == 0:
        points = points.reshape(count, points.shape[-1])
    if rows is not None and rows.shape[:-1] != (count,):
        length = rows.shape[-1]
        whole = (count, length) if rows.ndim == 1 else (*shape, length)
        rows = np.broadcast_to(rows, whole).reshape(count, length)
    results = blocks.results_for(out, shape if form.width == 1 else (*shape, form.width), points, rows)
    target = np.asarray(results).reshape(count, form.width)
    if compiled:
        blocks.run_compiled(fill, points, rows, target, parallel=parallel)
    else:
        # Threads of plain Python, and of numpy's many short steps, would only wait for each other.
        blocks.run(fill, points, rows, target)
    return results


def broadcast(shape: tuple[int, ...], rows: FloatArray) -> tuple[int, ...]:
    """Return the shape of points with states, or raise `ArgumentError`."""
    try:
        return np.broadcast_shapes(shape, rows.shape[:-1])
    except ValueError:
        raise ArgumentError(f"a state of shape {rows.shape} does not fit points of shape {shape}") from None


def fill_in_sequence(
    plan: Plan, fill: Fill, checked: Fill, points: FloatArray, state: FloatArray, results: FloatArray
) -> None:
    """Fill the results of points in sequence; each begins with the state that the last one left.

    Args:
        plan: The system.
        fill: Computes some points.
        checked: Does so, and checks the promises of the outputs.
        points: Shape (n, inputs).
        state: Shape (states,); the state after the last point is left in it.
        results: Shape (n, outputs).
    """

    def some(points: FloatArray, states: FloatArray) -> FloatArray:
        outputs = np.empty((len(points), len(plan.outputs)))
        fill(points, states, outputs)
        return outputs

    for first in range(0, len(results), blocks.BLOCK):
        last = min(first + blocks.BLOCK, len(results))
        rows = states_along(plan, some, points[first:last], state)
        checked(points[first:last], rows, results[first:last])
        state[:] = state_after(plan, state, results[first:last])


def fill_of(program: Program, backend: str, names: Sequence[str], promises: Promises | None = None) -> Fill:
    """Return the function that fills the results of a program at many points.

    Args:
        program: The program.
        backend: "numba", "numpy" or "python".
        names: Of its arguments.
        promises: Checked by machine code for the points before one that is refused, so that the first one is named.
    """
    if backend == "numpy":
        from fuzzyctl.kernels.backends import numpy_backend

        return numpy_backend.compile_batch(program, names)
    if backend == "python":
        source = scalar.storing_source(program)
        return _fill_by_storing(scalar.compile_source(source, program, names))
    from fuzzyctl.kernels.backends.numba.machine_code import loop

    return fill_by_loop(loop(program), program, names, promises)


def fill_by_loop(loop: Loop, program: Program, names: Sequence[str], promises: Promises | None = None) -> Fill:
    """Return the function that fills results by machine code of a program, see `fill_of`."""
    refusals = Refusals(program, names)

    def fill(points: FloatArray, states: FloatArray | None, results: FloatArray) -> None:
        code = loop(points, states, results)
        if code >= 0:
            first, output = refusals.place(code)
            if promises is not None:
                promises.check_block(points[:first], None if states is None else states[:first], results[:first])
            raise NoRuleFiresError(output, scalar.point_text(names, points[first]))

    return fill


def fill_by_calls(function: Callable[..., Any]) -> Fill:
    """Return the function that fills results by calls of a function (x0, ..., C)."""

    def fill(points: FloatArray, states: FloatArray | None, results: FloatArray) -> None:
        rows = None if states is None else states.tolist()
        for i, point in enumerate(points.tolist()):
            results[i] = function(*point) if rows is None else function(*point, rows[i])

    return fill


def _fill_by_storing(function: Callable[..., None]) -> Fill:
    """Return the function that fills results by calls of a function (x0, ..., C, result), which stores them."""

    def fill(points: FloatArray, states: FloatArray | None, results: FloatArray) -> None:
        rows = None if states is None else states.tolist()
        for i, point in enumerate(points.tolist()):
            function(*point, *(() if rows is None else (rows[i],)), results[i])

    return fill


class Arrays:
    """Evaluates a program at many points; results that are numbers, such as constant derivatives, are not computed.

    Args:
        program: The program.
        backend: "numba", "numpy" or "python".
        names: Of its arguments.
    """

    def __init__(self, program: Program, backend: str, names: Sequence[str]) -> None:
        self._takes_rows = bool(program.state)
        self._constants = np.array([r.value if isinstance(r, Number) else 0.0 for r in program.results])
        self._computed = [k for k, r in enumerate(program.results) if not isinstance(r, Number)]
        computed = replace(program, results=tuple(program.results[k] for k in self._computed))
        self._fill = fill_of(computed, backend, names) if self._computed else None

    def __call__(self, points: Any, rows: FloatArray | None = None) -> FloatArray:
        """Evaluate.

        Args:
            points: Shape (..., arguments).
            rows: The state, shape (..., states), which broadcasts with the points.

        Returns:
            Shape (..., results).

        Raises:
            ArgumentError: For a state that does not fit the points.
        """
        array, shape = float_array(points, "points"), points.shape[:-1]
        if rows is not None:
            shape = broadcast(shape, rows)
            rows = np.ascontiguousarray(np.broadcast_to(rows, (*shape, rows.shape[-1]))).reshape(-1, rows.shape[-1])
        count = math.prod(shape)
        flat = np.ascontiguousarray(np.broadcast_to(array, (*shape, array.shape[-1]))).reshape(count, array.shape[-1])
        results = np.empty((count, len(self._computed)))
        if self._fill is not None:
            blocks.run(self._fill, flat, rows if self._takes_rows else None, results)
        width = len(self._constants)
        if len(self._computed) < width:
            computed, results = results, np.tile(self._constants, (count, 1))
            results[:, self._computed] = computed
        return results.reshape(*shape, width)


def by_name(plan: Plan, degrees: FloatArray, points: Any) -> dict[str, dict[str, Any]]:
    """Return the degrees of a plan, shape (..., degrees), by variable and term, with the row labels of the points."""
    by_output: dict[str, dict[str, Any]] = {}
    for k, d in enumerate(plan.degrees):
        by_output.setdefault(plan.variable(d.variable).name, {})[d.term] = labelled(degrees[..., k], [d.term], points)
    return by_output


def derivatives(form: Form, by: str) -> Program:
    """Differentiate a form in forward mode.

    Args:
        form: What to differentiate.
        by: "inputs", "state", or "all", which is the inputs, then the state.

    Returns:
        The program of the derivatives of each of its numbers by each argument; it has the arguments of the form.
    """
    program, state = form.named()
    inputs = program.arguments[: len(form.input_names)]
    names = {"inputs": inputs, "state": state, "all": (*inputs, *state)}[by]
    return with_values_as_array(differentiated(program, names), state)
