import dataclasses

import numpy as np
import pytest
from matplotlib.figure import Figure

from dwmr.figures import draw_errors, draw_path, panels


@pytest.fixture
def figures(monkeypatch):
    """Figures in place of the files that would hold them."""
    drawn = []
    monkeypatch.setattr(Figure, "savefig", lambda self, *a, **k: drawn.append(self))
    return drawn


@pytest.mark.parametrize("draw", [draw_path, draw_errors])
def test_the_legend_lies_within_the_picture_whatever_the_names(tmp_path, run_paper, figures, draw):
    file, run = run_paper("aifqsmc", "run.horizon=5")
    names = [f"{name:_<40}" for name in run.robots]
    robots = dict(zip(names, file.scenario.robots.values(), strict=True))
    scenario = file.scenario.model_copy(update={"robots": robots})
    draw(tmp_path / "x.png", [dataclasses.replace(run, robots=tuple(names))], scenario)
    (legend,) = figures[0].legends
    figures[0].draw_without_rendering()
    found = legend.get_window_extent()
    assert found.x0 >= 0.0
    assert found.x1 <= figures[0].bbox.width


def test_paths_and_axes_are_not_exchanged(tmp_path, run_paper, figures):
    file, trajectory = run_paper("aifqsmc", "run.horizon=5")
    draw_path(tmp_path / "x.png", [trajectory], file.scenario)
    (axes,) = figures[0].axes
    assert axes.get_xlabel() == "x [m]"
    assert axes.get_ylabel() == "y [m]"
    line = next(one for one in axes.lines if one.get_label() == "follower1")
    assert line.get_xdata()[0] == -3.5
    assert line.get_ydata()[0] == 3.0


def test_the_time_axis_ends_with_the_run(tmp_path, run_paper, figures):
    file, trajectory = run_paper("aifqsmc", "run.horizon=5")
    draw_errors(tmp_path / "x.png", [trajectory], file.scenario)
    for axes in figures[0].axes:
        assert axes.get_xlim() == (0.0, 5.0)
        assert all(patch.get_extents().x1 <= axes.bbox.x1 + 1e-6 for patch in axes.patches)


def moved(run, factor):
    """Return a run whose second follower is farther from the origin by a factor."""
    values = run.values.copy()
    values[:, 2, :2] *= factor
    return dataclasses.replace(run, values=values)


class TestLimitsOfPaths:
    def limits(self, figures, tmp_path, run_paper, *factors):
        file, run = run_paper("aifqsmc", "run.horizon=60")
        draw_path(tmp_path / "x.png", [run, *(moved(run, one) for one in factors)], file.scenario)
        return figures[0].axes

    def test_a_law_that_runs_away_does_not_shrink_the_others(self, figures, tmp_path, run_paper):
        first, second, far = self.limits(figures, tmp_path, run_paper, 1.2, 8.0)
        assert first.get_xlim() == second.get_xlim()
        assert np.ptp(first.get_xlim()) < 50.0
        assert np.ptp(far.get_xlim()) > 150.0
        assert [axes.get_title(loc="right") for axes in (first, second, far)] == ["", "", "own scale"]
        assert np.ptp(far.get_xlim()) == np.ptp(far.get_ylim())

    def test_who_leaves_the_picture_is_named(self, figures, tmp_path, run_paper):
        near, far = self.limits(figures, tmp_path, run_paper, 1e6)
        assert np.ptp(far.get_xlim()) < 250.0
        assert [text.get_text() for text in far.texts] == ["follower2 out of the picture"]
        assert not near.texts


class TestPeaks:
    def drawn(self, signals):
        axes = Figure().subplots()
        panels.lines(axes, np.arange(float(len(signals))), signals, ["a", "b"], "x [m]")
        panels.cut_peaks(axes, signals)
        return axes

    def test_that_would_flatten_all_else_are_cut_off_and_said(self):
        signals = np.random.default_rng(1).uniform(-1.0, 1.0, (4000, 2))
        signals[2000, 0], signals[3000, 1] = 40.0, -9.0
        axes = self.drawn(signals)
        assert max(map(abs, axes.get_ylim())) < 2.0
        assert axes.texts[0].get_text() == "peaks cut off, \u22129 to 40"

    def test_that_last_are_no_peaks(self):
        signals = np.zeros((4000, 2))
        signals[2000:2100] = 40.0
        axes = self.drawn(signals)
        assert axes.get_ylim()[1] >= 40.0
        assert not axes.texts

    def test_a_band_lies_below_a_line(self):
        signals = np.stack([np.zeros(400), np.tile([1.0, -1.0], 200)], axis=1)
        line, band = self.drawn(signals).lines
        assert band.get_zorder() < line.get_zorder()
