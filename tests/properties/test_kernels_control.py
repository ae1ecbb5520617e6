"""What the controllers of the paper rely on, along random sequences."""

from pathlib import Path

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from fuzzyctl import compile as compile_system
from fuzzyctl import load, output_bounds
from tests.sizes import examples

RULES = Path(__file__).parents[2] / "rules"
QUICK = settings(max_examples=examples(150), deadline=None)

anything = st.floats(allow_nan=False) | st.floats(-0.1, 0.1) | st.sampled_from([0.0, 0.015, -0.03, 1e-320, -5e-324])


@pytest.fixture(scope="module", params=["python", pytest.param("numba", marks=pytest.mark.long)])
def immune(request):
    return compile_system(load(RULES / "ais_reaction.fz"), request.param)


@pytest.fixture(scope="module", params=["python", pytest.param("numba", marks=pytest.mark.long)])
def layer(request):
    return compile_system(load(RULES / "boundary_layer.fz"), request.param)


@pytest.fixture(scope="module", params=["python", pytest.param("numba", marks=pytest.mark.long)])
def gain(request):
    return compile_system(load(RULES / "fcafsmc.fz"), request.param)


class TestImmuneReaction:
    @QUICK
    @given(anything, anything)
    def test_stays_within_its_proved_bounds(self, immune, sigma, dsigma):
        assert -1.0 <= immune(sigma, dsigma) <= 0.18

    @QUICK
    @given(anything, anything, st.floats(0, 1e6))
    def test_the_adaptive_gain_is_positive_for_every_admissible_gain(self, immune, sigma, dsigma, above):
        k_h, k_s = 0.1 + above, 0.55
        assert k_h - k_s * immune(sigma, dsigma) >= 0.001 - 1e-12

    @QUICK
    @given(anything, anything)
    def test_answers_both_semi_cycles_alike(self, immune, sigma, dsigma):
        assert immune(-sigma, -dsigma) == pytest.approx(immune(sigma, dsigma), abs=1e-12)


class TestBoundaryLayer:
    @QUICK
    @given(st.floats(0, allow_nan=False) | st.floats(0, 0.06))
    def test_stays_within_its_proved_bounds(self, layer, abs_sigma):
        bound = output_bounds(load(RULES / "boundary_layer.fz"))["beta"]
        assert 0.005 <= bound.lo <= layer(abs_sigma) <= bound.hi <= 0.05


class TestAdaptiveGain:
    @QUICK
    @given(st.lists(st.floats(-5, 5) | anything, min_size=1, max_size=40), st.floats(1e-4, 10.0))
    def test_never_leaves_its_range_under_euler_steps_with_projection(self, gain, sigmas, dt):
        limit = 2.0
        state, rates, xi = gain.start(), np.empty(gain.n_rules), np.empty(gain.n_rules)
        for sigma in sigmas:
            assert abs(gain(sigma, state)) <= limit
            gain.jit_strengths(sigma, xi)
            assert (xi >= 0).all()
            assert xi.sum() == pytest.approx(1, abs=1e-12)
            assert gain(sigma, state) == pytest.approx(float(xi @ state), abs=1e-12)
            gain.jit_rates(sigma, state, rates)
            assert not (rates[state >= limit] > 0).any()
            assert not (rates[state <= -limit] < 0).any()
            with np.errstate(over="ignore"):
                state = np.clip(state + dt * rates, -limit, limit)

    def test_grows_where_the_error_is_and_nowhere_else(self, gain):
        rates = np.empty(7)
        gain.jit_rates(0.4 / 6, np.zeros(7), rates)
        assert np.flatnonzero(rates).tolist() == [3, 4]
        assert rates[[3, 4]] == pytest.approx([0.4 / 12, 0.4 / 12])
