import numpy as np

from dwmr.figures.panels import kept, thin


class TestThin:
    def test_short_signals_stay_as_they_are(self):
        signal = np.arange(10.0)
        assert list(kept(signal, 4)) == list(range(10))

    def test_every_peak_stays_at_its_own_time(self):
        signal = np.zeros(10_000)
        signal[1234], signal[7777] = 5.0, -3.0
        t, values = thin(np.arange(10_000) * 0.1, signal, 50)
        assert len(t) <= 102
        assert dict(zip(t, values, strict=True))[123.4] == 5.0
        assert values.min() == -3.0
        assert t[np.argmin(values)] == 777.7

    def test_first_and_last_stay_and_times_increase(self):
        index = kept(np.sin(np.arange(9_999)), 100)
        assert (index[0], index[-1]) == (0, 9_998)
        assert np.all(np.diff(index) > 0)

    def test_chattering_fills_its_band_in_every_stretch(self):
        signal = np.where(np.arange(8_000) % 2 == 0, 1.0, -1.0)
        _, values = thin(np.arange(8_000.0), signal, 100)
        assert np.mean(values > 0.0) > 0.4
        assert np.mean(values < 0.0) > 0.4
