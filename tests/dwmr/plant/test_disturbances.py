import math

import numpy as np
import pytest

from dwmr.plant.disturbances import DISTURBANCE, disturbance, disturbance_since


def acting(*rows):
    return np.array(list(rows), dtype=DISTURBANCE).view(np.recarray)


SINUSOID = (3.0, 20.0, 2.0, 0.0, 0.2, 0.05, 15.0, 5.0)
CONSTANT = (10.0, 30.0, 0.0, 0.0, 0.1, 0.01, 1.0, 2.0)


class TestDisturbance:
    def test_is_nothing_outside_its_window(self):
        assert disturbance(2.999, acting(SINUSOID)) == (0.0, 0.0, 0.0, 0.0)
        assert disturbance(20.0, acting(SINUSOID)) == (0.0, 0.0, 0.0, 0.0)

    def test_of_frequency_zero_is_constant(self):
        assert disturbance(10.0, acting(CONSTANT)) == pytest.approx((0.1, 0.01, 1.0, 2.0))

    def test_with_a_frequency_is_a_sine_of_time(self):
        assert disturbance(5.0, acting(SINUSOID)).v == pytest.approx(0.2 * math.sin(10.0))
        assert disturbance(5.0, acting(SINUSOID)).torque == pytest.approx(5.0 * math.sin(10.0))

    def test_with_a_phase_begins_elsewhere(self):
        late = (*SINUSOID[:3], 1.25, *SINUSOID[4:])
        assert disturbance(5.0, acting(late)).omega == pytest.approx(0.05 * math.sin(11.25))

    def test_adds_up(self):
        total = disturbance(15.0, acting(SINUSOID, CONSTANT))
        assert total.omega == pytest.approx(0.05 * math.sin(30.0) + 0.01)
        assert total.force == pytest.approx(15.0 * math.sin(30.0) + 1.0)


class TestDisturbanceSince:
    def test_acts_throughout_a_period_at_whose_start_it_acts(self):
        assert disturbance_since(29.999, 30.001, acting(CONSTANT)).v == pytest.approx(0.1)
        assert disturbance_since(19.99, 20.01, acting(SINUSOID)).v == pytest.approx(0.2 * math.sin(40.02))

    def test_does_not_begin_inside_a_period(self):
        assert disturbance_since(9.999, 10.001, acting(CONSTANT)) == (0.0, 0.0, 0.0, 0.0)
