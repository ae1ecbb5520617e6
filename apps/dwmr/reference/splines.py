"""Cubic splines through points of the plane, their length, and the speed along them."""

from __future__ import annotations

from typing import Any

import numpy as np

from dwmr.core.arrays import FloatArray

#: Points of the Gauss-Legendre rule for the length of one piece; 1e-9 of it where pieces turn by less than 90°.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
#: Parts into which the way between two waypoints is cut.
PARTS = 32


def cubic(t: FloatArray, values: FloatArray, closed: bool) -> FloatArray:
    """Return the cubic spline through values at times.

    Args:
        t: Increasing knots, shape (n + 1,).
        values: Values at the knots, shape (n + 1, m); for a closed spline the last row equals the first.
        closed: Whether slope and curvature agree at both ends. Those of an open spline have no curvature there, so that
            a straight continuation is as smooth as the spline itself.

    Returns:
        Coefficients of each piece, shape (n, m, 4), lowest power of the time since the piece's first knot first.
    """
    h, n = np.diff(t)[:, None], len(t) - 1
    slope = np.diff(values, axis=0) / h
    second = _periodic(h, slope) if closed else _natural(h, slope)
    left, right = second[:n], second[1:]
    return np.stack(
        [values[:n], slope - h * (2.0 * left + right) / 6.0, left / 2.0, (right - left) / (6.0 * h)], axis=-1
    )


def _natural(h: FloatArray, slope: FloatArray) -> FloatArray:
    """Return the second derivatives at the knots; they are zero at the ends."""
    second = np.zeros((len(h) + 1, slope.shape[1]))
    if len(h) > 1:
        second[1:-1] = _tridiagonal(h[1:-1, 0], 2.0 * (h[:-1, 0] + h[1:, 0]), 6.0 * np.diff(slope, axis=0))
    return second


def _periodic(h: FloatArray, slope: FloatArray) -> FloatArray:
    """Return the second derivatives at the knots of a closed spline, by Sherman's and Morrison's formula."""
    before = np.roll(h, 1)
    right = 6.0 * (slope - np.roll(slope, 1, axis=0))
    diagonal, corner = 2.0 * (before + h)[:, 0], h[-1, 0]
    gamma = -diagonal[0]
    diagonal[0] -= gamma
    diagonal[-1] -= corner * corner / gamma
    u = np.zeros((len(h), 1))
    u[0], u[-1] = gamma, corner
    both = _tridiagonal(h[:-1, 0], diagonal, np.hstack([right, u]))
    y, z = both[:, :-1], both[:, -1:]
    share = (y[:1] + corner / gamma * y[-1:]) / (1.0 + z[0] + corner / gamma * z[-1])
    second = y - share * z
    return np.vstack([second, second[:1]])


def _tridiagonal(beside: FloatArray, diagonal: FloatArray, right: FloatArray) -> FloatArray:
    """Solve a symmetric tridiagonal system, diagonally dominant, for several right sides, shape (n, m)."""
    side, middle, rows = beside.tolist(), diagonal.tolist(), right.copy()
    for k in range(1, len(middle)):
        share = side[k - 1] / middle[k - 1]
        middle[k] -= share * side[k - 1]
        rows[k] -= share * rows[k - 1]
    rows[-1] /= middle[-1]
    for k in range(len(middle) - 2, -1, -1):
        rows[k] = (rows[k] - side[k] * rows[k + 1]) / middle[k]
    return rows


def velocity(coefficients: FloatArray, tau: FloatArray) -> FloatArray:
    """Return the derivative of each piece at times since its first knot, shape (n, k) -> (n, k, m)."""
    c = coefficients[:, None]
    s = tau[:, :, None]
    result: FloatArray = c[..., 1] + s * (2.0 * c[..., 2] + s * 3.0 * c[..., 3])
    return result


