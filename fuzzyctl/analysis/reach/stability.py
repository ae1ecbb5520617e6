"""Proofs that every member of a family converges: the map of a period contracts a set that holds all of them.

All states of a loop, those of plants and controllers, are one vector z; a period maps z to F(z). If the derivatives of
F over a ball D of some norm are at most q < 1 in this norm, and F maps D into itself, then F has one fixed point in D,
and each run that is in D converges to it, its distance shrinking by q each period (Banach). The norm is Euclidean in
the coordinates of the modes of the loop; an exact bound decides, the modes only propose.

Source:
    Lohmiller, Slotine: On contraction analysis for non-linear systems, 1998; Banach's fixed-point theorem.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Final, NamedTuple

import numpy as np

from fuzzyctl.analysis.reach import forms
from fuzzyctl.analysis.reach.flow import NoTubeError
from fuzzyctl.analysis.reach.forms import Form, Value, as_form, ends, hulled, interval
from fuzzyctl.analysis.reach.reach import ReachableSets
from fuzzyctl.analysis.reach.series import Series
from fuzzyctl.analysis.reach.slopes import Slopes

#: Terms of the series of the derivatives of a step.
_TERMS: Final = 8
#: How often the step is cut for them at most.
_PARTS: Final = 64


class Contraction(NamedTuple):
    """A ball that a period maps into itself.

    Args:
        rate: The largest factor by which distances shrink in a period.
        radius: The radius of the ball in the coordinates of the modes.
        centre: Of the states, those of plants first.
        modes: Columns: the coordinates.
    """

    rate: float
    radius: float
    centre: Form
    modes: Form


def contraction(
    sets: ReachableSets, rows: Sequence[Form], free: Sequence[Value], motion: tuple[Form, Form] | None
) -> Contraction | None:
    """Return a ball that holds some states, and that a period of the loop contracts; None if none is proved.

    Args:
        sets: The loop, its equations without time.
        rows: The states of one box.
        free: Values of its free params.
        motion: How a set moves in a period, see `sets.modes`.

    Raises:
        DomainError, NoTubeError: If no bound of the derivatives is known there.
    """
    if motion is None:
        return None
    largest = np.abs(motion[1]).max(0)  # not the norm, which underflows for states that stay constant
    modes = motion[1] / np.where(largest > 0.0, largest, 1.0)
    if not np.all(np.isfinite(modes)):
        return None
    exact = _inverted([[Fraction(x) for x in row] for row in modes.tolist()])
    if exact is None:
        return None
    inverse = np.array([[float(x) for x in row] for row in exact])
    centre = np.stack(rows)[:, 0, 0]
    whole = np.stack(rows)[:, 0, :]
    apart = np.concatenate([whole[:, 1:2] * np.eye(len(rows)), whole[:, 2:]], 1)
    sides = np.abs(inverse @ apart).sum(1) + 1e-14 * (np.abs(inverse) @ np.abs(apart)).sum(1)
    radius = float(np.sqrt((sides**2).sum())) * (1.0 + 1e-9)
    fixed = [hulled(as_form(f)) for f in free]
    for _ in range(4):
        reach = np.sqrt((modes**2).sum(1)) * radius * (1.0 + 1e-9) + 1e-12 * (1.0 + np.abs(centre))
        ball = [interval(np.array([c - w]), np.array([c + w])) for c, w in zip(centre, reach, strict=True)]
        slopes = period_slopes(sets, ball, fixed)
        rate = norm_bound(slopes, modes)
        if not rate < 1.0:
            return None
        moved = _image(sets, [np.array([[c, 0.0]]) for c in centre], fixed)
        low, high = (np.array([float(e[0]) for e in x]) for x in zip(*map(ends, moved), strict=True))
        shift = np.maximum(np.abs(low - centre), np.abs(high - centre))
        drift = float(np.linalg.norm(np.abs(inverse) @ shift)) * (1.0 + 1e-9)
        needed = drift / (1.0 - rate) * (1.0 + 1e-9)
        if needed <= radius:
            return Contraction(rate, radius, centre, modes)
        radius = 1.05 * needed
    return None


def _image(sets: ReachableSets, rows: Sequence[Form], free: Sequence[Value]) -> list[Form]:
    """Return the states after a period."""
    count = len(sets.plant)
    results: list[list[Form]] = []

    def keep(_: int, states: list[Form]) -> None:
        results.append(states)

    for _ in sets.run(list(rows[:count]), list(rows[count:]), free, 0, keep):
        pass
    return results[-1]


def period_slopes(sets: ReachableSets, rows: Sequence[Form], free: Sequence[Value]) -> Form:
    """Return the derivatives of the states after a period by those at its begin, shape (states, states, 2).

    Between samples the derivatives X of a plant's states by something obey X' = A X + B with A and B those of the
    equations along the solution: X is enclosed by the series of Peano and Baker, whose integrals lie in the products of
    the intervals that hold A and B.
    """
    count, size = len(sets.plant), len(rows)
    plant, memory = list(rows[:count]), list(rows[count:])
    flags = [1.0] * len(sets.equations.rates)
    inputs: list[Value] = [0.0, *plant, *memory, *free, *flags]
    sampled = Slopes(sets.sample, [*sets.plant, *sets.memory])
    control = sampled.over(inputs)
    results = Series(sets.sample, inputs).extend()
    outputs = [as_form(v) for v in results[: len(sets.held)]]
    length = sets.equations.step
    between = Slopes(sets.flow.nodes, [*sets.plant, *sets.held])
    tube, parts = plant, 1
    while True:
        try:
            tube = _tubes(sets, plant, [*outputs, *free, *memory], parts)
            break
        except NoTubeError:
            if parts >= _PARTS:
                raise
            parts *= 2
    slopes = between.over([np.array([[0.5 * length, 0.5 * length]]), *tube, *outputs, *free, *memory])
    a, b = slopes[:, :count], slopes[:, count:]
    moved = _series(a, length, forward=True)
    driven = _series(a, length, forward=False)
    total = np.zeros((size, size, 2))
    by_held = _product(driven, b)
    from_control = _product(by_held, control[: len(outputs)])
    total[:count] = from_control
    total[:count, :count] = as_form(forms.plus(moved, from_control[:, :count]))
    total[count:] = control[len(outputs) :]
    return total


def _tubes(sets: ReachableSets, plant: Sequence[Form], constants: Sequence[Value], parts: int) -> list[Form]:
    """Return intervals that hold the plants' states over a whole period."""
    length = sets.equations.step / parts
    states = list(plant)
    low: list[list[Form]] = []
    high: list[list[Form]] = []
    for part in range(parts):
        tube = sets.flow.tube(part * length, length, states, constants)
        end, _ = sets.flow.advance(part * length, length, states, constants)
        states = [hulled(e) for e in end]
        for ends_of, at in ((low, 0), (high, 1)):
            ends_of.append([ends(t)[at] for t in tube])
    least, most = np.array(low).min(0), np.array(high).max(0)
    return [interval(a, b) for a, b in zip(least, most, strict=True)]


