"""State of kernels: initial values of callers, and sequences whose outputs hold their previous value."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final

from fuzzyctl.diagnostics.diagnostic import ArgumentError, ValueOutOfBoundsError
from fuzzyctl.kernels.backends.arguments import float_array, row_array, writable
from fuzzyctl.kernels.plan.build import Plan
from fuzzyctl.kernels.program.scalar import as_number

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

NO_STATE: Final = "the system has no state: no output is adaptive or says 'else hold'"


def argument(state: Any, names: Sequence[str], *, compiled: bool) -> Any:
    """Return a state as the function of a backend takes it; compiled code would read beyond a short one.

    Raises:
        ArgumentError: For a state of another shape.
    """
    count = len(names)
    if type(state) in (list, tuple) and not compiled:  # no numpy for a light start
        try:
            plain: Any = [c if type(c) is float else as_number(c, "each entry of the state") for c in state]
        except OverflowError:
            raise ValueOutOfBoundsError("state", type(state), "within the range of floats") from None
    else:
        array = row_array(names, state, "state") if hasattr(state, "keys") else float_array(state, "state")
        if array.ndim != 1:
            raise ArgumentError(f"the state must have the shape ({count},), got {array.shape}")
        plain = writable(array) if compiled else array.tolist()
    if len(plain) != count:
        raise ArgumentError(f"the state must have {count} entries, got {len(plain)}")
    return plain


def states_along(
    plan: Plan, batch: Callable[[FloatArray, FloatArray], FloatArray], points: FloatArray, state: FloatArray
) -> FloatArray:
    """Return the state before each point of a sequence.

    An output is NaN where it would hold a previous value of NaN, which shows where it holds; the value that it holds
    there is the last one before. Outputs may read each other, so they are found one by one, each after those it reads:
    as many batches as there are such outputs, and no loop over points.

    Args:
        plan: The system.
        batch: The function (points, states) -> results.
        points: Shape (n, inputs).
        state: State before the first point, shape (states,).

    Returns:
        Shape (n, states).
    """
    import numpy as np

    states = np.tile(state, (len(points), 1))
    adaptive = len(plan.states)
    for k, position in enumerate(plan.held):
        column = states[:, adaptive + k]
        column[:] = np.nan
        fresh = batch(points, states)[:, position]
        column[:] = previous(fresh, float(state[adaptive + k]))
    return states


def previous(values: FloatArray, first: float) -> FloatArray:
    """Return for each of some values, shape (n,), the last one before it that is no NaN, or `first` where none is."""
    import numpy as np

    latest = np.where(np.isnan(values), 0, np.arange(1, len(values) + 1))
    before = np.concatenate(([0], np.maximum.accumulate(latest)[:-1])) if len(values) else latest
    result: FloatArray = np.concatenate(([first], values))[before]
    return result


def state_after(plan: Plan, state: FloatArray, results: FloatArray) -> FloatArray:
    """Return the state after results of shape (n, outputs), the state before them given."""
    import numpy as np

    after = np.array(state, dtype=np.float64)
    for k, position in enumerate(plan.held):
        fresh = results[~np.isnan(results[:, position]), position]
        if len(fresh):
            after[len(plan.states) + k] = fresh[-1]
    return after