def slowest(t: FloatArray, coefficients: FloatArray) -> tuple[float, float]:
    """Return the least speed along a path and where on the axis of `t` it is.

    The square of the speed is a polynomial on each piece; its extrema are looked for only where the speed between
    samples can lie below the least sample.

    Args:
        t: Knots, shape (n + 1,).
        coefficients: From `cubic`, shape (n, 2, 4).
    """
    h = np.diff(t)
    tau = np.linspace(0.0, 1.0, 9) * h[:, None]
    speed = np.linalg.norm(velocity(coefficients, tau), axis=-1)
    piece, sample = divmod(int(np.argmin(speed)), speed.shape[1])
    least, where = float(speed[piece, sample]), float(t[piece] + tau[piece, sample])
    # acceleration is linear on a piece, so it is greatest at an end
    ends = 2.0 * coefficients[..., 2, None] + 6.0 * coefficients[..., 3, None] * tau[:, None, [0, -1]]
    hardest = np.linalg.norm(ends, axis=1).max(axis=1)
    for k in np.flatnonzero(speed.min(axis=1) - hardest * h / 16.0 < least):
        for at in _extrema(coefficients[k], h[k]):
            value = float(np.linalg.norm(velocity(coefficients[k : k + 1], np.array([[at]]))))
            if value < least:
                least, where = value, float(t[k] + at)
    return least, where


def _extrema(piece: FloatArray, h: float) -> list[float]:
    """Return where inside one piece the speed may be least."""
    square: Any = np.polynomial.Polynomial([0.0])
    for _, b, c, d in piece:
        square += np.polynomial.Polynomial([b, 2.0 * c, 3.0 * d]) ** 2
    return [float(r.real) for r in square.deriv().roots() if abs(r.imag) < 1e-6 * h and 0.0 < r.real < h]


def lengths(t: FloatArray, coefficients: FloatArray) -> FloatArray:
    """Return the length of each piece of a path, shape (n,)."""
    h = np.diff(t)[:, None]
    speed = np.linalg.norm(velocity(coefficients, 0.5 * h * (_NODES + 1.0)), axis=-1)
    result: FloatArray = 0.5 * h[:, 0] * (speed @ _WEIGHTS)
    return result


def by_length(u: FloatArray, coefficients: FloatArray, closed: bool) -> tuple[FloatArray, FloatArray]:
    """Return the same path with its length as the parameter, so that the speed along it is nearly constant.

    Args:
        u: Knots, shape (n + 1,).
        coefficients: From `cubic`, shape (n, 2, 4).
        closed: Whether the path is closed.

    Returns:
        Lengths at the knots, shape (PARTS n + 1,) [m]; coefficients of the pieces between them.
    """
    total = np.concatenate([[0.0], np.cumsum(lengths(u, coefficients))])
    knots, places = [total[:1]], [_position(coefficients[0], np.zeros(1))]
    for k, piece in enumerate(coefficients):
        s, tau = _cut(piece, float(u[k + 1] - u[k]))
        knots.append(total[k] + s / s[-1] * (total[k + 1] - total[k]))
        places.append(_position(piece, tau))
    points = np.vstack(places)
    if closed:
        points[-1] = points[0]
    s_knots = np.concatenate(knots)
    return s_knots, cubic(s_knots, points, closed)


def _cut(piece: FloatArray, h: float) -> tuple[FloatArray, FloatArray]:
    """Cut one piece into `PARTS`; return lengths from its begin to their ends, and the times of those."""
    at = np.linspace(0.0, h, PARTS + 1)
    cells = np.diff(at)[:, None]
    tau = at[:-1, None] + 0.5 * cells * (_NODES + 1.0)
    speed = np.linalg.norm(velocity(piece[None], tau.reshape(1, -1)), axis=-1).reshape(tau.shape)
    return np.cumsum(0.5 * cells[:, 0] * (speed @ _WEIGHTS)), at[1:]


def _position(piece: FloatArray, tau: FloatArray) -> FloatArray:
    s = tau[:, None]
    result: FloatArray = piece[:, 0] + s * (piece[:, 1] + s * (piece[:, 2] + s * piece[:, 3]))
    return result
