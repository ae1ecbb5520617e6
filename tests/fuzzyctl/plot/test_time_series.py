"""Pictures of runs: which panels there are, and what is drawn in them."""

import pytest
from matplotlib.figure import Figure

import fuzzyctl
from fuzzyctl.plot.time_series import draw_runs, panels
from fuzzyctl.support.shipped import rules_folder

FOLDER = rules_folder() / "loops"


@pytest.fixture(scope="module")
def run():
    return fuzzyctl.simulate(fuzzyctl.load_loop(FOLDER / "water_tank.fz"), backend="python")


def drawn(runs, labels):
    figure = Figure()
    draw_runs(figure, runs, labels)
    return figure


def test_outputs_with_their_reference_then_controls_then_disturbances(run):
    assert [(p.signal, p.reference, p.held) for p in panels(run)] == [
        ("tank.y", "reference", False),
        ("law.valve", "", True),
        ("leak", "", False),
    ]


def test_axes_have_labels_and_units(run):
    axes = drawn([run], ["fill"]).axes
    assert [ax.get_ylabel() for ax in axes] == ["level [m]", "valve [V]", "leak"]
    assert axes[-1].get_xlabel() == "time [s]"
    assert axes[0].get_title() == run.loop.title


def test_the_legend_names_each_run_once_and_the_reference(run):
    other = fuzzyctl.simulate(fuzzyctl.load_loop(FOLDER / "water_tank.fz"), backend="python", GU=4)
    figure = drawn([run, other], ["fast", "slow"])
    (legend,) = figure.legends
    assert [t.get_text() for t in legend.get_texts()] == ["fast", "slow", "reference"]
    assert [len(ax.lines) for ax in figure.axes] == [3, 2, 1]
    assert figure.axes[1].lines[0].get_drawstyle() == "steps-post"


def test_a_loop_without_measures_shows_its_only_reference(tmp_path):
    text = (FOLDER / "water_tank.fz").read_text("utf-8")
    lines = [line for line in text.split("\n") if not line.startswith(("measure", "require"))]
    (tmp_path / "a.fz").write_text("\n".join(lines), encoding="utf-8")
    first, *_ = panels(fuzzyctl.simulate(fuzzyctl.load_loop(tmp_path / "a.fz"), backend="python"))
    assert (first.signal, first.reference) == ("tank.y", "reference")


def test_signals_that_only_one_run_has_are_left_out_of_the_others(run):
    pendulum = fuzzyctl.simulate(fuzzyctl.load_loop(FOLDER / "pendulum.fz"), backend="python")
    figure = drawn([pendulum, run], ["pendulum", "tank"])
    assert [len(ax.lines) for ax in figure.axes] == [2, 1, 1, 1, 1, 1]
