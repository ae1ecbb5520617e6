"""Programs over arrays: what kernels have besides their outputs, such as degrees and gradients."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fuzzyctl.expr import Number
from fuzzyctl.kernels.backends import blocks
from fuzzyctl.kernels.backends.arguments import float_array
from fuzzyctl.kernels.backends.labels import labelled
from fuzzyctl.kernels.batch import broadcast, fill_of
from fuzzyctl.kernels.inference.free import with_values_as_array
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.program.passes.differentiate import differentiated
from fuzzyctl.kernels.program.program import Program

if TYPE_CHECKING:
    import numpy.typing as npt

    from fuzzyctl.kernels.forms import Form

    FloatArray = npt.NDArray[np.float64]


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
    found: dict[str, dict[str, Any]] = {}
    for k, d in enumerate(plan.degrees):
        found.setdefault(plan.variable(d.variable).name, {})[d.term] = labelled(degrees[..., k], [d.term], points)
    return found


def derivatives(form: Form, by: str) -> Program:
    """Differentiate a form in forward mode.

    Args:
        form: What to differentiate.
        by: "inputs", "state", or "all", which is the inputs, then the state.

    Returns:
        The program of the derivatives of each of its numbers by each argument; it takes what the form takes.
    """
    program, state = form.named()
    inputs = program.arguments[: len(form.input_names)]
    names = {"inputs": inputs, "state": state, "all": (*inputs, *state)}[by]
    return with_values_as_array(differentiated(program, names), state)
