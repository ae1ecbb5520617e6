"""Many points at a time: what a kernel makes of arrays of any shape, and of outputs that hold their values."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError, NoRuleFiresError
from fuzzyctl.kernels.backends import sequence
from fuzzyctl.kernels.backends.arguments import float_array, point_array
from fuzzyctl.kernels.backends.python import backend as python_backend

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from fuzzyctl.kernels.algorithms.select import Algorithm
    from fuzzyctl.kernels.backends.blocks import Fill
    from fuzzyctl.kernels.backends.numba.native import Loop
    from fuzzyctl.kernels.plan.build import Plan

    FloatArray = npt.NDArray[np.float64]

NO_STATE: Final = "the system has no state: no output is adaptive or says 'else hold'"


class Batches:
    """What kernels have for many points.

    Attributes:
        plan: What the kernel computes.
        backend: "numba", "numpy" or "python".
        algorithm: The programs that compute it.
        input_names: The names of its inputs, in their order.
        output_names: The names of its outputs.
        n_states: The number of entries of its state.
    """

    plan: Plan
    backend: str
    algorithm: Algorithm
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    n_states: int
    jit: Any
    initial_state: Callable[[], FloatArray]
    #: Outputs of refusals by message.
    _refusals: dict[str, str]
    #: Outputs that promise to have a value everywhere, where it is not seen beforehand that they do.
    _promised: tuple[int, ...]

    def batch(self, points: Any, state: Any = None, *, out: Any = None, parallel: bool = True) -> FloatArray:
        """Evaluate at many points.

        Args:
            points: Shape (..., inputs), in the order of the inputs; or what has named columns, such as a data frame, a
                structured array or a dict of arrays, or what has labels along its last axis, such as a DataArray of
                xarray. The names must be exactly those of the inputs, in any order.
            state: The state, shape (..., states), for each point its own. Of shape (states,) it is the state before
                the first point: adaptive consequents stay as they are, and an output that says `else hold` holds, point
                after point in the order of indices, the last value before that is no NaN. Left out, it is the initial
                state of a system without adaptive outputs.
            out: A contiguous array of float64 of the result's shape to write to; None for a new one.
            parallel: Whether all cores may be used; they are where the work is worth it.

        Returns:
            Shape (...) for one output, (..., outputs) for several.

        Raises:
            ArgumentError: For arrays of another shape or not of numbers, and for columns of other names.
            NoRuleFiresError: For the first point where no rule fires for an output that says `else error` or has no
                `else`.
        """
        import numpy as np

        from fuzzyctl.kernels.backends import blocks as batching

        array = point_array(self.input_names, points)
        if array.ndim == 0 or array.shape[-1] != len(self.input_names):
            raise ArgumentError(
                f"points must have the shape (..., {len(self.input_names)}) for {', '.join(self.input_names)}, "
                f"got {array.shape}"
            )
        shape = array.shape[:-1]
        count = math.prod(shape)
        if array.flags.c_contiguous or array.size == 0:
            array = array.reshape(count, array.shape[-1])
        states = self._flat_state(state, shape)
        width = len(self.output_names)
        results = batching.results_for(out, shape if width == 1 else (*shape, width), array, states)
        flat = np.asarray(results).reshape(count, width)
        if states is not None and self.plan.held and np.ndim(0.0 if state is None else state) <= 1:
            self._fill_sequence(array, self._first_state(state), flat)
        elif self.backend == "numba":
            batching.run_compiled(self._checked_fill, array, states, flat, parallel=parallel)
        else:
            # Threads of plain Python, and of numpy's many short steps, would only wait for each other.
            batching.run(self._checked_fill, array, states, flat)
        return results

    def _fill_sequence(self, points: Any, state: FloatArray, results: FloatArray) -> None:
        """Fill the results of points one after another, each of which begins with what the last one left."""
        from fuzzyctl.kernels.backends import blocks as batching

        for first in range(0, len(results), batching.BLOCK):
            last = min(first + batching.BLOCK, len(results))
            block = batching.plain(float_array(batching.listed(points, first, last), "points"))
            states = sequence.states_along(self.plan, self._results, block, state)
            self._checked_fill(block, states, results[first:last])
            state = sequence.state_after(self.plan, state, results[first:last])

    def _results(self, points: FloatArray, states: FloatArray) -> FloatArray:
        """Return the results of some points, promises unchecked."""
        import numpy as np

        results = np.empty((len(points), len(self.output_names)))
        self._fill(points, states, results)
        return results

    def _fill_compiled(self, points: FloatArray, states: FloatArray | None, results: FloatArray) -> None:
        """Fill the results by machine code, of arrays as that takes them."""
        refused = self._loop(points, states, results)
        if refused >= 0:
            first, kind = divmod(refused, len(self._refusals))
            before = slice(first)
            self._keep_promises_at(points[before], None if states is None else states[before], results[before])
            text = python_backend.point_text(self.input_names, points[first])
            raise NoRuleFiresError(list(self._refusals.values())[kind], text)

    def _checked_fill(self, points: FloatArray, states: FloatArray | None, results: FloatArray) -> None:
        """Fill a block; raise where an output without `else` is NaN though nothing that it reads is."""
        import numpy as np

        self._fill(points, states, results)
        # The least number is NaN if any is, and takes no memory; only then is it worth looking closer.
        if self._promised and np.isnan(np.min(results, initial=np.inf)):
            self._keep_promises_at(points, states, results)

    def _keep_promises_at(self, points: FloatArray, states: FloatArray | None, results: FloatArray) -> None:
        """Raise for the first point of a block at which an output without `else` is NaN though nothing it reads is."""
        import numpy as np

        missing = np.isnan(results)
        bad = np.zeros(len(points), dtype=bool)
        for k in self._promised:
            bad |= missing[:, k] & ~missing[:, list(self.plan.outputs[k].reads)].any(axis=1)
        bad &= ~np.isnan(points).any(axis=1)
        if states is not None:
            bad &= ~np.isnan(states[:, : len(self.plan.states)]).any(axis=1)
        if bad.any():
            first = int(np.argmax(bad))
            self._keep_promises(points[first].tolist(), tuple(results[first].tolist()))

    def _keep_promises(self, arguments: Any, result: float | tuple[float, ...]) -> None:
        """Raise where an output without `else` is NaN though nothing that it reads is."""
        values = result if isinstance(result, tuple) else (result,)
        point = [float(a) for a in arguments[: len(self.input_names)]]
        # What is held may be NaN at first: an output that reads it is NaN, too, and others promise what they promised.
        consequents = arguments[-1] if self.plan.states and len(arguments) > len(point) else ()
        if any(x != x for x in point) or any(c != c for c in consequents):
            return
        for k in self._promised:
            if values[k] != values[k] and all(values[r] == values[r] for r in self.plan.outputs[k].reads):
                text = python_backend.point_text(self.input_names, point)
                raise NoRuleFiresError(self.output_names[k], text)

    @cached_property
    def _fill(self) -> Fill:
        """The function (points (n, inputs), states (n, states) or None, results (n, outputs)) that writes results."""
        if self.backend == "numba":
            assert self._loop is not None  # compiled here, so that it is no part of the time of the first block
            return self._fill_compiled
        if self.backend == "numpy":
            from fuzzyctl.kernels.backends.numpy import backend as numpy_backend

            return numpy_backend.compile_batch(self.algorithm.arrays, self.input_names)
        return self._python_fill

    @cached_property
    def _loop(self) -> Loop:
        """The loop in machine code."""
        from fuzzyctl.kernels.backends.numba import native

        return native.loop(self.algorithm.many)

    def _python_fill(self, points: FloatArray, states: FloatArray | None, results: FloatArray) -> None:
        given = None if states is None else states.tolist()
        for i, point in enumerate(points.tolist()):
            results[i] = self.jit(*point) if given is None else self.jit(*point, given[i])

    def _flat_state(self, state: Any, shape: tuple[int, ...]) -> FloatArray | None:
        import numpy as np

        if not self.n_states:
            if state is not None:
                raise ArgumentError(f"{NO_STATE}, so batch takes none")
            return None
        array = self._first_state(None) if state is None else float_array(state, "state")
        if array.ndim == 0 or array.shape[-1] != self.n_states:
            raise ArgumentError(f"the state must have the shape (..., {self.n_states}), got {array.shape}")
        try:
            return np.broadcast_to(array, (*shape, self.n_states)).reshape(-1, self.n_states)
        except ValueError:
            raise ArgumentError(f"a state of shape {array.shape} does not fit points of shape {shape}") from None

    def _first_state(self, state: Any) -> FloatArray:
        """Return a state of shape (states,), the initial one for None where nothing adapts."""
        if state is None and self.plan.states:
            raise ArgumentError(f"the state is missing: {self.n_states} adaptive consequents")
        array = self.initial_state() if state is None else float_array(state, "state")
        if array.shape != (self.n_states,):
            raise ArgumentError(f"the state must have the shape ({self.n_states},), got {array.shape}")
        return array
