"""Proof of claims about slopes of multilinear systems at the corners of cells, in rational arithmetic."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import pairwise, product
from typing import Final

from fuzzyctl.analysis.claims import Claim, Slope
from fuzzyctl.analysis.multilinear.surface import Surface
from fuzzyctl.analysis.verdicts import Proved, Refuted, Undecided, Verdict
from fuzzyctl.analysis.witnesses import Judge
from fuzzyctl.model.system import FuzzySystem

#: Two corners, the one before the other along an input.
Pair = tuple[tuple[int, ...], tuple[int, ...]]

#: What must not rise, as multiples of the output.
_SIGNS: Final = {"increasing": (-1,), "decreasing": (1,), "lipschitz": (1, -1)}


def steepest(surface: Surface, output: int, k: int) -> Fraction:
    """Return a bound of the slope of an output along the input at position k of the surface's inputs."""
    most = Fraction(0)
    if surface.is_unity[output]:
        for row in _rows(surface, k):
            for a, b in pairwise(row):
                rise = surface.sums_at(output, b)[0] - surface.sums_at(output, a)[0]
                most = max(most, abs(rise) / (surface.corners[k][b[k]] - surface.corners[k][a[k]]))
        return most
    # (V / W)' = (V' - W' F) / W, and V' - W' F is at most the largest |Σ w' (c - F)|.
    low, high = (Fraction(e) for e in surface.hull(output))
    middle = (low + high) / 2
    least = min(surface.sums_at(output, c)[1] for c in surface.indices)
    for row in _rows(surface, k):
        for a, b in pairwise(row):
            run = surface.corners[k][b[k]] - surface.corners[k][a[k]]
            (v0, w0), (v1, w1) = surface.sums_at(output, a), surface.sums_at(output, b)
            most = max(most, (abs(v1 - v0 - middle * (w1 - w0)) + abs(w1 - w0) * (high - low) / 2) / run)
    return most / least


def decide_slope(system: FuzzySystem, surface: Surface, claim: Claim, slope: Slope, judge: Judge) -> Verdict | None:
    """Decide a word about slopes over all inputs; None for a quotient of two sums whose slopes corners do not show."""
    output = [o.name for o in system.outputs].index(slope.output)
    position = [i.name for i in system.inputs].index(slope.input)
    error = surface.errors[output]
    if position not in surface.inputs:
        return Proved(claim.text)
    k = surface.inputs.index(position)
    if not surface.is_unity[output]:
        return _of_quotient(surface, output, k, claim, slope)
    worst, pair = _worst(surface, output, k, slope)
    if worst <= slope.tolerance:
        if worst + 2 * error <= slope.tolerance:
            return Proved(claim.text)
        if slope.tolerance:
            return Undecided(
                claim.text,
                f"numbers that kernels return may be off by {float(error):.1e}; a wider tolerance would decide it",
            )
        return Proved(claim.text, note=f"in exact arithmetic; kernels round by up to {float(error):.1e}")
    assert pair is not None
    points = [_full(system, surface, c) for c in pair]
    witness = judge.broken_slope(slope, points[0], points[1][position], error)
    if witness is not None:
        return Refuted(claim.text, witness)
    return Undecided(
        claim.text,
        f"it is broken by {float(worst):.1e}, less than rounding in kernels can show; 'within' would decide it",
    )


def _of_quotient(surface: Surface, output: int, k: int, claim: Claim, slope: Slope) -> Verdict | None:
    """Prove that a quotient V / W of two multilinear sums does not fall, or not rise, along an input.

    V' W - V W' does not depend on that input within a cell, and is quadratic in each other one: it has one sign if its
    Bernstein coefficients have.
    """
    if slope.word == "lipschitz":
        return None
    sign = 1 if slope.word == "increasing" else -1
    sides = [[(i, i + 1) for i in range(len(c) - 1)] if len(c) > 1 else [(0, 0)] for c in surface.corners]
    for cell in product(*sides):
        if any(sign * c < 0 for c in _coefficients(surface, output, k, cell)):
            return None
    error = surface.errors[output]
    if 2 * error <= slope.tolerance:
        return Proved(claim.text)
    return Proved(claim.text, note=f"in exact arithmetic; kernels round by up to {float(error):.1e}")


def _coefficients(surface: Surface, output: int, k: int, cell: Sequence[tuple[int, int]]) -> Iterator[Fraction]:
    """Yield the Bernstein coefficients of V' W - V W' in a cell, but for positive factors."""
    others = [tuple(dict.fromkeys(ends)) if j != k else (0,) for j, ends in enumerate(cell)]
    totals: dict[tuple[int, ...], Fraction] = {}
    for a, b in product(product(*others), repeat=2):
        (v0, w0), (v1, w1) = (
            surface.sums_at(output, (*corner[:k], end, *corner[k + 1 :]))
            for corner, end in ((a, cell[k][0]), (b, cell[k][1]))
        )
        index = tuple(
            (x != cell[j][0]) + (y != cell[j][0]) for j, (x, y) in enumerate(zip(a, b, strict=True)) if j != k
        )
        totals[index] = totals.get(index, Fraction(0)) + v1 * w0 - v0 * w1
    yield from totals.values()


def _worst(surface: Surface, output: int, k: int, slope: Slope) -> tuple[Fraction, Pair | None]:
    """Return by how much a word is broken at most, and by which two corners.

    For given other inputs the output is straight between corners; along these it is multilinear, and how far it
    rises from one corner to a later one is largest at their corners.
    """
    worst, pair = Fraction(0), None
    steepness = Fraction(slope.limit)
    for row in _rows(surface, k):
        values = [surface.sums_at(output, c)[0] for c in row]
        for sign in _SIGNS[slope.word]:
            tilted = [sign * v - steepness * x for v, x in zip(values, surface.corners[k], strict=True)]
            lowest = 0
            for j in range(1, len(row)):
                lowest = lowest if tilted[lowest] <= tilted[j - 1] else j - 1
                if tilted[j] - tilted[lowest] > worst:
                    worst, pair = tilted[j] - tilted[lowest], (row[lowest], row[j])
    return worst, pair


def _rows(surface: Surface, k: int) -> Iterator[list[tuple[int, ...]]]:
    """Yield the corners along one input, for each choice of the corners of the others."""
    others = [range(len(c)) if j != k else range(1) for j, c in enumerate(surface.corners)]
    for start in product(*others):
        yield [(*start[:k], i, *start[k + 1 :]) for i in range(len(surface.corners[k]))]


def _full(system: FuzzySystem, surface: Surface, corner: tuple[int, ...]) -> list[float]:
    point = [system.number(v.lower) for v in system.inputs]
    for k, i in enumerate(surface.inputs):
        point[i] = float(surface.corners[k][corner[k]])
    return point
