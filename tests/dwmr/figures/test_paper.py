import dataclasses

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.text import Text

from dwmr import find, read
from dwmr.cli.figures import index_text
from dwmr.core.geometry import wrap_array
from dwmr.figures import panels, paper
from dwmr.figures.animation import body
from dwmr.results import derived
from dwmr.results.metrics import distances, measure
from dwmr.simulation.simulate import COLUMNS

BY_NUMBER = {figure.number: figure for figure in paper.FIGURES}
#: A run short enough to be drawn sample by sample, with an obstacle that is avoided.
RUN = ("run.horizon=5", "obstacles=[{x=3.0, y=2.0, radius=0.5}, {x=9.0, y=9.0, radius=0.5}, {x=-9.0, y=9.0, radius=1}]")


@pytest.fixture(scope="module")
def drawn(run_paper):
    """A function number -> (figure, trajectory, scenario)."""

    def draw(number):
        file, trajectory = run_paper(BY_NUMBER[number].law, *RUN)
        return BY_NUMBER[number].draw(trajectory, file.scenario), trajectory, file.scenario

    return draw


def title_of(axes):
    """Return the title of a panel, in its middle or at its left."""
    return axes.get_title() or axes.get_title(loc="left")


def line(figure, label_of_axis, label, title=None):
    """Return the data of the one line with a label in the panel with a label of its y axis."""
    found = [
        one
        for axes in figure.axes
        if axes.get_ylabel() == label_of_axis and (title is None or title_of(axes).split(";")[0] == title)
        for one in axes.lines
        if one.get_label() == label
    ]
    assert len(found) == 1, (label_of_axis, label, [axes.get_ylabel() for axes in figure.axes])
    return found[0].get_xdata(), found[0].get_ydata()


def same(data, t, signal):
    """Whether a line holds samples of a signal, each at its time, the extremes among them."""
    x, y = data
    index = np.searchsorted(t, x - 1e-9)
    return (
        len(x) > 100
        and np.array_equal(t[index], x)
        and np.allclose(signal[index], y, rtol=0.0, atol=1e-12)
        and y.max() == pytest.approx(signal.max())
        and y.min() == pytest.approx(signal.min())
    )


class TestCatalogue:
    def test_has_all_figures_of_the_paper_from_8_to_39(self):
        assert [figure.number for figure in paper.FIGURES] == list(range(8, 40))

    def test_those_of_the_experiment_show_what_those_of_the_simulation_do(self):
        for number in range(29, 40):
            figure, simulated = BY_NUMBER[number], BY_NUMBER[number - 16]
            assert (figure.title, figure.about, figure.draw) == (simulated.title, simulated.about, simulated.draw)
            assert figure.subject == "AIFQSMC, experiment"

    @pytest.mark.parametrize(("name", "numbers"), [("paper", range(8, 29)), ("experiment", range(29, 40))])
    def test_a_scenario_has_those_of_its_plant(self, name, numbers):
        scenario = read(find(name)).scenario
        shown = paper.usual(scenario)
        assert [figure.number for figure in shown] == list(numbers)
        assert not any(figure.obstacle_to(scenario) for figure in shown)

    def test_those_of_the_experiment_need_bodies(self):
        why = BY_NUMBER[30].obstacle_to(read(find("paper")).scenario)
        assert why == "it shows rigid bodies, and run.plant is 'equations'; see figure 14"
        assert not BY_NUMBER[9].obstacle_to(read(find("experiment")).scenario)

    @pytest.mark.parametrize("number", range(8, 29))
    def test_every_figure_has_labelled_axes_with_units(self, drawn, number):
        figure, _, _ = drawn(number)
        assert figure.axes
        for axes in figure.axes:
            assert axes.get_ylabel().endswith("]"), axes.get_ylabel()
        assert any(axes.get_xlabel() in ("t [s]", "x [m]") for axes in figure.axes)


