"""Step of the control laws that are text: the compiled function that the loop calls for all of them."""

from __future__ import annotations

from collections.abc import Callable

from dwmr.core.arrays import FloatArray
from dwmr.core.interfaces import TrackingError, control_law

#: Takes the tracking error, field by field, the control period and the state, two arrays: the state, and as results
#: outputs and next state.
Kernel = Callable[..., None]


@control_law(f"void({'float64, ' * (len(TrackingError._fields) + 1)}float64[::1], float64[::1])")
def step(
    error: TrackingError,
    dt: float,
    gains: FloatArray,
    state: FloatArray,
    kernels: tuple[Kernel],
    next_state: FloatArray,
    signals: FloatArray,
) -> tuple[float, float, int]:
    """Return the first two outputs of a law as the velocity command, and record the others.

    A state of the loop is a row of outputs, those of the period before, then the states of the law and its gains.
    """
    outputs = signals.shape[0] + 2
    e = error
    kernels[0](
        e.x_e, e.y_e, e.theta_e_star, e.drift_x, e.drift_y, e.drift_theta, e.d, e.theta_e, e.v_r, e.omega_r, e.v,
        e.omega, e.t, dt, state[outputs:], next_state,
    )  # fmt: skip
    for k in range(signals.shape[0]):
        signals[k] = next_state[k + 2]
    return next_state[0], next_state[1], 0
