"""The counterparts of the paper's figures that `dwmr figures` draws, and their index."""

import re

import numpy as np
import pytest
from matplotlib.patches import Polygon
from matplotlib.text import Text

from dwmr import measure
from dwmr.control.formation import separation_and_bearing
from dwmr.core.geometry import wrap_array
from tests.dwmr.process import here
from tests.dwmr.scenarios import changed, in_frame
from tests.physics import needs_mujoco

#: A run short enough to be drawn sample by sample, with an obstacle that is avoided.
RUN = ("run.horizon=5", "obstacles=[{x=3.0, y=2.0, radius=0.5}, {x=9.0, y=9.0, radius=0.5}, {x=-9.0, y=9.0, radius=1}]")
LAWS = {**dict.fromkeys(range(8, 13), "smc"), **dict.fromkeys(range(13, 24), "aifqsmc"),
        **dict.fromkeys(range(24, 29), "fcafsmc")}  # fmt: skip


@pytest.fixture(scope="module")
def figures(figures_of):
    """All figures of RUN by number."""
    return {int(name[3:5]): figure for name, figure in figures_of("figures", "paper", sets=RUN).items()}


@pytest.fixture(scope="module")
def drawn(figures, run_paper):
    """A function number -> (figure, trajectory, scenario)."""

    def draw(number):
        file, trajectory = run_paper(LAWS[number], *RUN)
        return figures[number], trajectory, file.scenario

    return draw


@pytest.fixture
def drawn_of(figures_of, recorded):
    """A function (number, trajectory, *overrides) -> the figure of that trajectory."""

    def draw(number, trajectory, *overrides):
        recorded(trajectory)
        (figure,) = figures_of("figures", "paper", "--only", number, sets=(*RUN, *overrides)).values()
        return figure

    return draw


def index(folder, *arguments, status=0):
    """Return the text of the index that a command writes."""
    here("figures", *arguments, "-o", folder, status=status)
    return (folder / "index.md").read_text(encoding="utf-8")


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