class TestContent:
    @pytest.mark.parametrize("number", [15, 17])
    def test_the_legend_leaves_a_margin_at_both_sides(self, drawn, number):
        figure, *_ = drawn(number)
        figure.canvas.draw()
        (legend,) = figure.legends
        found, width = legend.get_window_extent(), figure.bbox.width
        assert 0.01 * width <= found.x0 < found.x1 <= 0.99 * width

    def test_paths_have_x_to_the_right_and_y_upwards(self, drawn):
        figure, trajectory, _ = drawn(13)
        x, y = line(figure, "y [m]", "follower1")
        assert (x[0], y[0]) == (-3.5, 3.0)
        assert (x[-1], y[-1]) == (trajectory["x"][-1, 1], trajectory["y"][-1, 1])

    def test_bodies_stand_along_the_paths_with_their_headings(self, drawn):
        figure, trajectory, scenario = drawn(13)
        bodies = [one.get_xy()[:5] for one in figure.axes[0].patches if isinstance(one, Polygon)]
        assert len(bodies) == 3 * panels.BODIES
        places = (float(trajectory[name][-1, 2]) for name in ("x", "y", "theta"))
        assert bodies[-1] == pytest.approx(body(scenario.robots["follower2"], *places))

    def test_a_place_that_is_no_number_has_no_body(self, drawn):
        _, trajectory, scenario = drawn(13)
        values = trajectory.values.copy()
        values[-1, :, COLUMNS["x"]] = np.nan
        axes = Figure().add_subplot()
        panels.bodies(axes, dataclasses.replace(trajectory, values=values), scenario)
        assert len(axes.patches) == 3 * (panels.BODIES - 1)

    @pytest.mark.parametrize(("factor", "spans"), [(1.2, [(1.0, 5.0)]), (1.0, [])])
    def test_the_load_is_marked_where_there_is_one(self, drawn, factor, spans):
        _, trajectory, scenario = drawn(13)
        given = {"start": 1.0, "stop": 9.0, "mass_factor": factor, "inertia_factor": 1.0}
        scenario = scenario.model_copy(update={"load": scenario.load.model_copy(update=given)})
        axes = Figure().add_subplot()
        panels.mark(np.array([[axes]]), trajectory, scenario)
        found = [one for one in axes.patches if one.get_label() == "load"]
        assert [(one.get_x(), one.get_x() + one.get_width()) for one in found] == spans

    def test_angles_are_unwrapped(self, drawn):
        turns = np.linspace(0.0, 8.0, 1001)
        _, trajectory, scenario = drawn(14)
        values = trajectory.values.copy()
        values[:, 0, COLUMNS["obstacle"]] = -1.0
        values[:, 0, COLUMNS["theta_r"]] = wrap_array(turns)
        figure = BY_NUMBER[14].draw(dataclasses.replace(trajectory, values=values), scenario)
        for label in ("original path, tt", "in force, oa during avoidance"):
            assert same(line(figure, r"$\theta_r$ [rad]", label), trajectory.t, turns)
        _, trajectory, scenario = drawn(10)
        values = trajectory.values.copy()
        values[:, 0, COLUMNS["theta"]] += turns
        figure = BY_NUMBER[10].draw(dataclasses.replace(trajectory, values=values), scenario)
        _, bearing = line(figure, r"$\Psi_d - \Psi$ [rad]", "follower1")
        assert bearing[-1] - bearing[0] == pytest.approx(8.0, abs=1.5)

    def test_chattering_shows_the_peak_of_every_stretch(self, drawn):
        figure, trajectory, scenario = drawn(8)
        level = derived.chattering(trajectory, "omega", scenario.run.dt)[:, 2]
        _, y = line(figure, r"peaks of $|\dot{\omega}_c|$ [rad/s²]", "follower2")
        assert y.max() == level.max()
        assert y[10] == level[30:33].max()  # 1001 samples in stretches of three

    @pytest.mark.parametrize(("number", "robot"), [(9, "leader"), (26, "follower2")])
    def test_velocity_errors_stand_beside_their_compensation(self, drawn, number, robot):
        figure, trajectory, scenario = drawn(number)
        i = trajectory.robots.index(robot)
        for channel, label in (("v", "$v_e$ [m/s]"), ("omega", r"$\omega_e$ [rad/s]")):
            error = derived.velocity_error(trajectory, channel)[:, i]
            portion = derived.compensation(trajectory, scenario, channel)[:, i]
            assert same(line(figure, label, "auxiliary velocity tracking error", robot), trajectory.t, error)
            assert same(line(figure, label, "compensation by the sliding mode portion", robot), trajectory.t, portion)

    def test_separation_and_bearing_are_not_exchanged(self, drawn):
        figure, trajectory, scenario = drawn(19)
        separation, bearing = derived.formation_error(trajectory, scenario, "follower2")
        assert same(line(figure, r"$L_d - L$ [m]", "follower2"), trajectory.t, separation)
        assert same(line(figure, r"$\Psi_d - \Psi$ [rad]", "follower2"), trajectory.t, bearing)

    @pytest.mark.parametrize(
        ("number", "label", "signal"),
        [
            (11, r"${\sigma}_{v}^*$ [m]", "sigma_v"),
            (21, r"$\dot{\sigma}_{\omega}^*$ [rad/s]", "sigma_dot_omega"),
            (22, r"$\hat{k}_{h,\omega}$ [rad/s]", "k_h_omega"),
            (23, r"$f_{v}$ [-]", "f_v"),
            (23, r"$\hat{G}_{AIS,\omega}$ [rad/s]", "g_ais_omega"),
        ],
    )
    def test_signals_of_the_law_stand_on_their_axes(self, drawn, number, label, signal):
        figure, trajectory, _ = drawn(number)
        for i, robot in enumerate(trajectory.robots):
            assert same(line(figure, label, robot), trajectory.t, trajectory[signal][:, i])

    def test_surfaces_before_their_transformation_stand_above(self, drawn):
        figure, trajectory, _ = drawn(11)
        sigma = 0.3 * trajectory["y_e"] + 0.7 * wrap_array(trajectory["theta_r_star"] - trajectory["theta"])
        assert same(line(figure, r"${\sigma}_{\omega}$ [rad]", "follower2"), trajectory.t, sigma[:, 2])
        assert same(line(figure, r"${\sigma}_{v}$ [m]", "leader"), trajectory.t, 0.5 * trajectory["x_e"][:, 0])

    def test_sigma_stands_within_its_layer(self, drawn):
        figure, trajectory, _ = drawn(20)
        beta = trajectory["beta_v"][:, 1]
        label = r"$\sigma_{v}^*$ [m]"
        assert same(line(figure, label, r"boundary layer $\pm\beta$", "follower1"), trajectory.t, beta)
        (axes,) = (one for one in figure.axes if (one.get_ylabel(), one.get_title()) == (label, "follower1"))
        below = next(one for one in axes.lines if one.get_label().startswith("_"))
        assert same(below.get_data(), trajectory.t, -beta)

    def test_each_obstacle_has_its_radius(self, drawn):
        figure, trajectory, scenario = drawn(15)
        radii = derived.avoidance_radii(trajectory, scenario, "leader")
        assert same(line(figure, "$R_d$ [m]", "$R_d$", "obstacles.0"), trajectory.t, radii[:, 0])
        assert [axes.get_title() for axes in figure.axes] == ["obstacles.0", "obstacles.1"]
        assert drawn(16)[0].axes[0].get_title() == "obstacles.2"

    def test_distances_come_with_the_least_gap_of_the_body(self, drawn):
        figure, trajectory, scenario = drawn(16)
        gap = measure(trajectory, scenario, ["obstacle_gap"])["obstacle_gap"]["leader"]
        assert f"least gap of its body {gap:.2f} m, from obstacles.0" in figure.axes[-1].get_title()

    @pytest.mark.parametrize(("number", "robot"), [(16, "leader"), (17, "follower2")])
    def test_distances_are_those_of_the_robot(self, drawn, number, robot):
        figure, trajectory, scenario = drawn(number)
        wanted = distances(trajectory, scenario, robot)[:, 1]
        assert same(line(figure, r"$d_{ia}$ [m]", "obstacles.1", robot), trajectory.t, wanted)

    def test_both_orientations_of_the_reference_are_shown(self, drawn):
        figure, trajectory, _ = drawn(14)
        _, original = line(figure, r"$\theta_r$ [rad]", "original path, tt")
        _, active = line(figure, r"$\theta_r$ [rad]", "in force, oa during avoidance")
        assert original.max() < 1.0 < active.max() == pytest.approx(trajectory["theta_r"][:, 0].max())
        axes = next(axes for axes in figure.axes if axes.get_title().startswith("obstacles.0"))
        assert [text.get_text() for text in axes.get_legend().get_texts()] == ["$U_b$", "$U_f$", "$U$"]
        back, around, whole = (np.stack([one.U, one.V], axis=1) for one in axes.collections)
        total = back + around
        assert total / np.hypot(*total.T)[:, None] == pytest.approx(whole)
        assert (back * around).sum(axis=1) == pytest.approx(np.zeros(len(back)), abs=1e-9)