def _series(a: Form, length: float, *, forward: bool) -> Form:
    """Return bounds of X(length) for X' = A X: from X = 1, or the integral of such solutions for a constant input."""
    size = len(a)
    identity = np.zeros((size, size, 2))
    identity[:, :, 0] = np.eye(size)
    term = identity if forward else as_form(forms.scaled(identity, length))
    total: Value = term
    divisor = 1 if forward else 2
    for _ in range(_TERMS):
        term = as_form(forms.scaled(_product(a, term), length / divisor))
        total = forms.plus(total, term)
        divisor += 1
    norm = float(np.max(np.abs(a[..., 0]) + a[..., 1])) * size * length
    if norm > 0.5 * divisor:
        raise NoTubeError
    rest = as_form(total).copy()
    last = float(np.max(np.abs(term[..., 0]) + term[..., 1]))
    rest[..., 1] += 2.0 * last * size * norm / divisor + 1e-300
    return rest


def _product(a: Form, b: Form) -> Form:
    """Return the product of two matrices of intervals."""
    total: Value = np.zeros((a.shape[0], b.shape[1], 2))
    for k in range(a.shape[1]):
        total = forms.plus(total, forms.times(a[:, k, None], b[None, k]))
    return as_form(total)


def norm_bound(slopes: Form, modes: Form) -> float:
    """Return a bound of the norm of all matrices J between some ends, as maps of vectors whose norm is |modes^-1 z|.

    Of the centre M the bound q is decided in rational arithmetic: q^2 - M' M is positive definite. Infinite for none.
    """
    size = len(slopes)
    exact_modes = [[Fraction(x) for x in row] for row in modes.tolist()]
    exact_inverse = _inverted(exact_modes)
    if exact_inverse is None:
        return math.inf
    centre = [[Fraction(x) for x in row] for row in slopes[..., 0].tolist()]
    middle = _matrix_product(exact_inverse, _matrix_product(centre, exact_modes))
    exact = np.array([[abs(float(x)) * (1.0 + 1e-15) for x in row] for row in exact_inverse])
    spread = exact @ slopes[..., 1] @ np.abs(modes) * (1.0 + 1e-12)
    apart = float(np.sqrt((spread**2).sum())) * (1.0 + 1e-12)
    proposed = float(np.linalg.norm(np.array([[float(x) for x in row] for row in middle]), 2))
    q = Fraction(proposed) + Fraction(1, 1 << 40)
    gram = _matrix_product([list(column) for column in zip(*middle, strict=True)], middle)
    rest = [[(q * q if i == k else Fraction(0)) - gram[i][k] for k in range(size)] for i in range(size)]
    return float(q) + apart + 1e-15 if is_positive_definite(rest) else math.inf


def is_positive_definite(matrix: Sequence[Sequence[Fraction]]) -> bool:
    """Return whether a symmetric matrix is positive definite, by the pivots of its factors L D L'."""
    rows = [list(row) for row in matrix]
    for k in range(len(rows)):
        if rows[k][k] <= 0:
            return False
        for i in range(k + 1, len(rows)):
            factor = rows[i][k] / rows[k][k]
            for j in range(k, len(rows)):
                rows[i][j] -= factor * rows[k][j]
    return True


def _matrix_product(a: Sequence[Sequence[Fraction]], b: Sequence[Sequence[Fraction]]) -> list[list[Fraction]]:
    columns = list(zip(*b, strict=True))
    return [[sum((x * y for x, y in zip(row, c, strict=True)), Fraction(0)) for c in columns] for row in a]


def _inverted(matrix: Sequence[Sequence[Fraction]]) -> list[list[Fraction]] | None:
    """Return the inverse of a matrix, None if it has none."""
    size = len(matrix)
    rows = [[*row, *(Fraction(i == k) for k in range(size))] for i, row in enumerate(matrix)]
    for k in range(size):
        pivot = max(range(k, size), key=lambda i: abs(rows[i][k]))
        if rows[pivot][k] == 0:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(size):
            if i != k and rows[i][k]:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[size:] for row in rows]