def bodies(figure):
    """Return the outlines of robots in a figure of paths, five corners each."""
    return [one.get_xy()[:5] for one in figure.axes[0].patches if isinstance(one, Polygon)]


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
    def test_has_all_figures_of_the_paper_from_8_to_39_and_those_of_the_experiment_show_what_the_others_do(
        self, recorded, run_paper, tmp_path
    ):
        recorded(*(run_paper(law, *RUN)[1] for law in ("smc", "aifqsmc")))
        text = index(tmp_path, "paper", "--only", "8,29-39", "--set", "run.horizon=5")
        heads = dict(re.findall(r"^## Fig\. (\d+): (.*)$", text, flags=re.MULTILINE))
        assert [int(number) for number in heads] == list(range(8, 40))
        for number in range(29, 40):
            simulated, subject = heads[str(number - 16)].rsplit(" (", 1)
            assert (subject, heads[str(number)]) == ("AIFQSMC)", f"{simulated} (AIFQSMC, experiment)")
        why = "Left out: it shows rigid bodies, and run.plant is 'equations'; see figure 14."
        assert why in text.partition("## Fig. 30")[2].partition("## Fig. 31")[0]

    def test_the_paper_has_those_of_its_simulation(self, figures):
        assert list(figures) == list(range(8, 29))

    @needs_mujoco
    def test_the_experiment_has_those_of_rigid_bodies(self, tmp_path):
        text = index(tmp_path, "experiment", "--only", "29", "--set", "run.horizon=0.1")
        assert re.findall(r"^## Fig\. (\d+)", text, flags=re.MULTILINE) == [str(k) for k in range(29, 40)]
        assert "Figs. 29 to 39 of Goto" in text

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
        last = bodies(figure)[-1]
        robot, own = scenario.robots["follower2"], scenario.robots["follower2"].body
        places = in_frame(last, robot, *(trajectory[name][-1, 2] for name in ("x", "y", "theta")))
        assert places.max(axis=0) == pytest.approx((own.front, 0.5 * own.width))
        assert places.min(axis=0) == pytest.approx((-own.rear, -0.5 * own.width))
        assert places[3] == pytest.approx((own.front, 0.0))

    def test_a_place_that_is_no_number_has_no_body(self, drawn, drawn_of):
        figure, trajectory, _ = drawn(13)
        ended = drawn_of(
            13, changed(trajectory, x=lambda x: np.where(np.arange(len(x))[:, None] < len(x) - 1, x, np.nan))
        )
        assert len(bodies(ended)) == len(bodies(figure)) - 3

    @pytest.mark.parametrize(("factor", "spans"), [(1.2, [(1.0, 5.0)]), (1.0, [])])
    def test_the_load_is_marked_where_there_is_one(self, drawn, drawn_of, factor, spans):
        load = f"load={{start=1.0, stop=9.0, mass_factor={factor}, inertia_factor=1.0}}"
        figure = drawn_of(22, drawn(22)[1], load)
        found = [one for one in figure.axes[0].patches if one.get_label() == "load"]
        assert [(one.get_x(), one.get_x() + one.get_width()) for one in found] == spans

    def test_angles_are_unwrapped(self, drawn, drawn_of):
        turns, leader = np.linspace(0.0, 8.0, 1001)[:, None], np.array([True, False, False])
        _, trajectory, _ = drawn(14)
        turned = changed(
            trajectory,
            obstacle=lambda a: np.where(leader, -1.0, a),
            theta_r=lambda theta: np.where(leader, wrap_array(turns), theta),
        )
        figure = drawn_of(14, turned)
        for label in ("original path, tt", "in force, oa during avoidance"):
            assert same(line(figure, r"$\theta_r$ [rad]", label), trajectory.t, turns[:, 0])
        _, trajectory, _ = drawn(10)
        figure = drawn_of(10, changed(trajectory, theta=lambda theta: theta + leader * turns))
        _, bearing = line(figure, r"$\Psi_d - \Psi$ [rad]", "follower1")
        assert bearing[-1] - bearing[0] == pytest.approx(8.0, abs=1.5)

    def test_chattering_shows_the_peak_of_every_stretch(self, drawn):
        figure, trajectory, scenario = drawn(8)
        command = trajectory["omega_c"][:, 2]
        level = np.abs(np.diff(command, prepend=command[0])) / scenario.run.dt
        _, y = line(figure, r"peaks of $|\dot{\omega}_c|$ [rad/s²]", "follower2")
        assert y.max() == level.max()
        assert y[10] == level[30:33].max()  # 1001 samples in stretches of three

    @pytest.mark.parametrize(("number", "robot"), [(9, "leader"), (18, "follower1"), (26, "follower2")])
    def test_velocity_errors_stand_beside_their_compensation(self, drawn, number, robot):
        figure, trajectory, scenario = drawn(number)
        i, gains = trajectory.robots.index(robot), scenario.robots[robot].controllers
        for channel, label in (("v", "$v_e$ [m/s]"), ("omega", r"$\omega_e$ [rad/s]")):
            commanded, sigma = trajectory[f"{channel}_c"][:, i], trajectory[f"sigma_{channel}"][:, i]
            error = commanded - trajectory[channel][:, i] - trajectory[f"d_{channel}"][:, i]
            if number == 9:
                portion = -gains["smc"][f"g_{channel}"] * np.sign(sigma)
            elif number == 18:
                inside = np.clip(sigma / trajectory[f"beta_{channel}"][:, i], -1.0, 1.0)
                portion = -trajectory[f"g_ais_{channel}"][:, i] * inside
            else:
                portion = -trajectory[f"f_{channel}"][:, i]
            assert same(line(figure, label, "auxiliary velocity tracking error", robot), trajectory.t, error)
            assert same(line(figure, label, "compensation by the sliding mode portion", robot), trajectory.t, portion)

    def test_separation_and_bearing_are_not_exchanged(self, drawn):
        figure, trajectory, scenario = drawn(19)
        wanted, (x, y, theta) = scenario.robots["follower2"].formation, (trajectory[n] for n in ("x", "y", "theta"))
        found = np.vectorize(separation_and_bearing)(x[:, 0], y[:, 0], theta[:, 0], 0.1, x[:, 2], y[:, 2])
        separation, bearing = wanted.separation - found[0], wrap_array(wanted.bearing - found[1])
        # the position error in the robot's frame is the same distance, seen from the follower
        gap = np.hypot(trajectory["x_e"][:, 2], trajectory["y_e"][:, 2])
        assert np.all(np.abs(separation) <= gap + 1e-9)
        assert separation[0] < -1.0  # it begins too far behind
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
        figure, trajectory, _ = drawn(15)
        t, radii = line(figure, "$R_d$ [m]", "$R_d$", "obstacles.0")
        samples = np.searchsorted(trajectory.t, t - 1e-9)
        active = trajectory["obstacle"][samples, 0] == 0
        assert len(radii) > 100
        assert 0 < active.sum() < len(active)
        assert radii[active] == pytest.approx(trajectory["avoidance_radius"][samples[active], 0])
        distance = np.hypot(trajectory["x"][samples, 0] - 3.0, trajectory["y"][samples, 0] - 2.0)
        assert np.array_equal(active, distance <= radii)
        assert [axes.get_title() for axes in figure.axes] == ["obstacles.0", "obstacles.1"]
        assert drawn(16)[0].axes[0].get_title() == "obstacles.2"

    def test_distances_come_with_the_least_gap_of_the_body(self, drawn):
        figure, trajectory, scenario = drawn(16)
        gap = measure(trajectory, scenario, ["obstacle_gap"])["obstacle_gap"]["leader"]
        assert f"least gap of its body {gap:.2f} m, from obstacles.0" in figure.axes[-1].get_title()

    @pytest.mark.parametrize(("number", "robot"), [(16, "leader"), (17, "follower2")])
    def test_distances_are_those_of_the_robot(self, drawn, number, robot):
        figure, trajectory, _ = drawn(number)
        i = trajectory.robots.index(robot)
        wanted = np.hypot(trajectory["x"][:, i] - 9.0, trajectory["y"][:, i] - 9.0)
        assert same(line(figure, r"$d_{ia}$ [m]", "obstacles.1", robot), trajectory.t, wanted)

    def test_both_orientations_of_the_reference_are_shown(self, drawn, run_paper):
        figure, trajectory, _ = drawn(14)
        t, original = line(figure, r"$\theta_r$ [rad]", "original path, tt")
        free = run_paper("aifqsmc", "run.horizon=5", "obstacles=[]")[1]["theta_r"][:, 0]
        assert original == pytest.approx(free[np.searchsorted(trajectory.t, t - 1e-9)], abs=1e-3)
        _, active = line(figure, r"$\theta_r$ [rad]", "in force, oa during avoidance")
        assert original.max() < 1.0 < active.max() == pytest.approx(trajectory["theta_r"][:, 0].max())
        axes = next(axes for axes in figure.axes if axes.get_title().startswith("obstacles.0"))
        assert [text.get_text() for text in axes.get_legend().get_texts()] == ["$U_b$", "$U_f$", "$U$"]
        back, around, whole = (np.stack([one.U, one.V], axis=1) for one in axes.collections)
        total = back + around
        assert total / np.hypot(*total.T)[:, None] == pytest.approx(whole)
        assert (back * around).sum(axis=1) == pytest.approx(np.zeros(len(back)), abs=1e-9)
        active = trajectory["theta_r"][trajectory["obstacle"][:, 0] >= 0, 0]
        off = wrap_array(np.arctan2(whole[:, 1], whole[:, 0])[:, None] - active)
        assert np.abs(off).min(axis=1) == pytest.approx(np.zeros(len(whole)), abs=1e-9)