class TestOtherScenarios:
    @pytest.mark.parametrize(
        ("overrides", "without"),
        [
            (["obstacles=[]"], {14, 15, 16, 17}),
            (["robots.leader.avoids_obstacles=false"], {14, 15, 16}),
            ([], set()),
        ],
    )
    def test_have_no_figures_of_what_they_lack(self, overrides, without):
        scenario = read(find("paper"), overrides).scenario
        assert {f.number for f in paper.usual(scenario) if f.obstacle_to(scenario)} == without

    def test_notes_on_peaks_leave_titles_free(self, run_paper):
        file, trajectory = run_paper("smc", *RUN)
        values = trajectory.values.copy()
        values[5, :, [COLUMNS["v_c"], COLUMNS["omega_c"]]] = -3140.0
        values[6, :, [COLUMNS["v_c"], COLUMNS["omega_c"]]] = 2120.0
        figure = BY_NUMBER[10].draw(dataclasses.replace(trajectory, values=values), file.scenario)
        figure.draw_without_rendering()
        noted = [axes for axes in figure.axes if axes.texts]
        assert len(noted) == 2
        for axes in noted:
            (note,) = axes.texts
            (title,) = (one for one in axes.get_children() if isinstance(one, Text) and one.get_text() == "follower2")
            assert not note.get_window_extent().overlaps(title.get_window_extent())

    @pytest.mark.parametrize("number", [10, 13])
    def test_of_five_robots_are_drawn(self, run_paper, number):
        more = [
            f"robots.follower{k}={{x_0={-2.0 * k}, y_0=0.0, theta_0=0.0, d=0.4, "
            f'formation={{leader="follower{k - 2}", separation=1.25, bearing=3.0}}}}'
            for k in (3, 4)
        ]
        file, trajectory = run_paper(BY_NUMBER[number].law, "run.horizon=1", *more)
        figure = BY_NUMBER[number].draw(trajectory, file.scenario)
        titles = {title_of(axes) for axes in figure.axes}
        assert ("follower4" in titles) == (number == 10)


