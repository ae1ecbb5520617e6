"""Zonotopes of several signals, and their reduction to fewer symbols."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from fuzzyctl.analysis.reach import forms
from fuzzyctl.analysis.reach.forms import Form

#: Symbols per signal from which on they are reduced, and to which.
MOST: Final = 60
LEFT: Final = 30
#: Least radius of a parallelotope relative to its states, and by which part it is wider than the set.
_LEAST: Final = 1e-9
_WIDER: Final = 0.02
#: After how many steps the boxes of several bases are compared.
AHEAD: Final = (1, 10, 40)


@dataclass
class Dimension:
    """A start of a state, or a param, that varies over the family; `state` is empty for a param."""

    name: str
    low: float
    high: float
    state: str = ""


def with_symbols(rows: Sequence[Form], kept: int = 0) -> list[Form]:
    """Return signals whose own errors are symbols, behind the first ones that are `kept` for other signals."""
    width = max(2 + kept, *(r.shape[-1] for r in rows))
    stacked = np.stack([forms.widened(r, width) for r in rows])
    errors = stacked[..., 1]
    new = np.zeros((*stacked.shape[:-1], len(rows)))
    for k in range(len(rows)):
        new[k, :, k] = errors[k]
    used = new.any(axis=(0, 1))
    stacked[..., 1] = 0.0
    return list(np.concatenate([stacked, new[..., used]], -1))


def is_long(rows: Sequence[Form], kept: int) -> bool:
    """Return whether signals have enough symbols to reduce them."""
    return bool(max(r.shape[-1] for r in rows) - 2 - kept > MOST * len(rows))


def reduced(rows: Sequence[Form], kept: int, motion: tuple[Form, Form] | None = None) -> list[Form]:
    """Return signals with fewer symbols that hold the same values and more.

    Args:
        rows: Without independent errors.
        kept: How many of the first symbols stay.
        motion: The matrix by which the set moves in a step, and the basis of its modes.
    """
    count = len(rows)
    stacked = np.stack(rows)
    if not is_long(rows, kept):
        return list(rows)
    head, tail = stacked[..., : 2 + kept], stacked[..., 2 + kept :]
    left = LEFT * count
    results = np.zeros((count, stacked.shape[1], 2 + kept + left + count))
    results[..., : 2 + kept] = head
    for box in range(stacked.shape[1]):
        g = tail[:, box, :]
        scale = np.maximum(np.abs(g).sum(1), 1e-300)
        sized = g / scale[:, None]
        order = np.argsort(np.abs(sized).sum(0) - np.abs(sized).max(0))
        small, large = g[:, order[: g.shape[1] - left]], g[:, order[g.shape[1] - left :]]
        columns, slack = _boxed(small, scale, motion)
        results[:, box, 2 + kept : 2 + kept + left] = large
        results[:, box, 2 + kept + left :] = columns
        results[:, box, 1] += slack
    return list(results)


def modes(before: Sequence[Form], after: Sequence[Form]) -> tuple[Form, Form] | None:
    """Return the matrix by which a set moved into another, from their common symbols, and a real basis of its modes.

    They only propose a basis: the reduced set holds the whole one for any basis. None if no modes are known.
    """
    width = min(before[0].shape[-1], after[0].shape[-1])
    old, new = (np.stack([r[0, 2:width] for r in rows]) for rows in (before, after))
    scale = np.maximum(np.abs(old).sum(1), 1e-300)
    try:
        matrix = np.linalg.lstsq((old / scale[:, None]).T, (new / scale[:, None]).T, rcond=1e-10)[0].T
        _, vectors = np.linalg.eig(matrix)
    except np.linalg.LinAlgError:
        return None
    columns = []
    for v in vectors.T:
        if np.abs(v.imag).max() < 1e-12:
            columns.append(v.real)
        elif v.imag[np.argmax(np.abs(v.imag))] > 0.0:
            columns += [v.real, v.imag]
    basis = np.stack(columns, -1) if len(columns) == len(old) else None
    if basis is None or not np.all(np.isfinite(basis)) or np.linalg.cond(basis) > 1e8:
        return None
    return matrix * scale[:, None] / scale, basis * scale[:, None]


class Parallelotope:
    """A set of states that is spanned by as many symbols as there are states, beside those that stay as they are.

    Args:
        rows: States of one box, without independent errors.
        kept: How many of the first symbols stay.
        motion: See `reduced`.
    """

    def __init__(self, rows: Sequence[Form], kept: int, motion: tuple[Form, Form] | None) -> None:
        stacked = np.stack(rows)[:, 0, :]
        self.centre, self.kept = stacked[:, 0], stacked[:, 2 : 2 + kept]
        tail = stacked[:, 2 + kept :]
        scale = np.maximum(np.abs(tail).sum(1), _LEAST * (1.0 + np.abs(self.centre)))
        columns, slack = _boxed(np.concatenate([tail, np.diag(_LEAST * scale)], 1), scale, motion)
        self.columns, self.slack = columns * (1.0 + _WIDER), slack + stacked[:, 1]

    @property
    def rows(self) -> list[Form]:
        """The states as forms."""
        whole = np.concatenate([self.centre[:, None], self.slack[:, None], self.kept, self.columns], 1)
        return list(whole[:, None, :])

    def holds(self, rows: Sequence[Form]) -> bool:
        """Return whether a set lies inside, for each value of the symbols that stay."""
        width = self.kept.shape[1]
        stacked = np.stack(rows)[:, 0, :]
        shift = np.concatenate([stacked[:, :1] - self.centre[:, None], stacked[:, 2 : 2 + width] - self.kept], 1)
        apart = np.concatenate([shift, stacked[:, 2 + width :]], 1)
        try:
            inverse = np.linalg.inv(self.columns)
        except np.linalg.LinAlgError:
            return False
        rounding = 1e-15 * len(rows) * (np.abs(inverse) @ np.abs(self.columns) + 1.0)
        wrong = (np.abs(np.eye(len(rows)) - inverse @ self.columns) + rounding).sum(1).max()
        inside = np.abs(inverse @ apart).sum(1) + np.abs(inverse) @ (stacked[:, 1] + 1e-14 * np.abs(apart).sum(1))
        rounding = 1e-14 * len(rows) * (np.abs(inverse) @ np.abs(apart).sum(1))
        return bool(np.all((inside + rounding) * (1.0 + 1e-12) <= 1.0 - wrong))


@np.errstate(all="ignore")
def _boxed(g: Form, scale: Form, motion: tuple[Form, Form] | None) -> tuple[Form, Form]:
    """Return the columns of a parallelotope that holds a zonotope, and what rounding adds to each signal."""
    sized = g / scale[:, None]
    principal = np.linalg.svd(sized, full_matrices=False)[0]
    tried = [principal, np.eye(len(g))]
    ahead = [np.eye(len(g))]
    if motion is not None:
        tried.append(motion[1] / scale[:, None])
        matrix = motion[0] * scale / scale[:, None]
        ahead += [np.linalg.matrix_power(matrix, k) for k in AHEAD]
    best: tuple[float, Form, Form] | None = None
    for basis in tried:
        if basis.shape != (len(g), len(g)):
            continue
        try:
            inside = np.linalg.solve(basis, sized)
        except np.linalg.LinAlgError:
            continue
        lengths = np.abs(inside).sum(1)
        rest = np.abs(sized - basis @ inside).sum(1) + 1e-15 * len(g) * (np.abs(basis) @ lengths)
        size = sum(float((np.abs(a @ basis) @ lengths).sum()) for a in ahead) + float(rest.sum())
        if np.isfinite(size) and (best is None or size < best[0]):
            best = size, basis * lengths * (1.0 + 1e-15 * (10 + sized.shape[1])), rest
    assert best is not None
    return best[1] * scale[:, None], best[2] * scale * (1.0 + 1e-14)


def widest(low: Form, high: Form) -> int:
    """Return the longest side of a box beside the size of its numbers, -1 if none has a length."""
    lengths = (high - low) / np.maximum(np.abs(low), np.abs(high) + 1e-300)
    return int(np.argmax(lengths)) if lengths.any() else -1


def halves(low: Form, high: Form, side: int) -> list[tuple[Form, Form]]:
    """Return the two halves of a box along a side."""
    middle = 0.5 * (low[side] + high[side])
    first, last = high.copy(), low.copy()
    first[side] = last[side] = middle
    return [(low, first), (last, high)]
