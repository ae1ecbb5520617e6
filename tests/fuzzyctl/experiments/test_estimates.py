import numpy as np
import pytest
from scipy import stats

from fuzzyctl.experiments.estimates import mean_interval, share_interval


class TestIntervals:
    def test_of_a_mean_is_that_of_students_t(self):
        values = [1.0, 2.5, 2.0, 4.0]
        expected = stats.t.interval(0.95, 3, np.mean(values), stats.sem(values))
        assert mean_interval(values) == pytest.approx(expected)

    def test_of_a_mean_holds_the_mean_as_often_as_it_says(self):
        random = np.random.default_rng(1)
        found = [mean_interval(random.normal(2.0, 3.0, 6).tolist()) for _ in range(2000)]
        assert np.mean([low <= 2.0 <= high for low, high in found]) == pytest.approx(0.95, abs=0.02)

    @pytest.mark.parametrize(("hits", "n"), [(0, 20), (3, 20), (20, 20), (1, 2)])
    def test_of_a_share_is_wilsons(self, hits, n):
        expected = stats.binomtest(hits, n).proportion_ci(0.95, method="wilson")
        assert share_interval(hits, n) == pytest.approx((expected.low, expected.high))

    def test_of_one_run_there_is_none(self):
        assert mean_interval([1.0]) is None
        assert share_interval(0, 1) is None
