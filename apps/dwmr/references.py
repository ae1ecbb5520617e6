"""Reference trajectories: posture and velocities of the virtual robot as functions of time."""

from __future__ import annotations

import math

from dwmr.compiled import compiled
from dwmr.contracts import FloatArray, Reference, reference_path


@reference_path
def eight(t: float, shape: FloatArray) -> Reference:
    """Return posture and velocity on a figure eight at a time.

    Args:
        t: Time [s].
        shape: Half the width along x, travelled twice per period [m]; half the length along y [m]; period [s].

    Returns:
        The virtual robot's posture and linear velocity; its orientation is the direction of travel.

    Source:
        Goto, Bertol, Martins, Eq. (76) with x and y exchanged: only so do the obstacles of Table 11 lie on the path in
        the middle of the disturbance windows, as section 7.2 says.
    """
    w, a_x, a_y = 2.0 * math.pi / shape[2], shape[0], shape[1]
    x_dot = 2.0 * w * a_x * math.cos(2.0 * w * t)
    y_dot = w * a_y * math.cos(w * t)
    x = a_x * math.sin(2.0 * w * t)
    y = a_y * math.sin(w * t)
    return Reference(x, y, math.atan2(y_dot, x_dot), math.hypot(x_dot, y_dot))


@compiled
def eight_turn_rate(t: float, shape: FloatArray) -> float:
    """Return the angular velocity of the virtual robot on the eight [rad/s].

    Source:
        Goto, Bertol, Martins, Eq. (76), third row, with the numerator's second derivatives restored.
    """
    w, a_x, a_y = 2.0 * math.pi / shape[2], shape[0], shape[1]
    x_dot = 2.0 * w * a_x * math.cos(2.0 * w * t)
    y_dot = w * a_y * math.cos(w * t)
    x_ddot = -4.0 * w * w * a_x * math.sin(2.0 * w * t)
    y_ddot = -w * w * a_y * math.sin(w * t)
    rate: float = (y_ddot * x_dot - x_ddot * y_dot) / (x_dot * x_dot + y_dot * y_dot)
    return rate
