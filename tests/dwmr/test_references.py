import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dwmr.references import eight, eight_turn_rate

SHAPE = np.array([15.0, 15.0, 200.0])
OBSTACLES = ((0.0, 15.5), (8.0, -4.25), (-14.5, -11.25))


class TestEight:
    @given(st.floats(0.0, 200.0))
    def test_velocity_and_orientation_are_those_of_the_moving_point(self, t):
        h = 1e-4
        before, here, after = eight(t - h, SHAPE), eight(t, SHAPE), eight(t + h, SHAPE)
        x_dot, y_dot = (after.x - before.x) / (2 * h), (after.y - before.y) / (2 * h)
        assert math.hypot(x_dot, y_dot) == pytest.approx(here.v, rel=1e-5)
        assert math.cos(here.theta) * here.v == pytest.approx(x_dot, abs=1e-5)
        assert math.sin(here.theta) * here.v == pytest.approx(y_dot, abs=1e-5)

    def test_keeps_the_printed_speeds(self):
        speeds = [eight(t, SHAPE).v for t in np.arange(0.0, 200.0, 0.1)]
        assert (min(speeds), max(speeds)) == pytest.approx((0.33, 1.05), abs=0.01)

    def test_starts_at_the_origin_counter_clockwise(self):
        start, later = eight(0.0, SHAPE), eight(20.0, SHAPE)
        assert (start.x, start.y) == (0.0, 0.0)
        assert math.degrees(start.theta) == pytest.approx(26.57, abs=0.01)
        assert later.x > 0.0
        assert later.y > 0.0

    @pytest.mark.parametrize(
        ("obstacle", "when", "distance"), list(zip(OBSTACLES, (50.0, 109.0, 172.5), (0.50, 0.08, 0.35), strict=True))
    )
    def test_passes_the_obstacles_when_disturbances_act(self, obstacle, when, distance):
        times = np.arange(0.0, 200.0, 0.1)
        gaps = [math.hypot(eight(t, SHAPE).x - obstacle[0], eight(t, SHAPE).y - obstacle[1]) for t in times]
        assert min(gaps) == pytest.approx(distance, abs=0.01)
        assert times[int(np.argmin(gaps))] == pytest.approx(when, abs=0.5)


class TestEightTurnRate:
    @given(st.floats(0.0, 200.0))
    def test_is_the_rate_of_the_orientation(self, t):
        h = 1e-4
        change = eight(t + h, SHAPE).theta - eight(t - h, SHAPE).theta
        change = (change + math.pi) % (2 * math.pi) - math.pi
        assert eight_turn_rate(t, SHAPE) == pytest.approx(change / (2 * h), abs=1e-5)

    def test_keeps_the_printed_turn_rates(self):
        rates = [eight_turn_rate(t, SHAPE) for t in np.arange(0.0, 200.0, 0.1)]
        assert (min(rates), max(rates)) == pytest.approx((-0.18, 0.18), abs=0.005)