class TestOtherScenarios:
    @pytest.mark.parametrize(
        ("override", "without"),
        [("obstacles=[]", (14, 15, 16, 17)), ("robots.leader.avoids_obstacles=false", (14, 15, 16))],
    )
    def test_have_no_figures_of_what_they_lack(self, recorded, run_paper, tmp_path, override, without):
        recorded(run_paper("aifqsmc", *RUN)[1])
        options = ("--set", override, "--set", "run.horizon=5", "--only", "14-17", "-o", tmp_path)
        done = here("figures", "paper", *options, status=int(17 in without))
        assert re.findall(r"warning: figure (\d+) is left out", done.stderr) == [str(k) for k in without]

    def test_notes_on_peaks_leave_titles_free(self, drawn, drawn_of):
        def peaks(command):
            command = command.copy()
            command[5], command[6] = -3140.0, 2120.0
            return command

        figure = drawn_of(10, changed(drawn(10)[1], v_c=peaks, omega_c=peaks))
        figure.draw_without_rendering()
        noted = [axes for axes in figure.axes if axes.texts]
        assert len(noted) == 2
        for axes in noted:
            (note,) = axes.texts
            (title,) = (one for one in axes.get_children() if isinstance(one, Text) and one.get_text() == "follower2")
            assert not note.get_window_extent().overlaps(title.get_window_extent())

    def test_of_five_robots_are_drawn(self, figures_of):
        more = [
            f"robots.follower{k}={{x_0={-2.0 * k}, y_0=0.0, theta_0=0.0, d=0.4, "
            f'formation={{leader="follower{k - 2}", separation=1.25, bearing=3.0}}}}'
            for k in (3, 4)
        ]
        drawn = figures_of("figures", "paper", "--only", "10,13", sets=("run.horizon=1", *more))
        shown = {name: {title_of(axes) for axes in figure.axes} for name, figure in drawn.items()}
        assert ["follower4" in titles for titles in shown.values()] == [True, False]


