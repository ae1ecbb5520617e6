"""Many points at a time: arrays of any shape, and outputs that hold their values."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fuzzyctl.diagnostics.diagnostic import ArgumentError, NoRuleFiresError
from fuzzyctl.kernels.backends import blocks
from fuzzyctl.kernels.backends import states as sequence
from fuzzyctl.kernels.backends.arguments import float_array, point_array
from fuzzyctl.kernels.backends.python import backend as python_backend
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.program.program import Program
from fuzzyctl.kernels.promises import Promises, Refusals

if TYPE_CHECKING:
    import numpy.typing as npt

    from fuzzyctl.kernels.backends.blocks import Fill

    FloatArray = npt.NDArray[np.float64]
    #: Fills results; returns -1, or the number of kinds of refusals · the first point that was refused + the kind.
    Loop = Callable[[FloatArray, FloatArray | None, FloatArray], int]


class Batch:
    """Evaluates a system at many points.

    Args:
        plan: The system.
        fill: Computes a block of them.
        promises: Checks the results.
        is_compiled: Whether `fill` needs no lock of the interpreter.
    """

    def __init__(self, plan: Plan, fill: Fill, promises: Promises, *, is_compiled: bool) -> None:
        self._plan, self._fill, self._promises, self._is_compiled = plan, fill, promises, is_compiled

    def __call__(self, points: Any, state: Any, out: Any, *, parallel: bool) -> FloatArray:
        """Evaluate, see `Kernel.batch`."""
        names, width = [i.name for i in self._plan.inputs], len(self._plan.outputs)
        array = point_array(names, points)
        if array.ndim == 0 or array.shape[-1] != len(names):
            wanted = f"(..., {len(names)}) for {', '.join(names)}"
            raise ArgumentError(f"points must have the shape {wanted}, got {array.shape}")
        shape = array.shape[:-1]
        count = math.prod(shape)
        if array.flags.c_contiguous or array.size == 0:
            array = array.reshape(count, array.shape[-1])
        states = sequence.flat_state(self._plan, state, shape)
        results = blocks.results_for(out, shape if width == 1 else (*shape, width), array, states)
        flat = np.asarray(results).reshape(count, width)
        if states is not None and self._plan.held and np.ndim(0.0 if state is None else state) <= 1:
            self._fill_sequence(array, sequence.first_state(self._plan, state), flat)
        elif self._is_compiled:
            blocks.run_compiled(self._checked_fill, array, states, flat, parallel=parallel)
        else:
            # Threads of plain Python, and of numpy's many short steps, would only wait for each other.
            blocks.run(self._checked_fill, array, states, flat)
        return results

    def _fill_sequence(self, points: Any, state: FloatArray, results: FloatArray) -> None:
        """Fill the results of points in sequence; each begins with the state that the last one left."""
        for first in range(0, len(results), blocks.BLOCK):
            last = min(first + blocks.BLOCK, len(results))
            block = blocks.plain(float_array(blocks.listed(points, first, last), "points"))
            states = sequence.states_along(self._plan, self._results, block, state)
            self._checked_fill(block, states, results[first:last])
            state = sequence.state_after(self._plan, state, results[first:last])

    def _results(self, points: FloatArray, states: FloatArray) -> FloatArray:
        """Return the results of some points, promises unchecked."""
        results = np.empty((len(points), len(self._plan.outputs)))
        self._fill(points, states, results)
        return results

    def _checked_fill(self, points: FloatArray, states: FloatArray | None, results: FloatArray) -> None:
        self._fill(points, states, results)
        self._promises.check_block(points, states, results)


def fill_of(program: Program, backend: str, names: Sequence[str], promises: Promises | None = None) -> Fill:
    """Return the function that fills the results of a program at many points.

    Args:
        program: The program.
        backend: "numba", "numpy" or "python".
        names: Of its arguments.
        promises: Checked by machine code for the points before one that is refused, so that the first one is named.
    """
    if backend == "numpy":
        from fuzzyctl.kernels.backends.numpy import backend as numpy_backend

        return numpy_backend.compile_batch(program, names)
    if backend == "python":
        source = python_backend.storing_source(program)
        return _fill_by_storing(python_backend.compile_source(source, program, names))
    from fuzzyctl.kernels.backends.numba.batch_loop import loop

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
            raise NoRuleFiresError(output, python_backend.point_text(names, points[first]))

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
