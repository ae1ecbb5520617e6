"""Pictures of runs: which panels there are, and what is drawn in them."""

import numpy as np
import pytest

import fuzzyctl
from tests.shipped import SYSTEMS

FOLDER = SYSTEMS[0].parent / "loops"
CONSTANT = """
controller law
input r
input y
output u = r - y
every 0.25 s
plant p
input u
state x = 0
der x = u
output y = x + 0 * sqrt({end} - t)
loop {name}
param goal = 1
block law = law({law}, p.y)
block p = p(law.u)
measure m = {measure}
run 1 s
"""


@pytest.fixture(scope="module")
def run():
    return fuzzyctl.simulate(fuzzyctl.load("water_tank", block=fuzzyctl.Loop), backend="python")


def drawn(runs, labels):
    return fuzzyctl.plot.runs(*runs, labels=labels).figure


def test_axes_have_labels_and_units(run):
    axes = drawn([run], ["fill"]).axes
    assert [ax.get_ylabel() for ax in axes] == ["level [m]", "valve [V]", "leak"]
    assert axes[-1].get_xlabel() == "time [s]"
    assert axes[0].get_title() == run.loop.title


def test_the_legend_names_each_run_once_and_the_reference(run):
    other = fuzzyctl.simulate(fuzzyctl.load("water_tank", block=fuzzyctl.Loop), backend="python", GU=4)
    figure = drawn([run, other], ["fast", "slow"])
    (legend,) = figure.legends
    assert [t.get_text() for t in legend.get_texts()] == ["fast", "slow", "reference"]
    assert [len(ax.lines) for ax in figure.axes] == [3, 2, 1]
    assert figure.axes[1].lines[0].get_drawstyle() == "steps-post"


def test_a_loop_without_measures_shows_its_only_reference(tmp_path):
    text = (FOLDER / "water_tank.fz").read_text("utf-8")
    lines = [line for line in text.split("\n") if not line.startswith(("measure", "require"))]
    (tmp_path / "a.fz").write_text("\n".join(lines), encoding="utf-8")
    run = fuzzyctl.simulate(fuzzyctl.load(tmp_path / "a.fz", block=fuzzyctl.Loop), backend="python")
    signal, reference = drawn([run], ["a"]).axes[0].lines
    assert signal.get_ydata().tolist() == run["tank.y"].tolist()
    assert (reference.get_linestyle(), reference.get_ydata()[0]) == ("--", run["reference"][0])


@pytest.mark.parametrize(
    ("law", "measure", "value"),
    [
        ("1.5", "iae(p.y, 1.5)", 1.5),
        ("goal", "iae(p.y, 2 * goal)", 2.0),
        ("goal", "final(p.y)", 1.0),
        ("2", "final(p.y)", 2.0),
    ],
)
def test_a_constant_reference_is_drawn(loop_of, law, measure, value):
    axes = drawn([loop_of(law, measure)], ["a"]).axes
    (dashed,) = [line.get_ydata().tolist() for ax in axes for line in ax.lines if line.get_linestyle() == "--"]
    assert dashed == [value] * 5


@pytest.fixture
def loop_of(tmp_path):
    def simulated(law, measure, name="a", end=9):
        path = tmp_path / "loop.fz"
        path.write_text(CONSTANT.format(law=law, measure=measure, name=name, end=end), encoding="utf-8")
        return fuzzyctl.simulate(fuzzyctl.load(path, block=fuzzyctl.Loop))

    return simulated


def test_runs_with_other_references_have_them_in_their_colours(loop_of):
    runs = [loop_of("1", "iae(p.y, 1)"), loop_of("2", "iae(p.y, 2)", name="b")]
    figure = drawn(runs, ["a", "b"])
    solid, dashed = ([line for line in figure.axes[0].lines if line.get_linestyle() == s] for s in ("-", "--"))
    assert [line.get_color() for line in solid] == [line.get_color() for line in dashed]
    assert figure.axes[0].get_title() == "", "two loops have no title in common"


def test_a_long_run_keeps_its_peaks_and_ends(run, monkeypatch):
    monkeypatch.setattr("fuzzyctl.plot.time_series.POINTS", len(run) // 50)
    level = drawn([run], ["a"]).axes[0].lines[0]
    given = run["tank.y"]
    assert len(level.get_ydata()) < len(given) / 20
    assert (level.get_ydata().min(), level.get_ydata().max()) == (given.min(), given.max())
    assert level.get_xdata()[[0, -1]].tolist() == run.t[[0, -1]].tolist()
    at = np.searchsorted(run.t, level.get_xdata())
    assert level.get_ydata().tolist() == given[at].tolist()


def test_a_run_that_was_stopped_ends_in_a_cross(loop_of):
    runs = [loop_of("1", "iae(p.y, 1)"), loop_of("1", "final(p.y)", end=0.5), loop_of("1", "final(p.y)", end=-1)]
    assert [len(run) for run in runs] == [5, 3, 0]
    figure = drawn(runs, ["a", "b", "c"])
    crosses = [line for line in figure.axes[0].lines if line.get_marker() == "x"]
    assert [line.get_xdata().tolist() for line in crosses] == [[0.5]]
    labels = [t.get_text() for t in figure.legends[0].get_texts()]
    assert labels == ["a", "b, stopped", "c, stopped", "reference"]


def test_signals_that_only_one_run_has_have_panels_too(run):
    pendulum = fuzzyctl.simulate(fuzzyctl.load("pendulum", block=fuzzyctl.Loop), backend="python")
    figure = drawn([pendulum, run], ["pendulum", "tank"])
    assert [len(ax.lines) for ax in figure.axes] == [2, 1, 1, 1, 2, 1, 1, 1]  # outputs of both plants first


def test_peaks_are_cut_off_as_on_a_page_and_named_below_the_panel():
    run = fuzzyctl.simulate(fuzzyctl.load("pendulum", block=fuzzyctl.Loop), backend="python")
    figure = drawn([run], ["balanced"])
    force = next(ax for ax in figure.axes if ax.get_ylabel() == "force [N]")
    assert run["law.force"].max() == 32.0
    assert force.get_ylim()[1] < 10.0
    assert "Peaks cut off: force [N] 32 at 0.00 s" in force.get_xlabel()
    assert [ax.get_xlabel() for ax in figure.axes if ax is not force][-1] == "time [s]"


def test_the_tube_of_a_family_and_its_members_are_drawn_behind_a_run():
    loop = fuzzyctl.loads(
        "plant p\nstate x = 1\nder x = -x\noutput y = x\nloop l\nblock p = p()\nfor p.x in [0.5, 1.5]\n"
        "run 1 s step 100 ms\nrequire always p.y <= 2\n",
        block="l",
    )
    tube = fuzzyctl.prove(loop).tube
    members = [fuzzyctl.simulate(loop, backend="python", **{"p.x": start}) for start in (0.5, 1.5)]
    panels = fuzzyctl.plot.runs(fuzzyctl.simulate(loop, backend="python"), tube=tube, members=members)
    (ax,) = panels
    assert len(ax.lines) == 3
    (band,) = ax.collections
    low, high = tube.bounds["p.y"]
    assert band.get_datalim(ax.transData).ymin == pytest.approx(low.min())
    assert band.get_datalim(ax.transData).ymax == pytest.approx(high.max())
    (legend,) = panels.figure.legends
    assert [t.get_text() for t in legend.get_texts()] == ["members", "all members, proved", "l"]
