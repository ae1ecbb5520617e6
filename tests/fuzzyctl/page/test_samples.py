"""Pages keep the peaks of runs, and few numbers."""

import math

from hypothesis import example, given
from hypothesis import strategies as st

from fuzzyctl.page.blocks import FEWEST, NUMBERS, SEEN, Drawn, samples

VALUES = st.lists(st.floats(-1e3, 1e3) | st.just(math.nan), max_size=1500)


def of(*lines, followed=1, runs=1, height=1.0):
    return samples(len(lines[0]), [Drawn(values, height) for values in lines], followed, runs)


def test_a_signal_of_period_two_keeps_both_values_in_each_stretch():
    found = of([float(k % 2) for k in range(2001)])
    assert found.every == 6
    assert found.peaks == [[k + 1 for k in found.shown[:-1]]]


def test_what_is_smooth_or_too_small_to_be_seen_has_no_peaks():
    assert of([math.sin(k / 500) for k in range(3001)]).peaks == [[]]
    assert of([float(k % 2) * 0.9 * SEEN for k in range(3001)]).peaks == [[]]


def test_a_narrow_pulse_of_one_line_is_kept_by_it_alone():
    pulse = [0.0] * 3001
    pulse[1234] = 5.0
    assert of(pulse, [0.0] * 3001).peaks == [[1234], []]


@given(VALUES)
@example([])
@example([math.nan] * 900)
def test_a_page_shows_the_least_and_the_greatest_value_and_the_last_sample(values):
    found = of(values, height=1e-9)
    seen = {*found.shown, *found.peaks[0]}
    if values and not any(map(math.isnan, values)):
        assert min(values[k] for k in seen) == min(values)
        assert max(values[k] for k in seen) == max(values)
    assert found.shown[-1:] == [*range(len(values))][-1:]
    assert found.shown == [*range(0, len(values), found.every), *found.shown[len(range(0, len(values), found.every)) :]]
    assert not {*found.shown} & {*found.peaks[0]}
    assert all(math.isfinite(values[k]) for k in found.peaks[0])


@given(st.integers(1, 8), st.integers(1, 6), st.integers(1, 3000))
def test_lines_that_chatter_leave_fewer_samples_and_no_more_numbers(lines, runs, count):
    own = [(-1.0) ** (k // 2) for k in range(count)]
    found = of(*[own] * lines, runs=runs)
    size = len(found.shown) * (lines + 1) + 2 * sum(map(len, found.peaks))
    assert size <= NUMBERS // runs or len(found.shown) <= FEWEST + 1
