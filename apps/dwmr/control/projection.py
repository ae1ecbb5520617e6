"""Projection of velocities onto an intersection of half-spaces, with a dual active-set method."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from dwmr.core.arrays import FloatArray
from dwmr.core.jit import compiled

#: A constraint that is broken by less is met [m/s].
TOLERANCE = 1e-9
#: Least squared part of a normal outside the span of the active ones; one with less depends on them [-].
DEPENDENT = 1e-10
#: What `_solve` returns for a solution, and for a search that does not end.
SOLVED, ENDLESS = -1, -2


class HalfSpaces(NamedTuple):
    """Linear constraints on the velocities of robots, each about one robot or two.

    Row k reads `normals[k, :2] · y[a] + normals[k, 2:] · y[b] >= bounds[k]` for the robots a, b of `robots[k]`; a row
    about one robot names it twice and has zeros for the second.

    Attributes:
        robots: Numbers of robots, shape (m, 2).
        normals: Coefficients, shape (m, 4) [-].
        bounds: Shape (m,) [m/s].
        shortfalls: By how much each bound was lowered to make them consistent, shape (m,) [m/s]; written.
    """

    robots: Any
    normals: FloatArray
    bounds: FloatArray
    shortfalls: FloatArray


class ActiveSet(NamedTuple):
    """Working memory of the projection, for up to K = 2n + 1 active constraints of n robots.

    Attributes:
        rows: Numbers of the active constraints, shape (K,).
        multipliers: Their Lagrange multipliers, shape (K,).
        factor: Cholesky factor of their Gram matrix, shape (K, K).
        shares: Coefficients of a new constraint's normal in theirs, shape (K,).
    """

    rows: Any
    multipliers: FloatArray
    factor: FloatArray
    shares: FloatArray


def half_spaces(count: int) -> HalfSpaces:
    """Return room for some constraints."""
    return HalfSpaces(np.zeros((count, 2), dtype=np.int64), np.zeros((count, 4)), np.zeros(count), np.zeros(count))


def active_set(robots: int) -> ActiveSet:
    """Return working memory for some robots."""
    most = 2 * robots + 1
    return ActiveSet(np.zeros(most, dtype=np.int64), np.zeros(most), np.zeros((most, most)), np.zeros(most))


@compiled
def project(wanted: FloatArray, spaces: HalfSpaces, count: int, hard: int, active: ActiveSet, y: FloatArray) -> bool:
    """Write the velocities nearest to the wanted ones that meet all constraints.

    Constraints that contradict one another are lowered by as little as makes them consistent: each contradiction that
    is found, by the same amount for all of its constraints but the hard ones. This is the least largest amount by which
    the constraints of that contradiction are broken.

    Args:
        wanted: Shape (n, 2) [m/s].
        spaces: Constraints; `shortfalls` is written.
        count: How many there are.
        hard: How many of them, the first ones, are never lowered; they must be consistent.
        active: Working memory.
        y: Shape (n, 2) [m/s]; written.

    Returns:
        Whether all constraints can be met.

    Source:
        Goldfarb, Idnani, "A numerically stable dual method for solving strictly convex quadratic programs", 1983, for
        the identity as Hessian; the lowering is the dual ray of an infeasible step (lemma of Farkas).
    """
    for k in range(count):
        spaces.shortfalls[k] = 0.0
    for attempt in range(10 + 2 * count):
        blocked, size = _solve(wanted, spaces, count, active, y)
        if blocked == SOLVED:
            return attempt == 0
        if blocked == ENDLESS or not _lower(spaces, hard, active, size, blocked):
            break
    # unreachable but for rounding: stay at rest, and return by how much that breaks constraints
    for i in range(y.shape[0]):
        y[i, 0] = y[i, 1] = 0.0
    for k in range(count):
        spaces.shortfalls[k] = max(0.0, spaces.bounds[k])
    return False


@compiled
def _solve(wanted: FloatArray, spaces: HalfSpaces, count: int, active: ActiveSet, y: FloatArray) -> tuple[int, int]:
    """Solve for the lowered bounds.

    Returns:
        `SOLVED`, `ENDLESS` or the number of a constraint that contradicts the active ones, and how many are active.
    """
    for i in range(y.shape[0]):
        y[i, 0], y[i, 1] = wanted[i, 0], wanted[i, 1]
    size = 0
    for _ in range(20 + 10 * count):
        new = _most_broken(spaces, count, y)
        if new < 0:
            return SOLVED, size
        multiplier = 0.0
        while True:
            left = _decompose(spaces, active, size, new)
            drop, step = -1, math.inf
            for c in range(size):
                if active.shares[c] > DEPENDENT and active.multipliers[c] < step * active.shares[c]:
                    drop, step = c, active.multipliers[c] / active.shares[c]
            full = math.inf
            if left > DEPENDENT:
                full = _broken_by(spaces, new, y) / left
            if full == math.inf and drop < 0:
                return new, size
            step = min(step, full)
            if left > DEPENDENT:
                _move(spaces, new, step, y)
                for c in range(size):
                    _move(spaces, active.rows[c], -step * active.shares[c], y)
            for c in range(size):
                active.multipliers[c] -= step * active.shares[c]
            multiplier += step
            if step == full:
                active.rows[size], active.multipliers[size] = new, multiplier
                size += 1
                break
            size -= 1
            for c in range(drop, size):
                active.rows[c], active.multipliers[c] = active.rows[c + 1], active.multipliers[c + 1]
    return ENDLESS, size


@compiled
def _lower(spaces: HalfSpaces, hard: int, active: ActiveSet, size: int, new: int) -> bool:
    """Lower the bounds of a contradiction: of normals that cancel, each times a positive share, while bounds do not."""
    excess, weight = spaces.bounds[new] - spaces.shortfalls[new], 1.0 if new >= hard else 0.0
    for c in range(size):
        k, share = active.rows[c], max(0.0, -active.shares[c])
        excess += share * (spaces.bounds[k] - spaces.shortfalls[k])
        if k >= hard:
            weight += share
    if not weight > 0.0:
        return False
    by = max(excess, 0.0) / weight + TOLERANCE
    if new >= hard:
        spaces.shortfalls[new] += by
    for c in range(size):
        k = active.rows[c]
        if k >= hard and active.shares[c] < -DEPENDENT:
            spaces.shortfalls[k] += by
    return True


@compiled
def _broken_by(spaces: HalfSpaces, k: int, y: FloatArray) -> float:
    """Return by how much a constraint with its lowered bound is broken, negative where it is met [m/s]."""
    a, b, normal = spaces.robots[k, 0], spaces.robots[k, 1], spaces.normals[k]
    by: float = spaces.bounds[k] - spaces.shortfalls[k]
    by -= normal[0] * y[a, 0] + normal[1] * y[a, 1] + normal[2] * y[b, 0] + normal[3] * y[b, 1]
    return by


@compiled
def _most_broken(spaces: HalfSpaces, count: int, y: FloatArray) -> int:
    """Return the number of the constraint that is broken most, −1 where all are met."""
    worst, most = -1, TOLERANCE
    for k in range(count):
        by = _broken_by(spaces, k, y)
        if by > most:
            worst, most = k, by
    return worst


@compiled
def _move(spaces: HalfSpaces, k: int, step: float, y: FloatArray) -> None:
    """Move the velocities along the normal of a constraint."""
    a, b, normal = spaces.robots[k, 0], spaces.robots[k, 1], spaces.normals[k]
    y[a, 0] += step * normal[0]
    y[a, 1] += step * normal[1]
    y[b, 0] += step * normal[2]
    y[b, 1] += step * normal[3]


@compiled
def _product(spaces: HalfSpaces, j: int, k: int) -> float:
    """Return the inner product of two constraints' normals [-]."""
    total = 0.0
    for p in range(2):
        for q in range(2):
            if spaces.robots[j, p] == spaces.robots[k, q]:
                total += spaces.normals[j, 2 * p] * spaces.normals[k, 2 * q]
                total += spaces.normals[j, 2 * p + 1] * spaces.normals[k, 2 * q + 1]
    return total


@compiled
def _decompose(spaces: HalfSpaces, active: ActiveSet, size: int, new: int) -> float:
    """Write the shares of the active normals in a new one; return the square of its remaining length [-]."""
    factor, shares = active.factor, active.shares
    for r in range(size):
        for c in range(r + 1):
            rest = _product(spaces, active.rows[r], active.rows[c])
            for e in range(c):
                rest -= factor[r, e] * factor[c, e]
            factor[r, c] = math.sqrt(max(rest, DEPENDENT)) if r == c else rest / factor[c, c]
    left = _product(spaces, new, new)
    for r in range(size):
        rest = _product(spaces, active.rows[r], new)
        for e in range(r):
            rest -= factor[r, e] * shares[e]
        shares[r] = rest / factor[r, r]
        left -= shares[r] * shares[r]
    for r in range(size - 1, -1, -1):
        for e in range(r + 1, size):
            shares[r] -= factor[e, r] * shares[e]
        shares[r] /= factor[r, r]
    return left
