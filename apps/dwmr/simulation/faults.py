"""Faults that end a run: numbers that are not finite, or that no robot has."""

from __future__ import annotations

import math

from dwmr.core.jit import compiled
from dwmr.plant.robot import State

#: Fault number of a run in which a number became infinite or undefined; a law's own faults are positive.
NOT_FINITE = -1
#: Fault number of a run in which a number grew beyond `LARGEST`.
TOO_LARGE = -2

#: A place beyond this is the run's, not its scenario's, whose places lie within a tenth of it [m].
FARTHEST_RUN = 1e10
#: A velocity beyond this is no robot's; the fastest reference has a tenth of it [m/s, rad/s].
FASTEST_RUN = 1e7
#: A command beyond this is no mere consequence of the way to go, with which commands grow [m/s, rad/s].
LARGEST_COMMAND = 1e12
#: Beyond this in magnitude a signal says that the run diverged.
LARGEST = {
    "x": FARTHEST_RUN,
    "y": FARTHEST_RUN,
    "v": FASTEST_RUN,
    "omega": FASTEST_RUN,
    "v_c": LARGEST_COMMAND,
    "omega_c": LARGEST_COMMAND,
}


@compiled
def fault_of(fault: int, state: State, v_c: float, omega_c: float) -> int:
    """Return the fault that ends the run; those of numbers come before those of the law."""
    if not (math.isfinite(v_c) and math.isfinite(omega_c) and _is_finite(state)):
        return NOT_FINITE
    return TOO_LARGE if _is_too_large(state, v_c, omega_c) else fault


@compiled
def _is_finite(s: State) -> bool:
    return (
        math.isfinite(s.x)
        and math.isfinite(s.y)
        and math.isfinite(s.theta)
        and math.isfinite(s.v)
        and math.isfinite(s.omega)
    )


@compiled
def _is_too_large(s: State, v_c: float, omega_c: float) -> bool:
    """Return whether a number is beyond `LARGEST`."""
    return (
        max(abs(s.x), abs(s.y)) > FARTHEST_RUN
        or max(abs(s.v), abs(s.omega)) > FASTEST_RUN
        or max(abs(v_c), abs(omega_c)) > LARGEST_COMMAND
    )
