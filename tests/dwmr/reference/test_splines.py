"""Splines against scipy's, and how fast one moves along them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from dwmr.reference import splines


def zigzag(seed, n, closed):
    rng = np.random.default_rng(seed)
    t, points = np.cumsum(rng.uniform(0.1, 2.0, n)), rng.normal(size=(n, 2))
    if closed:
        points[-1] = points[0]
    return t, points


class TestCubic:
    @given(st.integers(0, 10_000), st.integers(2, 40), st.booleans())
    def test_is_the_spline_of_scipy(self, seed, n, closed):
        t, points = zigzag(seed, n + 2 * closed, closed)
        wanted = CubicSpline(t, points, bc_type="periodic" if closed else "natural")
        coefficients = np.moveaxis(wanted.c[::-1], 0, -1)
        assert splines.cubic(t, points, closed) == pytest.approx(coefficients, rel=1e-6, abs=1e-6)


class TestSlowest:
    @given(st.integers(0, 10_000), st.booleans())
    def test_is_not_above_any_sample_and_is_reached(self, seed, closed):
        t, points = zigzag(seed, 12, closed)
        rate = CubicSpline(t, points, bc_type="periodic" if closed else "natural").derivative()
        least, where = splines.slowest(t, splines.cubic(t, points, closed))
        samples = np.linalg.norm(rate(np.linspace(t[0], t[-1], 20_001)), axis=1)
        assert least <= samples.min() + 1e-12
        assert np.linalg.norm(rate(where)) == pytest.approx(least, abs=1e-9)
        assert least == pytest.approx(samples.min(), abs=1e-2)

    def test_finds_a_standstill_between_two_samples(self):
        # x = t³/3 − a t² + a² t has the speed (t − a)²
        a = 0.4321
        piece = np.array([[[0.0, a * a, -a, 1 / 3], [0.0, 0.0, 0.0, 0.0]]])
        least, where = splines.slowest(np.array([0.0, 1.0]), piece)
        assert (least, where) == (pytest.approx(0.0, abs=1e-9), pytest.approx(a, abs=1e-4))


class TestByLength:
    @pytest.mark.parametrize("closed", [False, True])
    def test_leads_through_the_same_places_at_a_constant_speed(self, closed):
        points = np.array([[0.0, 0.0], [10.0, 0.0], [12.0, 8.0], [0.0, 9.0], [0.0, 0.0]])
        u = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        s, pieces = splines.by_length(u, splines.cubic(u, points, closed), closed)
        assert len(pieces) == 4 * splines.PARTS
        assert pieces[:: splines.PARTS, :, 0] == pytest.approx(points[:-1])
        tau = np.linspace(0.0, 1.0, 7) * np.diff(s)[:, None]
        speed = np.linalg.norm(splines.velocity(pieces, tau), axis=-1)
        assert speed == pytest.approx(np.ones_like(speed), abs=1e-3)
        assert splines.lengths(s, pieces).sum() == pytest.approx(s[-1], rel=1e-6)
