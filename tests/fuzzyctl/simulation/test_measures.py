"""Measures beside closed forms of a step response of second order, and of signals whose integrals are known."""

import math

import numpy as np
import pytest

from fuzzyctl.model.loop import MEASURES
from fuzzyctl.simulation.measures import measured

T = np.linspace(0.0, 40.0, 40_001)
ONE = np.ones_like(T)
#: y'' + 2 zeta w y' + w^2 y = w^2, at rest at first.
ZETA, W = 0.4, 1.5
DAMPED = W * math.sqrt(1 - ZETA**2)
STEP = 1 - np.exp(-ZETA * W * T) * (np.cos(DAMPED * T) + ZETA * W / DAMPED * np.sin(DAMPED * T))


def value(name, *signals, t=T, **settings):
    return measured(name, t, signals, {**MEASURES[name].settings, **settings})


class TestStepResponse:
    def test_overshoot(self):
        assert value("overshoot", STEP, ONE) == pytest.approx(
            math.exp(-math.pi * ZETA / math.sqrt(1 - ZETA**2)), rel=1e-6
        )

    def test_overshoot_of_a_step_down_and_of_another_size_is_the_same_part_of_it(self):
        assert value("overshoot", 3 - 2 * STEP, ONE) == pytest.approx(value("overshoot", STEP, ONE))

    def test_rise_time_of_a_lag(self):
        lag = 1 - np.exp(-T / 2)
        assert value("rise_time", lag, ONE) == pytest.approx(2 * math.log(9), rel=1e-6)
        assert value("rise_time", lag, ONE, low=0.0, high=0.5) == pytest.approx(2 * math.log(2), rel=1e-6)

    def test_settling_of_a_lag(self):
        lag = 1 - np.exp(-T / 2)
        assert value("settling", lag, ONE) == pytest.approx(2 * math.log(50), rel=1e-6)
        assert value("settling", lag, ONE, band=0.1) == pytest.approx(2 * math.log(10), rel=1e-6)

    def test_settling_is_the_last_entry_into_the_band(self):
        outside = np.flatnonzero(np.abs(STEP - 1) > 0.02)[-1]
        assert T[outside] <= value("settling", STEP, ONE) <= T[outside + 1]

    def test_coarse_samples_are_joined_by_straight_lines(self):
        t = np.array([0.0, 1.0, 2.0, 3.0])
        y = np.array([0.0, 0.5, 1.0, 1.0])
        assert value("rise_time", y, np.ones(4), t=t) == pytest.approx(1.6)
        assert value("settling", y, np.ones(4), t=t, band=0.1) == pytest.approx(1.8)

    def test_what_never_arrives_takes_for_ever(self):
        assert value("rise_time", 0.5 * STEP, ONE) == math.inf
        assert value("settling", 0.5 * STEP, ONE) == math.inf

    def test_what_is_there_from_the_first_sample_takes_no_time(self):
        y = np.where(T > 0, 1.0, 0.999)
        assert value("settling", 1 + 0 * T, ONE + 0.0, t=T) != 0.0  # there is no step: it has no value
        assert value("settling", y, ONE) == pytest.approx(0.001, rel=0.05)

    @pytest.mark.parametrize("name", ["overshoot", "rise_time", "settling"])
    def test_a_part_of_no_step_has_no_value(self, name):
        assert math.isnan(value(name, ONE, ONE))

    def test_windows(self):
        reference = np.where(T < 20, 1.0, 2.0)
        y = np.where(T < 20, STEP, 1 + np.interp(T - 20, T, STEP))
        assert value("overshoot", y, reference, begin=20.0) == pytest.approx(value("overshoot", STEP, ONE), rel=1e-6)
        assert value("settling", y, reference, begin=20.0) == pytest.approx(value("settling", STEP, ONE), abs=2e-3)
        assert value("overshoot", y, reference, end=19.99) == pytest.approx(value("overshoot", STEP, ONE), rel=1e-6)

    @pytest.mark.parametrize("window", [{"begin": 50.0}, {"end": -1.0}, {"begin": 5.0, "end": 5.0}])
    def test_an_empty_window_has_no_value(self, window):
        assert math.isnan(value("iae", STEP, ONE, **window))

    def test_the_ends_of_a_window_belong_to_it_whatever_their_rounding(self):
        t = np.arange(11) * 0.1
        assert value("maximum", t, t=t, end=0.3) == pytest.approx(0.3)
        assert value("minimum", t, t=t, begin=0.7) == pytest.approx(0.7)


class TestIntegrals:
    def test_of_the_error(self):
        lag = 1 - np.exp(-T / 2)
        assert value("iae", lag, ONE) == pytest.approx(2, rel=1e-6)
        assert value("ise", lag, ONE) == pytest.approx(1, rel=1e-6)
        assert value("itae", lag, ONE) == pytest.approx(4, rel=1e-6)
        assert value("itae", np.where(T < 10, 0, lag), ONE, begin=10.0) == pytest.approx(4 * math.exp(-5), rel=1e-4)

    def test_of_a_signal(self):
        wave = np.sin(2 * math.pi * T)
        assert value("integral", T) == pytest.approx(800)
        assert value("effort", 2 * wave) == pytest.approx(80, rel=1e-6)
        assert value("rms", 2 * wave) == pytest.approx(math.sqrt(2), rel=1e-6)
        assert value("mean", 3 + wave) == pytest.approx(3, rel=1e-6)
        assert value("mean", T, begin=10.0, end=20.0) == pytest.approx(15)

    def test_ends_and_extremes(self):
        assert value("final", STEP) == STEP[-1]
        assert value("maximum", STEP) == STEP.max()
        assert value("minimum", STEP) == 0.0

    def test_the_steady_state_error_is_a_mean_over_the_last_twentieth(self):
        y = np.where(T < 38, 0.0, 0.9)
        assert value("steady_state_error", y, ONE) == pytest.approx(0.1)
        assert value("steady_state_error", y, ONE, end=37.0) == pytest.approx(1.0)


def test_every_measure_of_the_language_is_computed():
    for name, form in MEASURES.items():
        assert math.isfinite(value(name, *[STEP, ONE][: len(form.signals)])), name


def test_a_stopped_signal_has_no_step_response():
    assert math.isnan(value("iae", STEP[:1], ONE[:1], t=T[:1]))
