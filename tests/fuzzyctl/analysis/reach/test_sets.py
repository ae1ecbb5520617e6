"""Reduced sets hold whole ones, and a set is inside of a parallelotope only if it is."""

from fractions import Fraction

import numpy as np
import pytest

from fuzzyctl.analysis.reach import sets
from fuzzyctl.analysis.reach.sets import Parallelotope, modes, reduced, with_symbols

KINDS = ["any", "a plane in space", "sizes apart", "nearly parallel", "one is 0", "all are 0"]


def drawn(kind, seed, states=3, symbols=40, kept=2):
    """Return rows of one box without errors of their own."""
    rng = np.random.default_rng(seed)
    g = rng.normal(size=(states, kept + symbols))
    if kind == "a plane in space":
        g[2] = g[0] - g[1]
    elif kind == "sizes apart":
        g *= np.array([[1e-12], [1.0], [1e9]])
    elif kind == "nearly parallel":
        g = g[:1] * np.array([[1.0], [2.0], [-1.0]]) + 1e-13 * g
    elif kind == "one is 0":
        g[1] = 0.0
    elif kind == "all are 0":
        g[:, kept:] = 0.0
    return [np.array([[rng.normal(), 0.0, *row]]) for row in g]


def support(rows, direction, first):
    """Return the largest value of a direction over a set, the symbols before `first` being 0, as a rational number."""
    rows = [[Fraction(float(x)) for x in r[0]] for r in rows]
    centre = sum(d * r[0] for d, r in zip(direction, rows, strict=True))
    own = sum(abs(d) * r[1] for d, r in zip(direction, rows, strict=True))
    symbols = (sum(d * r[k] for d, r in zip(direction, rows, strict=True)) for k in range(2 + first, len(rows[0])))
    return centre + own + sum(map(abs, symbols))


def directions(rows, rng):
    """Return directions along axes, and those in which a set is flat or long."""
    sizes = [Fraction(float(np.abs(r[0, 2:]).sum()) or 1.0) for r in rows]
    for k in range(len(rows)):
        yield [Fraction(int(i == k)) for i in range(len(rows))]
    for _ in range(12):
        yield [Fraction(int(i)) / s for i, s in zip(rng.integers(-5, 6, len(rows)), sizes, strict=True)]
    yield [Fraction(1), Fraction(-1), Fraction(-1)]
    yield [Fraction(2), Fraction(-1), Fraction(0)]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("moved", [False, True])
def test_a_reduced_set_holds_the_whole_one(kind, moved, monkeypatch):
    monkeypatch.setattr(sets, "MOST", 5)
    monkeypatch.setattr(sets, "LEFT", 2)
    rng = np.random.default_rng(0)
    for seed in range(4):
        rows = drawn(kind, seed)
        motion = None
        if moved:
            matrix = rng.normal(size=(3, 3))
            stacked = np.stack(rows)[:, 0]
            motion = modes(rows, [np.array([[0.0, 0.0, *row]]) for row in matrix @ stacked[:, 2:]])
        less = reduced(rows, 2, motion)
        assert less[0].shape[-1] < rows[0].shape[-1]
        for a, b in zip(rows, less, strict=True):
            assert (a[0, 2:4] == b[0, 2:4]).all()
        for direction in directions(rows, rng):
            for sign in (1, -1):
                towards = [sign * d for d in direction]
                assert support(less, towards, 2) >= support(rows, towards, 2)


def test_own_errors_become_symbols_of_their_own():
    rows = with_symbols([np.array([[1.0, 0.5, 2.0]]), np.array([[0.0, 0.0]]), np.array([[0.0, 0.25, 0.0]])])
    assert [r.tolist() for r in rows] == [[[1, 0, 2, 0.5, 0]], [[0, 0, 0, 0, 0]], [[0, 0, 0, 0, 0.25]]]


@pytest.mark.parametrize("kind", KINDS)
def test_a_parallelotope_holds_its_set_and_no_wider_one(kind):
    for seed in range(3):
        rows = drawn(kind, seed)
        whole = Parallelotope(rows, 2, None)
        for direction in directions(rows, np.random.default_rng(1)):
            assert support(whole.rows, direction, 2) >= support(rows, direction, 2)
        if kind != "nearly parallel":  # whose coordinates round
            assert whole.holds(rows)
        lengths = np.abs(whole.columns).sum(1)
        for k in range(3):
            size = 1.001 * lengths[k] + 1e-13 * (1.0 + abs(whole.centre[k]))
            for shift in (size, -size):
                moved = [r.copy() for r in rows]
                moved[k][0, 0] = whole.centre[k] + shift
                assert not whole.holds(moved)
                wide = [r.copy() for r in rows]
                wide[k][0, 1] = abs(shift)
                assert not whole.holds(wide)
        # Of the symbols that stay each value counts by itself.
        turned = [r.copy() for r in rows]
        turned[0][0, 2] += 3 * lengths[0] + 1e-12
        assert not whole.holds(turned)
