"""Pictures of `dwmr run`, and what its panels share with those of `dwmr figures`."""

import dataclasses

import numpy as np
import pytest

from tests.dwmr.scenarios import PAPER, by_hand, changed, edited

SHORT = ("run.horizon=5",)


@pytest.fixture
def pictures(figures_of, recorded):
    """A function (*trajectories) -> the figures of `dwmr run` about them: paths, errors."""

    def draw(*trajectories, scenario="paper", sets=SHORT):
        recorded(*trajectories)
        laws = ",".join(one.controller for one in trajectories)
        drawn = figures_of("run", scenario, "--controller", laws, sets=sets)
        return drawn["path.png"], drawn["errors.png"]

    return draw


def test_the_legend_lies_within_the_picture_whatever_the_names(pictures, run_paper, tmp_path):
    run = run_paper("smc", *SHORT)[1]
    names = {name: f"{name:_<40}" for name in run.robots}
    renamed = [(f"[robots.{old}]", f"[robots.{new}]") for old, new in names.items()]
    leader = ('leader = "leader"', f'leader = "{names["leader"]}"')
    scenario = edited(PAPER, tmp_path / "long.toml", *renamed, leader, leader)
    for figure in pictures(dataclasses.replace(run, robots=tuple(names.values())), scenario=scenario):
        (legend,) = figure.legends
        figure.draw_without_rendering()
        extent = legend.get_window_extent()
        assert extent.x0 >= 0.0
        assert extent.x1 <= figure.bbox.width


def test_paths_and_times_have_their_axes(pictures, run_paper):
    path, errors = pictures(run_paper("smc", *SHORT)[1])
    (axes,) = path.axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [m]", "y [m]")
    line = next(one for one in axes.lines if one.get_label() == "follower1")
    assert (line.get_xdata()[0], line.get_ydata()[0]) == (-3.5, 3.0)
    for axes in errors.axes:
        assert axes.get_xlim() == (0.0, 5.0)
        assert all(patch.get_extents().x1 <= axes.bbox.x1 + 1e-6 for patch in axes.patches)


def test_bodies_that_touch_have_a_mark_where_they_first_do(pictures):
    x = np.array([[0.0, 50.0, 100.0], [0.0, 0.7, 100.0], [0.0, 0.5, 100.0]])
    y = np.array([[-6.0], [-5.0], [-6.0]]) * [1, 0, 0]
    columns = {"sigma_v": 0.0, "sigma_omega": 0.0}
    for places, wanted in (
        ({"x": [0.0, 50.0, 100.0]}, []),
        ({"x": x}, [(-0.1865, 0.0)]),
        ({"x": [8.0, 50.0, 100.0], "y": y}, [(7.8135, -5.0)]),
    ):
        (axes,) = pictures(by_hand(**columns, **places), scenario="paper-with-limits")[0].axes
        marks = [one for one in axes.lines if one.get_label() == "collision"]
        assert [pytest.approx(one) for one in wanted] == [tuple(row) for one in marks for row in one.get_xydata()]


class TestLimitsOfPaths:
    def limits(self, pictures, run_paper, *factors):
        run = run_paper("aifqsmc", "run.horizon=60")[1]
        factor = [np.array([1.0, 1.0, one]) for one in factors]
        others = [changed(run, x=lambda x, f=f: f * x, y=lambda y, f=f: f * y) for f in factor]
        laws = zip(("fcafsmc", "smc"), others, strict=False)
        runs = [run, *(dataclasses.replace(one, controller=law) for law, one in laws)]
        return pictures(*runs, sets=("run.horizon=60",))[0].axes

    def test_a_law_that_runs_away_does_not_shrink_the_others(self, pictures, run_paper):
        first, second, far = self.limits(pictures, run_paper, 1.2, 8.0)
        assert first.get_xlim() == second.get_xlim()
        assert np.ptp(first.get_xlim()) < 50.0
        assert np.ptp(far.get_xlim()) > 150.0
        assert [axes.get_title(loc="right") for axes in (first, second, far)] == ["", "", "own scale"]
        assert np.ptp(far.get_xlim()) == np.ptp(far.get_ylim())

    def test_who_leaves_the_picture_is_named(self, pictures, run_paper):
        near, far = self.limits(pictures, run_paper, 1e6)
        assert np.ptp(far.get_xlim()) < 250.0
        assert [text.get_text() for text in far.texts] == ["follower2 out of the picture"]
        assert not near.texts


@pytest.fixture
def panel(figures_of, recorded):
    """A function (signals of shape (samples, 3)) -> the panel of Fig. 11 that shows them as σ*_v."""

    def draw(signals):
        recorded(by_hand(samples=len(signals), sigma_v=signals, sigma_omega=0.0))
        (figure,) = figures_of("figures", "paper", "--only", "11").values()
        return next(axes for axes in figure.axes if axes.get_ylabel() == r"${\sigma}_{v}^*$ [m]")

    return draw


class TestPeaks:
    def test_that_would_flatten_all_else_are_cut_off_and_said(self, panel):
        signals = np.random.default_rng(1).uniform(-1.0, 1.0, (4000, 3))
        signals[2000, 0], signals[3000, 1] = 40.0, -9.0
        axes = panel(signals)
        assert max(map(abs, axes.get_ylim())) < 2.0
        assert axes.texts[0].get_text() == "peaks cut off, \u22129 to 40"

    def test_that_last_are_no_peaks(self, panel):
        signals = np.zeros((4000, 3))
        signals[2000:2100] = 40.0
        axes = panel(signals)
        assert axes.get_ylim()[1] >= 40.0
        assert not axes.texts


class TestThinning:
    def test_short_signals_stay_as_they_are(self, panel):
        signals = np.arange(30.0).reshape(10, 3)
        lines = panel(signals).lines
        assert [line.get_ydata().tolist() for line in lines] == signals.T.tolist()

    def test_keeps_peaks_ends_and_the_band_of_chattering_which_lies_below(self, panel):
        peaks, times = np.zeros(10_000), 0.005 * np.arange(10_000)
        peaks[1234], peaks[7777] = 5.0, -3.0
        band = np.where(np.arange(10_000) % 2 == 0, 1.0, -1.0)
        lines = panel(np.stack([peaks, band, np.sin(np.arange(10_000))], axis=1)).lines
        for line in lines:
            t = line.get_xdata()
            assert (t[0], t[-1]) == (0.0, times[-1])
            assert np.all(np.diff(t) > 0)
            assert len(t) < 5_000
        shown = dict(zip(*lines[0].get_data(), strict=True))
        assert (shown[times[1234]], shown[times[7777]]) == (5.0, -3.0)
        values = lines[1].get_ydata()
        for stretch in np.array_split(values, 10):
            assert 0.4 < np.mean(stretch > 0.0) < 0.6
        assert lines[1].get_zorder() < lines[0].get_zorder()