class TestNumbers:
    def test_are_lists_and_ranges(self):
        assert paper.numbers("12, 8,13-15,14") == (8, 12, 13, 14, 15)

    @pytest.mark.parametrize("text", ["", "8,", "7", "40", "12-8", "8.5"])
    def test_that_are_none_are_refused(self, text):
        with pytest.raises(ValueError):
            paper.numbers(text)


class TestFiles:
    @pytest.mark.parametrize("suffix", ["svg", "pdf"])
    def test_are_the_same_twice(self, tmp_path, run_paper, suffix):
        file, trajectory = run_paper("smc", *RUN)
        for name in ("a", "b"):
            paper.draw(BY_NUMBER[8], tmp_path / f"{name}.{suffix}", trajectory, file.scenario)
        picture = (tmp_path / f"a.{suffix}").read_bytes()
        assert picture == (tmp_path / f"b.{suffix}").read_bytes()
        assert b"/Type3" not in picture

    def test_the_index_says_what_is_there_and_what_is_not(self):
        scenario = read(find("paper"), ['name="a|b"']).scenario
        text = index_text([8], {14: "the scenario has no obstacles"}, "svg", scenario)
        assert "(fig08.svg)" in text
        assert "(fig09.svg)" not in text
        assert "Left out: the scenario has no obstacles." in text
        assert "Left out: not selected by --only." in text
        assert "a\\|b" in text
        assert all(f"## Fig. {k}: " in text for k in range(8, 29))
        assert "## Fig. 29" not in text
        assert "Figs. 29 to 39 of Goto" in index_text([29], {}, "png", read(find("experiment")).scenario)