class TestNumbers:
    def test_are_lists_and_ranges(self, figures_of, recorded, run_paper):
        recorded(*(run_paper(law, *RUN)[1] for law in ("smc", "aifqsmc")))
        drawn = figures_of("figures", "paper", "--only", "12, 8,20-22,21", sets=RUN)
        assert list(drawn) == [f"fig{k:02}.png" for k in (8, 12, 20, 21, 22)]

    @pytest.mark.parametrize("text", ["", "8,", "7", "40", "12-8", "8.5"])
    def test_that_are_none_are_refused(self, text):
        assert f"--only {text}: " in here("figures", "paper", "--only", text, status=2).stderr


class TestFiles:
    @pytest.mark.parametrize("suffix", ["svg", "pdf"])
    def test_are_the_same_twice(self, tmp_path, recorded, run_paper, suffix):
        recorded(run_paper("smc", *RUN)[1])
        for name in ("a", "b"):
            options = ("--only", "8", "--format", suffix, "--set", "run.horizon=5", "-o", tmp_path / name)
            here("figures", "paper", *options)
        first, second = ((tmp_path / name / f"fig08.{suffix}").read_bytes() for name in ("a", "b"))
        assert first == second
        assert b"/Type3" not in first

    def test_the_index_says_what_is_there_and_what_is_not(self, tmp_path, recorded, run_paper):
        recorded(run_paper("smc", *RUN)[1])
        sets = ("--set", 'name="a|b"', "--set", "obstacles=[]", "--set", "run.horizon=5")
        text = index(tmp_path, "paper", "--only", "8,14", "--format", "svg", *sets)
        assert "(fig08.svg)" in text
        assert "(fig09.svg)" not in text
        assert "Left out: the scenario has no obstacles." in text
        assert "Left out: not selected by --only." in text
        assert "a\\|b" in text
        assert all(f"## Fig. {k}: " in text for k in range(8, 29))
        assert "## Fig. 29" not in text
