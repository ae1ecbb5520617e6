"""Limits of axes that a few peaks do not crush."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fuzzyctl.plot import limits

T = np.linspace(0.0, 10.0, 1001)


def test_two_spikes_do_not_crush_the_rest_and_are_said():
    values = np.sin(T)
    values[300], values[700] = 150.0, -80.0
    found = limits.of([limits.Line("smc", T, values)])
    assert -2.0 < found.shown[0] < -1.0 < 1.0 < found.shown[1] < 2.0
    assert found.whole[0] < -80.0 < 150.0 < found.whole[1]
    assert found.note == "Peaks cut off: smc 150 at 3.00 s (beyond for 0.2 % of the time)."


def test_a_law_that_diverges_does_not_set_the_limits():
    tame = [limits.Line(name, T, np.sin(T)) for name in ("a", "b")]
    found = limits.of([*tame, limits.Line("wild", T, np.exp(T))])
    assert found.shown[1] < 2.0
    assert "wild 2.2e+04 at 10.00 s" in found.note


def test_a_pulse_on_a_line_that_rests_is_no_peak():
    values = np.where(np.abs(T - 5.0) < 0.02, 5.0, 0.0)
    found = limits.of([limits.Line("push", T, values)])
    assert found.shown == found.whole
    assert found.shown[1] > 5.0
    assert found.note == ""


def test_without_peaks_everything_is_shown():
    found = limits.of([limits.Line("a", T, np.sin(T))])
    assert found.shown == found.whole
    assert found.note == ""


@given(st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=1, max_size=40))
def test_limits_are_finite_and_ordered_and_what_is_cut_is_said(values):
    values = np.array(values)
    low, high = (found := limits.of([limits.Line("a", np.arange(len(values)), values)])).shown
    assert np.isfinite([low, high, *found.whole]).all()
    assert low < high
    drawn = values[np.abs(values) <= np.finfo(np.float32).max]
    assert found.note or not ((drawn < low) | (drawn > high)).any()
