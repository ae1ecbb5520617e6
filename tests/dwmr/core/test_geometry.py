import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dwmr.core.geometry import to_body, wrap, wrap_array

angles = st.floats(-50.0, 50.0)
lengths = st.floats(-100.0, 100.0)


class TestWrap:
    @given(angles)
    def test_lands_in_the_half_open_turn(self, angle):
        assert -math.pi < wrap(angle) <= math.pi + 1e-12

    @given(angles)
    def test_keeps_the_direction(self, angle):
        assert math.isclose(math.cos(wrap(angle)), math.cos(angle), abs_tol=1e-9)
        assert math.isclose(math.sin(wrap(angle)), math.sin(angle), abs_tol=1e-9)

    def test_of_arrays_agrees_with_that_of_one(self):
        angles = [3.5, -math.pi, math.pi, 7.0, -0.2]
        assert wrap_array(np.array(angles)).tolist() == [wrap(a) for a in angles]

    def test_keeps_half_a_turn_positive(self):
        assert wrap(math.pi) == math.pi
        assert wrap(-math.pi) == math.pi


class TestToBody:
    def test_puts_what_is_ahead_on_the_first_axis(self):
        ahead, left = to_body(0.0, 2.0, math.pi / 2)
        assert (ahead, left) == pytest.approx((2.0, 0.0))

    def test_puts_what_is_on_the_left_on_the_second_axis(self):
        ahead, left = to_body(-3.0, 0.0, math.pi / 2)
        assert (ahead, left) == pytest.approx((0.0, 3.0))

    @given(lengths, lengths, angles)
    def test_keeps_the_length(self, x, y, theta):
        assert math.hypot(*to_body(x, y, theta)) == pytest.approx(math.hypot(x, y), abs=1e-9)
