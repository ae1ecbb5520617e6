"""Reference trajectories compiled: posture and velocities of the virtual robot as functions of time."""

from __future__ import annotations

import math
from collections.abc import Callable

from dwmr.core.arrays import FloatArray
from dwmr.core.interfaces import reference_path
from dwmr.core.jit import compiled
from dwmr.core.reference import Reference
from dwmr.reference import curves

eight = reference_path(curves.eight)
circle = reference_path(curves.circle)
line = reference_path(curves.line)
spline = reference_path(curves.spline)

#: Compiled path by the name of its function in `curves`, see `prepared.Shape`.
PATHS: dict[str, Callable[[float, FloatArray], Reference]] = {
    "eight": eight,
    "circle": circle,
    "line": line,
    "spline": spline,
}


@compiled
def eight_turn_rate(t: float, shape: FloatArray) -> float:
    """Return the angular velocity of the virtual robot on the eight [rad/s].

    Args:
        t: Time [s].
        shape: Constants of the eight, see `curves.eight`.

    Source:
        Goto, Bertol, Martins, Eq. (76), third row, with the numerator's second derivatives restored.
    """
    w, a_x, a_y = 2.0 * math.pi / shape[2], shape[0], shape[1]
    w_x, w_y = shape[3] * w, shape[4] * w
    x_dot = w_x * a_x * math.cos(w_x * t)
    y_dot = w_y * a_y * math.cos(w_y * t)
    x_ddot = -w_x * w_x * a_x * math.sin(w_x * t)
    y_ddot = -w_y * w_y * a_y * math.sin(w_y * t)
    rate: float = (y_ddot * x_dot - x_ddot * y_dot) / (x_dot * x_dot + y_dot * y_dot)
    return rate
