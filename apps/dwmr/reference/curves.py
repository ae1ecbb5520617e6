"""Reference trajectories in plain Python: the one definition, compiled for the loop and called by `dwmr show`."""

from __future__ import annotations

import math

from dwmr.core.arrays import FloatArray
from dwmr.core.reference import Reference


def eight(t: float, shape: FloatArray) -> Reference:
    """Return posture and velocity on a figure eight at a time.

    Args:
        t: Time [s].
        shape: Half the width along x and along y [m]; period [s]; how often each of the two is travelled per period.

    Returns:
        The virtual robot's posture and velocities; its orientation is the direction of travel.

    Source:
        Goto, Bertol, Martins, Eq. (76) with x and y exchanged: only so do the obstacles of Table 11 lie on the path in
        the middle of the disturbance windows, as section 7.2 says; third row with the numerator's second derivatives
        restored.
    """
    w, a_x, a_y = 2.0 * math.pi / shape[2], shape[0], shape[1]
    w_x, w_y = shape[3] * w, shape[4] * w
    x_dot = w_x * a_x * math.cos(w_x * t)
    y_dot = w_y * a_y * math.cos(w_y * t)
    x = a_x * math.sin(w_x * t)
    y = a_y * math.sin(w_y * t)
    omega = (w_x * w_x * x * y_dot - w_y * w_y * y * x_dot) / (x_dot * x_dot + y_dot * y_dot)
    return Reference(x, y, math.atan2(y_dot, x_dot), math.hypot(x_dot, y_dot), omega)


def circle(t: float, shape: FloatArray) -> Reference:
    """Return posture and velocity on a circle at a time.

    Args:
        t: Time [s].
        shape: Centre x, y and radius [m]; angle of the place at t = 0 [rad]; angular velocity, positive
            counter-clockwise [rad/s].
    """
    angle = shape[3] + shape[4] * t
    c, s = math.cos(angle), math.sin(angle)
    turn = 1.0 if shape[4] > 0.0 else -1.0
    theta = math.atan2(turn * c, -turn * s)
    return Reference(shape[0] + shape[2] * c, shape[1] + shape[2] * s, theta, shape[2] * abs(shape[4]), shape[4])


def line(t: float, shape: FloatArray) -> Reference:
    """Return posture and velocity on a straight line at a time.

    Args:
        t: Time [s].
        shape: Place x, y at t = 0 [m]; direction [rad]; velocity [m/s].
    """
    way = shape[3] * t
    theta = math.atan2(math.sin(shape[2]), math.cos(shape[2]))
    return Reference(shape[0] + way * math.cos(theta), shape[1] + way * math.sin(theta), theta, shape[3], 0.0)


def spline(t: float, shape: FloatArray) -> Reference:
    """Return posture and velocity on a piecewise cubic path at a time.

    Before its first knot and behind its last one an open path goes on straight, at the velocity it has there: a
    reference must not stand still.

    Args:
        t: Time [s].
        shape: Number n of pieces; period [s], 0 for an open path; n + 1 knots [s]; and for each piece the coefficients
            of x and then of y, lowest power of the time since the piece's first knot first [m, m/s, m/s², m/s³].
    """
    n, period, first = int(shape[0]), shape[1], shape[2]
    if period > 0.0:
        t -= period * math.floor((t - first) / period)
    inside = min(max(t, first), shape[2 + n])
    low, high = 0, n
    while high - low > 1:
        middle = (low + high) // 2
        if shape[2 + middle] <= inside:
            low = middle
        else:
            high = middle
    c, tau = 3 + n + 8 * low, inside - shape[2 + low]
    x_dot = shape[c + 1] + tau * (2.0 * shape[c + 2] + tau * 3.0 * shape[c + 3])
    y_dot = shape[c + 5] + tau * (2.0 * shape[c + 6] + tau * 3.0 * shape[c + 7])
    x = shape[c] + tau * (shape[c + 1] + tau * (shape[c + 2] + tau * shape[c + 3]))
    y = shape[c + 4] + tau * (shape[c + 5] + tau * (shape[c + 6] + tau * shape[c + 7]))
    beyond, omega = t - inside, 0.0
    if beyond == 0.0:
        x_ddot = 2.0 * shape[c + 2] + 6.0 * tau * shape[c + 3]
        y_ddot = 2.0 * shape[c + 6] + 6.0 * tau * shape[c + 7]
        omega = (y_ddot * x_dot - x_ddot * y_dot) / max(x_dot * x_dot + y_dot * y_dot, 1e-300)
    return Reference(x + beyond * x_dot, y + beyond * y_dot, math.atan2(y_dot, x_dot), math.hypot(x_dot, y_dot), omega)
