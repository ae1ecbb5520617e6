import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dwmr.control.sliding import denominator, equivalent_control, gain_rate, saturation, sliding_variables
from dwmr.core.interfaces import TrackingError

SLOPES = (0.5, 0.3, 0.7)
small = st.floats(-1.5, 1.5)


def error(x_e=0.0, y_e=0.0, theta=0.0, drift=(0.0, 0.0, 0.0), d=0.1):
    return TrackingError(x_e, y_e, theta, *drift, d)


class TestSlidingVariables:
    @given(small, small, small, st.sampled_from([0.1, 0.4]))
    def test_are_the_transposed_input_matrix_times_sigma(self, x_e, y_e, theta, d):
        l1, l2, l3 = SLOPES
        matrix = np.array([[-l1, l1 * y_e], [0.0, -(l2 * (d + x_e) + l3)]])
        expected = matrix.T @ np.array([l1 * x_e, l2 * y_e + l3 * theta])
        assert sliding_variables(error(x_e, y_e, theta, d=d), *SLOPES) == pytest.approx(tuple(expected), abs=1e-12)

    def test_vanish_without_error(self):
        assert sliding_variables(error(), *SLOPES) == (0.0, 0.0)


class TestEquivalentControl:
    @given(small, small, small, small, small, small)
    def test_holds_the_surfaces_still(self, x_e, y_e, theta, drift_x, drift_y, drift_theta):
        l1, l2, l3 = SLOPES
        e = error(x_e, y_e, theta, (drift_x, drift_y, drift_theta))
        v, omega = equivalent_control(e, *SLOPES)
        # Eq. (6) with these velocities, and sigma of Eq. (7)
        x_rate = drift_x - v + y_e * omega
        y_rate = drift_y - (0.1 + x_e) * omega
        theta_rate = drift_theta - omega
        assert l1 * x_rate == pytest.approx(0.0, abs=1e-9)
        assert l2 * y_rate + l3 * theta_rate == pytest.approx(0.0, abs=1e-9)


class TestDenominator:
    def test_is_the_printed_one_away_from_zero(self):
        assert denominator(1.0, 0.1, 0.3, 0.7) == pytest.approx(0.3 * 1.1 + 0.7)

    @given(st.floats(-10.0, 10.0))
    def test_keeps_its_sign_and_a_least_size(self, x_e):
        plain = 0.3 * (0.1 + x_e) + 0.7
        guarded = denominator(x_e, 0.1, 0.3, 0.7)
        assert abs(guarded) >= 0.05
        assert guarded * plain >= 0.0


class TestSaturation:
    @given(st.floats(-1.0, 1.0), st.floats(0.005, 0.05))
    def test_is_bounded_and_odd(self, sigma, beta):
        assert abs(saturation(sigma, beta)) <= 1.0
        assert saturation(-sigma, beta) == -saturation(sigma, beta)

    def test_is_linear_inside_the_layer_and_a_sign_outside(self):
        assert saturation(0.01, 0.04) == pytest.approx(0.25)
        assert saturation(-0.05, 0.04) == -1.0


class TestGainRate:
    FLOOR, GAMMA, EPSILON = 0.1, 0.4, 0.05

    def test_rises_at_the_floor_by_the_floor(self):
        assert gain_rate(0.1, self.FLOOR, self.GAMMA, 0.0, 0.02, self.EPSILON) == 0.1

    def test_grows_beyond_the_margin(self):
        assert gain_rate(0.5, self.FLOOR, self.GAMMA, -0.2, 0.005, self.EPSILON) == pytest.approx(0.4 * 0.2)

    def test_declines_between_layer_and_margin(self):
        assert gain_rate(0.5, self.FLOOR, self.GAMMA, 0.03, 0.01, self.EPSILON) == pytest.approx(-0.4 * 0.03)

    def test_declines_quadratically_inside_the_layer(self):
        assert gain_rate(0.5, self.FLOOR, self.GAMMA, 0.03, 0.04, self.EPSILON) == pytest.approx(-0.4 * 0.03**2 / 0.04)

    def test_rests_at_the_margin(self):
        assert gain_rate(0.5, self.FLOOR, self.GAMMA, 0.05, 0.01, self.EPSILON) == 0.0

    @given(st.floats(0.11, 5.0), st.floats(-2.0, 2.0), st.floats(0.005, 0.05))
    def test_never_grows_inside_the_layer(self, k_h, sigma, beta):
        if abs(sigma) <= beta:
            assert gain_rate(k_h, self.FLOOR, self.GAMMA, sigma, beta, self.EPSILON) <= 0.0
        assert math.isfinite(gain_rate(k_h, self.FLOOR, self.GAMMA, sigma, beta, self.EPSILON))
