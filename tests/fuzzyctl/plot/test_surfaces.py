import numpy as np
import pytest

from fuzzyctl.loading.load import load, loads
from fuzzyctl.plot.surfaces import draw_surface, sample
from fuzzyctl.support.shipped import rules_folder


class TestSample:
    def test_the_first_axis_runs_along_the_columns(self):
        system = load(rules_folder() / "tipper.fz")
        (service, food), values = sample(system, ["service", "food"], {}, "tip", 7)
        assert values.shape == (7, 7)
        # Inputs of one range hide swapped axes; the function is not symmetric, so that a swap shows.
        for i, j in ((0, 6), (5, 1), (3, 4)):
            assert values[i, j] == pytest.approx(system(service=service[j], food=food[i]), rel=1e-12)

    def test_axes_follow_their_own_ranges(self, base):
        (y, x), values = sample(loads(base), ["y", "x"], {}, "u", 5)
        assert (x[0], x[-1], y[0], y[-1]) == (-1, 1, 0, 10)
        assert values[1, 3] == pytest.approx(loads(base)(x=x[1], y=y[3]), rel=1e-12)

    def test_other_inputs_stand_at_mid_range_or_where_they_are_put(self, base):
        system = loads(base)
        (x,), values = sample(system, ["x"], {}, "u", 5)
        assert values[1] == pytest.approx(system(x=x[1], y=5.0), rel=1e-12)
        (x,), values = sample(system, ["x"], {"y": 2.0}, "u", 5)
        assert values[1] == pytest.approx(system(x=x[1], y=2.0), rel=1e-12)


class TestDrawSurface:
    def test_labels_name_variable_and_unit(self, base):
        from matplotlib.figure import Figure

        figure = Figure()
        draw_surface(figure, loads(base), ["x", "y"], {}, "u", 9)
        assert [a.get_xlabel() for a in figure.axes[:2]] == ["x", "x"]
        assert [a.get_ylabel() for a in figure.axes[:2]] == ["y [m]", "y [m]"]
        assert figure.axes[0].get_zlabel() == "u"

    def test_one_axis_gives_a_curve(self, base):
        from matplotlib.figure import Figure

        figure = Figure()
        draw_surface(figure, loads(base), ["y"], {"x": 1.0}, "u", 9)
        (line,) = figure.axes[0].get_lines()
        assert np.all(np.diff(line.get_ydata()) >= 0)
