import dataclasses

import numpy as np
import pytest
from PIL import Image

from dwmr.figures import draw_errors, draw_path


@pytest.mark.parametrize("draw", [draw_path, draw_errors])
@pytest.mark.parametrize("laws", [("aifqsmc",), ("aifqsmc", "smc")])
def test_picture_is_drawn_and_is_the_same_twice(tmp_path, run_paper, draw, laws):
    runs = [run_paper(law, "run.horizon=5")[1] for law in laws]
    scenario = run_paper(laws[0], "run.horizon=5")[0].scenario
    for name in ("a.png", "b.png"):
        draw(tmp_path / name, runs, scenario)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    with Image.open(tmp_path / "a.png") as picture:
        assert len(np.unique(np.asarray(picture.convert("RGB")).reshape(-1, 3), axis=0)) > 50


@pytest.mark.parametrize("draw", [draw_path, draw_errors])
@pytest.mark.parametrize("length", [9, 40])
def test_the_legend_lies_within_the_picture_whatever_the_names(tmp_path, run_paper, monkeypatch, draw, length):
    from matplotlib.figure import Figure

    figures = []
    monkeypatch.setattr(Figure, "savefig", lambda self, *a, **k: figures.append(self))
    file, run = run_paper("aifqsmc", "run.horizon=5")
    names = [f"{name:_<{length}}" for name in run.robots]
    robots = dict(zip(names, file.scenario.robots.values(), strict=True))
    scenario = file.scenario.model_copy(update={"robots": robots})
    draw(tmp_path / "x.png", [dataclasses.replace(run, robots=tuple(names))], scenario)
    (legend,) = figures[0].legends
    figures[0].draw_without_rendering()
    found = legend.get_window_extent()
    assert found.x0 >= 0.0
    assert found.x1 <= figures[0].bbox.width


def test_paths_and_axes_are_not_exchanged(tmp_path, run_paper, monkeypatch):
    from matplotlib.figure import Figure

    figures = []
    monkeypatch.setattr(Figure, "savefig", lambda self, *a, **k: figures.append(self))
    file, trajectory = run_paper("aifqsmc", "run.horizon=5")
    draw_path(tmp_path / "x.png", [trajectory], file.scenario)
    (axes,) = figures[0].axes
    assert axes.get_xlabel() == "x [m]"
    assert axes.get_ylabel() == "y [m]"
    line = next(one for one in axes.lines if one.get_label() == "follower1")
    assert line.get_xdata()[0] == -3.5
    assert line.get_ydata()[0] == 3.0


def test_the_time_axis_ends_with_the_run(tmp_path, run_paper, monkeypatch):
    from matplotlib.figure import Figure

    figures = []
    monkeypatch.setattr(Figure, "savefig", lambda self, *a, **k: figures.append(self))
    file, trajectory = run_paper("aifqsmc", "run.horizon=5")
    draw_errors(tmp_path / "x.png", [trajectory], file.scenario)
    for axes in figures[0].axes:
        assert axes.get_xlim() == (0.0, 5.0)
        assert all(patch.get_extents().x1 <= axes.bbox.x1 + 1e-6 for patch in axes.patches)
